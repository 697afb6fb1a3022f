//! Why the model asked for is solved itself, as far as the case tells.

use crate::case::{Case, Form, Linear, Reduce, Stability, Value};

/// That two interfaces both soften, in words. Local.
pub fn both_could_soften(first: &str, second: &str) -> String {
    format!("{first} and {second} could both soften: what is left out decides which of them opens")
}

/// Models with fewer unknowns take no longer than a proof about them.
const FEWEST_UNKNOWNS: u64 = 3000;

/// What else matters beside the case.
#[derive(Debug, Clone, Copy)]
pub struct Situation {
    /// Unknowns of the model asked for.
    pub unknowns: u64,
    /// Whether the run goes on from a checkpoint.
    pub goes_on: bool,
    /// Whether the command line or the environment has options for PETSc.
    pub has_options: bool,
    /// Whether the case has stages.
    pub has_stages: bool,
}

/// Why no smaller model is tried, in words; none if one is. Local.
pub fn refusal(case: &Case, situation: Situation) -> Option<String> {
    let Situation { unknowns, goes_on, has_options, has_stages } = situation;
    let solver = &case.solver;
    let says = |text: &str| Some(text.to_owned());
    if case.reduce == Reduce::Never {
        return says("reduce: never");
    }
    if has_stages {
        return says("the case has stages");
    }
    // Where an accuracy is asked for, the proof spares the search for a mesh.
    if unknowns < FEWEST_UNKNOWNS && case.sections().accuracy.is_none() {
        return says("the model is small as it is");
    }
    if goes_on {
        return says("the run goes on from a checkpoint");
    }
    if solver.linear != Linear::Auto || solver.form != Form::Condensed {
        return says("solver names how the equations are solved");
    }
    if has_options || !solver.petsc_options.trim().is_empty() {
        return says("options for PETSc are given");
    }
    if !matches!(solver.stability, Stability::Auto | Stability::Off) {
        return says("solver.stability asks for tests of the model");
    }
    if case.has_pressure() {
        return says("a pore pressure acts");
    }
    if case.initial_stress.is_some() {
        return says("stresses are there at the start");
    }
    if let Some(interface) = case.interfaces.iter().find(|i| i.has_friction()) {
        return Some(format!("{} slides with friction", interface.name));
    }
    if case.control.is_some() {
        return says("a path is followed");
    }
    if let Some(surface) = case.rigid_surfaces().first() {
        return Some(format!("{} moves as a rigid body", surface.name()));
    }
    if let Some(imperfection) = case.imperfections.first() {
        let name = &case.interfaces[imperfection.interface].name;
        return Some(format!("{name} has an imperfection"));
    }
    if let Some(interface) = case.interfaces.iter().find(|i| i.initial.gap.is_some()) {
        return Some(format!("{} has a gap at the start", interface.name));
    }
    if let Some(material) = case.materials.iter().find(|m| case.has_mean_dilatation(m)) {
        return Some(format!("no bound is known for the B-bar cells of {}", material.name));
    }
    varying(case).map(|what| format!("{what} varies in space"))
}

/// The first value that varies in space, in words.
fn varying(case: &Case) -> Option<String> {
    let varies = |values: &[Option<Value>; 3]| values.iter().flatten().any(Value::varies_in_space);
    for entry in &case.boundary {
        for (what, values) in
            [("the displacement", &entry.displacement), ("the traction", &entry.traction)]
        {
            if varies(values) {
                return Some(format!("{what} of {}", entry.on.name()));
            }
        }
    }
    if case.body_force.iter().any(Value::varies_in_space) {
        return Some("the body force".into());
    }
    let cracked = |i: &&crate::case::InterfaceSpec| {
        i.initial.damage.as_ref().is_some_and(Value::varies_in_space)
    };
    if let Some(interface) = case.interfaces.iter().find(cracked) {
        return Some(format!("the damage of {} at the start", interface.name));
    }
    let fluid = |i: &&crate::case::InterfaceSpec| {
        i.fluid_pressure.as_ref().is_some_and(Value::varies_in_space)
    };
    case.interfaces.iter().find(fluid).map(|i| format!("the fluid pressure of {}", i.name))
}

