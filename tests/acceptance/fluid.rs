//! A prescribed fluid pressure p on the lips of a column that is held at both ends, nu = 0.
//!
//! The bulk is a spring: total traction t - p = K (g - w) with K = E/LZ, g the displacement of the
//! top and w the normal jump; the law relates t and w.

use crate::scene::{Run, Scene};

const STIFFNESS: f64 = 5.8e9 / 5.0;
const STRENGTH: f64 = 1.1e6;
const SLOPE: f64 = STRENGTH * STRENGTH / (2.0 * 900.0);

const MATCHING: &str = "cells: [2, 2, 4]";
const NON_MATCHING: &str = "bodies: [{cells: [2, 2, 2]}, {cells: [3, 3, 3]}]";
const MIXED: &str = "bodies: [{cells: [2, 2, 2], order: 2}, {cells: [3, 3, 3]}]";

/// Displacements of the top and pressures at the instants 1, 2, ...
fn run(mesh: &str, law: &str, top: &[f64], pressure: &[f64], ranks: usize) -> Run {
    let table = |values: &[f64]| {
        let rows: Vec<String> =
            values.iter().enumerate().map(|(i, v)| format!("[{}, {v:e}]", i + 1)).collect();
        format!("{{table: [[0, 0], {}]}}", rows.join(", "))
    };
    let instants: Vec<String> = (1..=top.len()).map(|t| t.to_string()).collect();
    let yaml = format!(
        "
mesh: {{column: {{size: [1.0, 1.0, 5.0], {mesh}}}}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.0}}}}}}
interfaces:
  - {{name: joint, z: 2.5, law: {law}, fluid: {{pressure: {}, connected: false}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{on: top, displacement: {{x: 0, y: 0, z: {}}}}}
time: {{instants: [{}]}}
",
        table(pressure),
        table(top),
        instants.join(", ")
    );
    Scene::new("fluid", &yaml).on(ranks)
}

/// The exact (t, w) of every instant, and the reaction t - p over 1 m2.
fn check(law: &str, top: &[f64], pressure: &[f64], exact: &[(f64, f64)]) {
    for (mesh, ranks) in [(MATCHING, 1), (MATCHING, 2), (NON_MATCHING, 1), (MIXED, 3)] {
        let run = run(mesh, law, top, pressure, ranks);
        let traction: Vec<f64> = exact.iter().map(|e| e.0).collect();
        let jump: Vec<f64> = exact.iter().map(|e| e.1).collect();
        let total: Vec<f64> = traction.iter().zip(pressure).map(|(t, p)| t - p).collect();
        for (row, (t, w)) in exact.iter().enumerate() {
            let spring = STIFFNESS * (top[row] - w);
            assert!((t - pressure[row] - spring).abs() < 1e-6, "the exact answer is in balance");
        }
        run.assert_column("joint.normal_traction", &traction, 1e-9, 1e-3);
        run.assert_column("joint.normal_jump", &jump, 1e-9, 1e-14);
        run.assert_column("joint.shear_traction_x", &vec![0.0; top.len()], 0.0, 1e-3);
        for (surface, sign) in [("top", 1.0), ("bottom", -1.0)] {
            let computed = run.column(&format!("{surface}.reaction_z"));
            for (force, total) in computed.iter().zip(&total) {
                assert!((force - sign * total).abs() <= 1e-3 + 1e-9 * total.abs(), "{}", run.label);
            }
        }
        run.assert_energy_balance(1e-8);
    }
}

/// Held, at the strength, softening, unloading by a lower pressure, pressed together, broken.
#[test]
fn on_a_cohesive_interface() {
    let softening = |p: f64| {
        let w = (p - STRENGTH) / (STIFFNESS - SLOPE);
        (STRENGTH - SLOPE * w, w)
    };
    let kappa = softening(1.5e6).1;
    let secant = STRENGTH / kappa - SLOPE;
    let unloading = |p: f64| {
        let w = p / (STIFFNESS + secant);
        (secant * w, w)
    };
    let top = [0.0, 0.0, 0.0, 0.0, 0.0, -1.0e-3, 0.0, 0.0, 0.0, 0.0];
    let critical = STRENGTH / SLOPE;
    let pressure =
        [5.0e5, STRENGTH, 1.5e6, 4.0e5, 0.0, 6.0e5, 0.0, 1.5e6, STIFFNESS * critical, 2.5e6];
    let exact = [
        (5.0e5, 0.0),
        (STRENGTH, 0.0),
        softening(1.5e6),
        unloading(4.0e5),
        (0.0, 0.0),
        (6.0e5 - STIFFNESS * 1.0e-3, 0.0),
        (0.0, 0.0),
        softening(1.5e6),
        (0.0, critical),
        (0.0, 2.5e6 / STIFFNESS),
    ];
    let law = format!("{{linear_softening: {{strength: {STRENGTH:e}, fracture_energy: 900.0}}}}");
    check(&law, &top, &pressure, &exact);
}

/// Pressed together, opened by the pressure, closed again with the pressure on.
#[test]
fn on_a_contact() {
    let top = [-1.0e-4, -1.0e-4, -1.0e-4, -5.0e-4, -5.0e-4];
    let closes = STIFFNESS * 1.0e-4;
    let pressure = [0.0, closes, 5.0e5, 3.0e5, 0.0];
    let exact = [
        (-closes, 0.0),
        (0.0, 0.0),
        (0.0, 5.0e5 / STIFFNESS - 1.0e-4),
        (3.0e5 - STIFFNESS * 5.0e-4, 0.0),
        (-STIFFNESS * 5.0e-4, 0.0),
    ];
    // From the third to the fourth instant it closes on the way: the work is not trapezoidal there.
    check("{contact: {}}", &top[..3], &pressure[..3], &exact[..3]);
    check("{contact: {}}", &top[3..], &pressure[3..], &exact[3..]);
}

/// The pressure is carried by the bond.
#[test]
fn on_a_tie() {
    let top = [0.0, 2.0e-4, -3.0e-4];
    let pressure = [7.0e5, 7.0e5, -1.0e5];
    let exact: Vec<(f64, f64)> =
        top.iter().zip(pressure).map(|(g, p)| (p + STIFFNESS * g, 0.0)).collect();
    check("{tied: {}}", &top, &pressure, &exact);
}
