//! Refinement after distribution gives the mesh that could have been generated at once.

use crate::scene::Scene;

fn column(lower: usize, upper: usize, factor: usize, order: usize) -> Scene {
    let cells = |n: usize| format!("[{0}, {0}, {1}]", n * factor, 2 * factor);
    let yaml = format!(
        "
mesh: {{column: {{size: [1.0, 1.0, 3.0], bodies: [{{cells: {}}}, {{cells: {}}}]}}}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.3}}}}}}
interfaces:
  - {{name: joint, z: 1.5, law: {{linear_softening: {{strength: 1.1e6, fracture_energy: 900.0}}}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{on: top, displacement: {{x: 0, y: 0, z: {{formula: \"4e-4*t*(1 + 0.4*(x-0.5))\"}}}}}}
time: {{instants: [1, 2]}}
solver: {{tolerance: 1.0e-12, linear: mumps}}
probes: [{{name: inside, at: [0.3, 0.4, 2.3]}}]
",
        cells(lower),
        cells(upper)
    );
    Scene::new("refined", &yaml).set(&format!("mesh.order={order}"))
}

fn check(lower: usize, upper: usize, order: usize) {
    let at_once = column(lower, upper, 4, order).on(2);
    let damage = at_once.column("joint.damage.max");
    assert!(damage[1] > 0.05, "{damage:?}");
    let coarse = 2 * (lower * lower + upper * upper) as u64;
    for ranks in [1, 3] {
        let refined = column(lower, upper, 1, order).set("mesh.refine=2").on(ranks);
        at_once.assert_same(&refined, 1e-10);
        assert_eq!(refined.report["cells"], at_once.report["cells"], "{}", refined.label);
        let before = &refined.report["partition"]["cells_before_distribution"];
        assert_eq!(*before, coarse, "{}", refined.label);
    }
    assert_eq!(at_once.report["partition"]["cells_before_distribution"], 64 * coarse);
}

#[test]
fn matching() {
    check(2, 2, 1);
}

#[test]
fn non_matching() {
    check(2, 3, 1);
}

#[test]
fn of_second_order() {
    check(1, 2, 2);
}
