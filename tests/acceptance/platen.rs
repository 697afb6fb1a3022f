//! Surfaces that move as rigid bodies under their loads.

use std::path::Path;

use crate::blocks::{Block, Blocks, even};
use crate::scene::{Run, Scene};

/// A block of 0.8 m x 0.6 m x 2 m (2D: 0.8 m x 2 m) of E = 1 GPa and nu = 0 that stands on its
/// foot, cut by a joint of some law, with a platen on top.
fn block(dim: usize, order: usize, law: &str, platen: &str) -> Scene {
    let (size, cells, held, at) = match dim {
        2 => ("0.8, 2.0", "2, 4", "x: 0, z: 0", "0.2, 1.6"),
        _ => ("0.8, 0.6, 2.0", "2, 2, 4", "x: 0, y: 0, z: 0", "0.2, 0.15, 1.6"),
    };
    let yaml = format!(
        "
mesh: {{column: {{size: [{size}], cells: [{cells}]}}, order: {order}}}
materials: {{rock: {{elastic: {{young_modulus: 1.0e9, poisson_ratio: 0}}}}}}
interfaces: [{{name: joint, z: 1.0, law: {law}}}]
boundary:
  - {{on: bottom, displacement: {{{held}}}}}
  - {{on: top, rigid: {{{platen}}}}}
time: {{instants: [1, 2]}}
probes: [{{name: inside, at: [{at}]}}]
"
    );
    Scene::new("platen", &yaml)
}

fn close(run: &Run, column: &str, exact: f64) {
    for (time, value) in [1.0, 2.0].into_iter().zip(run.column(column)) {
        let exact = exact * time;
        let error = (value - exact).abs() / exact.abs();
        assert!(error < 1e-8, "{}: {column} at {time}: {value:e}, not {exact:e}", run.label);
    }
}

/// A force of 1 MN presses the block by N h/(E A) with one correction, whatever the solver.
#[test]
fn a_smooth_platen_presses_a_block() {
    let platen = "z: free, rotation: fixed, force: {z: {formula: \"-1.0e6*t\"}}";
    for (dim, order, solver, ranks) in [
        (2, 1, "mumps", 1),
        (2, 2, "gamg", 3),
        (3, 1, "aggregation", 2),
        (3, 2, "hypre", 1),
        (3, 1, "multigrid", 3),
    ] {
        let scene = block(dim, order, "{tied: {}}", platen);
        let run = scene.set(&format!("solver.linear={solver}")).on(ranks);
        let area = if dim == 2 { 0.8 } else { 0.48 };
        close(&run, "top.displacement_z", -1.0e6 * 2.0 / (1.0e9 * area));
        close(&run, "top.reaction_z", -1.0e6);
        assert_eq!(run.corrections(), [1.0, 1.0], "{}", run.label);
        run.assert_energy_balance(1e-9);
    }
}

/// Under the moment M a platen turns by M h/(E I) and moves sideways by half of that times h.
#[test]
fn a_platen_turns_as_the_end_of_a_beam() {
    let platen = "x: free, z: free, rotation: free, moment: {y: {formula: \"4.0e4*t\"}}";
    for (dim, ranks) in [(2, 1), (3, 3)] {
        let run = block(dim, 2, "{tied: {}}", platen).on(ranks);
        let inertia = 0.8_f64.powi(3) / 12.0 * if dim == 2 { 1.0 } else { 0.6 };
        let turn = 4.0e4 * 2.0 / (1.0e9 * inertia);
        close(&run, "top.rotation_y", turn);
        close(&run, "top.displacement_x", turn);
        close(&run, "top.moment_y", 4.0e4);
    }
}

