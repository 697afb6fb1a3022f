//! Smaller models in the place of the one asked for: the same results, and a bound of the
//! difference.

use crate::grid;
use crate::scene::{Run, Scene, fresh};

/// The reference on a mesh that is worth a reduction.
fn reference() -> Scene {
    Scene::shipped("wtnv146/case.yaml").set("mesh.column.cells=[6, 6, 30]")
}

/// A column of two rocks with an interface between them, its supports and more as YAML.
fn column(cells: &str, more: &str) -> Scene {
    let yaml = format!(
        "mesh: {{column: {{size: [1, 1, 4], bodies: [{{cells: {cells}}}, {{cells: {cells}}}]}}}}\n\
         materials:\n  soft: {{z: [0, 1.5], elastic: {{young_modulus: 4.0e9, poisson_ratio: 0.2}}, \
         porous: {{biot: 1, porosity: 0.15, permeability: 1.0e-18, viscosity: 1.0e-3, \
         fluid_compressibility: 5.0e-10, fluid_density: 1000, density: 2500}}}}\n  \
         hard: {{z: [1.5, 4], elastic: {{young_modulus: 8.0e9, poisson_ratio: 0.2}}, \
         porous: {{biot: 1, porosity: 0.15, permeability: 1.0e-18, viscosity: 1.0e-3, \
         fluid_compressibility: 5.0e-10, fluid_density: 1000, density: 2700}}}}\n\
         interfaces: [{{name: joint, z: 2, law: {{exponential_softening: {{strength: 1.1e6, \
         fracture_energy: 2000}}}}}}]\n{more}"
    );
    Scene::new("column", &yaml)
}

/// Rollers on all sides: uniform with any Poisson's ratio.
const ROLLERS: &str = "boundary:
  - {on: bottom, displacement: {z: 0}}
  - {on: left, displacement: {x: 0}}
  - {on: right, displacement: {x: 0}}
  - {on: front, displacement: {y: 0}}
  - {on: back, displacement: {y: 0}}
  - {on: top, displacement: {z: {table: [[0, 0], [1, -1.0e-4], [2, 8.0e-4], [3, 3.0e-4], [4, 2.0e-3]]}}}
time: {instants: [1, 2, 3, 4]}
probes: [{name: aside, at: [0.3, 0.8, 3.1]}]
physics: mechanics
";

fn certificate(run: &Run, number: &str) -> f64 {
    run.report["reduction"][number].as_f64().unwrap_or_else(|| panic!("{}: {number}", run.label))
}

/// The model asked for and the smaller one in its place, which is solved; the first one is
/// returned.
fn same(scene: &Scene, ranks: usize, unknowns: f64) -> Run {
    // As far as rounding lets the model asked for be solved.
    let full = scene.set("solver.tolerance=1e-11").in_any_steps().on(ranks);
    let reduced = scene.reduced().in_any_steps().on(ranks);
    assert_eq!(full.report["reduction"]["applied"], false, "{}", full.label);
    assert_eq!(reduced.report["reduction"]["applied"], true, "{}", reduced.screen);
    assert_eq!(certificate(&reduced, "unknowns_solved"), unknowns, "{}", reduced.label);
    // Jumps of nothing but rounding have no scale of their own.
    let opens = |name: &&String| {
        name.ends_with(".damage.max") && full.column(name).iter().any(|d| *d > 0.0)
    };
    if full.table.columns.iter().any(|name| opens(&name)) {
        full.assert_same(&reduced, 1e-9);
    } else {
        for name in ["joint.normal_traction.max", "joint.shear_traction_x.min", "top.reaction_z"] {
            reduced.assert_column(name, &full.column(name), 1e-9, 1e-3);
        }
    }
    let bound = certificate(&reduced, "error_bound");
    assert!(bound > 0.0 && bound <= 1e-9, "{}: {bound:e}", reduced.label);
    full
}

#[test]
fn the_reference_is_solved_by_one_cell_for_each_body() {
    for ranks in 1..=3 {
        same(&reference(), ranks, 48.0);
    }
    same(&reference().scattered(), 2, 48.0);
    same(&reference().set("mesh.order=2"), 2, 48.0);
    // Among them one without any displacement.
    let many = "time.instants=[0.5, 1, 1.5, 2, 2.5, 3, 4, 5, 6, 6.5, 8]";
    same(&reference().set(many).set("expect=[]"), 1, 48.0);
    let plane = Scene::shipped("wtnv146/case_2d.yaml").set("mesh.column.cells=[20, 90]");
    same(&plane, 1, 16.0);
}

