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
    let loads = [(2.0e6, -5.0e6), (6.0e6, -5.0e6), (9.0e6, -1.2e7)];
    // The scenes share out the solvers.
    let solvers = [(1, "mumps"), (2, "gamg"), (3, "mumps")];
    for (index, (pressure, total)) in loads.into_iter().enumerate() {
        let law = "{linear_softening: {strength: 1.1e6, fracture_energy: 900}}";
        let joint = format!("{{name: j, z: 2.5, law: {law}, fluid: {{pressure: {pressure}}}}}");
        let solid = ("[1, 1, 5]", "[3, 3, 10]");
        for (place, (size, cells)) in [solid, ("[1, 5]", "[4, 8]")].into_iter().enumerate() {
            let top = format!("traction: {{z: {total}}}");
            let scene = column(size, cells, 0.25, &[&joint], &top);
            let (ranks, solver) = solvers[(index + place) % 3];
            let run = scene.set(&format!("solver.linear={solver}")).on(ranks);
            assert_value(&run, "j.normal_traction.mean", total + pressure, pressure);
            assert_value(&run, "j.damage.max", 0.0, 1.0);
        }
    }
}

/// A contact that opens relieves a joint in series with it, which would break if it stayed closed:
/// with every solver, in one step.
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

/// A law whose traction depends on the length of the steps: where it presses open lips together
/// steps are cut, and what is left of it is told once.
#[test]
fn steps_that_press_open_lips_are_cut() {
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
    let scene = Scene::new("turning_modes", yaml).in_any_steps();
    let run = scene.on(1);
    let remarks = run.told("remarks");
    let of_lips = remarks.iter().filter(|r| r.contains("is open and pressed"));
    assert_eq!(of_lips.count(), 1, "{remarks:?}");
    let last = |run: &Run| run.column("energy.dissipated").pop().expect("three instants");
    let finer: Vec<String> = (1..=40).map(|i| (0.0375 * f64::from(i)).to_string()).collect();
    let finer = scene.set(&format!("time.instants=[{}]", finer.join(", "))).on(1);
    let (coarse, fine) = (last(&run), last(&finer));
    assert!((coarse / fine - 1.0).abs() < 0.05, "dissipated {coarse} J, in finer steps {fine} J");
}

