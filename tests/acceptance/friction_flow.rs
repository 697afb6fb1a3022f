//! Friction beside fluid: faults that slip as their fluid takes pressure off them.

use crate::flow::last;
use crate::scene::{Kind, Run, Scene};

const FLUID: &str = "porous: {biot: 0.8, porosity: 0.1, permeability: 1.0e-15, viscosity: 1.0e-3,
             fluid_compressibility: 5.0e-10, fluid_density: 1000, density: 2300}";

/// Pressed, then sheared there and back while pressures grow; bodies of `cells` and others.
fn sheared(cells: [&str; 2], law: &str, fluid: &str) -> Scene {
    let [lower, upper] = cells;
    let yaml = format!(
        "
mesh: {{column: {{size: [1.0, 2.0], bodies: [{{cells: {lower}}}, {{cells: {upper}}}]}}}}
materials:
  rock:
    elastic: {{young_modulus: 5.0e9, poisson_ratio: 0.2}}
    {FLUID}
interfaces: [{{name: fault, z: 1.0, law: {law}, {fluid}}}]
boundary:
  - {{on: bottom, displacement: {{x: 0, z: 0}}, pressure: {{table: [[1, 0], [6, 8.0e5]]}}}}
  - on: top
    displacement:
      x: {{table: [[1, 0], [3, 6.0e-4], [4, 6.0e-4], [6, -4.0e-4]]}}
      z: {{table: [[0, 0], [1, -6.0e-4]]}}
    pressure: 0
  - {{on: left, traction: {{x: 5.0e5}}}}
time: {{instants: [1, 2, 3, 4, 5, 6]}}
"
    );
    Scene::new("fault", &yaml).in_any_steps()
}

const CONTACT: &str = "{contact: {friction: 0.2}}";
const COHESIVE: &str = "{linear_softening: {strength: 1.5e5, fracture_energy: 20, friction: 0.2}}";
const IMPOSED: &str = "fluid: {pressure: {table: [[1, 0], [6, 1.0e6]]}}";
const INJECTED: &str =
    "fluid: {injection: {table: [[1, 0], [6, 0.02]]}}, initial: {aperture: 5.0e-5}";

fn assert_same(one: &Run, other: &Run, tolerance: f64) {
    assert_eq!(one.table.rows.len(), other.table.rows.len());
    let difference = one.difference_above(other, |kind| match kind {
        Kind::Length => 1.0e-4,
        Kind::Damage => 1.0,
        _ => f64::MIN_POSITIVE,
    });
    assert!(difference <= tolerance, "{} {}: {difference:e}", one.label, other.label);
}

/// The work of loads and fluid is what is stored, dissipated and taken by friction.
fn assert_balance(run: &Run, relative: f64) {
    let of = |name: &str| run.column(&format!("energy.{name}"));
    let [given, kept] = [vec!["external", "fluid"], vec!["elastic", "dissipated", "friction"]]
        .map(|names| names.into_iter().map(of).reduce(sum).expect("columns"));
    for (given, kept) in given.iter().zip(kept) {
        assert!((given - kept).abs() <= relative * given.abs(), "{}: {given} {kept}", run.label);
    }
}

fn sum(a: Vec<f64>, b: Vec<f64>) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