#[test]
fn fields_and_expectations_are_those_of_the_mesh_asked_for() {
    let scene = reference().with_fields();
    let [full, reduced] = [scene.set("solver.tolerance=1e-11"), scene.reduced()].map(|s| s.on(2));
    let expectations = reduced.report["expectations"].as_array().expect("a list");
    assert!(expectations.len() > 40 && expectations.iter().all(|e| e["met"] == true));
    for step in [1, 3, 7, 8] {
        for (file, array, scale) in [
            ("bulk", "displacement", 1e-3),
            ("joint", "jump", 1e-3),
            ("joint", "traction", 1e6),
            ("joint", "damage", 1.0),
            ("joint", "state", 1.0),
        ] {
            let read = |run: &Run| {
                let name = format!("fields/{file}_{step:06}.vtkhdf");
                grid::read(&run.directory.join(name), array)
            };
            let (one, other) = (read(&full), read(&reduced));
            assert_eq!(one.points, other.points);
            let values = |grid: &grid::Grid| grid.values.as_flattened().to_vec();
            for (one, other) in values(&one).iter().zip(&values(&other)) {
                let off = (one - other).abs();
                assert!(off <= 1e-9 * scale, "{file} {step} {array}: {one} {other}");
            }
        }
    }
}

/// The traction of the model asked for, solved to rounding, is closer than the bound says.
#[test]
fn the_bound_is_above_the_error() {
    let scene = reference().set("solver.linear=mumps").set("solver.tolerance=1e-13");
    let full = scene.on(1);
    for tolerance in ["1e-9", "1e-4"] {
        let reduced = reference().reduced().set(&format!("solver.tolerance={tolerance}")).on(1);
        let bound = certificate(&reduced, "error_bound");
        for name in ["joint.normal_traction.mean", "joint.normal_jump.mean", "top.reaction_z"] {
            let (one, other) = (full.column(name), reduced.column(name));
            let largest = one.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            let error = one.iter().zip(&other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(error <= bound * largest, "{name}: {:e} {bound:e}", error / largest);
        }
    }
}

#[test]
fn shipped_columns_on_finer_meshes() {
    for (case, more, unknowns) in [
        ("fluid_pressure/case_cohesive.yaml", "mesh.refine=3", 48.0),
        ("laws/exponential_softening.yaml", "mesh.refine=3", 48.0),
        ("layered/case.yaml", "mesh.refine=3", 60.0),
        ("two_interfaces/case.yaml", "mesh.refine=3", 72.0),
        ("v101359/case.yaml", "mesh.refine=3", 48.0),
    ] {
        same(&Scene::shipped(case).set(more), 2, unknowns);
    }
}

#[test]
fn rollers_weight_and_two_rocks() {
    // Straight between the ends of each rock: 3 layers of 4 nodes more than bodies.
    same(&column("[7, 6, 9]", ROLLERS), 2, 60.0);
    let weight = format!("{ROLLERS}gravity: [0, 0, -9.81]\n");
    same(&column("[7, 6, 9]", &weight), 2, 4.0 * 21.0 * 3.0);
    let load = format!("{ROLLERS}body_force: {{z: {{table: [[0, 0], [4, -1.0e4]]}}}}\n");
    same(&column("[7, 6, 9]", &load).set("mesh.order=2"), 1, 9.0 * 40.0 * 3.0);
}

/// Free to contract on two sides, so that the section stretches evenly.
#[test]
fn a_column_that_contracts() {
    let free = "boundary:
  - {on: bottom, displacement: {z: 0}}
  - {on: left, displacement: {x: 0}}
  - {on: front, displacement: {y: 0}}
  - {on: top, displacement: {z: {table: [[0, 0], [1, -1.0e-4], [2, 5.0e-4], [3, 1.5e-3]]}}}
time: {instants: [1, 2, 3]}
physics: mechanics
";
    let rock = "materials={rock: {elastic: {young_modulus: 6.0e9, poisson_ratio: 0.3}}}";
    same(&column("[7, 7, 9]", free).set(rock), 2, 48.0);
    // Two rocks contract differently: nothing is uniform.
    refused(&column("[7, 7, 9]", free), "vary across the section");
}

/// Clamped at the ends, nothing moves along y: a slice.
const SLICE: &str = "boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}
  - {on: front, displacement: {y: 0}}
  - {on: back, displacement: {y: 0}}
  - {on: top, displacement: {x: 0, y: 0, z: {table: [[0, 0], [1, -1.0e-4], [2, 2.0e-4]]}}}
time: {instants: [1, 2]}
physics: mechanics
";

#[test]
fn plane_strain_is_solved_in_a_slice() {
    same(&column("[6, 10, 6]", SLICE).set("solver.tolerance=1e-8"), 2, 7.0 * 2.0 * 15.0 * 3.0);
}

/// The figures of docs/theory.md, section 8; with --nocapture.
#[test]
#[ignore = "ten seconds, for its figures"]
#[allow(clippy::print_stdout)]
fn the_bound_of_an_uneven_state_grows_with_the_mesh() {
    let rock = "materials={rock: {elastic: {young_modulus: 4.0e9, poisson_ratio: 0.2}}}";
    let bounds = [6, 16, 24, 32].map(|n| {
        let scene = column(&format!("[{n}, {n}, {}]", 2 * n), SLICE).set(rock);
        let run = scene.reduced().on(1);
        println!("{n}: {}", run.report["reduction"]);
        run.report["reduction"]["error_bound"].as_f64()
    });
    assert!(bounds[..3].is_sorted() && bounds[..3].iter().all(Option::is_some), "{bounds:?}");
    assert_eq!(bounds[3], None, "above the tolerance, which the reason tells");
}

/// The model asked for is solved, and told why.
fn refused(scene: &Scene, words: &str) {
    let run = scene.reduced().in_any_steps().on(2);
    let reduction = &run.report["reduction"];
    assert_eq!(reduction["applied"], false, "{}", run.screen);
    let why = reduction["why"].as_str().expect("words");
    assert!(why.contains(words), "{why}, not {words}");
    // Every rank finds out by itself, and none is named.
    assert!(!why.contains("rank"), "{why}");
    assert!(run.screen.contains(why), "{}", run.screen);
}

#[test]
fn what_could_differ_across_the_section_is_not_reduced() {
    let tilted = "boundary.1.displacement.z={formula: 2.0e-4*t*(1 + 0.1*(x-0.5))}";
    let short = "time.instants=[1, 2, 3]";
    refused(&reference().set("expect=[]").set(short).set(tilted), "displacement of top varies");
    let equal = Scene::shipped("stability/two_equal_interfaces.yaml");
    let equal = equal.set("solver.stability=auto").set("expect=[]");
    let cells = equal.set("mesh.column.cells=[8, 8, 18]");
    refused(&cells, "lower and upper could both soften");
    // Weaker by a thousandth: only one opens, but the softening takes too much.
    let slender = reference().set("mesh.column.size=[1, 1, 8]").set("expect=[]").set("probes=[]");
    refused(&slender.set("interfaces.0.z=4"), "may open unevenly");
    refused(&reference().set("materials.rock.elastic.poisson_ratio=0.2").set("expect=[]"), "vary");
    let sheared = "boundary.1.displacement.x={table: [[0, 0], [3, 1.0e-3]]}";
    refused(&reference().set("expect=[]").set(short).set(sheared), "vary across");
}

/// A run stopped between two instants goes on, with the model asked for, to the same end.
#[test]
fn a_stop_leaves_a_checkpoint_of_the_mesh_asked_for() {
    let scene = reference().set("output.fields=none").in_any_steps();
    let full = scene.set("solver.tolerance=1e-11").on(1);
    for instant in [1, 4] {
        let run = scene.reduced().stopped(2, &format!("history:1:term:{instant}"), 1);
        assert_eq!(run.report["reduction"]["applied"], false);
        full.assert_same(&run, 1e-9);
    }
    // Checkpoints at every instant, the last one too.
    let directory = fresh();
    let every = scene.set("output.checkpoint={every: 1 instant}").reduced();
    let output = every.launch(2, &directory, "", &["--overwrite"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(directory.join("checkpoint.h5").is_file());
}
