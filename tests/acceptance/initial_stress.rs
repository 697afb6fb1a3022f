//! Stresses that were there before, and bodies that contact alone holds.

use crate::blocks::{Block, Blocks, even};
use crate::scene::{Kind, Run, Scene};

const AXES: [&str; 3] = ["x", "y", "z"];
const NU: f64 = 0.25;
/// Young's moduli, and with walls at the sides (Pa).
const YOUNG: [f64; 2] = [1.0e9, 2.0e8];
const DENSITY: f64 = 2000.0;
const LOAD: f64 = 1.0e5;

/// Two blocks of 1 m and 2 m between smooth walls, with the weight above and k0 = 0.5, and from
/// t = 1 on a load on their head.
fn ground(rest: &str) -> String {
    format!(
        "
initial: {{stress: {{k0: 0.5}}}}
time: {{instants: [0.5, 1]}}
{rest}"
    )
}

fn column(dim: usize, order: usize, law: &str) -> Scene {
    let walls = [["left", "right"], ["front", "back"]];
    let walls: Vec<String> = (0..dim - 1)
        .flat_map(|axis| {
            walls[axis].map(|on| format!("  - {{on: {on}, displacement: {{{}: 0}}}}\n", AXES[axis]))
        })
        .collect();
    let (size, cells, g) = match dim {
        2 => ("[1.0, 3.0]", ["[2, 2]", "[3, 3]"], "[0, -10]"),
        _ => ("[1.0, 1.0, 3.0]", ["[2, 1, 2]", "[1, 2, 3]"], "[0, 0, -10]"),
    };
    let at = if dim == 2 { "[0.3, 3.0]" } else { "[0.3, 0.6, 3.0]" };
    let yaml = format!(
        "
mesh: {{column: {{size: {size}, bodies: [{{cells: {}, order: {order}}}, {{cells: {}, order: {order}}}]}}}}
materials:
  base: {{z: [0, 1], elastic: {{young_modulus: {}, poisson_ratio: {NU}, density: {DENSITY}}}}}
  soil: {{z: [1, 3], elastic: {{young_modulus: {}, poisson_ratio: {NU}, density: {DENSITY}}}}}
interfaces: [{{name: joint, z: 1.0, law: {law}}}]
boundary:
  - {{on: bottom, displacement: {{z: 0}}}}
{}  - {{on: top, traction: {{z: {{formula: \"-{LOAD}*step(t - 1)\"}}}}}}
gravity: {g}
probes: [{{name: head, at: {at}}}]
{}",
        cells[0],
        cells[1],
        YOUNG[0],
        YOUNG[1],
        walls.concat(),
        ground("")
    );
    Scene::new("ground", &yaml)
}

/// The same of a mesh file, whose upright axis is its last one.
fn imported(dim: usize, order: usize, law: &str) -> Scene {
    let mut blocks = Blocks::default();
    let height = dim - 1;
    for (number, name) in ["low", "high"].into_iter().enumerate() {
        let mut planes = vec![even(2 + number, 1.0); dim];
        planes[height] = even(2 + number, [1.0, 2.0][number]);
        // Leaning inside, upright at the ends.
        let place = |mut x: [f64; 3]| {
            x[height] += number as f64;
            x
        };
        let faces = [["base", "face"], ["lip", "head"]][number];
        let mut sides = vec![(height, false, faces[0]), (height, true, faces[1])];
        for axis in 0..height {
            let wall = [["wall_x", "wall_x"], ["wall_y", "wall_y"]][axis];
            sides.extend([(axis, false, wall[0]), (axis, true, wall[1])]);
        }
        blocks.add(&Block { name, planes: &planes, order, place: &place, sides: &sides });
    }
    let up = AXES[height];
    let walls: Vec<String> = AXES[..height]
        .iter()
        .map(|axis| format!("  - {{on: wall_{axis}, displacement: {{{axis}: 0}}}}\n"))
        .collect();
    let (g, at) =
        if dim == 2 { ("[0, -10]", "[0.3, 3.0]") } else { ("[0, 0, -10]", "[0.3, 0.6, 3.0]") };
    let yaml = format!(
        "
mesh: {{file: \"{}\"}}
materials:
  base: {{on: low, elastic: {{young_modulus: {}, poisson_ratio: {NU}, density: {DENSITY}}}}}
  soil: {{on: high, elastic: {{young_modulus: {}, poisson_ratio: {NU}, density: {DENSITY}}}}}
interfaces: [{{name: joint, between: [face, lip], law: {law}}}]
boundary:
  - {{on: base, displacement: {{{up}: 0}}}}
{}  - {{on: head, traction: {{{up}: {{formula: \"-{LOAD}*step(t - 1)\"}}}}}}
gravity: {g}
probes: [{{name: head, at: {at}}}]
{}",
        blocks.write(),
        YOUNG[0],
        YOUNG[1],
        walls.concat(),
        ground("")
    );
    Scene::new("imported", &yaml)
}

/// It stays where it is to 1e-12 m, and sinks then as an elastic column between walls.
fn stays_and_sinks(run: &Run, up: &str) {
    let walled = (1.0 - NU) / ((1.0 + NU) * (1.0 - 2.0 * NU));
    let sinking = LOAD * (1.0 / YOUNG[0] + 2.0 / YOUNG[1]) / walled;
    for axis in AXES {
        let name = format!("head.displacement_{axis}");
        if run.table.column(&name).is_some() {
            let last = if axis == up { -sinking } else { 0.0 };
            run.assert_column(&name, &[0.0, 0.0, last], 1e-9, 1e-12);
        }
    }
    let weight = -DENSITY * 10.0 * 2.0;
    run.assert_column("joint.normal_traction", &[weight, weight, weight - LOAD], 1e-9, 0.0);
    run.assert_column("joint.normal_jump", &[0.0; 3], 0.0, 1e-14);
    assert_eq!(run.column("time"), [0.0, 0.5, 1.0]);
    run.assert_energy_balance(1e-8);
}

const COHESIVE: &str = "{linear_softening: {strength: 1.0e4, fracture_energy: 100}}";

#[test]
fn ground_at_rest_stays_where_it_is_and_sinks_under_a_load() {
    let laws = [COHESIVE, "{contact: {}}", "{contact: {friction: 0.3}}", "{tied: {}}"];
    for (number, law) in laws.into_iter().enumerate() {
        let (dim, order, ranks) = (2 + number % 2, 1 + number / 2, 1 + number % 3);
        stays_and_sinks(&column(dim, order, law).on(ranks), "z");
    }
    // A crack that is there before is pressed as a contact is.
    stays_and_sinks(&column(2, 1, &format!("{COHESIVE}, initial: {{damage: 1}}")).on(2), "z");
}

/// What is half damaged unloads to the origin with 5e5 Pa/m.
#[test]
fn a_damaged_joint_under_tension_counts_from_its_opening() {
    let run = column(2, 1, &format!("{COHESIVE}, initial: {{damage: 0.5}}"))
        .set("initial.stress={zz: 4.0e3}")
        .set("gravity=[0, 0]")
        .set("boundary.3={on: top, traction: {z: {formula: \"4.0e3*(1 - step(t - 1))\"}}}")
        .on(1);
    run.assert_column("joint.normal_traction", &[4e3, 4e3, 0.0], 1e-9, 1e-6);
    run.assert_column("joint.normal_jump", &[0.0, 0.0, -8e-3], 1e-9, 1e-12);
    run.assert_column("energy.dissipated", &[0.0; 3], 0.0, 1e-9);
    run.assert_energy_balance(1e-8);
}

/// The stresses are those of the ground as it was, whatever a stage makes of it.
#[test]
fn a_stage_adds_to_the_stresses_that_were_there() {
    let stage = "{until: 1, materials: {soil: {elastic: {young_modulus: 4.0e8, density: 3000}}}}";
    let run = column(2, 1, COHESIVE).set(&format!("stages=[{{until: 0.5}}, {stage}]")).on(2);
    let walled = (1.0 - NU) / ((1.0 + NU) * (1.0 - 2.0 * NU));
    let added = 1000.0 * 10.0 * 2.0;
    let sinking = (LOAD + added) / YOUNG[0] + (LOAD + 0.5 * added) * 2.0 / 4e8;
    let weight = -DENSITY * 10.0 * 2.0;
    let last = [-sinking / walled, weight - added - LOAD];
    run.assert_column("head.displacement_z", &[0.0, 0.0, last[0]], 1e-9, 1e-12);
    run.assert_column("joint.normal_traction", &[weight, weight, last[1]], 1e-9, 0.0);
    run.assert_energy_balance(1e-8);
}

#[test]
fn ground_at_rest_of_a_mesh_file() {
    for (dim, order, law, ranks) in [(2, 2, COHESIVE, 2), (3, 1, "{contact: {}}", 1)] {
        let run = imported(dim, order, law).on(ranks);
        stays_and_sinks(&run, AXES[dim - 1]);
        let told = run.told("remarks");
        assert!(told.iter().any(|words| words.contains("up to the highest point")), "{told:?}");
    }
}

/// Stress that is not in equilibrium with the loads, across a joint with friction.
fn uneven() -> Scene {
    column(2, 1, "{contact: {friction: 0.2}}")
        .set("initial.stress={zz: {formula: \"-3.0e4 - 2.0e4*(3 - z)*(1 + 0.1*x)\"}, xx: -2.0e4}")
        .set("boundary.3={on: top, traction: {x: {formula: \"2.0e3*t\"}, z: -3.0e4}}")
        .set("time.instants=[0.5, 1, 2, 3]")
        .set("solver.tolerance=1.0e-12")
}

#[test]
fn a_run_that_was_stopped_goes_on_from_the_stresses_that_were_there() {
    let scene = uneven();
    let whole = scene.on(1);
    assert_eq!(whole.column("head.displacement_z")[0], 0.0);
    assert!(whole.largest(Kind::Length) > 0.0);
    let external = whole.column("energy.external");
    let held = ["elastic", "dissipated", "friction"].map(|n| whole.column(&format!("energy.{n}")));
    for (row, external) in external.iter().enumerate() {
        let held: f64 = held.iter().map(|of| of[row]).sum();
        assert!((held - external).abs() <= 1e-6 * external.abs() + 1e-9, "{held} {external}");
    }
    whole.assert_same(&scene.stopped(2, "history:0:term:1", 1), 1e-9);
    let stages = scene.set("stages=[{until: 1}, {until: 3}]");
    whole.assert_same(&stages.stopped(2, "history:1:term:3", 1), 1e-9);
}

#[test]
fn saturated_ground_under_still_water_stays_where_it_is() {
    let porous = "porous={biot: 0.8, porosity: 0.2, permeability: 1.0e-12, viscosity: 1.0e-3, \
                  fluid_compressibility: 0, fluid_density: 1000, density: 2000}";
    for physics in ["hydro_mechanics", "auto"] {
        let known = if physics == "auto" { "all" } else { "top" };
        let run = column(2, 1, "{tied: {}}")
            .set("materials.base.elastic.density=")
            .set("materials.soil.elastic.density=")
            .set(&format!("materials.base.{porous}"))
            .set(&format!("materials.soil.{porous}"))
            .set("initial.pressure={formula: \"1.0e4*(5 - z)\"}")
            .set(&format!("boundary.3={{on: {known}, pressure: {{formula: \"1.0e4*(5 - z)\"}}}}"))
            .set("boundary.4={on: top, traction: {z: -1.6e4}}")
            .set("initial.stress={zz: {formula: \"-2.0e4*(3 - z) - 1.6e4 + 0.8e4*(5 - z)\"}, k0: 0.5}")
            .set(&format!("physics={physics}"))
            .on(2);
        for axis in ["x", "z"] {
            run.assert_column(&format!("head.displacement_{axis}"), &[0.0; 3], 0.0, 1e-12);
        }
        // No fluid stands in the joint: its traction is the total one.
        run.assert_column("joint.normal_traction", &[-4.0e4 - 1.6e4; 3], 1e-9, 0.0);
    }
}

#[test]
fn stresses_above_a_strength_are_refused() {
    let law = "interfaces.0.law={linear_softening: {strength: 1.0e4, fracture_energy: 100}}";
    let scene = column(2, 1, COHESIVE).set(law);
    let pulled = scene
        .set("initial.stress={zz: 1.1e4}")
        .set("gravity=[0, 0]")
        .set("boundary.3={on: top, traction: {z: 1.1e4}}");
    let Err(failure) = pulled.attempt(2) else { panic!("it holds") };
    assert_eq!(failure.status, Some(2), "{}", failure.complaint);
    for words in ["initial.stress", "interface joint at", "above the strength"] {
        assert!(failure.complaint.contains(words), "{}", failure.complaint);
    }
}

#[test]
fn a_block_that_its_weight_holds_is_lifted_with_words() {
    let block = Scene::shipped("weight/held.yaml").set("expect=[]");
    for (scene, ranks) in
        [(block.clone(), 2), (block.set("interfaces.0.law={contact: {friction: 0.4}}"), 1)]
    {
        let lifted = scene.set("boundary.3.traction.z={formula: \"6.1e4*step(t - 2)\"}");
        let Err(failure) = lifted.attempt(ranks) else { panic!("it stays") };
        assert_eq!(failure.status, Some(3), "{}", failure.complaint);
        for words in ["interface contact", "body 2", "translation along z", "up to time 1"] {
            assert!(failure.complaint.contains(words), "{}", failure.complaint);
        }
    }
}
