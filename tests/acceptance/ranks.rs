//! The same numbers on any number of ranks, with any solver, however the cells are shared out.

use crate::scene::{Run, Scene};

/// The column of the reference with lateral contraction and, in `top`, what moves its top.
fn column(name: &str, poisson_ratio: f64, top: &str, instants: &str) -> Scene {
    let yaml = format!(
        "
mesh: {{column: {{size: [1.0, 1.0, 5.0], cells: [4, 4, 20]}}}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: {poisson_ratio}}}}}}}
interfaces:
  - {{name: joint, z: 2.5, law: {{linear_softening: {{strength: 1.1e6, fracture_energy: 900.0}}}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{on: top, displacement: {top}}}
time: {{instants: {instants}}}
probes: [{{name: off_axis, at: [0.21, 0.83, 3.1]}}]
"
    );
    Scene::new(name, &yaml)
}

fn contracting() -> Scene {
    let z = "{table: [[0, 0], [1, -1.0e-4], [2, 1.0e-4], [3, 1.0e-3], [4, 5.0e-4], [5, 1.2e-3], \
             [6, 1.7e-3], [7, 1.7e-3], [8, -1.0e-4]]}";
    let top = format!("{{x: {{table: [[6, 0], [7, 1.0e-3], [8, 0]]}}, y: 0, z: {z}}}");
    column("contracting", 0.25, &top, "[1, 2, 3, 4, 5, 6, 7, 8]")
}

/// Opens unevenly up to the fourth instant, then closes again.
fn tilting() -> Scene {
    let top = "{x: 0, y: 0, z: {formula: \"3e-4*min(t, 8-t)*(1 + 0.4*(x-0.5) + 0.2*(y-0.5))\"}}";
    column("tilting", 0.25, top, "[1, 2, 3, 4, 5, 6]")
}

/// The largest of the two errors after every correction, instant by instant.
fn convergence(run: &Run) -> Vec<Vec<f64>> {
    let mut instants: Vec<Vec<f64>> = Vec::new();
    for line in run.screen.lines().filter(|l| l.trim_start().starts_with("correction")) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let after = |word| {
            let at = words.iter().position(|w| *w == word).expect("the line names what it holds");
            words[at + 1].parse::<f64>().expect("a number")
        };
        if words[1] == "0" {
            instants.push(Vec::new());
        }
        let errors = instants.last_mut().expect("the first line of an instant is correction 0");
        errors.push(after("balance").max(after("jumps")));
    }
    instants
}

/// The last correction gains at least three digits: quadratic, or finite where the law is piecewise
/// linear. A tangent that is not consistent gains one at best.
fn assert_quadratic(run: &Run) {
    let instants = convergence(run);
    assert_eq!(instants.len(), run.table.rows.len(), "{}", run.label);
    for errors in instants {
        if let [.., before, last] = errors[..] {
            assert!(last <= 1e-3 * before, "{}: {errors:?}", run.label);
        }
    }
}

/// Elimination on these numbers of ranks, the iterative solvers as `chosen` says by their place in
/// the list and the number of ranks.
fn the_same(scene: &Scene, eliminated: &[usize], chosen: fn(usize) -> bool) {
    let with = |solver: &str, ranks| scene.set(&format!("solver.linear={solver}")).on(ranks);
    let one = with("mumps", 1);
    assert_quadratic(&one);
    for ranks in eliminated {
        let run = with("mumps", *ranks);
        one.assert_same(&run, 1e-8);
        assert_quadratic(&run);
    }
    for (place, solver) in ["gamg", "hypre", "multigrid", "aggregation"].into_iter().enumerate() {
        for ranks in (1..=4).filter(|ranks| chosen(place + ranks)) {
            one.assert_same(&with(solver, ranks), 1e-8);
        }
    }
}

fn tilting_of_second_order() -> Scene {
    tilting().set("mesh.order=2").set("mesh.column.cells=[3, 3, 12]")
}

// The columns share out the solvers and the numbers of ranks: each solver has three of the four.

#[test]
fn column_with_lateral_contraction() {
    the_same(&contracting(), &[2, 4], |sum| sum % 4 == 1);
}

#[test]
fn column_with_a_tilting_top() {
    the_same(&tilting(), &[3], |sum| sum % 4 == 2);
}

#[test]
fn columns_of_second_order() {
    the_same(&tilting_of_second_order(), &[2], |sum| sum % 4 == 3);
}

#[test]
#[ignore = "a minute: cargo test --release --test acceptance every_solver -- --ignored"]
fn columns_with_every_solver_on_1_to_4_ranks() {
    for scene in [contracting(), tilting(), tilting_of_second_order()] {
        the_same(&scene, &[2, 3, 4], |_| true);
    }
}