/// The shipped case in 3D, of second order, with iterations.
#[test]
fn a_fault_slips_where_the_effective_pressure_lets_it() {
    let flat = Scene::shipped("friction/injection.yaml");
    let deep = flat
        .set("mesh.column={size: [1, 1, 2], bodies: [{cells: [2, 1, 1]}, {cells: [1, 2, 2]}]}")
        .set("boundary.0.displacement.y=0")
        .set("boundary.1.displacement.y=0");
    for (scene, linear, ranks) in [
        (flat.set("mesh.order=2"), "mumps", 2),
        (flat.set("mesh.column.cells=[4, 4]"), "aggregation", 3),
        (deep, "mumps", 3),
    ] {
        let run = scene.set("expect=[]").set(&format!("solver.linear={linear}")).on(ranks);
        let of = |name: &str| run.column(&format!("fault.{name}.mean"));
        let (pressure, normal) = (of("pressure"), of("normal_traction"));
        let (shear, slid) = (of("shear_traction_x"), of("sliding_x"));
        for (row, slides) in [(3, true), (4, true), (7, true), (2, false), (5, false)] {
            let bears = 0.6 * (2.0e6 - pressure[row]);
            assert!((normal[row] + 2.0e6 - pressure[row]).abs() < 2.0, "{}", run.label);
            assert_eq!((shear[row].abs() - bears).abs() < 0.1, slides, "{} {row}", run.label);
        }
        let exact = [0.0, 0.0, 0.0, 2.4e-10, 1.2e-4, 1.2e-4, 1.2e-4, 2.0e-5];
        for (slid, exact) in slid.iter().zip(exact) {
            assert!((slid - exact).abs() < 1e-12, "{}: {slid:e} {exact:e}", run.label);
        }
        assert_eq!(run.column("fault.slip.max")[2], 0.0, "{}", run.label);
        run.assert_column(
            "energy.friction",
            &[0.0, 0.0, 0.0, 0.0, 54.0, 54.0, 54.0, 144.0],
            1e-6,
            1e-3,
        );
    }
}

/// With factors of both fields a linear solve takes one iteration where lips slide: the pressure is
/// in the traction that friction follows.
#[test]
fn sliding_lips_are_eliminated_together_with_the_pressure() {
    let scene = sheared(["[4, 3]", "[3, 2]"], CONTACT, IMPOSED);
    let one = scene.set("solver.linear=mumps").on(1);
    assert_eq!(one.column("linear_iterations"), one.corrections());
    assert!(last(&one, "fault.slip.max") > 1e-5);
    assert_balance(&one, 1e-10);
    for (solver, ranks) in [("mumps", 3), ("aggregation", 2)] {
        assert_same(&one, &scene.set(&format!("solver.linear={solver}")).on(ranks), 1e-9);
    }
    assert_same(&one, &scene.stopped(2, "history:1:term:2", 3), 1e-8);
}

#[test]
fn injected_faults_slide_alike_on_all_ranks_and_go_on_after_a_stop() {
    for law in [CONTACT, COHESIVE] {
        let scene = sheared(["[4, 3]", "[3, 2]"], law, INJECTED);
        let one = scene.on(1);
        assert!(last(&one, "energy.friction") > 1.0);
        let [fluid, out, stored] =
            ["in", "out", "stored"].map(|n| last(&one, &format!("mass.{n}")));
        assert!((fluid - out - stored).abs() <= 1e-10 * fluid, "{fluid} {out} {stored}");
        assert_same(&one, &scene.set("solver.linear=multigrid").on(3), 1e-9);
        assert_same(&one, &scene.stopped(3, "history:2:term:3", 2), 1e-8);
    }
}

/// Fluid that neither presses nor flows leaves the dry answer.
#[test]
fn without_pressure_the_answer_is_the_dry_one() {
    let dry = Scene::shipped("friction/joint.yaml").set("expect=[]");
    let porous = "materials.rock.porous={biot: 1.0e-12, porosity: 1.0e-12, permeability: 1.0e-30, \
                  viscosity: 1, fluid_compressibility: 1.0e-9, fluid_density: 1000, density: 2000}";
    let wet = dry.set(porous).set("physics=hydro_mechanics").set("solver.linear=mumps");
    let known = wet.set("boundary.4={on: all, pressure: 0}");
    let (dry, wet) = (dry.on(1), wet.on(2));
    let difference = |other: &Run| {
        let mut worst = 0.0_f64;
        for name in ["joint.shear_traction_x.mean", "joint.normal_traction.mean"] {
            let pairs = dry.column(name).into_iter().zip(other.column(name));
            worst = pairs.fold(worst, |worst, (a, b)| worst.max((a - b).abs() / 1.0e6));
        }
        for name in ["joint.sliding_x.mean", "joint.normal_jump.mean", "joint.slip.mean"] {
            let pairs = dry.column(name).into_iter().zip(other.column(name));
            worst = pairs.fold(worst, |worst, (a, b)| worst.max((a - b).abs() / 2.4e-3));
        }
        worst
    };
    assert!(difference(&wet) < 1e-9, "{:e}", difference(&wet));
    let known = known.on(1);
    assert!(difference(&known) < 1e-9, "{:e}", difference(&known));
}
