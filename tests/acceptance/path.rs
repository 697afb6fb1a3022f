//! Path following: through snap-back, whatever the solver, the number of ranks and the shape of the
//! front.

use crate::scene::{Run, Scene};

/// A column of 20 m, which snaps back, whose top is pulled unevenly.
fn uneven(control: &str, instants: &str) -> Scene {
    let yaml = format!(
        "
mesh: {{column: {{size: [1.0, 1.0, 20.0], cells: [4, 4, 40]}}}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.25}}}}}}
interfaces:
  - {{name: joint, z: 10.0, law: {{linear_softening: {{strength: 1.1e6, fracture_energy: 900.0}}}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{on: top, displacement: {{x: 0, y: 0, z: {{formula: \"1 + 0.2*(x-0.5) + 0.1*(y-0.5)\"}}}}}}
control: {control}
time: {{instants: {instants}}}
"
    );
    // At the first point that gives way only a small step is close to linear.
    Scene::new("uneven", &yaml).in_any_steps()
}

/// On the numbers of ranks of `eliminated`, and by multigrid on those of `levels`.
fn the_same(scene: &Scene, eliminated: &[usize], levels: &[usize]) -> Run {
    let with = |solver: &str, ranks| scene.set(&format!("solver.linear={solver}")).on(ranks);
    let one = with("mumps", 1);
    // Past the peak the loads fall while the interface opens.
    let factor = one.column("load_factor");
    let peak = factor.iter().copied().fold(0.0, f64::max);
    assert!(factor[factor.len() - 1] < 0.7 * peak, "{factor:?}");
    for ranks in eliminated {
        one.assert_same(&with("mumps", *ranks), 1e-8);
    }
    for ranks in levels {
        one.assert_same(&with("multigrid", *ranks), 1e-8);
    }
    one
}

#[test]
fn a_given_opening_scales_the_loads() {
    let control = "{opening: {of: joint, equals: {table: [[0, 0], [1, 1.6e-3]]}}}";
    the_same(&uneven(control, "[0.05, 0.2, 0.4, 0.6, 0.8, 1]"), &[4], &[2]);
}

#[test]
fn a_given_dissipation_breaks_the_interface() {
    let scene = uneven("{dissipation: {of: joint, step: 0.1}}", "[1]");
    // Several times as many steps as along an opening, which has the other numbers of ranks.
    let run = the_same(&scene, &[3], &[2]);
    let dissipated = run.column("energy.dissipated");
    assert_eq!(dissipated.len(), 11);
    for (part, energy) in run.column("time").iter().zip(dissipated) {
        assert!((energy - 900.0 * part).abs() <= 1e-8 * 900.0, "{part}: {energy}");
    }
}

#[test]
#[ignore = "half a minute: cargo test --release --test acceptance path:: -- --ignored"]
fn a_given_dissipation_is_the_same_on_1_to_4_ranks() {
    the_same(&uneven("{dissipation: {of: joint, step: 0.1}}", "[1]"), &[2, 3, 4], &[1, 2]);
}

/// Two interfaces: the weaker one alone opens, and the other unloads.
#[test]
fn of_two_interfaces_the_weaker_breaks() {
    let law = |strength: &str| {
        format!("{{linear_softening: {{strength: {strength}, fracture_energy: 900.0}}}}")
    };
    let yaml = format!(
        "
mesh: {{column: {{size: [1.0, 1.0, 30.0], cells: [1, 1, 9]}}}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.0}}}}}}
interfaces:
  - {{name: lower, z: 10.0, law: {}}}
  - {{name: upper, z: 20.0, law: {}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{on: top, displacement: {{x: 0, y: 0, z: 1}}}}
control: {{dissipation: {{of: upper, step: 0.05}}}}
time: {{instants: [1]}}
",
        law("1.1e6"),
        law("0.9e6"),
    );
    let run = Scene::new("two", &yaml).on(1);
    let damage = run.column("lower.damage.max");
    assert!(damage.iter().all(|d| *d == 0.0), "{damage:?}");
    let critical = 2.0 * 900.0 / 0.9e6;
    let parts = run.column("time").into_iter().zip(run.column("load_factor"));
    for (part, factor) in parts {
        let exact = part * critical + 0.9e6 * (1.0 - part) * 30.0 / 5.8e9;
        assert!((factor - exact).abs() <= 1e-8 * exact, "{part}: {factor} for {exact}");
    }
    let dissipated = run.column("energy.dissipated");
    assert!((dissipated[dissipated.len() - 1] - 900.0).abs() <= 1e-8 * 900.0);
}

/// Along the opening of a joint, past its peak in one step, a stronger joint in series stays whole.
#[test]
fn a_stronger_joint_in_series_stays_whole() {
    let yaml = "
mesh: {column: {size: [0.5, 3], cells: [1, 3]}}
materials: {rock: {elastic: {young_modulus: 1.0e9, poisson_ratio: 0}}}
interfaces:
  - {name: weak, z: 1, law: {bilinear: {strength: 1.0e5, fracture_energy: 90, stiffness: 1.0e9}}}
  - {name: strong, z: 2, law: {linear_softening: {strength: 1.1e5, fracture_energy: 108.9}}}
boundary:
  - {on: bottom, displacement: {x: 0, z: 0}}
  - {on: top, displacement: {x: 0, z: 4.5e-4}}
control: {opening: {of: weak, equals: {table: [[0, 0], [1, 1.5e-5], [2, 1.6e-4]]}}}
time: {instants: [1, 2]}
";
    // From the peak at 1e-4 m on a line to 1.8e-3 m.
    let traction = 1.0e5 * (1.8e-3 - 1.6e-4) / 1.7e-3;
    for (ranks, solver) in [(1, "mumps"), (2, "gamg")] {
        let run = Scene::new("in_series", yaml).set(&format!("solver.linear={solver}")).on(ranks);
        let found = run.column("weak.normal_traction.mean")[1];
        assert!((found - traction).abs() < 1e-8 * traction, "{}: {found}", run.label);
        assert_eq!(run.column("strong.damage.max"), [0.0, 0.0], "{}", run.label);
    }
}
