//! Cases that are built in code: the same as those of files, checked alike.

use super::super::sections::*;
use super::shipped::shipped;
use super::*;
use crate::law::{
    BenzeggaghKenane, Bilinear, Contact, ExponentialSoftening, LinearSoftening, Tied,
};

fn read(text: &str) -> Case {
    Case::read(text, Path::new("case.yaml"), &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn refusal(sections: CaseFile) -> String {
    Case::build(sections).expect_err("a refusal").to_string()
}

/// The column of `GOOD`.
fn column() -> CaseFile {
    let held = || Components::xyz(0.0, 0.0, 0.0);
    CaseFile::new(
        MeshSection::column([1.0, 1.0, 5.0], [1, 1, 5]),
        TimeSection::instants([1.0, 2.0]),
    )
    .material("rock", MaterialSection::elastic(5.8e9, 0.0))
    .interface(InterfaceSection::new("joint", 2.5, LinearSoftening::new(1.1e6, 900.0)))
    .boundary(BoundarySection::on(Surface::Bottom).displacement(held()))
    .boundary(BoundarySection::on(Surface::Top).displacement(held().z([[0.0, 0.0], [1.0, 1.0e-4]])))
    .probe(ProbeSection::new("mid", [0.5, 0.5, 1.25]))
    .expect(ExpectSection::new("joint.normal_traction", 1.0, 116000.0).relative(1.0e-9))
}

#[test]
fn what_is_built_in_code_is_what_a_file_says() {
    assert_eq!(Case::build(column()), Ok(read(GOOD)));
}

#[test]
fn every_shipped_case_can_be_built_of_its_sections() {
    for file in shipped() {
        let text = read_text(&file).expect("a readable case");
        let read = |set: &[String]| {
            Case::read(&text, &file, set).unwrap_or_else(|error| panic!("{error}"))
        };
        let mut case = read(&[]);
        // A case in code has no folder from which the name of its mesh file goes on.
        if let Some(mesh) = case.mesh.file() {
            case = read(&[format!("mesh.file={}", mesh.path.display())]);
        }
        let sections: CaseFile =
            serde_json::from_value(case.resolved()).expect("the sections of a case");
        assert_eq!(&sections, case.sections(), "{}", file.display());
        assert_eq!(Case::build(sections), Ok(case), "{}", file.display());
    }
}

#[test]
fn every_key_can_be_built() {
    let text = "\
title: all keys
mesh:
  column: {size: [2, 5], bodies: [{cells: [2, 4], order: 2}, {cells: [3, 6]}, {cells: [1, 1]}]}
  refine: 1
  formulation: b_bar
materials:
  clay:
    z: [0, 3]
    elastic: {young_modulus: 1.0e9, poisson_ratio: 0.3}
    porous: {biot: 1, porosity: 0.2, permeability: 1.0e-15, viscosity: 1.0e-3,
             fluid_compressibility: 5.0e-10, fluid_density: 1000, density: 2000}
  rock:
    z: [3, 5]
    elastic: {young_modulus: 5.8e9, poisson_ratio: 0.2}
    porous: {biot: 1, porosity: 0.2, permeability: 1.0e-15, viscosity: 1.0e-3,
             fluid_compressibility: 5.0e-10, fluid_density: 1000, density: 2000}
interfaces:
  - {name: lower, z: 1, law: {tied: {}}, secondary: upper}
  - name: joint
    z: 3
    law: {exponential_softening: {strength: 1.1e6, fracture_energy: 900}}
    fluid: {flow: true, injection: {table: [[1, 0], [3, 1.0e-6]]}}
boundary:
  - {on: bottom, displacement: {x: 0, z: 0}}
  - {on: left, pressure: {formula: 1e5*t}}
  - {on: top, traction: {z: 1.0e5}, flux: 1.0e-9}
gravity: [0, -9.81]
body_force: {x: 10}
initial: {pressure: {formula: 1e4*(5 - z)}, equilibrium: true, imperfection: [{interface: joint, factor: {formula: 1 - 0.01*x}}]}
time: {instants: [2, 3], start: 1, theta: 0.6, tolerance: 0.01}
physics: hydro_mechanics
solver: {tolerance: 1.0e-8}
reduce: never
output: {directory: results/keys, fields: [3], checkpoint: {every: 5 instants}}
limits: {wall: 2 h}
expect: [{quantity: joint.damage.mean, at: 3, equals: 0, absolute: 1}]
";
    let porous = Porous {
        biot: 1.0,
        porosity: 0.2,
        permeability: 1.0e-15,
        viscosity: 1.0e-3,
        fluid_compressibility: 5.0e-10,
        fluid_density: 1000.0,
        density: 2000.0,
        reference_pressure: 0.0,
    };
    let bodies = [
        BodySection::cells([2, 4]).order(2),
        BodySection::cells([3, 6]),
        BodySection::cells([1, 1]),
    ];
    let material =
        |modulus, ratio, z| MaterialSection::elastic(modulus, ratio).z(z).porous(porous.clone());
    let water = FluidSection::injection([[1.0, 0.0], [3.0, 1.0e-6]]);
    let built = CaseFile::new(
        MeshSection::bodies([2.0, 5.0], bodies).refine(1).formulation(Formulation::BBar),
        TimeSection::instants([2.0, 3.0]).start(1.0).theta(0.6).tolerance(0.01),
    )
    .title("all keys")
    .material("clay", material(1.0e9, 0.3, [0.0, 3.0]))
    .material("rock", material(5.8e9, 0.2, [3.0, 5.0]))
    .interface(InterfaceSection::new("lower", 1.0, Tied {}).secondary(Side::Upper))
    .interface(
        InterfaceSection::new("joint", 3.0, ExponentialSoftening::new(1.1e6, 900.0)).fluid(water),
    )
    .boundary(BoundarySection::on(Surface::Bottom).displacement(Components::xz(0.0, 0.0)))
    .boundary(BoundarySection::on(Surface::Left).pressure("1e5*t"))
    .boundary(
        BoundarySection::on(Surface::Top).traction(Components::default().z(1.0e5)).flux(1.0e-9),
    )
    .gravity([0.0, -9.81])
    .body_force(Components::default().x(10.0))
    .initial(InitialSection {
        pressure: Some("1e4*(5 - z)".into()),
        equilibrium: true,
        stress: None,
        imperfection: vec![ImperfectionSection::new("joint", "1 - 0.01*x")],
    })
    .physics(Physics::HydroMechanics)
    .solver(SolverSpec { tolerance: 1.0e-8, ..SolverSpec::default() })
    .reduce(Reduce::Never)
    .output(
        OutputSection::default()
            .directory("results/keys")
            .fields(vec![3.0])
            .checkpoint("5 instants"),
    )
    .limits(LimitsSection::wall("2 h"))
    .expect(ExpectSection::new("joint.damage.mean", 3.0, 0.0).absolute(1.0));
    assert_eq!(Case::build(built), Ok(read(text)));
}

#[test]
fn paths_and_laws_can_be_built() {
    let with = |law: LawSpec, control: Option<ControlSection>| {
        let mut sections = column();
        sections.interfaces[0].law = law;
        // A load factor does not scale a fluid.
        let fluid = FluidSection::pressure(1.0e3).connected(false);
        sections.interfaces[0].fluid = control.is_none().then_some(fluid);
        sections.control = control;
        sections.output = sections.output.fields(FieldsWord::None);
        sections.expect.clear();
        sections
    };
    let opening = ControlSection::opening("joint", [[0.0, 0.0], [2.0, 1.0e-3]]);
    let laws: [(LawSpec, Option<ControlSection>, &str); 5] = [
        (
            LinearSoftening::new(1.0e6, 900.0).into(),
            Some(opening),
            "control={opening: {of: joint, equals: {table: [[0, 0], [2, 1.0e-3]]}}}",
        ),
        (
            Bilinear::new(1.0e6, 900.0, 1.0e12).into(),
            None,
            "interfaces.0.law={bilinear: {strength: 1.0e6, fracture_energy: 900, stiffness: 1.0e12}}",
        ),
        (
            BenzeggaghKenane::new([1.0e6, 2.0e6], [900.0, 1800.0], 2.0).into(),
            None,
            "interfaces.0.law={benzeggagh_kenane: {strength: 1.0e6, shear_strength: 2.0e6, \
             fracture_energy: 900, shear_fracture_energy: 1800, exponent: 2}}",
        ),
        (Contact::default().into(), None, "interfaces.0.law={contact: {}}"),
        (
            ExponentialSoftening::new(1.0e6, 900.0).into(),
            Some(ControlSection::dissipation("joint", 0.1)),
            "control={dissipation: {of: joint, step: 0.1}}",
        ),
    ];
    for (law, control, words) in laws {
        let name = law.name();
        let fluid = if control.is_some() { "" } else { "{pressure: 1.0e3}" };
        let sections = with(law, control);
        let changes = [
            format!("interfaces.0.law={{{name}: {{strength: 1.0e6, fracture_energy: 900}}}}"),
            format!("interfaces.0.fluid={fluid}"),
            "output.fields=none".to_owned(),
            "expect=".to_owned(),
            words.to_owned(),
        ];
        let read = Case::read(GOOD, Path::new("case.yaml"), &changes);
        assert_eq!(Case::build(sections), read, "{name}");
    }
}

#[test]
fn all_mistakes_are_told_at_once_with_their_paths() {
    let mut sections = column();
    sections.materials.insert("wrong name".into(), MaterialSection::elastic(-1.0, 0.2));
    sections.interfaces[0].z = Some(f64::NAN);
    sections.boundary[1] = BoundarySection::on(Surface::Top);
    sections.expect[0].quantity = "joint.normal_tracton".into();
    let told = refusal(sections);
    let lines: Vec<&str> = told.lines().collect();
    let beginnings = [
        "boundary.1 prescribes nothing",
        "interfaces.0.z must be finite",
        "materials.wrong name.elastic.young_modulus must be positive, got -1",
    ];
    assert_eq!(lines.len(), beginnings.len(), "{told}");
    for (line, beginning) in lines.iter().zip(beginnings) {
        assert!(line.starts_with(beginning), "{line}");
    }
    let mut sections = column();
    sections.expect[0].quantity = "joint.normal_tracton".into();
    sections.materials.insert("wrong name".into(), MaterialSection::elastic(1.0, 0.2));
    let told = refusal(sections);
    assert!(
        told.contains("expect.0.quantity cannot be `joint.normal_tracton`; did you mean"),
        "{told}"
    );
    assert!(told.contains("materials.wrong name must be made of letters"), "{told}");
}

#[test]
fn what_a_file_may_not_hold_is_refused() {
    let told = refusal(column().title("\u{1b}[2J"));
    assert!(told.starts_with("title: a text holds the control character"), "{told}");
    let table: Vec<[f64; 2]> = (0..100_000).map(|i| [f64::from(i) / 3.0, 1.0 / 3.0]).collect();
    let loads = Components::xyz(table.clone(), table.clone(), table);
    let told = refusal(column().boundary(BoundarySection::on(Surface::Right).traction(loads)));
    assert!(told.starts_with("the case: its sections have"), "{told}");
}
