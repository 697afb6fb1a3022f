//! The same scene in mm, N, MPa: the same iterations, the same values.

use crate::scene::{Kind, Scene};

/// `length`: how many units of length a metre has; forces are in N.
fn column(name: &str, length: f64, poisson_ratio: f64, top: &str, cells: &str) -> Scene {
    let area = length * length;
    let yaml = format!(
        "
mesh: {{column: {{size: [{length:e}, {length:e}, {:e}], cells: {cells}}}}}
materials: {{rock: {{elastic: {{young_modulus: {:e}, poisson_ratio: {poisson_ratio}}}}}}}
interfaces:
  - name: joint
    z: {:e}
    law: {{linear_softening: {{strength: {:e}, fracture_energy: {:e}}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{on: top, displacement: {top}}}
time: {{instants: [1, 2, 3, 4, 5, 6, 7, 8]}}
",
        5.0 * length,
        5.8e9 / area,
        2.5 * length,
        1.1e6 / area,
        900.0 / length
    );
    Scene::new(name, &yaml)
}

fn in_millimetres(kind: Kind) -> f64 {
    match kind {
        Kind::Traction | Kind::Pressure => 1e-6,
        Kind::Length | Kind::Energy | Kind::Moment => 1e3,
        Kind::Angle | Kind::Damage | Kind::Reaction | Kind::Time => 1.0,
        Kind::Area => 1e6,
        Kind::Flux | Kind::Mass => panic!("no fluid flows here"),
    }
}

fn compare(scene: impl Fn(f64) -> Scene) {
    for ranks in [1, 3] {
        let (metres, millimetres) = (scene(1.0).on(ranks), scene(1000.0).on(ranks));
        assert_eq!(metres.corrections(), millimetres.corrections(), "{}", metres.label);
        assert!(metres.corrections().iter().sum::<f64>() > 8.0, "{}", metres.label);
        metres.assert_same_in_units(&millimetres, 1e-8, in_millimetres);
    }
}

#[test]
fn reference_column() {
    compare(|length| {
        let z = [-1.0e-4, 1.0e-4, 1.0e-3, 5.0e-4, 1.2e-3, 1.7e-3, 1.7e-3, -1.0e-4];
        let rows: Vec<String> =
            z.iter().enumerate().map(|(i, z)| format!("[{}, {:e}]", i + 1, z * length)).collect();
        let x = format!("{{table: [[6, 0], [7, {:e}], [8, 0]]}}", 1e-3 * length);
        let z = format!("{{table: [[0, 0], {}]}}", rows.join(", "));
        let top = format!("{{x: {x}, y: 0, z: {z}}}");
        column("reference", length, 0.0, &top, "[1, 1, 5]")
    });
}

#[test]
fn tilting_column() {
    compare(|length| {
        let z = format!(
            "{:e}*min(t, 10-t)*(1 + 0.4*(x/{length:e}-0.5) + 0.2*(y/{length:e}-0.5))",
            2e-4 * length
        );
        let top = format!("{{x: 0, y: 0, z: {{formula: \"{z}\"}}}}");
        column("tilting", length, 0.25, &top, "[4, 4, 10]")
    });
}
