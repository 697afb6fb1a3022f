//! What a program may rely on that runs cases from code: checks within one process.

use std::path::Path;
use std::process::ExitCode;

use column_hpc::case::sections::*;
use column_hpc::case::{Case, Formulation};
use column_hpc::element::Shape;
use column_hpc::error::{Error, Result};
use column_hpc::law::{Contact, LinearSoftening};
use column_hpc::results::{Directory, History};
use column_hpc::run::{self, Run};
use column_hpc::runtime::Runtime;

/// A block of 4 x 8 cells that is bent while it is pulled.
fn block() -> CaseFile {
    let law = LinearSoftening::new(1.0e6, 900.0);
    let lifted = Components::xz(0.0, "5e-3*t*(1 + x)");
    CaseFile::new(MeshSection::column([1.0, 2.0], [4, 8]), TimeSection::instants([0.1, 0.3]))
        .material("rock", MaterialSection::elastic(5.0e9, 0.2))
        .interface(InterfaceSection::new("joint", 1.0, law))
        .boundary(BoundarySection::on(Surface::Bottom).displacement(Components::xz(0.0, 0.0)))
        .boundary(BoundarySection::on(Surface::Top).displacement(lifted))
}

/// A column that a smaller model may stand for.
fn column() -> CaseFile {
    let mut sections = block();
    sections.mesh = MeshSection::column([1.0, 2.0], [32, 64]);
    sections.boundary[1].displacement = Components::xz(0.0, [[0.0, 0.0], [1.0, 2.0e-3]]);
    sections.materials.insert("rock".into(), MaterialSection::elastic(5.0e9, 0.0));
    sections
}

/// Equal to the last bit on one rank; on more, elimination adds in the order of messages.
fn assert_same(runtime: &Runtime, a: &History, b: &History) {
    if runtime.comm.size() == 1 {
        return assert_eq!(a, b);
    }
    assert_eq!((a.columns(), a.times()), (b.columns(), b.times()));
    for name in a.columns() {
        let [a, b] = [a, b].map(|history| history.column(name).expect("no empty column"));
        let largest = a.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        for (a, b) in a.iter().zip(&b) {
            assert!((a - b).abs() <= 1e-9 * largest + 1e-7, "{name}: {a} and {b}");
        }
    }
}

pub fn main() -> ExitCode {
    run::program(|runtime| {
        let name = format!("column-hpc-library-{}", std::process::id());
        let place = runtime.comm.broadcast_bytes(name.into_bytes());
        let place = std::env::temp_dir().join(String::from_utf8_lossy(&place).as_ref());
        memory_and_disk_hold_the_same(runtime, &place)?;
        fields_are_those_of_the_model(runtime, &place)?;
        runs_do_not_touch_each_other(runtime)?;
        refusals_are_told(runtime, &place)?;
        runtime.comm.barrier();
        if runtime.comm.is_root() {
            std::fs::remove_dir_all(&place).expect("a directory of ours");
        }
        Ok(())
    })
}

fn memory_and_disk_hold_the_same(runtime: &Runtime, place: &Path) -> Result<()> {
    for (name, sections) in [("block", block()), ("column", column())] {
        let case = Case::build(sections)?;
        let memory = Run::of(&case).start(runtime)?;
        let disk = Run::of(&case).output(place.join(name)).report().start(runtime)?;
        assert_same(runtime, &memory.history, &disk.history);
        assert_eq!(memory.report["reduction"]["applied"], name == "column");
        assert!(memory.meets_expectations());
        assert_eq!(memory.history.times(), [0.1, 0.3]);
        let directory = Directory::open(place.join(name))?;
        assert_eq!(directory.history()?, disk.history);
        assert_eq!(directory.report()?, disk.report);
        assert_eq!(directory.case()?, case);
        assert!(place.join(name).join("report.html").is_file());
        // Every rank has read before the next run replaces it.
        runtime.comm.barrier();
    }
    Ok(())
}

