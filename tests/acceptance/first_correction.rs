//! The first correction of a step is the linear answer of the accepted state: what the loads leave
//! out of balance before it is no traction to judge a law by.

use crate::scene::{Run, Scene};

/// A column with its interfaces, one per line of YAML, and the boundary of its top.
fn column(size: &str, cells: &str, poisson: f64, interfaces: &[&str], top: &str) -> Scene {
    let dim = size.split(',').count();
    let held = if dim == 2 { "x: 0, z: 0" } else { "x: 0, y: 0, z: 0" };
    let interfaces: String = interfaces.iter().map(|line| format!("  - {line}\n")).collect();
    let yaml = format!(
        "
mesh: {{column: {{size: {size}, cells: {cells}}}}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: {poisson}}}}}}}
interfaces:
{interfaces}boundary:
  - {{on: bottom, displacement: {{{held}}}}}
  - {{on: top, {top}}}
time: {{instants: [1]}}
"
    );
    Scene::new("first_correction", &yaml)
}

fn joint(name: &str, z: f64, strength: f64, secondary: &str) -> String {
    let law = format!("{{linear_softening: {{strength: {strength}, fracture_energy: 900}}}}");
    format!("{{name: {name}, z: {z}, law: {law}, secondary: {secondary}}}")
}

fn assert_value(run: &Run, column: &str, exact: f64, scale: f64) {
    let values = run.column(column);
    let value = values[values.len() - 1];
    assert!((value - exact).abs() <= 1e-8 * scale, "{}: {column} {value} {exact}", run.label);
}

/// Of two joints in series the weaker opens, wherever the other lies, whichever side carries the
/// multipliers, and however far the step passes both strengths.
#[test]
fn the_weaker_joint_opens() {
    const WEAK: f64 = 1.1e6;
    let slope = WEAK * WEAK / 1800.0;
    for (cells, secondary, pull) in [
        ("[2, 2, 5]", "upper", 1.2e-3),
        ("[2, 2, 5]", "lower", 1.5e-3),
        ("[1, 2, 10]", "upper", 1.6e-3),
    ] {
        for (lower, upper) in [(WEAK, 1.5e6), (1.5e6, WEAK)] {
            let joints =
                [joint("lower", 2.0, lower, "upper"), joint("upper", 4.5, upper, secondary)];
            let joints: Vec<&str> = joints.iter().map(String::as_str).collect();
            let top = format!("displacement: {{x: 0, y: 0, z: {{table: [[0, 0], [1, {pull}]]}}}}");
            let scene = column("[1, 1, 5]", cells, 0.0, &joints, &top).in_any_steps();
            let stiffness = 5.8e9 / 5.0;
            let traction = stiffness * (pull - WEAK / slope) / (1.0 - stiffness / slope);
            let (weak, strong) =
                if lower < upper { ("lower", "upper") } else { ("upper", "lower") };
            for (ranks, solver) in [(1, "mumps"), (2, "gamg")] {
                let run = scene.set(&format!("solver.linear={solver}")).on(ranks);
                assert_value(&run, &format!("{weak}.normal_traction.mean"), traction, WEAK);
                assert_value(&run, &format!("{strong}.damage.max"), 0.0, 1.0);
            }
        }
    }
}

/// A displacement that is there from the start shears a joint below its strength: it holds, with
/// either form and side, in one correction.
#[test]
fn a_joint_below_its_strength_holds() {
    let shear = 5.8e9 / 2.0 * 2.0e-5 / 3.0;
    for side in ["upper", "lower"] {
        let joint = joint("j", 2.5, 5.0 * shear, side);
        let top = "displacement: {x: 2.0e-5, y: 0, z: 0}";
        let scene = column("[1, 1, 3]", "[2, 2, 6]", 0.0, &[&joint], top);
        for form in ["condensed", "saddle_point"] {
            let run = scene.set(&format!("solver.form={form}")).on(2);
            assert_value(&run, "j.damage.max", 0.0, 1.0);
            assert_value(&run, "j.sliding_x.max", 0.0, 2.0e-5);
            assert_eq!(run.column("newton_iterations"), [1.0]);
        }
    }
}

/// Fluid above the strength, in a joint that dead loads keep closed or leave pulled below its
/// strength: loads that are there from the start act together.
#[test]
fn fluid_and_loads_act_together() {
    for (pressure, total) in [(2.0e6, -5.0e6), (6.0e6, -5.0e6), (9.0e6, -1.2e7)] {
        let law = "{linear_softening: {strength: 1.1e6, fracture_energy: 900}}";
        let joint = format!("{{name: j, z: 2.5, law: {law}, fluid: {{pressure: {pressure}}}}}");
        let solid = ("[1, 1, 5]", "[3, 3, 10]");
        for (size, cells) in [solid, ("[1, 5]", "[4, 8]")] {
            let top = format!("traction: {{z: {total}}}");
            let scene = column(size, cells, 0.25, &[&joint], &top);
            for (ranks, solver) in [(1, "mumps"), (2, "gamg"), (3, "mumps")] {
                let run = scene.set(&format!("solver.linear={solver}")).on(ranks);
                assert_value(&run, "j.normal_traction.mean", total + pressure, pressure);
                assert_value(&run, "j.damage.max", 0.0, 1.0);
            }
        }
    }
}

