//! Meshes that are found for a wanted accuracy, cells that grow, and zones that are not resolved.

use crate::scene::Scene;

/// A clamped block, pulled unevenly: its corners are singular.
const TILTED: &str = "
mesh: {column: {size: [1, 4]}}
materials: {rock: {elastic: {young_modulus: 5.8e9, poisson_ratio: 0.3}}}
interfaces: [{name: joint, z: 2, law: {linear_softening: {strength: 1.1e6, fracture_energy: 900}}}]
boundary:
  - {on: bottom, displacement: {x: 0, z: 0}}
  - {on: top, displacement: {x: 0, z: {formula: \"3e-4*t*(1 + 0.4*(x-0.5))\"}}}
time: {instants: [1]}
";

/// Its mean traction, of a search for 2e-5 (Pa).
const MEAN: f64 = 4.83843e5;

fn wanted(relative: &str) -> String {
    format!("accuracy={{of: [joint.normal_traction.mean, top.reaction_z], relative: {relative}}}")
}

#[test]
fn the_error_is_what_was_estimated_and_within_what_was_asked_on_any_ranks() {
    let scene = Scene::new("tilted", TILTED).in_any_steps().set(&wanted("1e-3"));
    let runs = [1, 2].map(|ranks| scene.on(ranks));
    for run in &runs {
        let told = &run.report["accuracy"];
        assert_eq!(told["met"], true, "{told}");
        let mean = &told["quantities"][0];
        let number = |key: &str| mean[key].as_f64().expect(key);
        let error = number("value") - MEAN;
        assert!((error / MEAN).abs() < 1e-3, "{mean}");
        let effectivity = error / number("error");
        assert!((0.5..2.0).contains(&effectivity) && mean["trusted"] == true, "{mean}");
        assert_eq!(run.column("joint.normal_traction.mean"), [number("value")]);
    }
    runs[0].assert_same(&runs[1], 1e-8);
    let meshes = |run: usize| {
        let list = runs[run].report["accuracy"]["meshes"].as_array().expect("meshes");
        list.iter().map(|mesh| mesh["cells"].clone()).collect::<Vec<_>>()
    };
    assert_eq!(meshes(0), meshes(1));
}

#[test]
fn the_budget_ends_the_search_with_status_1_and_the_best_answer() {
    let text = "accuracy={of: [top.reaction_z], relative: 1e-7, budget: {unknowns: 1200}}";
    let scene = Scene::new("budget", TILTED).set(text);
    let failure = scene.attempt(1).err().expect("a budget that is too small");
    assert_eq!(failure.status, Some(1), "{}", failure.complaint);
}

#[test]
fn cells_that_grow_give_the_same_with_every_solver() {
    let grading = "mesh.column={size: [1, 4], cells: [8, 16], grading: \
        {x: {towards: [left, right], ratio: 4}, z: {towards: [bottom, top, joint], ratio: 8}}}";
    let scene = Scene::new("graded", TILTED).set(grading).set("solver.tolerance=1e-11");
    let exact = scene.set("solver.linear=mumps").on(1);
    for linear in ["gamg", "hypre", "multigrid", "aggregation"] {
        exact.assert_same(&scene.set(&format!("solver.linear={linear}")).on(2), 1e-8);
    }
    let error = exact.column("joint.normal_traction.mean")[0] / MEAN - 1.0;
    let uniform = scene.set("mesh.column.grading=").on(1);
    let even = uniform.column("joint.normal_traction.mean")[0] / MEAN - 1.0;
    assert!(error.abs() < 0.7 * even.abs(), "{error} {even}");
}

/// A zone of 1 m on nodes 0.5 m apart is warned of where it softens unevenly alone.
#[test]
fn an_unresolved_cohesive_zone_is_warned_of_where_it_softens_unevenly() {
    let joint = "interfaces.0={name: joint, z: 0.5, \
                 law: {linear_softening: {strength: 1.1e6, fracture_energy: 190}}}";
    let scene = Scene::new("zone", TILTED).in_any_steps().set(joint);
    let remarks = |cells: &str, top: &str, ratio: f64| {
        let scene = scene.set(&format!("mesh.column={{size: [1, 1], cells: {cells}}}"));
        let scene = scene.set(&format!("boundary.1.displacement.z={top}"));
        let run = scene.set(&format!("materials.rock.elastic.poisson_ratio={ratio}")).on(1);
        run.report["remarks"].to_string()
    };
    let uneven = "{formula: \"2.2e-4*t*(1 + 0.5*(x-0.5))\"}";
    let told = remarks("[2, 4]", uneven, 0.3);
    for part in ["joint softened unevenly", "1.001e0 m", "5.000e-1 m apart", "3.336e-1 m apart"] {
        assert!(told.contains(part), "{part}: {told}");
    }
    assert!(!remarks("[4, 4]", uneven, 0.3).contains("softened"), "cells that resolve it");
    assert!(!remarks("[2, 4]", "2.2e-4", 0.0).contains("softened"), "an even state");
    assert!(!remarks("[2, 4]", "1.0e-4", 0.3).contains("softened"), "no softening");
}

/// One cell for each body in the place of cells that grow gives every exact value of its source.
#[test]
fn a_smaller_model_serves_for_cells_that_grow() {
    let grading = "{x: {towards: [left], ratio: 3}, z: {towards: [joint], ratio: 8}}";
    let column = format!("{{size: [1, 1, 5], cells: [6, 6, 30], grading: {grading}}}");
    let scene = Scene::shipped("wtnv146/case.yaml").set(&format!("mesh.column={column}"));
    let run = scene.reduced().on(2);
    assert_eq!(run.report["reduction"]["applied"], true, "{}", run.screen);
    assert_eq!(run.report["status"], "done", "{}", run.screen);
}
