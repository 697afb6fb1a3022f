//! Nearly incompressible material: what locks, and what does not.

use crate::scene::Scene;

/// A block that is squeezed between rough platens.
fn block(cells: usize, poisson_ratio: f64) -> Scene {
    let yaml = format!(
        "
mesh: {{column: {{size: [1.0, 1.0, 1.0], cells: [{cells}, {cells}, {cells}]}}}}
materials: {{rock: {{elastic: {{young_modulus: 1.0e9, poisson_ratio: {poisson_ratio}}}}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{on: top, displacement: {{x: 0, y: 0, z: -1.0e-3}}}}
time: {{instants: [1]}}
"
    );
    Scene::new("block", &yaml)
}

#[test]
fn a_nearly_incompressible_block_does_not_lock() {
    let force = |scene: &Scene| -scene.on(1).column("top.reaction_z")[0];
    let fine = force(&block(16, 0.4999));
    let coarse = force(&block(4, 0.4999));
    assert!((coarse - fine).abs() < 0.04 * fine, "{coarse} {fine}");
    // What it is good for: full integration is eighty times too stiff on the same cells.
    let full = force(&block(4, 0.4999).set("mesh.formulation=full"));
    assert!(full > 50.0 * fine, "{full} {fine}");
}

/// Errors beside a fine mesh of second order, and what full integration gives on the same cells;
/// elimination takes one iteration whatever the material.
#[test]
fn neither_order_locks() {
    let force = |order: usize, cells: usize, formulation: &str| {
        let run = block(cells, 0.4999)
            .set(&format!("mesh.order={order}"))
            .set(&format!("mesh.formulation={formulation}"))
            .on(1);
        assert_eq!(run.column("linear_iterations"), [1.0], "{}", run.label);
        -run.column("top.reaction_z")[0]
    };
    let fine = force(2, 8, "auto");
    for (order, cells, error, of_full) in
        [(1, 4, 0.04, 50.0), (1, 8, 0.02, 15.0), (2, 2, 0.02, 0.2), (2, 4, 0.006, 0.08)]
    {
        let found = force(order, cells, "auto") / fine - 1.0;
        assert!(found.abs() < error, "order {order}, {cells}: {found}");
        let full = force(order, cells, "full") / fine - 1.0;
        assert!(full > of_full, "order {order}, {cells}, full: {full}");
    }
}

#[test]
fn the_formulation_is_reported_and_the_same_everywhere() {
    let one = block(6, 0.48).on(1);
    let elements = &one.report["model"]["elements"][0];
    assert!(elements.as_str().is_some_and(|e| e.starts_with("rock: B-bar, since")), "{elements}");
    for (solver, ranks) in [("mumps", 2), ("multigrid", 1), ("multigrid", 3)] {
        let run = block(6, 0.48).set(&format!("solver.linear={solver}")).on(ranks);
        one.assert_same(&run, 1e-8);
    }
    assert!(block(2, 0.45).on(1).report["model"].get("elements").is_none());
}
