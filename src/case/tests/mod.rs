//! Tests of the reader: good cases, overrides, what is left out; mistakes have their own file.

mod accuracy;
mod built;
mod cracks;
mod file_mesh;
mod flow;
mod limits;
mod mistakes;
mod places_and_names;
mod rigid;
mod shipped;
mod stability;
mod stages;
mod stress;

use super::*;

/// A small case in 3D; line 8 is the interface.
pub(super) const GOOD: &str = "\
mesh:
  column: {size: [1, 1, 5], cells: [1, 1, 5]}
materials:
  rock:
    elastic: {young_modulus: 5.8e9, poisson_ratio: 0}
interfaces:
  - name: joint
    z: 2.5
    law: {linear_softening: {strength: 1.1e6, fracture_energy: 900}}
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}
  - {on: top, displacement: {x: 0, y: 0, z: {table: [[0, 0], [1, 1.0e-4]]}}}
time: {instants: [1, 2]}
probes: [{name: mid, at: [0.5, 0.5, 1.25]}]
expect:
  - {quantity: joint.normal_traction, at: 1, equals: 116000, relative: 1.0e-9}
";

/// Reads `GOOD` with `from` replaced by `to`, with overrides.
pub(super) fn read_with(from: &str, to: &str, overrides: &[&str]) -> Result<Case> {
    assert!(GOOD.contains(from), "{from}");
    let overrides: Vec<String> = overrides.iter().map(|one| (*one).to_owned()).collect();
    Case::read(&GOOD.replacen(from, to, 1), Path::new("case.yaml"), &overrides)
}

fn good(overrides: &[&str]) -> Case {
    read_with("mesh", "mesh", overrides).expect("a good case")
}

#[test]
fn a_case_gets_its_defaults() {
    let case = good(&[]);
    assert_eq!((case.title.as_str(), case.dim, case.start), ("case", 3, 0.0));
    let column = case.mesh.column().expect("a column");
    assert_eq!(column.cells, Cells::Uniform([1, 1, 5]));
    assert_eq!(case.output.directory, Path::new("results/case"));
    assert_eq!(case.output.fields, Fields::All);
    assert_eq!(case.solver, SolverSpec::default());
    assert_eq!((case.solver.tolerance, case.solver.max_newton), (1.0e-9, 30));
    let LawSpec::LinearSoftening(law) = &case.interfaces[0].law else { panic!("the law") };
    assert_eq!((law.strength, law.fracture_energy, law.augmentation), (1.1e6, 900.0, 10.0));
    assert_eq!(case.boundary[1].displacement[2].as_ref().map(|z| z.at([0.0; 3], 0.5)), Some(5e-5));
    assert_eq!((case.expect[0].relative, case.expect[0].absolute), (1e-9, 0.0));
    assert!(case.left_out.is_empty());
}

#[test]
fn the_columns_are_those_of_the_contract() {
    let interface = |tangents: &[&str]| -> Vec<String> {
        let mut names = vec!["joint.normal_traction".to_owned()];
        names.extend(tangents.iter().map(|axis| format!("joint.shear_traction_{axis}")));
        names.push("joint.normal_jump".to_owned());
        names.extend(tangents.iter().map(|axis| format!("joint.sliding_{axis}")));
        names.push("joint.damage".to_owned());
        names.iter().flat_map(|n| ["min", "max", "mean"].map(|s| format!("{n}.{s}"))).collect()
    };
    let all = |tangents: &[&str], rest: &[&str]| -> Vec<String> {
        let first = ["time", "load_factor", "newton_iterations", "linear_iterations"];
        let own = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
        let last = ["energy.elastic", "energy.dissipated", "energy.external"];
        let forces = tangents.iter().chain(&["z"]).map(|axis| format!("joint.force_{axis}"));
        let totals = forces.chain(["joint.area".to_owned()]).collect();
        [own(&first), interface(tangents), totals, own(rest), own(&last)].concat()
    };
    let again = "boundary.2={on: top, displacement: {x: 0}}";
    let rest = [
        "bottom.reaction_x",
        "bottom.reaction_y",
        "bottom.reaction_z",
        "top.reaction_x",
        "top.reaction_y",
        "top.reaction_z",
        "total.reaction_x",
        "total.reaction_y",
        "total.reaction_z",
        "mid.displacement_x",
        "mid.displacement_y",
        "mid.displacement_z",
    ];
    assert_eq!(good(&[again]).columns(), all(&["x", "y"], &rest));
    let flat = good(&[
        "mesh.column={size: [1, 5], cells: [1, 5]}",
        "boundary.0.displacement.y=",
        "boundary.1.displacement.y=",
        "probes.0.at=[0.5, 1.25]",
    ]);
    assert_eq!((flat.dim, flat.probes[0].at), (2, [0.5, 0.0, 1.25]));
    let rest = [
        "bottom.reaction_x",
        "bottom.reaction_z",
        "top.reaction_x",
        "top.reaction_z",
        "total.reaction_x",
        "total.reaction_z",
        "mid.displacement_x",
        "mid.displacement_z",
    ];
    assert_eq!(flat.columns(), all(&["x"], &rest));
    let quantities = flat.quantities();
    assert!(quantities.contains(&"joint.damage".to_owned()));
    assert!(quantities.contains(&"joint.damage.mean".to_owned()));
    assert!(!quantities.contains(&"bottom".to_owned()));
}