/// What a platen finds under its load is what the same motion, prescribed as a displacement, gives:
/// the forces, the block and the corrections. The joint slides and opens.
#[test]
fn a_motion_that_was_found_is_that_which_is_prescribed() {
    let (law, load) = ("{contact: {friction: 0.3}}", "force: {x: 1.5e5, z: -1.0e6}");
    let platen = format!("x: free, z: free, rotation: free, {load}, moment: {{y: 1.1e5}}");
    let scene = block(2, 1, law, &platen).in_any_steps().set("time.instants=[1]");
    let free = scene.on(1);
    assert!(free.column("joint.normal_jump.max")[0] > 1e-6, "{}", free.label);
    free.assert_same(&scene.on(3), 1e-8);
    let of = |name: &str| free.column(&format!("top.{name}"))[0];
    let (x, z, turn) = (of("displacement_x"), of("displacement_z"), of("rotation_y"));
    let moved = format!("{{x: {x:e}, z: {{formula: \"{z:e} - ({turn:e})*(x - 0.4)\"}}}}");
    let held = scene.set("boundary.1.rigid=").set(&format!("boundary.1.displacement={moved}"));
    let held = held.on(1);
    for (column, exact) in [("top.reaction_x", 1.5e5), ("top.reaction_z", -1.0e6)] {
        let value = held.column(column)[0];
        assert!((value - exact).abs() < 1e-7 * 1e6, "{}: {column} {value:e}", held.label);
    }
    for column in ["inside.displacement_x", "inside.displacement_z", "joint.slip.max"] {
        let [one, two] = [&free, &held].map(|run| run.column(column)[0]);
        assert!((one - two).abs() < 1e-7 * one.abs(), "{column}: {one:e} and {two:e}");
    }
}

/// Stages change the platen, and a run that is stopped goes on, on other ranks.
#[test]
fn a_platen_goes_on_over_stages_and_stops() {
    let platen = "z: free, force: {z: {formula: \"-1.0e6*t\"}}";
    let stages = "stages=[{until: 2}, {until: 3, boundary: [{on: top, rigid: {z: free, rotation: \
                  free, force: {z: -2.0e6}, moment: {y: 2.0e4}}}]}, {until: 4, boundary: [{on: \
                  top, rigid: free, traction: {z: -2.5e6}}]}]";
    let scene = block(2, 2, "{tied: {}}", platen).set("time.instants=[1, 2, 3, 4]").set(stages);
    let run = scene.on(1);
    let pressed = -2.0e6 * 2.0 / (1.0e9 * 0.8);
    let at = |name: &str, row: usize| -> f64 {
        let column = run.table.column(&format!("top.{name}")).expect("a column of the platen");
        run.table.rows[row][column].expect("a platen at this instant")
    };
    let [before, turned] = [1, 2].map(|row| at("displacement_z", row));
    assert!((before - pressed).abs() < 1e-8 * pressed.abs(), "{before:e}");
    assert!((turned - pressed).abs() < 1e-8 * pressed.abs(), "{turned:e}");
    let turn = at("moment_y", 2);
    assert!((turn - 2.0e4).abs() < 1e-8 * 2.0e4, "{turn:e}");
    run.assert_same(&scene.stopped(3, "history:0:term:2", 2), 1e-9);
}