/// Beside prescribed components the tangent is not symmetric: points that begin to soften there,
/// under tension and shear, need all of it. The condensed form makes the corrections of the saddle
/// point.
#[test]
fn points_beside_held_ones_soften() {
    let yaml = "
mesh: {column: {size: [5.0e-4, 4.0e-3], cells: [4, 4]}}
materials: {rock: {elastic: {young_modulus: 1.0e10, poisson_ratio: 0}}}
interfaces:
  - {name: j, z: 2.0e-3, law: {linear_softening: {strength: 1.8e6, fracture_energy: 762}}}
boundary:
  - {on: bottom, displacement: {z: 0}}
  - {on: left, displacement: {x: 0}}
  - {on: right, displacement: {x: 0}}
  - {on: top, displacement: {z: {formula: \"5e-7*t*(1+2e3*(x-2.5e-4))\"}}}
time: {instants: [1, 2, 3]}
";
    let scene = Scene::new("beside_held", yaml);
    let saddle = scene.set("solver.form=saddle_point").on(1);
    for (ranks, solver) in [(1, "mumps"), (2, "gamg"), (1, "hypre"), (2, "multigrid")] {
        let run = scene.set(&format!("solver.linear={solver}")).on(ranks);
        for name in
            ["j.normal_traction.mean", "j.normal_jump.max", "j.damage.max", "top.reaction_z"]
        {
            let pairs = run.column(name).into_iter().zip(saddle.column(name));
            for (value, exact) in pairs {
                assert!((value - exact).abs() <= 1e-7 * exact.abs(), "{}: {name}", run.label);
            }
        }
        if solver == "mumps" {
            assert_eq!(run.column("newton_iterations"), saddle.column("newton_iterations"));
        }
    }
}

/// As before, in 3D with unlike meshes and a contact in series: what is not symmetric is little
/// beside the forces, and stiff secants make much of it.
#[test]
fn points_beside_held_ones_soften_above_a_contact() {
    let yaml = "
mesh: {column: {size: [1.5, 0.5, 4], bodies: [{cells: [2, 5, 2]}, {cells: [1, 4, 1]}, {cells: [1, 4, 1]}]}}
materials:
  soft: {z: [0, 2], elastic: {young_modulus: 1.0e9, poisson_ratio: 0}}
  hard: {z: [2, 3], elastic: {young_modulus: 5.0e10, poisson_ratio: 0}}
  top: {z: [3, 4], elastic: {young_modulus: 2.0e9, poisson_ratio: 0}}
interfaces:
  - {name: open, z: 2, law: {contact: {}}}
  - name: j
    z: 3
    law: {linear_softening: {strength: 1.9e5, fracture_energy: 1.4e5}}
    fluid: {pressure: {table: [[0, 0], [3, 1.25e5]]}}
boundary:
  - {on: bottom, displacement: {z: 0}}
  - {on: left, displacement: {x: 0}}
  - {on: front, displacement: {y: 0}}
  - {on: top, displacement: {z: {formula: \"6.3e-5*(t+max(t-1,0))*(1-2*(y-0.25))\"}}}
  - {on: right, traction: {z: {table: [[0, 0], [3, -4.0e4]]}}}
time: {instants: [1, 2, 3]}
";
    let scene = Scene::new("above_contact", yaml);
    let saddle = scene.set("solver.form=saddle_point").on(1);
    for (ranks, solver) in [(1, "mumps"), (3, "mumps"), (2, "gamg"), (1, "multigrid")] {
        let run = scene.set(&format!("solver.linear={solver}")).on(ranks);
        saddle.assert_same(&run, 1e-6);
    }
}

/// An intrinsic law opens from rest before anything gives way: in one step far past all strengths
/// the weakest of three joints still softens alone.
#[test]
fn an_intrinsic_joint_opens_before_others_soften() {
    let yaml = "
mesh: {column: {size: [0.5, 4], cells: [1, 4]}}
materials: {rock: {elastic: {young_modulus: 1.0e9, poisson_ratio: 0}}}
interfaces:
  - {name: a, z: 1, law: {linear_softening: {strength: 1.8e5, fracture_energy: 77.76}}}
  - {name: b, z: 2, law: {bilinear: {strength: 1.9e5, fracture_energy: 64.98, stiffness: 5.0e9}}}
  - {name: c, z: 3, law: {linear_softening: {strength: 1.6e5, fracture_energy: 92.16}}}
boundary:
  - {on: bottom, displacement: {x: 0, z: 0}}
  - {on: top, displacement: {x: 0, z: 9.0e-4}}
time: {instants: [1]}
solver: {stability: off}
";
    // t/2.5e8 + t/5e9 + w = 9e-4 with t = 1.6e5 - h w.
    let slope = 1.6e5 * 1.6e5 / (2.0 * 92.16);
    let compliance = 1.0 / 2.5e8 + 1.0 / 5.0e9;
    let traction = (9.0e-4 - 1.6e5 / slope) / (compliance - 1.0 / slope);
    for form in ["condensed", "saddle_point"] {
        let run = Scene::new("intrinsic", yaml).set(&format!("solver.form={form}")).on(1);
        for joint in ["a", "b", "c"] {
            assert_value(&run, &format!("{joint}.normal_traction.mean"), traction, 1.6e5);
        }
        assert_value(&run, "a.damage.max", 0.0, 1.0);
        assert_value(&run, "b.damage.max", 0.0, 1.0);
    }
}

/// A drained body is lifted off a contact as a whole: neither forces nor flow, but for rounding.
#[test]
fn a_porous_body_is_lifted() {
    let yaml = "
mesh: {column: {size: [1.0e-3, 5.0e-3], cells: [2, 5]}}
materials:
  rock:
    elastic: {young_modulus: 5.0e7, poisson_ratio: 0}
    porous: {biot: 0.8, porosity: 0.2, permeability: 1.0e-10, viscosity: 1.0e4,
             fluid_compressibility: 5.0e-8, fluid_density: 1000, density: 2500}
interfaces: [{name: j, z: 2.0e-3, law: {contact: {}}}]
boundary:
  - {on: bottom, displacement: {z: 0}}
  - {on: left, displacement: {x: 0}}
  - {on: top, displacement: {z: 2.5e-7}, pressure: 0}
physics: hydro_mechanics
time: {instants: [1]}
";
    for (ranks, solver) in [(1, "mumps"), (2, "hypre")] {
        let scene = Scene::new("lifted", yaml).set(&format!("solver.linear={solver}"));
        let run = scene.on(ranks);
        assert_value(&run, "j.normal_jump.min", 2.5e-7, 2.5e-7);
        assert_value(&run, "j.normal_traction.max", 0.0, 1.0e3);
    }
}
