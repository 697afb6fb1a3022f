//! Elements: experiments 5 and 6.

use super::{family, measured, near, sum};
use serde_json::json;

/// Pure bending; a cell of length l across the whole depth is stiffer by 1 + (l/depth)^2/2 where
/// the displacements are of first order.
#[test]
fn e05_bending_locks_first_order() {
    let mut rows = Vec::new();
    for (layers, ratio) in [(20, 1.0_f64), (4, 5.0), (2, 10.0), (1, 10.0)] {
        for order in [1, 2] {
            let run = family("bending")
                .set("boundary.1.displacement.z={formula: \"20*1.0e-5*(x - 0.5)*t\"}")
                .set(&format!("mesh.order={order}"))
                .set(&format!("mesh.column.cells=[1, 1, {layers}]"))
                .on(1);
            let energy = run.column("energy.elastic")[0] / (0.5 * 5.8e9 * 1e-10 / 12.0 * 20.0);
            let traction = run.column("joint.normal_traction.max")[0] / 29_000.0;
            if layers > 1 {
                let locked = if order == 1 { 1.0 + 0.5 * ratio * ratio } else { 1.0 };
                near("stiffness", energy, locked, 1e-7 * locked);
                rows.push(json!([ratio, order, energy, traction]));
            } else {
                // The interface splits the only layer.
                near("stiffness", energy, if order == 1 { 51.0 } else { 1.0 }, 1e-5);
            }
        }
    }
    measured("5.bending", rows);
    // So stiff that the interface gives way, at a 38th of its strength.
    let slender = |order: usize| {
        family("bending")
            .set("mesh.column.size=[1.0, 1.0, 40.0]")
            .set("interfaces.0.z=20.0")
            .set("mesh.column.cells=[1, 1, 2]")
            .set("boundary.1.displacement.z={formula: \"40*1.0e-5*(x - 0.5)*t\"}")
            .set(&format!("mesh.order={order}"))
            .on(1)
            .column("joint.damage.max")[0]
    };
    let damage = [slender(1), slender(2)];
    assert!(damage[0] > 0.05 && damage[1] == 0.0, "{damage:?}");
    measured("5.damage", damage.to_vec());
}

#[test]
#[ignore = "half a minute, for its figures: scripts/stability.sh"]
fn e06_incompressibility_locks_full_integration() {
    locking(|nu| nu == 0.49);
}

#[test]
#[ignore = "twenty seconds, for its figures: scripts/stability.sh"]
fn e06_iterations_of_every_ratio() {
    measured("6.locking", locking(|_| true));
}

/// A block between rough platens, its stiffness beside that of 6 x 6 x 6 cells of second order;
/// iterations for the ratios of Poisson that are `counted`.
fn locking(counted: fn(f64) -> bool) -> Vec<serde_json::Value> {
    let mut rows = Vec::new();
    for nu in [0.3, 0.45, 0.49, 0.499, 0.4999] {
        let block = family("incompressible")
            .set("time.instants=[1]")
            .set(
                "boundary=[{on: bottom, displacement: {x: 0, y: 0, z: 0}}, {on: top, displacement: \
                 {x: 0, y: 0, z: -1.0e-3}}]",
            )
            .set(&format!("materials.rock.elastic.poisson_ratio={nu}"));
        let force = |order: usize, n: usize, formulation: &str| {
            let run = block
                .set(&format!("mesh.order={order}"))
                .set(&format!("mesh.column.cells=[{n}, {n}, {n}]"))
                .set(&format!("mesh.formulation={formulation}"))
                .set("solver.linear=mumps")
                .on(1);
            run.column("top.reaction_z")[0]
        };
        let fine = force(2, 6, "b_bar");
        let stiffness = [(1, 4, "full"), (1, 4, "b_bar"), (2, 2, "full"), (2, 2, "b_bar")]
            .map(|(order, n, formulation)| force(order, n, formulation) / fine);
        let iterations = |formulation: &str| {
            ["gamg", "hypre", "multigrid"].map(|solver| {
                let run = block
                    .set("mesh.column.cells=[8, 8, 8]")
                    .set(&format!("mesh.formulation={formulation}"))
                    .set(&format!("solver.linear={solver}"))
                    .attempt(1);
                run.map(|run| sum(&run.column("linear_iterations"))).ok()
            })
        };
        let counts = if counted(nu) { iterations("b_bar") } else { [None; 3] };
        assert!((stiffness[1] - 1.0).abs() < 0.04, "{nu}: {stiffness:?}");
        assert!((stiffness[3] - 1.0).abs() < 0.02, "{nu}: {stiffness:?}");
        if nu == 0.4999 {
            assert!(stiffness[0] > 50.0 && stiffness[2] > 1.2, "{stiffness:?}");
        }
        if nu == 0.49 {
            assert!(counts.iter().all(|c| c.is_some_and(|c| c < 120.0)), "{counts:?}");
        }
        rows.push(json!([nu, stiffness, counts]));
    }
    rows
}