fn fields_are_those_of_the_model(runtime: &Runtime, place: &Path) -> Result<()> {
    let directory = Directory::open(place.join("block"))?;
    assert_eq!(directory.fields()?, ["bulk", "joint"]);
    let bulk = directory.series("bulk")?;
    assert_eq!(bulk.times(), [0.1, 0.3]);
    let fields = bulk.at(0.3)?;
    let (points, displacement) = (fields.points()?, fields.at_points("displacement")?);
    assert_eq!((points.len(), displacement.components, displacement.rows().len()), (50, 3, 50));
    let mut top = 0;
    for ([x, _, z], u) in points.iter().zip(displacement.rows()) {
        if *z == 2.0 {
            top += 1;
            assert!((u[2] - 5e-3 * 0.3 * (1.0 + x)).abs() < 1e-15 && u[0] == 0.0, "{u:?}");
        }
    }
    assert_eq!(top, 5);
    let cells = fields.cells()?;
    assert_eq!(cells.len(), 32);
    let area: f64 = cells
        .iter()
        .map(|(shape, nodes)| {
            assert_eq!(*shape, Shape::Quad4);
            let [a, c] = [points[nodes[0]], points[nodes[2]]];
            (c[0] - a[0]) * (c[2] - a[2])
        })
        .sum();
    assert!((area - 2.0).abs() < 1e-12, "{area}");
    assert_eq!(fields.at_cells("stress")?.rows().len(), 32);
    let ranks = fields.at_cells("rank")?.values;
    assert_eq!(
        ranks.iter().fold(0.0, |most, r| f64::max(most, *r)) as i32 + 1,
        runtime.comm.size()
    );
    assert!(fields.names_at_points()?.contains(&"global_node_id".to_owned()));
    assert!(fields.names_at_cells()?.contains(&"material".to_owned()));
    let told = fields.at_points("jump").expect_err("of interfaces").to_string();
    assert!(told.contains("has no PointData `jump`") && told.contains("displacement"), "{told}");
    let joint = directory.series("joint")?.at(0.1)?;
    assert_eq!(joint.cells()?.len(), 4);
    assert_eq!(joint.at_points("damage")?.components, 1);
    runtime.comm.barrier();
    Ok(())
}

fn runs_do_not_touch_each_other(runtime: &Runtime) -> Result<()> {
    let plain = Case::build(block())?;
    let before = Run::of(&plain).start(runtime)?;
    let words = "-ksp_type gmres -of_nobody 7";
    let solver = SolverSpec { petsc_options: words.into(), ..SolverSpec::default() };
    let with_options = Run::of(&Case::build(block().solver(solver))?).start(runtime)?;
    let told = with_options.report["linear_solver"]["petsc_options"].to_string();
    assert!(told.contains("of_nobody"), "{told}");
    assert_eq!(runtime.petsc.has_option("of_nobody"), Ok(true));

    // As good as over when it begins.
    let hurried = Case::build(block().limits(LimitsSection::wall("1 s")).reduce(Reduce::Never))?;
    let stopped = Run::of(&hurried).start(runtime);
    let Err(Error::Stopped(told)) = stopped else { panic!("{stopped:?}") };
    assert_eq!(told, "stopped by the wall-clock limit, limits.wall");

    // One correction is too few for what softens.
    let solver = SolverSpec { max_newton: 1, ..SolverSpec::default() };
    let failed = Run::of(&Case::build(block().solver(solver))?).start(runtime);
    assert!(matches!(failed, Err(Error::Numerics(_))), "{failed:?}");

    let after = Run::of(&plain).start(runtime)?;
    assert_same(runtime, &before.history, &after.history);
    assert_eq!(before.report["linear_solver"], after.report["linear_solver"]);
    assert_eq!(runtime.petsc.has_option("of_nobody"), Ok(false));
    Ok(())
}

fn refusals_are_told(runtime: &Runtime, place: &Path) -> Result<()> {
    let told = |case: Run<'_>| match case.start(runtime) {
        Err(Error::Input(told)) => told,
        other => panic!("{other:?}"),
    };
    let case = Case::build(block())?;
    let in_memory = told(Run::of(&case).restart("latest"));
    assert_eq!(in_memory, "a restart and a page need an output directory");

    let mut other = block();
    other.mesh.formulation = Formulation::BBar;
    let other = Case::build(other)?;
    let taken = told(Run::of(&other).output(place.join("block")));
    assert!(taken.contains("holds results of another case"), "{taken}");
    Run::of(&other).output(place.join("block")).overwrite().start(runtime)?;

    let wrong = ExpectSection::new("joint.damage.max", 0.1, 7.0).absolute(0.0);
    let missed = Run::of(&Case::build(block().expect(wrong))?).start(runtime)?;
    assert!(!missed.meets_expectations());
    assert_eq!(missed.report["expectations"][0]["met"], false);

    if runtime.comm.size() > 1 {
        let mut differs = block();
        differs.time.instants[0] += 0.01 * f64::from(runtime.comm.rank());
        let differs = Case::build(differs)?;
        assert_eq!(told(Run::of(&differs)), "the case is not the same on all ranks");
    }
    let mut loose = block();
    loose.interfaces[0].law = Contact::default().into();
    loose.boundary.truncate(1);
    let told = Case::build(loose).expect_err("a body that floats").to_string();
    assert!(told.starts_with("boundary leaves a body free"), "{told}");
    Ok(())
}
