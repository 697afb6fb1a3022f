//! Cracks, gaps and apertures that are there at the start.

use crate::blocks::{Block, Blocks, even};
use crate::scene::{SOLVERS, Scene};

const LINEAR: &str = "{linear_softening: {strength: 1.0e6, fracture_energy: 1000}}";

#[test]
fn shipped_columns_start_damaged_or_apart() {
    for (case, order, ranks, side) in [
        ("crack/damaged.yaml", 1, 1, "lower"),
        ("crack/damaged.yaml", 2, 3, "upper"),
        ("crack/gap.yaml", 1, 2, "upper"),
        ("crack/gap.yaml", 2, 1, "lower"),
    ] {
        let scene = Scene::shipped(case).set(&format!("mesh.order={order}"));
        let scene = scene.set(&format!("solver.linear={}", SOLVERS[(order + ranks) % 5]));
        let run = scene.set(&format!("interfaces.0.secondary={side}")).on(ranks);
        assert_eq!(run.report["status"], "done", "{}", run.label);
    }
}

/// A column of 2 m with a joint at mid height that is drawn, sheared, unloaded and pressed: `law`
/// of the joint, `initial` state; `before` is what it goes through first, by instant (x, z).
fn column(law: &str, initial: &str, before: &[[f64; 2]]) -> Scene {
    let after = [[0.0, 1e-5], [1e-4, 2e-4], [0.0, -1e-4], [9e-4, 6e-4], [0.0, 0.0], [0.0, 3e-3]];
    let ways: Vec<[f64; 2]> = before.iter().chain(&after).copied().collect();
    let of = |c: usize| {
        let rows = ways.iter().enumerate().map(|(t, way)| format!("[{}, {:e}]", t + 1, way[c]));
        rows.collect::<Vec<_>>().join(", ")
    };
    let times: Vec<String> = (1..=ways.len()).map(|t| t.to_string()).collect();
    let yaml = format!(
        "
mesh: {{column: {{size: [1, 2], bodies: [{{cells: [2, 1]}}, {{cells: [3, 1]}}]}}}}
materials: {{rock: {{elastic: {{young_modulus: 1.0e10, poisson_ratio: 0}}}}}}
interfaces: [{{name: joint, z: 1, law: {law}{initial}}}]
boundary:
  - {{on: bottom, displacement: {{x: 0, z: 0}}}}
  - on: top
    displacement: {{x: {{table: [[0, 0], {}]}}, z: {{table: [[0, 0], {}]}}}}
time: {{instants: [{}]}}
solver: {{stability: \"off\"}}
",
        of(0),
        of(1),
        times.join(", ")
    );
    Scene::new("start", &yaml)
}

/// With every law that softens: what starts with a damage goes on as what was loaded to it and
/// unloaded.
#[test]
fn a_damage_at_the_start_is_as_good_as_one_from_loading() {
    for (law, ranks) in [
        (LINEAR, 1),
        ("{exponential_softening: {strength: 1.0e6, fracture_energy: 1000}}", 2),
        ("{bilinear: {strength: 1.0e6, fracture_energy: 1000, stiffness: 1.0e10}}", 1),
        (
            "{benzeggagh_kenane: {strength: 1.0e6, shear_strength: 1.5e6, fracture_energy: 1000, \
             shear_fracture_energy: 1500, exponent: 2}}",
            1,
        ),
        ("{linear_softening: {strength: 1.0e6, fracture_energy: 1000, friction: 0.5}}", 1),
    ] {
        let loaded = column(law, "", &[[0.0, 7e-4], [0.0, 0.0]]).in_any_steps().on(1);
        let damage = loaded.column("joint.damage.mean")[1];
        assert!(damage > 0.1 && damage < 0.9, "{law}: {damage}");
        let initial = format!(", initial: {{damage: {damage:.17e}}}");
        let given = column(law, &initial, &[]).in_any_steps().on(ranks);
        let cost = loaded.column("energy.dissipated")[1];
        for (name, scale) in [
            ("joint.normal_traction.mean", 1e6),
            ("joint.shear_traction_x.mean", 1e6),
            ("joint.normal_jump.mean", 1e-3),
            ("joint.sliding_x.mean", 1e-3),
            ("joint.damage.mean", 1.0),
            ("energy.dissipated", cost),
        ] {
            let off = if name == "energy.dissipated" { cost } else { 0.0 };
            let pairs = loaded.column(name)[2..].to_vec().into_iter().zip(given.column(name));
            for (row, (one, two)) in pairs.enumerate() {
                let error = (one - off - two).abs();
                assert!(error <= 1e-9 * scale, "{law} {name} row {row}: {one:e} {two:e}");
            }
        }
    }
}

/// What a formula leaves of a damage where it comes to nothing, by rounding or along a tail, is
/// none: the joint is the sound one there, with friction and without.
#[test]
fn a_trace_of_damage_at_the_start_is_none() {
    for law in [
        "{linear_softening: {strength: 1.0e6, fracture_energy: 1000, friction: MU}}",
        "{exponential_softening: {strength: 1.0e6, fracture_energy: 1000, friction: MU}}",
        "{bilinear: {strength: 1.0e6, fracture_energy: 1000, stiffness: 1.0e10, friction: MU}}",
        "{benzeggagh_kenane: {strength: 1.0e6, shear_strength: 1.5e6, fracture_energy: 1000, \
         shear_fracture_energy: 1500, exponent: 2, friction: MU}}",
    ] {
        for friction in ["0", "0.4"] {
            let law = law.replace("MU", friction);
            let run = |trace: &str| {
                let damage = format!("0.4*(x < 0.5) + {trace}*(x > 0.5)");
                let initial = format!(", initial: {{damage: {{formula: \"{damage}\"}}}}");
                column(&law, &initial, &[]).in_any_steps().on(1)
            };
            let sound = run("0");
            for trace in ["1e-300", "1e-20", "1e-13", "1e-11", "1e-9", "5e-7"] {
                sound.assert_same(&run(trace), 1e-9);
            }
        }
    }
}

/// Pressed hard and dragged, then pressed less in softer ground: where the damage is a trace, what
/// friction cannot hold slides.
#[test]
fn a_trace_of_damage_lets_no_more_shear_pass_than_the_strength() {
    let yaml = "
mesh: {column: {size: [1.4, 2.9], bodies: [{cells: [3, 1]}, {cells: [3, 2]}]}}
materials:
  low: {z: [0, 1], elastic: {young_modulus: 1.8e9, poisson_ratio: 0.3}}
  high: {z: [1, 2.9], elastic: {young_modulus: 1.3e9, poisson_ratio: 0.3}}
interfaces:
  - name: joint
    z: 1
    secondary: upper
    law:
      benzeggagh_kenane: {strength: 3.5e5, shear_strength: 4.8e5, fracture_energy: 490,
                          shear_fracture_energy: 1460, exponent: 2.4, friction: 0.43}
    initial:
      damage:
        formula: \"TRACE + (x < 0.1) + 0.8*(x > 0.1)*(x < 0.6) + 0.4*(x > 0.6)*(x < 1.2)\"
boundary:
  - {on: bottom, displacement: {x: 0, z: 0}}
  - on: top
    displacement: {x: {table: [[0, 0], [1, 3.8e-4], [2, 1.9e-3], [3, 1.75e-3]]}}
    traction: {z: {table: [[0, 0], [1, -1.0e6], [2, -6.2e5], [3, -1.1e6]]}}
  - {on: left, traction: {x: {table: [[0, 0], [1, 3.0e5]]}}}
  - {on: right, traction: {x: {table: [[0, 0], [1, -3.0e5]]}}}
stages:
  - {until: 1}
  - until: 3
    materials: {low: {elastic: {young_modulus: 4.3e9}}}
    boundary: [{on: right, traction: {x: -1.4e5, z: -1.3e4}}]
time: {instants: [1, 2, 3]}
solver: {stability: \"off\"}
";
    let run = |trace: &str| {
        let trace = format!("{trace}*(x > 1.2)");
        Scene::new("trace", &yaml.replace("TRACE", &trace)).in_any_steps().on(1)
    };
    let sound = run("0");
    ["1e-20", "1e-14", "1e-8"].into_iter().for_each(|trace| sound.assert_same(&run(trace), 1e-9));
}

/// A crack up to x = 0.5 in blocks from a file that are those of a box, of either side, on any
/// ranks, from a restart: the same history.
#[test]
fn a_crack_is_the_same_in_a_box_and_in_its_mesh_from_a_file_and_after_a_restart() {
    let mut blocks = Blocks::default();
    for (number, [name, below, above]) in
        [["low", "bottom", "face"], ["high", "lip", "top"]].into_iter().enumerate()
    {
        let planes = vec![even(4, 1.0), even(2, 1.0)];
        let place = |x: [f64; 3]| [x[0], x[1] + number as f64, 0.0];
        let sides = [(1, false, below), (1, true, above)];
        blocks.add(&Block { name, planes: &planes, order: 1, place: &place, sides: &sides });
    }
    let rest = |mesh: &str, place: &str, up: &str, on: &str| {
        format!(
            "
mesh: {mesh}
materials: {{rock: {{{on}elastic: {{young_modulus: 1.0e10, poisson_ratio: 0.2}}}}}}
interfaces:
  - {{name: joint, {place}, law: {LINEAR}, initial: {{damage: {{formula: \"x < 0.4\"}}}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, {up}: 0}}}}
  - {{on: top, displacement: {{x: 0, {up}: {{table: [[0, 0], [1, 1.0e-4], [2, -1.0e-4], [3, 1.0e-3], [4, 4.0e-3]]}}}}}}
time: {{instants: [1, 2, 3, 4]}}
"
        )
    };
    let column = "{column: {size: [1, 2], cells: [4, 4]}}";
    let of_box = Scene::new("box", &rest(column, "z: 1", "z", "")).in_any_steps();
    let one = of_box.on(1);
    assert_eq!((one.column("joint.damage.min")[0], one.column("joint.damage.max")[0]), (0.0, 1.0));
    let opened = one.column("joint.normal_jump.max")[0];
    assert!(opened > 1e-5, "the crack opens: {opened}");
    one.assert_same(&of_box.set("interfaces.0.secondary=lower").on(1), 1e-8);
    one.assert_same(&of_box.scattered().on(3), 1e-8);
    one.assert_same(&of_box.stopped(1, "history:0:term:2", 2), 1e-8);
    let stages = of_box.set("stages=[{until: 2}, {until: 4}]");
    one.assert_same(&stages.stopped(2, "history:1:term:3", 1), 1e-8);
    let mesh = format!("{{file: \"{}\"}}", blocks.write());
    let of_file = rest(&mesh, "between: [face, lip]", "y", "on: [low, high], ");
    let imported = Scene::new("file", &of_file).in_any_steps().on(2);
    for name in ["joint.normal_traction.max", "joint.normal_jump.max", "joint.damage.mean"] {
        let scale = one.column(name).into_iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        imported.assert_column(name, &one.column(name), 0.0, 1e-8 * scale);
    }
}

/// What a crack over part of an interface has broken before is no part of the path: its time is the
/// dissipated part of what is left.
#[test]
fn a_path_by_dissipation_goes_on_from_a_crack() {
    let scene = Scene::new(
        "path",
        &format!(
            "
mesh: {{column: {{size: [1, 12], bodies: [{{cells: [4, 6]}}, {{cells: [4, 6]}}]}}}}
materials: {{rock: {{elastic: {{young_modulus: 5.0e9, poisson_ratio: 0}}}}}}
interfaces:
  - {{name: joint, z: 6, law: {LINEAR}, initial: {{damage: {{formula: \"x < 0.4\"}}}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, z: 0}}}}
  - {{on: top, displacement: {{x: 0, z: 1}}}}
control: {{dissipation: {{of: joint, step: 0.1}}}}
time: {{instants: [1]}}
"
        ),
    );
    let run = scene.in_any_steps().on(1);
    let left: Vec<f64> = run.column("time").iter().map(|part| part * 1000.0 * 0.625).collect();
    run.assert_column("energy.dissipated", &left, 1e-6, 1e-6);
    let damage = run.column("joint.damage.mean");
    assert!((damage[0] - 0.375).abs() < 1e-9 && damage[damage.len() - 1] > 1.0 - 1e-9);
    assert!(run.column("load_factor").iter().all(|factor| *factor > 0.0));
}

/// Lips that touch let fluid pass and store it by the aperture that they have.
#[test]
fn closed_lips_with_an_aperture_follow_the_cubic_law() {
    let scene = Scene::new(
        "aperture",
        "
mesh: {column: {size: [2, 1], bodies: [{cells: [4, 2]}, {cells: [6, 3]}]}}
materials:
  rock:
    elastic: {young_modulus: 1.0e12, poisson_ratio: 0}
    porous: {biot: 1.0e-6, porosity: 1.0e-6, permeability: 1.0e-16, viscosity: 1.0e-3,
             fluid_compressibility: 0, fluid_density: 1000, density: 2300}
interfaces:
  - {name: joint, z: 0.5, law: {tied: {}}, fluid: {flow: true}, initial: {aperture: 1.0e-4}}
boundary:
  - {on: bottom, displacement: {x: 0, z: 0}}
  - {on: top, displacement: {x: 0, z: 0}}
  - {on: left, pressure: 100}
  - {on: right, pressure: 0}
time: {instants: [1000, 2000, 3000]}
probes: [{name: quarter, at: [0.5, 0.5]}]
",
    );
    let exact = (1e-12 / 12e-3 + 1e-16 / 1e-3) * 100.0 / 2.0;
    let open = "{contact: {}}, initial: {gap: 6.0e-5, aperture: 4.0e-5}";
    for (scene, ranks) in [
        (scene.clone(), 1),
        (scene.set("mesh.order=2"), 2),
        (
            scene.set(&format!(
                "interfaces.0={{name: joint, z: 0.5, fluid: {{flow: true}}, law: {open}}}"
            )),
            2,
        ),
    ] {
        let run = scene.on(ranks);
        let mass = run.column("mass.in");
        let rate = (mass[2] - mass[1]) / 1000.0 / 1000.0;
        assert!((rate - exact).abs() <= 1e-5 * exact, "{}: {rate} {exact}", run.label);
        assert!((run.column("quarter.pressure")[2] - 75.0).abs() < 1e-3, "{}", run.label);
    }
}

/// A body that only a crack joins to the others is refused before anything is solved, also where a
/// formula says so.
#[test]
fn bodies_that_nothing_holds_are_refused() {
    for damage in ["1", "{formula: \"x < 9\"}"] {
        let scene = column(LINEAR, &format!(", initial: {{damage: {damage}}}"), &[]);
        let loose = scene.set("boundary.1={on: top, traction: {z: 1.0e3}}");
        let failure = loose.attempt(2).err().expect("a refusal");
        assert_eq!(failure.status, Some(2), "{}", failure.complaint);
        assert!(failure.complaint.contains("can move freely"), "{}", failure.complaint);
    }
}

/// Tables over a coordinate are what formulas say, at the start and for loads.
#[test]
fn tables_over_a_coordinate_are_formulas() {
    let yaml = "
mesh: {column: {size: [1.0, 2.0], cells: [5, 4]}}
materials: {rock: {elastic: {young_modulus: 1.0e9, poisson_ratio: 0.2}}}
interfaces:
  - {name: joint, z: 0.5, law: {linear_softening: {strength: 1.0e6, fracture_energy: 1000}}}
  - {name: bed, z: 1.5, law: {contact: {friction: 0.5}}}
boundary:
  - {on: bottom, displacement: {x: 0, z: 0}}
  - {on: left, displacement: {x: 0}}
  - {on: top, traction: {z: -1.0e5}}
time: {instants: [1]}
probes: [{name: head, at: [0.7, 2.0]}]
";
    let scene = Scene::new("tables", yaml);
    let (stress, gap) = ("initial.stress={zz: VALUE}", "interfaces.1.initial={gap: VALUE}");
    let load = "boundary.3={on: right, traction: {x: VALUE}}";
    for (set, table, formula) in [
        (
            "interfaces.0.initial={damage: VALUE}",
            "over: x, table: [[0.2, 1], [0.7, 0]]",
            "max(0, min(1, (0.7 - x)/0.5))",
        ),
        (gap, "over: x, table: [[0, 0], [1, 1.0e-5]]", "1.0e-5*x"),
        (stress, "over: z, table: [[0, -2.0e5], [2, -1.0e5]]", "-2.0e5 + 0.5e5*z"),
        (load, "over: z, table: [[0, 0], [1, 1.0e4], [2, 0]]", "1.0e4*(1 - abs(z - 1))"),
    ] {
        let with = |value: String| scene.set(&set.replace("VALUE", &value)).in_any_steps().on(1);
        let run = with(format!("{{{table}}}"));
        with(format!("{{formula: \"{formula}\"}}")).assert_same(&run, 1e-9);
    }
    for (set, table, words) in [
        (gap, "table: [[0, 0], [1, 1.0e-5]]", "needs `over`: x, y or z"),
        (gap, "over: y, table: [[0, 0]]", "does not exist in 2D"),
        (stress, "table: [[0, 0]]", "say what coordinate the table is `over`"),
        (stress, "over: z, table: [[1, 0], [0, 1]]", "has coordinate 0 after 1"),
    ] {
        let set = set.replace("VALUE", &format!("{{{table}}}"));
        let output = scene.set(&set).launch(1, &crate::scene::fresh(), "", &[]);
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert!(told.contains(words), "{set}: {told}");
    }
}