/// The values at `time` of all that loads the bodies, which is the same everywhere. Local.
pub(super) fn loads_at(case: &Case, time: f64) -> Vec<f64> {
    let tractions = case.boundary.iter().flat_map(|entry| entry.traction.iter().flatten());
    let fluid = case.interfaces.iter().filter_map(|i| i.fluid_pressure.as_ref());
    // Gravity does not change, and is there at all times.
    let values = tractions.chain(&case.body_force).chain(fluid);
    let weight = case.gravity.iter().copied();
    values.map(|value| value.at([0.0; 3], time)).chain(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn case(more: &str, sets: &[&str]) -> Case {
        let yaml = format!(
            "mesh: {{column: {{size: [1, 1, 5], cells: [16, 16, 16]}}}}\n\
             materials: {{rock: {{elastic: {{young_modulus: 1.0e9, poisson_ratio: 0.0}}}}}}\n\
             interfaces: [{{name: joint, z: 2.5, law: {{linear_softening: {{strength: 1.0e6, \
             fracture_energy: 900}}}}}}]\n\
             boundary:\n  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}\n  \
             - {{on: top, displacement: {{z: {{table: [[0, 0], [1, 1.0e-3]]}}}}}}\n\
             time: {{instants: [1]}}\n{more}"
        );
        let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
        Case::read(&yaml, Path::new("t.yaml"), &sets).expect("a case")
    }

    #[test]
    fn reasons_are_told_in_words() {
        let situation =
            Situation { unknowns: 5000, goes_on: false, has_options: false, has_stages: false };
        assert_eq!(refusal(&case("", &[]), situation), None);
        let imperfection = "initial: {imperfection: [{interface: joint, factor: 0.9}]}";
        for (case, situation, words) in [
            (case("reduce: never", &[]), situation, "reduce: never"),
            (case("", &[]), Situation { unknowns: 100, ..situation }, "small"),
            (case("", &[]), Situation { goes_on: true, ..situation }, "checkpoint"),
            (case("", &[]), Situation { has_options: true, ..situation }, "PETSc"),
            (case("", &[]), Situation { has_stages: true, ..situation }, "stages"),
            (case("", &["solver.linear=gamg"]), situation, "solver names"),
            (case("", &["solver.petsc_options=-ksp_monitor"]), situation, "PETSc"),
            (case("", &["solver.stability=warn"]), situation, "solver.stability"),
            (case(imperfection, &[]), situation, "joint has an imperfection"),
            (
                case("", &["materials.rock.elastic.poisson_ratio=0.49"]),
                situation,
                "B-bar cells of rock",
            ),
            (
                case("", &["boundary.1.displacement.z={formula: 1e-3*x}"]),
                situation,
                "the displacement of top varies in space",
            ),
            (case("", &["body_force.z={formula: z}"]), situation, "the body force varies"),
            (
                case("", &["interfaces.0.initial.damage={formula: x < 0.5}"]),
                situation,
                "the damage of joint at the start varies in space",
            ),
            (
                case(
                    "",
                    &[
                        "interfaces.0.initial={damage: 1, gap: 1.0e-4}",
                        "boundary.1.displacement={x: 0, y: 0, z: 1.0e-3}",
                    ],
                ),
                situation,
                "joint has a gap at the start",
            ),
        ] {
            let found = refusal(&case, situation).unwrap_or_default();
            assert!(found.contains(words), "{found}: {words}");
        }
    }

    #[test]
    fn a_load_that_is_the_same_everywhere_does_not_vary() {
        let situation =
            Situation { unknowns: 5000, goes_on: false, has_options: false, has_stages: false };
        let case = case("", &["boundary.1.displacement.z={formula: 1e-3*t}", "body_force.z=2"]);
        assert_eq!(refusal(&case, situation), None);
        assert_eq!(loads_at(&case, 1.0), [0.0, 0.0, 2.0, 0.0, 0.0, 0.0]);
    }
}