/// A flat block whose top slides and tilts: a part of the interface opens, a part stays pressed
/// together, and all of it slides. With 0.5 m of rock on either side the bulk is stiffer than the
/// softening slope, so that the solution is unique.
fn block(bodies: &str) -> Scene {
    let yaml = format!(
        "
mesh: {{column: {{size: [4.0, 4.0, 1.0], {bodies}}}}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.3}}}}}}
interfaces:
  - {{name: joint, z: 0.5, law: {{linear_softening: {{strength: 1.1e6, fracture_energy: 900.0}}}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - on: top
    displacement:
      x: {{formula: \"2.5e-4*min(t, 4-t)\"}}
      y: {{formula: \"1e-4*min(t, 4-t)\"}}
      z: {{formula: \"2e-4*min(t, 4-t)*(0.4 + 0.4*(x-2) + 0.1*(y-2))\"}}
time: {{instants: [1, 2, 3]}}
probes: [{{name: inside, at: [1.3, 2.9, 0.4]}}]
"
    );
    Scene::new("block", &yaml)
}

/// On one rank and on `others`, with every cell on a rank of its own choice; `metis`: those of them
/// for which METIS cuts the mesh too.
fn on_cut_interfaces(bodies: &str, others: &[usize], metis: &[usize]) {
    let scene = block(bodies);
    let one = scene.on(1);
    let least = one.column("joint.damage.min");
    let most = one.column("joint.damage.max");
    assert!(least[1] < most[1] && most[1] > 0.05 && most[1] < 1.0, "damage {least:?} {most:?}");
    for &ranks in others {
        let scattered = scene.scattered().on(ranks);
        one.assert_same(&scattered, 1e-8);
        let partition = &scattered.report["partition"];
        let nodes = partition["interface_nodes"].as_array().expect("a list");
        assert_eq!(nodes.len(), ranks, "{partition}");
        assert!(nodes.iter().all(|n| n.as_u64() > Some(0)), "{partition}");
        assert!(partition["cut_pairs"].as_u64() > Some(0), "{partition}");
        if metis.contains(&ranks) {
            let metis = scene.on(ranks);
            one.assert_same(&metis, 1e-8);
            let kept = &metis.report["partition"]["cut_pairs"];
            assert!(kept.as_u64() < partition["cut_pairs"].as_u64(), "{kept} {partition}");
        }
    }
}

const MATCHING: &str = "cells: [12, 12, 4]";
const COARSE_ON_FINE: &str = "bodies: [{cells: [10, 10, 2]}, {cells: [15, 15, 2]}]";
const ALMOST_MATCHING: &str = "bodies: [{cells: [11, 11, 2]}, {cells: [12, 12, 2]}]";
const SECOND_ON_FIRST: &str = "bodies: [{cells: [5, 5, 1], order: 2}, {cells: [9, 9, 2]}]";
const SECOND: &str = "bodies: [{cells: [5, 5, 1], order: 2}, {cells: [6, 6, 1], order: 2}]";

// Every number of ranks once, and those that do not match on two each: they share what depends on
// it.

#[test]
fn matching_block_with_a_scattered_partition() {
    on_cut_interfaces(MATCHING, &[3, 7], &[2]);
}

#[test]
fn block_2_against_3_with_a_scattered_partition() {
    on_cut_interfaces(COARSE_ON_FINE, &[2, 4], &[4]);
}

#[test]
fn block_11_against_12_with_a_scattered_partition() {
    on_cut_interfaces(ALMOST_MATCHING, &[3, 7], &[3]);
}

#[test]
fn block_of_second_order_on_first_with_a_scattered_partition() {
    on_cut_interfaces(SECOND_ON_FIRST, &[2, 3], &[3]);
}

#[test]
fn block_of_second_order_with_a_scattered_partition() {
    on_cut_interfaces(SECOND, &[4], &[3]);
}

#[test]
#[ignore = "two minutes: cargo test --release --test acceptance scattered -- --ignored"]
fn blocks_with_a_scattered_partition_on_2_3_4_7_ranks() {
    let all = [2, 3, 4, 7];
    on_cut_interfaces(MATCHING, &all, &all);
    for (bodies, metis) in
        [(COARSE_ON_FINE, 4), (ALMOST_MATCHING, 3), (SECOND_ON_FIRST, 3), (SECOND, 3)]
    {
        on_cut_interfaces(bodies, &all, &[metis]);
    }
}

#[test]
fn multigrid_on_a_scattered_partition() {
    // On 3 ranks that which is the smallest: two cores are busy with messages on the others.
    by_multigrid([2, 2, 3], |sum| sum % 2 == 0);
}

#[test]
#[ignore = "a minute: cargo test --release --test acceptance scattered -- --ignored"]
fn multigrid_on_a_scattered_partition_of_3_ranks() {
    by_multigrid([3; 3], |_| true);
}

/// Two bodies of three kinds, on as many ranks, by iterative solvers as `chosen` says by the places
/// of both.
fn by_multigrid(ranks: [usize; 3], chosen: fn(usize) -> bool) {
    let bodies = [
        "bodies: [{cells: [8, 8, 2]}, {cells: [12, 12, 2]}]",
        "bodies: [{cells: [4, 4, 1], order: 2}, {cells: [6, 6, 1], order: 2}]",
        "bodies: [{cells: [4, 4, 1], order: 2}, {cells: [6, 6, 2]}]",
    ];
    for (kind, (bodies, ranks)) in bodies.into_iter().zip(ranks).enumerate() {
        let scene = block(bodies).scattered();
        let direct = scene.set("solver.linear=mumps").on(ranks);
        let solvers = ["gamg", "hypre", "multigrid", "aggregation"].into_iter().enumerate();
        for (_, solver) in solvers.filter(|(place, _)| chosen(kind + place)) {
            direct.assert_same(&scene.set(&format!("solver.linear={solver}")).on(ranks), 1e-8);
        }
    }
}
