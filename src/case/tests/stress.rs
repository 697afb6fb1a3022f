//! Stresses at the start.

use super::mistakes::message;
use super::read_with;

#[test]
fn stresses_at_the_start_have_a_row_of_their_own() {
    let stress = "initial={stress: {zz: -1.0e6, xx: {formula: \"-1e5*z\"}}}";
    let expect = "expect.0.at=0";
    let case = read_with("mesh", "mesh", &[stress, expect]).expect("a good case");
    let spec = case.initial_stress.as_ref().expect("stresses");
    let given: Vec<bool> = spec.components.iter().map(Option::is_some).collect();
    assert_eq!(given, [true, false, true, false, false, false]);
    assert!(spec.at_rest.is_none() && case.starts_in_equilibrium());
    assert_eq!(case.load_times(), [0.0, 1.0, 2.0]);
}

#[test]
fn the_vertical_lies_along_gravity() {
    let dense = "materials.rock.elastic.density=2500";
    for (gravity, vertical) in [("[0, 0, -10]", 2), ("[10, 0, 0]", 0), ("[0, -1, 0]", 1)] {
        let sets = [dense, &format!("gravity={gravity}"), "initial={stress: {k0: 0.5}}"];
        let case = read_with("mesh", "mesh", &sets).expect("a good case");
        let spec = case.initial_stress.expect("stresses");
        assert_eq!(spec.at_rest.map(|rest| rest.vertical), Some(vertical));
    }
    let given = "initial={stress: {zz: -1.0e5, k0: {formula: \"1 - x\"}}}";
    assert!(read_with("mesh", "mesh", &[given]).is_ok());
}

#[test]
fn mistakes_in_stresses_at_the_start_are_told() {
    let dense = "materials.rock.elastic.density=2500";
    for (sets, words) in [
        (vec!["initial={stress: {}}"], "initial.stress has no entries"),
        (
            vec!["initial={stress: {zz: {table: [[0, 1]]}}}"],
            "initial.stress.zz is of the start alone: give a number, a formula",
        ),
        (vec!["initial={stress: {xy: {formula: t}}}"], "initial.stress.xy.formula uses t"),
        (vec!["initial={stress: {k0: 0.5}}"], "needs the vertical stress: that of gravity"),
        (
            vec!["initial={stress: {k0: -0.5, zz: -1}}"],
            "initial.stress.k0 must not be negative, got -0.5",
        ),
        (
            vec!["initial={stress: {k0: 0.5, xx: 1, yy: 1, zz: 1}}"],
            "has nothing to give: all horizontal stresses are given",
        ),
        (
            vec![dense, "gravity=[1, 0, -10]", "initial={stress: {k0: 0.5}}"],
            "needs gravity along one axis",
        ),
        (
            vec![
                "control={opening: {of: joint, equals: {formula: t}}}",
                "initial={stress: {zz: 1}}",
            ],
            "initial.stress cannot stand beside control",
        ),
    ] {
        let text = message("mesh", "mesh", &sets);
        assert!(text.contains(words), "{text}: {words}");
    }
    let flat = "mesh.column={size: [1, 5], cells: [1, 5]}";
    let text = message("mesh", "mesh", &[flat, "initial={stress: {xy: 1}}"]);
    assert!(text.contains("initial.stress.xy does not exist in 2D"), "{text}");
}