/// A contact that opens relieves a joint in series with it, which would break if it stayed closed: with
/// every solver, in one step.
#[test]
fn a_contact_that_opens_spares_a_joint() {
    let joint = joint("joint", 1.0, 1.0e6, "upper");
    let contact = "{name: contact, z: 3, law: {contact: {}}}";
    let path = "{table: [[0, 0], [1, -1.0e-3], [2, 2.5e-3], [3, -2.5e-4]]}";
    let top = format!("displacement: {{x: 0, z: {path}}}");
    let sides = "boundary.2={on: left, displacement: {x: 0}}";
    let scene = column("[0.5, 5]", "[3, 10]", 0.0, &[&joint, contact], &top);
    let scene = scene.set(sides).set("time.instants=[1, 2, 3]");
    for (ranks, solver) in [(1, "mumps"), (2, "gamg"), (1, "hypre"), (3, "multigrid")] {
        let run = scene.set(&format!("solver.linear={solver}")).on(ranks);
        let jump = run.column("contact.normal_jump.mean");
        assert!((jump[1] - 2.5e-3).abs() <= 2.5e-11, "{}: {jump:?}", run.label);
        assert_value(&run, "joint.damage.max", 0.0, 1.0);
        assert_value(&run, "joint.normal_traction.mean", -2.9e5, 2.9e5);
    }
}

/// A contact is opened before any force has acted, and pressed later: with every solver, in any
/// unit of length.
#[test]
fn a_contact_opens_from_rest() {
    let path = |scale: f64| {
        let (open, shut) = (6.0e-4 * scale, -5.0e-5 * scale);
        format!("{{table: [[0, 0], [1, {open:e}], [2, {shut:e}]]}}")
    };
    let joint = "{name: j, z: 2.5, law: {contact: {}}}";
    let top = format!("displacement: {{x: 0, y: 0, z: {}}}", path(1.0));
    let scene = column("[1, 1, 4]", "[2, 2, 8]", 0.0, &[joint], &top).set("time.instants=[1, 2]");
    for (ranks, solver) in [(1, "mumps"), (2, "gamg"), (2, "hypre"), (3, "multigrid")] {
        let run = scene.set(&format!("solver.linear={solver}")).on(ranks);
        let jump = run.column("j.normal_jump.max");
        assert!((jump[0] - 6.0e-4).abs() <= 1e-12, "{}: {jump:?}", run.label);
        assert_value(&run, "j.normal_traction.mean", -5.8e9 * 5.0e-5 / 4.0, 7.25e4);
    }
    let top = format!("displacement: {{x: 0, y: 0, z: {}}}", path(1e3));
    let joint = "{name: j, z: 2500, law: {contact: {}}}";
    let long = column("[1000, 1000, 4000]", "[2, 2, 8]", 0.0, &[joint], &top);
    let run = long.set("time.instants=[1, 2]").on(1);
    assert_value(&run, "j.normal_traction.mean", -5.8e9 * 5.0e-5 / 4.0, 7.25e4);
}

/// A law whose traction depends on the length of the steps: what presses open lips together is
/// told.
#[test]
fn lips_that_are_open_and_pressed_are_told() {
    let yaml = "
mesh: {column: {size: [1, 1.5, 3], bodies: [{cells: [3, 4, 4]}, {cells: [4, 5, 5]}]}}
materials:
  hard: {elastic: {young_modulus: 3.0e+10, poisson_ratio: 0.2}, z: [0, 1.4]}
  soft: {elastic: {young_modulus: 8.0e+9, poisson_ratio: 0.35}, z: [1.4, 3]}
interfaces:
  - {name: j, z: 1.4, law: {benzeggagh_kenane: {strength: 1.5e6, shear_strength: 2.0e6,
     fracture_energy: 600, shear_fracture_energy: 1200, exponent: 1.8}}}
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}
  - {on: top, displacement: {x: {formula: \"4e-4*t\"}, y: 0,
     z: {formula: \"4e-4*t*(1+0.5*x-0.3*y)\"}}}
  - {on: right, traction: {x: {formula: \"2e5*t*z\"}}}
time: {instants: [0.5, 1, 1.5]}
";
    let run = Scene::new("turning_modes", yaml).in_any_steps().on(1);
    let remarks = run.told("remarks");
    assert!(remarks.iter().any(|r| r.contains("is open and pressed")), "{remarks:?}");
}
