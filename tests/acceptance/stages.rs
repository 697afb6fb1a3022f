//! Stages: what says the same gives the same, and states go on over changes of supports, loads and
//! materials, also from run to run.

use crate::scene::{Run, Scene, fresh};

/// A joint that opens and slides while the sides of the column are held.
fn held(stages: &str) -> Scene {
    let yaml = format!(
        "
mesh: {{column: {{size: [1.0, 1.0, 2.0], bodies: [{{cells: [2, 2, 2]}}, {{cells: [3, 3, 2]}}]}}}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.25}}}}}}
interfaces:
  - {{name: joint, z: 1.0, law: {{linear_softening: {{strength: 1.1e6, fracture_energy: 900.0}}}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{on: left, displacement: {{x: 0}}}}
  - {{on: right, displacement: {{x: 0}}}}
  - {{on: top, displacement: {{x: 0, y: 0, z: {{formula: \"4e-4*min(t, 8-t)*(1 + 0.2*y)\"}}}}}}
time: {{instants: [1, 2, 3, 4, 5, 6]}}
probes: [{{name: off_axis, at: [0.21, 0.83, 1.3]}}]
{stages}"
    );
    Scene::new("held", &yaml).set("solver.tolerance=1.0e-12").set("solver.linear=mumps")
}

fn energies_close(run: &Run, relative: f64) {
    let [elastic, dissipated, external] =
        ["elastic", "dissipated", "external"].map(|of| run.column(&format!("energy.{of}")));
    let largest = external.iter().fold(0.0, |m: f64, e| m.max(e.abs()));
    for i in 0..external.len() {
        let left = external[i] - elastic[i] - dissipated[i];
        assert!(left.abs() < relative * largest, "{}: row {i}: {left:e}", run.label);
    }
}

#[test]
fn stages_that_change_nothing_are_one() {
    let whole = held("").on(1);
    let same = "stages: [{until: 2}, {until: 5, boundary: [{on: left, displacement: {x: 0}}]}, \
                {until: 6}]\n";
    for ranks in [1, 3] {
        whole.assert_same(&held(same).on(ranks), 1e-12);
    }
}

#[test]
fn what_is_taken_away_is_released_and_work_is_accounted_for() {
    for (case, order, ranks) in
        [("excavation", 1, 3), ("excavation", 2, 2), ("stiffness", 2, 2), ("terzaghi", 1, 2)]
    {
        let scene = Scene::shipped(&format!("stages/{case}.yaml"));
        let run = scene.set(&format!("mesh.order={order}")).in_any_steps().on(ranks);
        assert_eq!(run.report["status"], "done", "{}", run.label);
        if case != "terzaghi" {
            energies_close(&run, 1e-8);
        }
    }
}

#[test]
fn a_run_goes_on_in_the_middle_of_a_stage() {
    let stages = "stages: [{until: 2}, {until: 5, boundary: [{on: left, displacement: free}], \
                  materials: {rock: {elastic: {young_modulus: 7.0e9}}}}, {until: 6}]\n";
    let scene = held(stages);
    let whole = scene.on(1);
    for (instant, from, to) in [(2, 1, 2), (3, 2, 3), (5, 3, 1)] {
        let run = scene.stopped(
            from,
            &format!("history:LAST:term:{instant}").replace("LAST", &(from - 1).to_string()),
            to,
        );
        whole.assert_same(&run, 1e-10);
    }
}

#[test]
fn a_finished_run_is_extended_by_stages() {
    let stages = "stages: [{until: 6}, {until: 8, boundary: [{on: left, displacement: free}]}]\n";
    let longer = held(stages).set("time.instants=[1, 2, 3, 4, 5, 6, 7, 8]");
    let whole = longer.on(1);
    let directory = fresh();
    for (scene, words) in [(held(""), "--overwrite"), (longer, "--restart=latest")] {
        let output = scene.launch(2, &directory, "", &[words]);
        let words = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{words}");
    }
    whole.assert_same(&Scene::left_in(&directory, "extended".into()), 1e-10);
    // What has been run cannot be changed.
    let other = held(&stages.replace("{until: 6}", "{until: 5}"));
    let output = other.set("time.instants=[1, 2, 3, 4, 5, 6, 7, 8]").launch(
        1,
        &directory,
        "",
        &["--restart", "latest"],
    );
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{words}");
    assert!(words.contains("`stages.0` is {\"until\":6.0} there"), "{words}");
}

/// Bodies whose meshes do not match, held along whole sides, of which some are let go.
fn let_go(dimension: usize, law: &str) -> Scene {
    let (mesh, axes, front) = match dimension {
        2 => ("size: [1.3, 1.1], bodies: [{cells: [5, 2]}, {cells: [3, 1], order: 2}]", "x: 0", ""),
        _ => (
            "size: [1.0, 0.8, 1.6], bodies: [{cells: [3, 2, 1]}, {cells: [2, 3, 1]}]",
            "x: 0, y: 0",
            "{on: front, displacement: free}, ",
        ),
    };
    let held = if front.is_empty() { "" } else { "  - {on: front, displacement: {y: 0}}\n" };
    let yaml = format!(
        "
mesh: {{column: {{{mesh}}}}}
materials: {{rock: {{elastic: {{young_modulus: 3.0e9, poisson_ratio: 0.2}}}}}}
interfaces:
  - {{name: joint, z: 0.6, law: {{{law}}}}}
boundary:
  - {{on: bottom, displacement: {{{axes}, z: 0}}}}
  - {{on: left, displacement: {{x: 0, z: 0}}}}
  - {{on: right, displacement: {{x: 0, z: 0}}}}
{held}  - {{on: top, traction: {{x: 2.0e4, z: -1.0e5}}}}
stages:
  - {{until: 1}}
  - {{until: 2, boundary: [{front}{{on: right, displacement: free}}]}}
  - {{until: 3, boundary: [{{on: left, displacement: {{z: free}}}}, {{on: top, traction: {{z: -5.0e4}}}}],
     materials: {{rock: {{elastic: {{young_modulus: 2.0e9}}}}}}}}
time: {{instants: [1, 1.5, 2, 3]}}
"
    );
    Scene::new("let_go", &yaml).set("solver.tolerance=1.0e-12").set("solver.linear=mumps")
}

#[test]
fn supports_at_the_edge_of_an_interface_are_let_go_without_work_of_the_mesh() {
    let laws = [
        "tied: {}",
        "linear_softening: {strength: 1.0e8, fracture_energy: 9.0e5}",
        "exponential_softening: {strength: 1.0e8, fracture_energy: 9.0e5}",
        "contact: {friction: 9}",
    ];
    for (dimension, law) in [(2, laws[1]), (2, laws[2]), (2, laws[3]), (3, laws[0])] {
        let run = let_go(dimension, law).on(1);
        energies_close(&run, 1e-10);
        let jump = run.column("joint.normal_jump.mean");
        assert!(jump.iter().all(|w| w.abs() < 1e-15), "{law}: {jump:?}");
    }
    let scene = let_go(2, laws[1]);
    let whole = scene.on(3);
    energies_close(&whole, 1e-10);
    let stopped = scene.stopped(2, "history:1:term:2", 1);
    for name in
        ["energy.external", "joint.force_x", "left.reaction_z", "joint.shear_traction_x.max"]
    {
        let (whole, stopped) = (whole.column(name), stopped.column(name));
        let largest = whole.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let off = whole.iter().zip(&stopped).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9 * largest, "{name}: {whole:?} {stopped:?}");
    }
}
