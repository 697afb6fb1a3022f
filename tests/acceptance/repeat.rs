//! The same case on the same ranks twice: the same history, bit for bit.

use std::fs;

use crate::scene::{Run, Scene};

/// Opens unevenly across several branches; many corrections, two interfaces, contraction.
fn tilting() -> Scene {
    let yaml = "
mesh: {column: {size: [1.0, 1.0, 5.0], cells: [4, 4, 20]}}
materials: {rock: {elastic: {young_modulus: 5.8e9, poisson_ratio: 0.25}}}
interfaces:
  - {name: lower, z: 2.0, law: {exponential_softening: {strength: 1.3e6, fracture_energy: 900.0}}}
  - {name: upper, z: 3.5, law: {linear_softening: {strength: 1.1e6, fracture_energy: 900.0}}}
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}
  - on: top
    displacement: {x: 0, y: 0, z: {formula: \"3e-4*min(t, 8-t)*(1 + 0.4*(x-0.5) + 0.2*(y-0.5))\"}}
time: {instants: [1, 2, 3, 4, 5]}
probes: [{name: off_axis, at: [0.21, 0.83, 3.1]}]
";
    Scene::new("repeated", yaml).in_any_steps()
}

/// Each rank factorises the whole matrix: several together would add in the order in which messages
/// come.
const ALONE: &str =
    "-pc_type redundant -redundant_pc_type cholesky -redundant_pc_factor_mat_solver_type mumps";
/// The same for the coarsest level of multigrid.
const COARSEST_ALONE: &str = "-mg_coarse_pc_type redundant -mg_coarse_redundant_pc_type cholesky \
                              -mg_coarse_redundant_pc_factor_mat_solver_type mumps";

fn twice(scene: &Scene, ranks: usize) -> [Run; 2] {
    [(), ()].map(|()| scene.on(ranks))
}

fn assert_same_bits(scene: &Scene, ranks: usize) {
    let [one, other] = twice(scene, ranks);
    let text =
        |run: &Run| fs::read_to_string(run.directory.join("history.csv")).expect("a history");
    assert!(one.table.rows.len() > 1, "{}", one.label);
    assert!(text(&one) == text(&other), "{} differs by {:e}", one.label, one.difference(&other));
    let norms = |run: &Run| run.report["residual_norms"].to_string();
    assert_eq!(norms(&one), norms(&other), "{}", one.label);
}

#[test]
fn a_run_repeated_on_the_same_ranks_gives_the_same_bits() {
    let scene = tilting();
    assert_same_bits(&scene.set("solver.linear=mumps"), 1);
    let alone = scene.set("solver.linear=mumps").set(&format!("solver.petsc_options={ALONE}"));
    let levels = scene
        .set("solver.linear=multigrid")
        .set("mesh.column.cells=[8, 8, 24]")
        .set("time.instants=[2, 5]")
        .set(&format!("solver.petsc_options={COARSEST_ALONE}"));
    for ranks in [2, 3] {
        assert_same_bits(&scene.set("solver.linear=hypre"), ranks);
        assert_same_bits(&alone, ranks);
    }
    assert_same_bits(&levels, 3);
}

/// MUMPS adds what comes from several ranks in the order in which it comes, also on the coarsest
/// level of multigrid; GAMG is not the same twice either.
#[test]
fn a_run_repeated_with_elimination_on_several_ranks_differs_by_rounding() {
    for (solver, tolerance) in [("mumps", 1e-11), ("gamg", 1e-9), ("multigrid", 1e-9)] {
        let scene = tilting().set(&format!("solver.linear={solver}"));
        let scene = scene.set("mesh.column.cells=[6, 6, 18]").set("time.instants=[2, 5]");
        let [one, other] = twice(&scene, 3);
        eprintln!("{} differs by {:e}", one.label, one.difference(&other));
        one.assert_same(&other, tolerance);
    }
}