#[test]
fn overrides_set_append_create_and_take_away() {
    let case = good(&[
        "title=Other",
        "boundary.1.displacement.z=-3.0e-4",
        "solver.linear=gamg",
        "solver.max_newton=7",
        "boundary.2={on: right, traction: {z: {formula: \"2*t\"}}}",
        "probes=",
        "output.fields=[2, 1]",
    ]);
    assert_eq!(case.title, "Other");
    assert_eq!(case.boundary[1].displacement[2], Some(Value::Constant(-3.0e-4)));
    assert_eq!((case.solver.linear, case.solver.max_newton), (Linear::Gamg, 7));
    assert_eq!(case.boundary[2].on, Surface::Right);
    assert_eq!(case.boundary[2].traction[2].as_ref().map(|z| z.at([0.0; 3], 3.0)), Some(6.0));
    assert!(case.probes.is_empty());
    assert_eq!(case.output.fields, Fields::Times(vec![1.0, 2.0]));
}

#[test]
fn the_resolved_case_is_a_case_file_that_reads_the_same() {
    let porous = "materials.rock.porous={biot: 1, porosity: 0.15, permeability: 1.0e-19, \
                  viscosity: 1.0e-3, fluid_compressibility: 5.0e-10, fluid_density: 1, density: 2.5}";
    let case = good(&[porous, "physics=mechanics"]);
    let resolved = case.resolved();
    assert_eq!(resolved["solver"]["tolerance"], 1.0e-9);
    assert_eq!(resolved["output"]["directory"], "results/case");
    assert_eq!(resolved["interfaces"][0]["law"]["linear_softening"]["augmentation"], 10.0);
    assert_eq!(resolved["physics"], "mechanics");
    let again = Case::read(&resolved.to_string(), Path::new("elsewhere.yaml"), &[]);
    assert_eq!(again, Ok(case));
}

#[test]
fn what_changes_nothing_is_left_out_with_its_reason() {
    let porous = "materials.rock.porous={biot: 1, porosity: 0.15, permeability: 1.0e-19, \
                  viscosity: 1.0e-3, fluid_compressibility: 5.0e-10, fluid_density: 1, density: 2.5}";
    let known = good(&[porous, "boundary.2={on: all, pressure: 0}"]);
    assert_eq!(known.physics, PhysicsDecision::Mechanics);
    assert_eq!(
        known.left_out,
        ["Pore pressure and flow are left out, and the porous data of rock with it: the pressure \
          is prescribed as 0 on all nodes, so it changes nothing."]
    );
    let asked = good(&[porous, "physics=mechanics", "gravity=[0, 0, 0]"]);
    assert_eq!(
        asked.left_out,
        [
            "Gravity is left out: it is 0.",
            "Pore pressure and flow are left out, and the porous data of rock with it: the case \
             asks for mechanics.",
        ]
    );
    let cold = good(&["materials.rock.elastic.thermal_expansion=0", "initial.pressure=0"]);
    assert_eq!(
        cold.left_out,
        [
            "Thermal strain is left out: the thermal expansion of rock is 0.",
            "Pore pressure is left out: it is 0 wherever it is prescribed and no material is \
             porous.",
        ]
    );
}

#[test]
fn several_materials_are_sorted_by_height() {
    let elastic = "elastic: {young_modulus: 1.0e9, poisson_ratio: 0.2}";
    let upper = format!("materials.basalt={{z: [2, 5], {elastic}}}");
    let case = good(&["materials.rock.z=[0, 2]", &upper]);
    let names: Vec<&str> = case.materials.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(names, ["rock", "basalt"]);
}
