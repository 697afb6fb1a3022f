//! The forces of supports on surfaces that share edges: each surface counts all its nodes. The
//! forces in interfaces.

use crate::scene::{Run, Scene};

const POISSON: f64 = 0.3;

/// A column between smooth walls, with what acts on its top and more as YAML; x (and y) by z long.
fn walled(size: &[f64], cells: &str, more: &str) -> Scene {
    let walls = match size.len() {
        2 => "",
        _ => "  - {on: front, displacement: {y: 0}}\n  - {on: back, displacement: {y: 0}}\n",
    };
    let yaml = format!(
        "mesh: {{column: {{size: {size:?}, bodies: {cells}}}}}\n\
         materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: {POISSON}}}}}}}\n\
         interfaces: [{{name: joint, z: 1.5, law: {{linear_softening: {{strength: 1.1e6, \
         fracture_energy: 900}}}}}}]\n\
         boundary:\n  - {{on: bottom, displacement: {{z: 0}}}}\n  \
         - {{on: left, displacement: {{x: 0}}}}\n  - {{on: right, displacement: {{x: 0}}}}\n{walls}{more}"
    );
    Scene::new("walled", &yaml)
}

fn check(run: &Run, exact: &[(&str, f64)], largest: f64) {
    for (name, exact) in exact {
        for value in run.column(name) {
            let off = (value - exact).abs();
            assert!(off <= 1e-9 * largest, "{}: {name} {value:e}, exact {exact:e}", run.label);
        }
    }
}

/// Pressed by a traction, which spreads sideways; the nodes of a wall that the bottom holds count
/// for the wall too, with as much of the bottom as the cells give them. A smaller model has other
/// cells.
#[test]
fn a_wall_counts_the_nodes_that_the_bottom_holds() {
    let [x, y, z] = [2.0, 1.5, 4.0];
    let (pressure, weight) = (8.0e5, 2.5e4);
    let sideways = POISSON / (1.0 - POISSON);
    let more = format!(
        "  - {{on: top, traction: {{z: {}}}}}\nbody_force: {{z: {}}}\ntime: {{instants: [1]}}\n",
        -pressure, -weight
    );
    for (cells, along, auto) in [
        ("[{cells: [8, 6, 6]}, {cells: [8, 6, 10]}]", [8.0, 6.0], true),
        ("[{cells: [1, 2, 2]}, {cells: [2, 3, 3]}]", [1.0, 2.0], false),
    ] {
        let scene = walled(&[x, y, z], cells, &more);
        // The weight makes the vertical stress linear, which cells of first order have in the mean.
        let on_wall = sideways * (pressure + 0.5 * weight * z) * z;
        let total = pressure * x * y + weight * x * y * z;
        let exact = [
            ("bottom.reaction_z", total),
            ("bottom.reaction_x", 0.0),
            ("left.reaction_x", on_wall * y),
            ("right.reaction_x", -on_wall * y),
            ("front.reaction_y", on_wall * x),
            ("back.reaction_y", -on_wall * x),
            ("left.reaction_z", 0.5 * total / along[0]),
            ("back.reaction_z", 0.5 * total / along[1]),
            ("total.reaction_x", 0.0),
            ("total.reaction_y", 0.0),
            ("total.reaction_z", total),
            // Of the upper side on the lower one.
            ("joint.force_x", 0.0),
            ("joint.force_y", 0.0),
            ("joint.force_z", -(pressure + weight * (z - 1.5)) * x * y),
        ];
        let check = |run: &Run, exact: &[(&str, f64)], largest: f64| {
            check(run, exact, largest);
            check(run, &[("joint.area", x * y)], 1.0);
        };
        for ranks in 1..=3 {
            check(&scene.on(ranks), &exact, total);
        }
        if auto {
            for ranks in [1, 3] {
                let reduced = scene.reduced().on(ranks);
                assert_eq!(reduced.report["reduction"]["applied"], true, "{}", reduced.screen);
                check(&reduced, &exact, total);
            }
        }
    }
}

