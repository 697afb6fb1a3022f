//! The same case on the same ranks twice: the same history, bit for bit.

use std::fs;

use crate::scene::{SOLVERS, Scene};

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

#[test]
fn a_run_repeated_on_the_same_ranks_gives_the_same_bits() {
    for solver in SOLVERS {
        let scene = tilting().set(&format!("solver.linear={solver}"));
        for ranks in [1, 2, 3] {
            let [one, other] = [(), ()].map(|()| scene.on(ranks));
            let text = |directory| fs::read_to_string(directory).expect("a history");
            let [a, b] = [&one, &other].map(|run| text(run.directory.join("history.csv")));
            assert_eq!(a.lines().count(), 6, "{}", one.label);
            assert_eq!(a, b, "{}", one.label);
            let norms = |run: &crate::scene::Run| run.report["residual_norms"].to_string();
            assert_eq!(norms(&one), norms(&other), "{}", one.label);
        }
    }
}
