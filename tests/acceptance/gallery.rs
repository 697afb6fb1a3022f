//! The shipped cases with a mesh from a file, on ranks and with solvers that the page of verified
//! quantities does not take: they meet every expectation.

use crate::scene::Scene;

fn check(case: &str, solver: &str, ranks: usize, least_expectations: usize) {
    let mut scene = Scene::shipped(case).set(&format!("solver.linear={solver}")).in_any_steps();
    if ranks > 2 {
        scene = scene.scattered();
    }
    let run = scene.on(ranks);
    assert_eq!(run.report["status"], "done", "{}", run.label);
    let expectations = run.report["expectations"].as_array().expect("a list");
    assert!(expectations.len() >= least_expectations, "{}", run.label);
    assert!(expectations.iter().all(|e| e["met"] == true), "{}", run.label);
}

#[test]
fn joints_that_lean_and_cross() {
    check("inclined_joint/case.yaml", "gamg", 2, 39);
    check("inclined_joint/contact.yaml", "hypre", 4, 13);
    check("crossing_joints/case.yaml", "hypre", 2, 54);
    check("crossing_joints/contact.yaml", "gamg", 4, 25);
    check("brick_wall/case.yaml", "gamg", 4, 64);
    check("brick_wall/case.yaml", "aggregation", 3, 64);
    check("crossing_joints/contact.yaml", "aggregation", 1, 25);
}

#[test]
fn an_inclusion_a_beam_and_a_dam() {
    check("circular_inclusion/case.yaml", "gamg", 2, 12);
    check("circular_inclusion/contact.yaml", "mumps", 4, 12);
    check("double_cantilever/opening.yaml", "hypre", 2, 4);
    check("gravity_dam/uplift.yaml", "gamg", 4, 9);
    check("circular_inclusion/contact.yaml", "aggregation", 3, 12);
    check("double_cantilever/opening.yaml", "aggregation", 2, 4);
}

#[test]
fn beams_that_delaminate() {
    check("notched_beam/end_notched_flexure.yaml", "mumps", 4, 14);
    check("notched_beam/mixed_mode_bending.yaml", "mumps", 2, 11);
}

#[test]
fn a_cylinder_and_a_ball_on_a_flat_block() {
    check("hertz/cylinder.yaml", "gamg", 2, 5);
    check("hertz/sphere.yaml", "gamg", 4, 5);
}