/// On a mesh from a file too, on a side that meets a leaning joint: the forces are met, and the
/// same on other ranks.
#[test]
fn a_platen_on_a_group_of_a_mesh_file() {
    let mesh =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/inclined_joint/inclined_joint.msh");
    let yaml = format!(
        "
mesh: {{file: \"{}\", raise_order: 2}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.3}}}}}}
interfaces: [{{name: joint, on: joint, law: {{contact: {{friction: 0.8}}}}}}]
boundary:
  - {{on: lower_rim, displacement: {{x: 0, y: 0}}}}
  - on: upper_rim
    rigid: {{x: free, y: free, rotation: free, force: {{y: -1.0e6}}, moment: {{z: 4.0e3}}}}
time: {{instants: [1]}}
",
        mesh.display()
    );
    let scene = Scene::new("rim", &yaml).in_any_steps();
    let one = scene.on(1);
    for (column, exact) in [("upper_rim.reaction_y", -1.0e6), ("upper_rim.moment_z", 4.0e3)] {
        let value = one.column(column)[0];
        assert!((value - exact).abs() < 1e-8 * exact.abs(), "{column}: {value:e}");
    }
    one.assert_same(&scene.on(3), 1e-8);
}

/// A joint that softens evenly is stable while the platen cannot turn, and tilts where it can: what
/// the pivots of the tangent with platens held do not tell, the motions of these do.
#[test]
fn a_platen_that_may_turn_lets_a_softening_joint_tilt() {
    let yaml = "
mesh: {column: {size: [1, 4], cells: [2, 4]}}
materials: {rock: {elastic: {young_modulus: 1.0e9, poisson_ratio: 0.0}}}
interfaces:
  - {name: joint, z: 2.0, law: {linear_softening: {strength: 1.0e6, fracture_energy: 2500.0}}}
boundary:
  - {on: bottom, displacement: {x: 0, z: 0}}
  - {on: top, rigid: {x: free, z: {table: [[0, 0], [1, 3.9e-3], [2, 4.2e-3]]}, rotation: free}}
time: {instants: [1, 2]}
solver: {stability: warn}
";
    let scene = Scene::new("tilting", yaml).in_any_steps();
    for (solver, rotation, is_stable) in
        [("mumps", "free", false), ("gamg", "free", false), ("mumps", "fixed", true)]
    {
        let scene = scene.set(&format!("solver.linear={solver}"));
        let run = scene.set(&format!("boundary.1.rigid.rotation={rotation}")).on(1);
        let told = run.told("instabilities");
        assert_eq!(told.is_empty(), is_stable, "{solver}: {told:?}");
        assert!(told.iter().all(|words| words.contains("tilting of interface joint")), "{told:?}");
    }
}

/// A bar of 1 m x 4 m with a joint in its middle that softens, under what acts on its top.
fn softening_bar(top: &str, more: &str) -> Scene {
    let yaml = format!(
        "
mesh: {{column: {{size: [1, 4], cells: [2, 4]}}, order: 2}}
materials: {{rock: {{elastic: {{young_modulus: 1.0e9, poisson_ratio: 0.2}}}}}}
interfaces:
  - name: joint
    z: 2.0
    law: {{exponential_softening: {{strength: 1.0e6, fracture_energy: 2500.0}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, z: 0}}}}
  - {{on: top, {top}}}
{more}
"
    );
    Scene::new("bar", &yaml)
}

/// On a path the force on a platen is scaled as a prescribed displacement would be: past the peak
/// both are in the same states. One that turns carries its moment too, and goes on after a stop.
#[test]
fn a_platen_under_a_force_is_followed_past_its_peak() {
    let path = "
control: {opening: {of: joint, equals: {table: [[0, 0], [1, 4.0e-3]]}}}
time: {instants: [0.1, 0.5, 1]}
";
    let held = softening_bar("displacement: {x: 0, z: 1.0e-3}", path).on(1);
    let free = "rigid: {x: fixed, z: free, rotation: fixed, force: {z: 1.0e5}}";
    let free = softening_bar(free, path).on(1);
    let factors = free.column("load_factor");
    assert!(factors[2] < 0.5 * factors[0] && factors[2] > 0.0, "{factors:?}");
    for (row, factor) in factors.iter().enumerate() {
        let force = held.column("top.reaction_z")[row];
        assert!((1.0e5 * factor - force).abs() < 1e-8 * force, "{factor:e} {force:e}");
        let moved = 1.0e-3 * held.column("load_factor")[row];
        let found = free.column("top.displacement_z")[row];
        assert!((moved - found).abs() < 1e-8 * moved, "{moved:e} {found:e}");
    }
    let turning =
        "rigid: {x: free, z: free, rotation: free, force: {z: 1.0e5}, moment: {y: 1.0e4}}";
    let scene = softening_bar(turning, path);
    let run = scene.on(1);
    for (factor, moment) in run.column("load_factor").iter().zip(run.column("top.moment_y")) {
        assert!((1.0e4 * factor - moment).abs() < 1e-8 * moment, "{factor:e} {moment:e}");
    }
    run.assert_same(&scene.stopped(1, "history:0:term:2", 2), 1e-7);
}

/// The saddle-point form finds the motions of platens that the condensed one finds.
#[test]
fn both_forms_move_a_platen_alike() {
    let platen = "rigid: {x: fixed, z: free, rotation: free, force: {z: -9.0e5}, \
                  moment: {y: {formula: \"4.0e5*t\"}}}";
    let scene = softening_bar(platen, "time: {instants: [0.5, 1]}");
    let scene = scene.set("interfaces.0.law={contact: {}}");
    let saddle = scene.set("solver.form=saddle_point");
    scene.on(1).assert_same(&saddle.on(2), 1e-8);
}

/// The even state of a softening joint is left for a tilted one where the platen may turn.
#[test]
fn a_platen_that_may_turn_follows_the_tilting_state() {
    let platen = "rigid: {x: free, z: {table: [[0, 0], [1, 3.9e-3], [2, 4.2e-3]]}, rotation: free}";
    let scene = softening_bar(platen, "time: {instants: [1, 2]}\nsolver: {stability: follow}");
    let law = "interfaces.0.law={linear_softening: {strength: 1.0e6, fracture_energy: 2500.0}}";
    let scene = scene.set(law).set("mesh.order=1");
    let run = scene.on(1);
    let told = run.told("bifurcations");
    assert!(told.len() == 1 && told[0].contains("tilting of interface joint"), "{told:?}");
    assert!(run.column("top.rotation_y")[1].abs() > 1e-3, "{}", run.label);
    assert!(run.column("top.moment_y")[1].abs() < 1e-3, "{}", run.label);
    // The moments are rounding alone, on any number of ranks.
    let [one, two] = [run, scene.on(2)].map(|run| run.column("top.rotation_y")[1]);
    assert!((one - two).abs() < 1e-7 * one.abs(), "{one:e} {two:e}");
}

/// A path ends alike on a box and on its mesh from a file where the joint has ruptured and nothing
/// else holds the body of a platen that is free: status 3, which names joint and body; rows before
/// stay.
#[test]
fn a_path_ends_where_nothing_else_holds_the_body_of_a_platen() {
    let mut blocks = Blocks::default();
    for (number, [name, below, above]) in
        [["low", "bottom", "face"], ["high", "lip", "top"]].into_iter().enumerate()
    {
        let planes = vec![even(2, 1.0), even(2, 1.0)];
        let place = |x: [f64; 3]| [x[0], x[1] + number as f64, 0.0];
        let sides = [(1, false, below), (1, true, above)];
        blocks.add(&Block { name, planes: &planes, order: 1, place: &place, sides: &sides });
    }
    let rest = |mesh: &str, on: &str, joint: &str, platen: &str, up: &str| {
        format!(
            "
mesh: {mesh}
materials: {{rock: {{{on}elastic: {{young_modulus: 1.0e9, poisson_ratio: 0.2}}}}}}
interfaces:
  - name: joint
    {joint}
    law: {{linear_softening: {{strength: 1.0e6, fracture_energy: 5000, friction: 0.2}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, {up}: 0}}}}
  - {{on: top, rigid: {{{platen}}}}}
control: {{dissipation: {{of: joint, step: 0.25}}}}
time: {{instants: [1]}}
"
        )
    };
    let mesh = format!("{{file: \"{}\"}}", blocks.write());
    for (platen, motion) in [
        ("UP: free, x: fixed, force: {UP: 1.0e6}", "translation along UP"),
        ("UP: free, x: free, rotation: free, force: {UP: 1.0e6}", "translation along x"),
        ("UP: free, x: free, force: {UP: 1.0e6, x: 5.0e5}", "translation along x"),
    ] {
        for (mesh, on, joint, up) in [
            ("{column: {size: [1, 2], cells: [2, 4]}}", "", "z: 1", "z"),
            (&mesh, "on: [low, high], ", "between: [face, lip]", "y"),
        ] {
            let [platen, motion] = [platen, motion].map(|text| text.replace("UP", up));
            let scene = Scene::new("path", &rest(mesh, on, joint, &platen, up));
            for ranks in [1, 2] {
                let Err(failure) = scene.attempt(ranks) else { panic!("{platen}: it goes on") };
                assert_eq!(failure.status, Some(3), "{}", failure.complaint);
                for word in ["joint has ruptured over its whole area: body 2", &motion] {
                    assert!(failure.complaint.contains(word), "{word}: {}", failure.complaint);
                }
            }
        }
    }
}
