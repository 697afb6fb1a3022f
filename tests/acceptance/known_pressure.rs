//! A pore pressure that is known beforehand acts as a load.

use crate::flow::TWO_ROCKS;
use crate::scene::{Run, Scene};

/// Rock of two kinds, with a joint that the pressure and the support above open and close.
const ROCK: &str = "
mesh: {column: {size: [1, 3], bodies: [{cells: [2, 3]}, {cells: [3, 3]}]}}
interfaces:
  - name: joint
    z: 2
    law: {linear_softening: {strength: 1.0e6, fracture_energy: 2000}}
    fluid: {pressure: {table: [[0, 0], [1, 2.0e5]]}}
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}
  - {on: top, displacement: {z: {table: [[0, 0], [1, 5.0e-4], [2, 8.0e-4], [3, 1.0e-4]]}}}
  - {on: all, pressure: 1.0e6}
time: {instants: [0.5, 1, 2, 3]}
solver: {linear: mumps, stability: off, tolerance: 1.0e-12}
probes: [{name: low, at: [0.3, 0.7]}, {name: high, at: [0.6, 2.6]}]
";

fn rock(dim: usize, order: usize) -> Scene {
    let flat = Scene::new("rock", &[ROCK, TWO_ROCKS].concat())
        .in_any_steps()
        .set("materials.rock.z=[1, 3]")
        .set(&format!("mesh.order={order}"));
    if dim == 2 {
        return flat.set("boundary.0={on: bottom, displacement: {x: 0, z: 0}}");
    }
    flat.set("mesh.column={size: [1, 1, 3], bodies: [{cells: [2, 1, 3]}, {cells: [2, 2, 3]}]}")
        .set("probes=[{name: low, at: [0.3, 0.2, 0.7]}, {name: high, at: [0.6, 0.4, 2.6]}]")
}

const PRESSURES: [&str; 4] = [
    "1.0e6",
    "{formula: \"1.0e6*(1 + x - 0.2*z*z)\"}",
    "{table: [[0, 0], [1, 2.0e6], [1.5, -1.0e6], [3, 4.0e5]]}",
    "{formula: \"1.0e5*t*(1 + 3*x)\"}",
];

/// All columns that both have, within `part` of the largest of their kind.
fn assert_agree(one: &Run, other: &Run, part: f64) {
    let kind = |name: &str| {
        let kinds = ["traction", "jump", "sliding", "displacement", "reaction", "energy"];
        match kinds.iter().position(|kind| name.contains(kind)) {
            _ if name.contains(".force_") => "reaction".to_owned(),
            Some(1..=3) => "length".to_owned(),
            Some(kind) => kinds[kind].to_owned(),
            None => name.to_owned(),
        }
    };
    let common = one.table.columns.iter().filter(|name| other.table.column(name).is_some());
    let common: Vec<&String> = common.filter(|name| !name.ends_with("_iterations")).collect();
    assert!(common.len() > 20, "{common:?}");
    for name in &common {
        let alike = common.iter().filter(|of| kind(of) == kind(name));
        let scale = alike.flat_map(|of| one.column(of)).fold(0.0_f64, |m, v| m.max(v.abs()));
        for (a, b) in one.column(name).iter().zip(other.column(name)) {
            assert!((a - b).abs() <= part * scale, "{}: {name}: {a} and {b}", other.label);
        }
    }
}

#[test]
fn a_known_pressure_is_a_load() {
    // The two orders share out the pressures, in the plane the other way than in space.
    for (dim, order, first) in [(2, 1, 0), (2, 2, 1), (3, 1, 1), (3, 2, 0)] {
        for (index, pressure) in PRESSURES.iter().enumerate().skip(first).step_by(2) {
            let scene = rock(dim, order).set(&format!("boundary.2.pressure={pressure}"));
            let (dropped, carried) =
                (scene.on(1 + index % 3), scene.set("physics=hydro_mechanics").on(1));
            assert_eq!(dropped.report["model"]["physics"], "mechanics");
            assert_eq!(carried.report["model"]["physics"], "hydro_mechanics");
            let why = dropped.report["model"]["left_out"][0]["why"].as_str().expect("a reason");
            assert!(why.contains("prescribed on all nodes, so it acts as a load"), "{why}");
            assert!(dropped.screen.contains("acts as a load"), "{}", dropped.screen);
            let opened = carried.column("joint.normal_jump.max").into_iter().fold(0.0, f64::max);
            assert!(opened > 1e-5, "{}: {opened}", carried.label);
            for name in ["low.pressure", "high.pressure", "energy.fluid"] {
                assert!(dropped.table.column(name).is_some(), "{name}");
            }
            assert!(dropped.table.column("mass.in").is_none());
            assert_agree(&carried, &dropped, 1e-10);
        }
    }
}

/// With every solver, and where a run goes on on other ranks.
#[test]
fn a_known_pressure_is_the_same_load_everywhere() {
    let scene =
        rock(3, 1).set(&format!("boundary.2.pressure={}", PRESSURES[1])).set("mesh.refine=1");
    let one = scene.set("physics=hydro_mechanics").on(1);
    for (ranks, solver) in [(2, "multigrid"), (3, "hypre"), (1, "gamg")] {
        let scene = scene.set(&format!("solver.linear={solver}"));
        let carried = scene.set("physics=hydro_mechanics").on(1);
        assert_agree(&carried, &scene.scattered().on(ranks), 1e-10);
    }
    assert_agree(&one, &scene.set("solver.form=saddle_point").on(2), 1e-10);
    assert_agree(&one, &scene.stopped(2, "history:0:term:2", 3), 1e-10);
}

/// What only flow gives makes it be computed.
#[test]
fn what_asks_for_flow_gets_it() {
    let expectation = |quantity: &str| {
        format!("expect=[{{quantity: {quantity}, at: 3, equals: 0, absolute: 1.0e9}}]")
    };
    for (change, physics) in [
        (expectation("mass.stored"), "hydro_mechanics"),
        (expectation("low.pressure"), "mechanics"),
        ("time.tolerance=0.1".into(), "hydro_mechanics"),
        ("physics=mechanics".into(), "mechanics"),
    ] {
        let run = rock(2, 1).set(&change).on(1);
        assert_eq!(run.report["model"]["physics"], physics, "{change}");
    }
    let zero = rock(2, 1).set("boundary.2.pressure=0");
    let run = zero.set(&expectation("low.pressure")).on(1);
    assert_eq!(run.report["model"]["physics"], "hydro_mechanics");
    let run = zero.on(1);
    assert!(run.table.column("low.pressure").is_none());
    // The reference pressure acts where another one is prescribed.
    let below = zero
        .set("materials.rock.porous.reference_pressure=1.0e5")
        .set("materials.sandstone.porous.reference_pressure=1.0e5");
    let run = below.on(1);
    assert!(run.screen.contains("acts as a load"), "{}", run.screen);
    assert_agree(&below.set("physics=hydro_mechanics").on(1), &run, 1e-10);
}
