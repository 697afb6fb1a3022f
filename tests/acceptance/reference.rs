//! WTNV146: the reference problem on every number of ranks and with every solver.

use crate::scene::{SOLVERS, Scene};

/// Exact normal tractions: one-dimensional column in series with the law.
const TRACTION: [f64; 8] = [
    -116000.0,
    116000.0,
    1017312.0728929382,
    508656.0364464691,
    697585.4214123009,
    0.0,
    0.0,
    -116000.0,
];

/// Large enough for multigrid on any number of ranks.
const LARGE: &str = "[8, 8, 40]";

fn check(case: &str, cells: &str, dim: usize) {
    check_solvers(case, cells, (dim, 1), &SOLVERS);
}

fn check_solvers(case: &str, cells: &str, (dim, order): (usize, usize), solvers: &[&str]) {
    for solver in solvers.iter().copied() {
        for ranks in 1..=4 {
            let run = Scene::shipped(case)
                .set(&format!("mesh.order={order}"))
                .set(&format!("mesh.column.cells={cells}"))
                .set(&format!("solver.linear={solver}"))
                .on(ranks);
            let choice = &run.report["linear_solver"]["choice"];
            // Too small for a coarser lattice: eliminated.
            let small = solver == "multigrid" && choice == "mumps" && cells != LARGE && order == 1;
            assert!(small || choice == solver, "{}: {choice}", run.label);
            for (row, exact) in TRACTION.iter().enumerate() {
                let absolute = if *exact == 0.0 { 1e-3 } else { 0.0 };
                for which in ["min", "max"] {
                    let value = run.column(&format!("joint.normal_traction.{which}"))[row];
                    assert!(
                        (value - exact).abs() <= absolute + 1e-9 * exact.abs(),
                        "{}: normal traction {which} at {} is {value:e}, exact {exact:e}",
                        run.label,
                        row + 1
                    );
                }
            }
            run.assert_column("joint.shear_traction_x", &[0.0; 8], 0.0, 1e-3);
            if dim == 3 {
                run.assert_column("joint.shear_traction_y", &[0.0; 8], 0.0, 1e-3);
            }
            let corrections = run.corrections();
            assert!(
                corrections.iter().sum::<f64>() <= 14.0,
                "{}: {corrections:?} corrections",
                run.label
            );
        }
    }
}

#[test]
fn in_3d_with_5_layers() {
    check("wtnv146/case.yaml", "[1, 1, 5]", 3);
}

#[test]
fn in_3d_with_20_layers() {
    check("wtnv146/case.yaml", "[4, 4, 20]", 3);
}

#[test]
fn in_2d_with_5_layers() {
    check("wtnv146/case_2d.yaml", "[1, 5]", 2);
}

#[test]
fn in_2d_with_20_layers() {
    check("wtnv146/case_2d.yaml", "[4, 20]", 2);
}

#[test]
fn in_3d_by_multigrid() {
    check_solvers("wtnv146/case.yaml", LARGE, (3, 1), &["multigrid"]);
}

/// The mesh of the reference itself: five elements of second order.
#[test]
fn in_3d_with_5_cells_of_second_order() {
    check_solvers("wtnv146/case.yaml", "[1, 1, 5]", (3, 2), &SOLVERS);
}

#[test]
fn in_2d_with_5_cells_of_second_order() {
    check_solvers("wtnv146/case_2d.yaml", "[1, 5]", (2, 2), &SOLVERS);
}

#[test]
fn in_3d_with_20_layers_of_second_order() {
    check_solvers("wtnv146/case.yaml", "[4, 4, 20]", (3, 2), &["mumps", "multigrid"]);
}
