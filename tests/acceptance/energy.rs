//! External work = elastic + dissipated, with every change of branch among the instants, so that
//! the trapezoidal rule is exact.

use crate::scene::Scene;

/// (x, z) of the top: the path of the reference, and the points where it crosses 0, the strength,
/// the old threshold and the end of softening. On the way back from (1e-3, 1.7e-3) to (0, -1e-4)
/// z = 0 is reached at x = 1e-3/18.
const PATH: [(f64, f64); 13] = [
    (0.0, -1.0e-4),
    (0.0, 0.0),
    (0.0, 1.0e-4),
    (0.0, 9.482758620689655e-4),
    (0.0, 1.0e-3),
    (0.0, 5.0e-4),
    (0.0, 1.0e-3),
    (0.0, 1.2e-3),
    (0.0, 1.6363636363636363e-3),
    (0.0, 1.7e-3),
    (1.0e-3, 1.7e-3),
    (1.0e-3 / 18.0, 0.0),
    (0.0, -1.0e-4),
];

fn table(values: impl Iterator<Item = f64>) -> String {
    let rows: Vec<String> =
        values.enumerate().map(|(i, v)| format!("[{}, {v:e}]", i + 1)).collect();
    format!("{{table: [[0, 0], {}]}}", rows.join(", "))
}

fn check(case: &str, cells: &str, order: usize) {
    let instants: Vec<String> = (1..=PATH.len()).map(|t| t.to_string()).collect();
    for (ranks, solver) in [(1, "mumps"), (2, "gamg"), (3, "hypre"), (4, "mumps")] {
        let run = Scene::shipped(case)
            .set(&format!("mesh.column.cells={cells}"))
            .set(&format!("mesh.order={order}"))
            .set(&format!("solver.linear={solver}"))
            .set(&format!("time.instants=[{}]", instants.join(", ")))
            .set(&format!("boundary.1.displacement.x={}", table(PATH.iter().map(|p| p.0))))
            .set(&format!("boundary.1.displacement.z={}", table(PATH.iter().map(|p| p.1))))
            .set("expect=[]")
            .on(ranks);
        run.assert_energy_balance(1e-8);
        let dissipated = run.column("energy.dissipated");
        // Nothing before the strength is passed, G_c over 1 m2 from the end of softening on.
        assert!(dissipated[..4].iter().all(|d| d.abs() <= 1e-9), "{dissipated:?}");
        assert!(dissipated.is_sorted(), "{}: {dissipated:?}", run.label);
        let last = dissipated[PATH.len() - 1];
        assert!((last - 900.0).abs() <= 900.0 * 1e-8, "{}: {last}", run.label);
    }
}

#[test]
fn balance_in_3d() {
    check("wtnv146/case.yaml", "[1, 1, 5]", 1);
    check("wtnv146/case.yaml", "[3, 3, 10]", 1);
    check("wtnv146/case.yaml", "[2, 2, 5]", 2);
}

#[test]
fn balance_in_2d() {
    check("wtnv146/case_2d.yaml", "[4, 20]", 1);
    check("wtnv146/case_2d.yaml", "[2, 10]", 2);
}
