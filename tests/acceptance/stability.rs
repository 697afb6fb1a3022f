//! Whether accepted states are stable, with factors and without.

use crate::scene::{Run, Scene};

/// A column that is pulled evenly until its interface softens.
fn column(height: f64) -> Scene {
    let yaml = format!(
        "
mesh: {{column: {{size: [1.0, 1.0, {height}], cells: [4, 4, 32]}}}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.0}}}}}}
interfaces:
  - {{name: joint, z: {}, law: {{linear_softening: {{strength: 1.1e6, fracture_energy: 900.0}}}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{on: top, displacement: {{x: 0, y: 0, z: {}}}}}
time: {{instants: [1]}}
",
        0.5 * height,
        1.1e6 * height / 5.8e9 + 1e-5,
    );
    Scene::new("stability", &yaml).set("solver.stability=warn")
}

fn instabilities(run: &Run) -> Vec<String> {
    let list = run.report["instabilities"].as_array();
    let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    list.map_or_else(Vec::new, |list| list.iter().map(text).collect())
}

/// The rotation of one half against the other meets the stiffness E I / height, the softening takes
/// h (1 + 2/n^2) / 12 of it with n cells across: at n = 4 the column is stable up to 7.7 m.
#[test]
fn a_column_that_is_too_tall_tilts() {
    for solver in ["mumps", "multigrid"] {
        for ranks in [1, 2] {
            let with = |height| column(height).set(&format!("solver.linear={solver}")).on(ranks);
            let stable = with(7.2);
            assert!(instabilities(&stable).is_empty(), "{}: {:?}", stable.label, stable.report);
            let found = instabilities(&with(8.4));
            assert_eq!(found.len(), 1, "{solver} on {ranks}");
            assert!(found[0].contains("tilting of interface joint"), "{found:?}");
            assert!(solver != "mumps" || found[0].contains("has 2 negative"), "{found:?}");
        }
    }
}

/// Two interfaces in series, the upper one weaker.
fn two(instants: usize, upper: f64) -> Scene {
    let list: Vec<String> =
        (1..=instants).map(|i| (i as f64 / instants as f64).to_string()).collect();
    let law = |strength: f64| {
        format!("{{linear_softening: {{strength: {strength}, fracture_energy: 900.0}}}}")
    };
    let yaml = format!(
        "
mesh: {{column: {{size: [1.0, 1.0, 3.0], cells: [2, 2, 9]}}}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.0}}}}}}
interfaces:
  - {{name: lower, z: 1.0, law: {}}}
  - {{name: upper, z: 2.0, law: {}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{on: top, displacement: {{x: 0, y: 0, z: {{formula: \"1.4e-3*t\"}}}}}}
time: {{instants: [{}]}}
",
        law(1.1e6),
        law(upper),
        list.join(", "),
    );
    Scene::new("two", &yaml)
}

/// One step far past the peak must not land on the state in which both interfaces are open.
#[test]
fn of_two_interfaces_the_weaker_alone_opens_in_one_step() {
    let slow = two(20, 0.9e6).set("solver.stability=warn").on(1);
    assert!(instabilities(&slow).is_empty());
    for setting in ["stability=auto", "stability=stop", "linear=multigrid"] {
        let fast = two(1, 0.9e6).set(&format!("solver.{setting}")).in_any_steps().on(1);
        for name in ["lower.damage.max", "upper.damage.mean", "upper.normal_traction.mean"] {
            let (slow, fast) = (slow.column(name), fast.column(name));
            let last = slow[slow.len() - 1];
            assert!((last - fast[0]).abs() <= 1e-8 * last.abs(), "{name}: {slow:?} {fast:?}");
        }
        assert_eq!(fast.column("lower.damage.max"), [0.0]);
    }
}

/// Two equal ones open together, which is an equilibrium, but no stable one.
#[test]
fn two_equal_interfaces_are_told_to_be_unstable() {
    let run = two(1, 1.1e6).set("solver.stability=warn").on(1);
    let found = instabilities(&run);
    assert_eq!(found.len(), 1);
    assert!(found[0].contains("opening of interface"), "{found:?}");
}
