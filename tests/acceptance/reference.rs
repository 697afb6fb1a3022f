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

/// The pairs of a solver, by its place in the list, and a number of ranks that are run: meshes
/// share them out, each with every solver on another number of ranks.
type Pairs = fn(usize) -> bool;
const FIRST: Pairs = |sum| sum % 4 == 0;
const SECOND: Pairs = |sum| sum % 4 == 1;
const THIRD: Pairs = |sum| sum % 4 == 2;
const FOURTH: Pairs = |sum| sum % 4 == 3;
const ALL: Pairs = |_| true;

fn check_solvers(
    case: &str,
    cells: &str,
    (dim, order): (usize, usize),
    solvers: &[&str],
    pairs: Pairs,
) {
    for (place, solver) in solvers.iter().copied().enumerate() {
        for ranks in (1..=4).filter(|ranks| pairs(place + ranks)) {
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

const IN_3D: &str = "wtnv146/case.yaml";
const IN_2D: &str = "wtnv146/case_2d.yaml";

#[test]
fn in_3d_with_5_layers() {
    check_solvers(IN_3D, "[1, 1, 5]", (3, 1), &SOLVERS, FIRST);
}

#[test]
fn in_3d_with_20_layers() {
    check_solvers(IN_3D, "[4, 4, 20]", (3, 1), &SOLVERS, SECOND);
}

#[test]
fn in_2d_with_5_layers() {
    check_solvers(IN_2D, "[1, 5]", (2, 1), &SOLVERS, THIRD);
}

#[test]
fn in_2d_with_20_layers() {
    check_solvers(IN_2D, "[4, 20]", (2, 1), &SOLVERS, FOURTH);
}

#[test]
fn in_3d_by_multigrid() {
    check_solvers(IN_3D, LARGE, (3, 1), &["multigrid"], ALL);
}

/// The mesh of the reference itself: five elements of second order.
#[test]
fn in_3d_with_5_cells_of_second_order() {
    check_solvers(IN_3D, "[1, 1, 5]", (3, 2), &SOLVERS, THIRD);
}

#[test]
fn in_2d_with_5_cells_of_second_order() {
    check_solvers(IN_2D, "[1, 5]", (2, 2), &SOLVERS, FIRST);
}

#[test]
fn in_3d_with_20_layers_of_second_order() {
    check_solvers(IN_3D, "[4, 4, 20]", (3, 2), &["mumps", "multigrid"], SECOND);
}

#[test]
#[ignore = "a minute: cargo test --release --test acceptance reference -- --ignored"]
fn every_mesh_with_every_solver_on_1_to_4_ranks() {
    for (case, cells, dim) in
        [(IN_3D, ["[1, 1, 5]", "[4, 4, 20]"], 3), (IN_2D, ["[1, 5]", "[4, 20]"], 2)]
    {
        check_solvers(case, cells[0], (dim, 1), &SOLVERS, ALL);
        check_solvers(case, cells[1], (dim, 1), &SOLVERS, ALL);
        check_solvers(case, cells[0], (dim, 2), &SOLVERS, ALL);
    }
    check_solvers(IN_3D, "[4, 4, 20]", (3, 2), &["mumps", "multigrid"], ALL);
}