/// Pulled until the joint opens, and back, which a smaller model meets at every instant.
#[test]
fn a_smaller_model_tells_the_reactions_of_the_one_asked_for() {
    let table = "[[0, 0], [1, 3.0e-4], [2, -2.0e-4], [3, 1.2e-3], [4, 6.0e-4], [5, 2.5e-3]]";
    let more = format!(
        "  - {{on: top, displacement: {{x: 0, y: 0, z: {{table: {table}}}}}}}\n\
         time: {{instants: [1, 2, 3, 3.5, 4, 5]}}\n"
    );
    let cells = "[{cells: [8, 6, 6]}, {cells: [8, 6, 10]}]";
    // Softening of cells of this size is bounded with this energy.
    let tough = "interfaces.0.law.linear_softening.fracture_energy=2000";
    let scene = walled(&[2.0, 1.5, 4.0], cells, &more).set(tough).in_any_steps();
    let (full, reduced) = (scene.set("solver.tolerance=1e-11").on(2), scene.reduced().on(2));
    assert_eq!(reduced.report["reduction"]["applied"], true, "{}", reduced.screen);
    let opened = full.column("joint.damage.max").into_iter().fold(0.0, f64::max);
    assert!(opened > 0.5, "{opened}");
    full.assert_same(&reduced, 1e-8);
}

/// Along a path in 2D, stopped and gone on with: the walls hold what follows from the traction of
/// the joint at every row.
#[test]
fn walls_in_2d_along_a_path() {
    let (x, z) = (1.0, 20.0);
    let more = "  - {on: top, displacement: {z: 1}}\n\
                control: {dissipation: {of: joint, step: 0.2}}\ntime: {instants: [1]}\n";
    let scene = walled(&[x, z], "[{cells: [3, 4]}, {cells: [2, 12]}]", more);
    let unbroken = scene.on(1);
    for run in [scene.on(3), scene.stopped(2, "history:1:term:2", 1)] {
        unbroken.assert_same(&run, 1e-9);
        check(&run, &[("joint.area", x)], 1.0);
        let traction = run.column("joint.normal_traction.mean");
        for (row, traction) in traction.into_iter().enumerate() {
            let wall = POISSON / (1.0 - POISSON) * traction * z;
            for (name, exact) in [
                ("left.reaction_x", -wall),
                ("right.reaction_x", wall),
                ("top.reaction_z", traction * x),
                ("left.reaction_z", 0.5 * traction * x * (1.0 / 2.0 - 1.0 / 3.0)),
                ("total.reaction_x", 0.0),
                ("total.reaction_z", 0.0),
                ("joint.force_x", 0.0),
                ("joint.force_z", traction * x),
            ] {
                let value = run.column(name)[row];
                assert!((value - exact).abs() <= 1e-8 * 1.1e6 * z, "{name} {value:e} {exact:e}");
            }
        }
    }
}

/// Sheared along both axes across the joint: what the upper side does to the lower one is the
/// stress times the area, also where the nodes of the sides do not match, and in a smaller model
/// that serves.
#[test]
fn a_sheared_joint_tells_its_force() {
    let [x, y] = [2.0, 1.5];
    let stress = [3.0e5, -2.0e5, -4.0e5];
    let entry =
        |on: &str, components: String| format!("  - {{on: {on}, traction: {{{components}}}}}\n");
    let [a, b, c] = stress;
    let (back, front) = (-a, -b);
    let more = [
        entry("top", format!("x: {a}, y: {b}, z: {c}")),
        entry("right", format!("z: {a}")),
        entry("left", format!("z: {back}")),
        entry("back", format!("z: {b}")),
        entry("front", format!("z: {front}")),
    ];
    for (cells, auto) in [
        ("[{cells: [6, 4, 3]}, {cells: [6, 4, 5]}]", true),
        ("[{cells: [2, 3, 2]}, {cells: [3, 2, 3]}]", false),
    ] {
        let yaml = format!(
            "mesh: {{column: {{size: [{x}, {y}, 4], bodies: {cells}}}}}\n\
             materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0}}}}}}\n\
             interfaces: [{{name: joint, z: 1.5, law: {{linear_softening: {{strength: 1.1e6, \
             fracture_energy: 900}}}}}}]\n\
             boundary:\n  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}\n{}\
             time: {{instants: [1]}}\n",
            more.concat()
        );
        let scene = Scene::new("sheared", &yaml);
        let area = x * y;
        let forces = [("x", 0), ("y", 1), ("z", 2)];
        let forces = forces.map(|(axis, i)| (format!("joint.force_{axis}"), stress[i] * area));
        let forces = forces.each_ref().map(|(name, force)| (name.as_str(), *force));
        let mut runs: Vec<Run> = (1..=3).map(|ranks| scene.on(ranks)).collect();
        if auto {
            runs.push(scene.reduced().on(2));
        }
        for run in &runs {
            check(run, &forces, 4.0e5 * area);
            check(run, &[("joint.area", area)], 1.0);
        }
    }
}
