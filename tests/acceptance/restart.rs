//! Runs that are stopped and go on, on another number of ranks, as if nothing had happened.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use rustix::fs::{FlockOperation, flock};

use crate::common::environment;
use crate::scene::{PROGRAM, Scene, fresh};

/// Ranks before the stop and after it.
const RANKS: [(usize, usize); 3] = [(1, 2), (2, 3), (3, 1)];

/// A checkpoint at every instant.
const EVERY: &str = "output.checkpoint={every: 1 instant}";

pub fn reference() -> Scene {
    Scene::shipped("wtnv146/case.yaml").set("mesh.column.cells=[2, 2, 6]").set("expect=[]")
}

/// Opens unevenly, then closes again; every instant takes several corrections.
pub fn tilting() -> Scene {
    let yaml = "
mesh: {column: {size: [1.0, 1.0, 5.0], bodies: [{cells: [2, 2, 3], order: 2}, {cells: [3, 3, 5]}]}}
materials: {rock: {elastic: {young_modulus: 5.8e9, poisson_ratio: 0.25}}}
interfaces:
  - {name: joint, z: 2.5, law: {linear_softening: {strength: 1.1e6, fracture_energy: 900.0}}}
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}
  - on: top
    displacement: {x: 0, y: 0, z: {formula: \"3e-4*min(t, 8-t)*(1 + 0.4*(x-0.5) + 0.2*(y-0.5))\"}}
time: {instants: [1, 2, 3, 4, 5, 6]}
probes: [{name: off_axis, at: [0.21, 0.83, 3.1]}]
";
    Scene::new("tilting", yaml)
}

/// Two interfaces with laws of their own, on a path through snap-back.
fn path() -> Scene {
    let yaml = "
mesh: {column: {size: [1.0, 1.0, 20.0], cells: [2, 2, 12]}}
materials: {rock: {elastic: {young_modulus: 5.8e9, poisson_ratio: 0.25}}}
interfaces:
  - {name: lower, z: 5.0, law: {exponential_softening: {strength: 1.3e6, fracture_energy: 900.0}}}
  - {name: upper, z: 10.0, law: {linear_softening: {strength: 1.1e6, fracture_energy: 900.0}}}
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}
  - {on: top, displacement: {x: 0, y: 0, z: {formula: \"1 + 0.1*(x-0.5)\"}}}
control: {dissipation: {of: upper, step: 0.2}}
time: {instants: [1]}
";
    Scene::new("path", yaml)
}

fn status(output: &Output) -> Option<i32> {
    output.status.code()
}

fn complaint(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Goes on from the latest checkpoint and compares the whole history with that of `unbroken`.
pub fn goes_on(scene: &Scene, ranks: usize, directory: &Path, unbroken: &Path, label: &str) {
    let output = scene.launch(ranks, directory, "", &["--restart", "latest"]);
    assert_eq!(status(&output), Some(0), "{label}: {}", complaint(&output));
    let whole = Scene::left_in(unbroken, format!("{label}, unbroken"));
    let broken = Scene::left_in(directory, format!("{label}, on {ranks} ranks"));
    whole.assert_same(&broken, 1e-10);
    for name in ["newton_iterations", "time"] {
        // The corrections of an abandoned step are not counted.
        assert_eq!(whole.column(name), broken.column(name), "{label}: {name}");
    }
    let count = |part: &str| broken.report[part].as_array().map(Vec::len);
    assert_eq!(count("residual_norms"), Some(broken.table.rows.len()), "{label}");
}

/// A scene with the results of its unbroken run.
pub fn unbroken(scene: Scene) -> (Scene, PathBuf) {
    let directory = fresh();
    let output = scene.launch(1, &directory, "", &["--overwrite"]);
    assert_eq!(status(&output), Some(0), "{}", complaint(&output));
    (scene, directory)
}

/// Stops with `fault` on some ranks, goes on with others.
fn stops_and_goes_on(
    (scene, unbroken): &(Scene, PathBuf),
    pairs: &[(usize, usize)],
    fault: &str,
    expected: i32,
) {
    for &(before, after) in pairs {
        let directory = fresh();
        let fault = fault.replace("LAST", &(before - 1).to_string());
        let output = scene.launch(before, &directory, &fault, &["--overwrite"]);
        let label = format!("{fault} on {before} ranks");
        assert_eq!(status(&output), Some(expected), "{label}: {}", complaint(&output));
        if expected == 75 {
            let text = complaint(&output);
            assert!(text.starts_with("stopped by the signal "), "{label}: {text}");
            assert!(text.ends_with("go on with --restart latest\n"), "{label}: {text}");
        }
        goes_on(scene, after, &directory, unbroken, &label);
    }
}

/// Stops a scene at these instants; `pairs` gives the ranks for the number of an instant.
fn stopped_at(scene: Scene, instants: &[usize], pairs: impl Fn(usize) -> Vec<(usize, usize)>) {
    let scene = unbroken(scene);
    for &instant in instants {
        let signal = ["term", "usr2", "int"][instant % 3];
        let fault = format!("history:LAST:{signal}:{instant}");
        stops_and_goes_on(&scene, &pairs(instant), &fault, 75);
    }
}

/// One pair after the other.
fn in_turn(number: usize) -> Vec<(usize, usize)> {
    vec![RANKS[number % RANKS.len()]]
}

#[test]
fn the_reference_stopped_at_an_instant() {
    stopped_at(reference(), &[1, 2, 3, 6], in_turn);
}

#[test]
fn the_tilting_column_stopped_at_an_instant() {
    stopped_at(tilting(), &[1, 3, 5], in_turn);
}

#[test]
#[ignore = "takes minutes"]
fn stopped_at_every_instant_on_every_pair_of_ranks() {
    stopped_at(reference(), &[1, 2, 3, 4, 5, 6, 7], |_| RANKS.to_vec());
    for scene in [tilting(), path()] {
        stopped_at(scene, &[1, 2, 3, 4, 5], |_| RANKS.to_vec());
    }
}

/// In the middle of Newton's method: the step is abandoned and made again.
#[test]
fn stopped_in_the_middle_of_a_step() {
    let tilting = unbroken(tilting());
    for evaluation in [2, 9, 14] {
        let fault = format!("residual:LAST:term:{evaluation}");
        stops_and_goes_on(&tilting, &in_turn(evaluation), &fault, 75);
    }
    stops_and_goes_on(&unbroken(reference()), &in_turn(7), "residual:LAST:usr2:7", 75);
}

#[test]
fn a_path_stopped_on_its_way() {
    let path = unbroken(path());
    for (phase, count) in [("history", 2), ("residual", 11)] {
        stops_and_goes_on(&path, &in_turn(count), &format!("{phase}:LAST:term:{count}"), 75);
    }
}

/// Without a word of warning: what was written at the last instant counts.
#[test]
fn a_killed_rank() {
    let scene = unbroken(tilting().set(EVERY));
    for (phase, count) in [("history", 3), ("residual", 12), ("checkpoint", 3)] {
        let fault = format!("{phase}:LAST:kill:{count}");
        stops_and_goes_on(&scene, &in_turn(count), &fault, 137);
    }
}

#[test]
fn usr1_writes_a_checkpoint_and_goes_on() {
    let directory = fresh();
    let output = reference().launch(2, &directory, "history:1:usr1:3", &["--overwrite"]);
    assert_eq!(status(&output), Some(0), "{}", complaint(&output));
    assert!(directory.join("checkpoint.h5").is_file());
    assert_eq!(Scene::left_in(&directory, "usr1".into()).table.rows.len(), 8);
    let elsewhere = fresh();
    let file = directory.join("checkpoint.h5");
    let output =
        reference().launch(3, &elsewhere, "", &["--restart", &file.to_string_lossy(), "--verbose"]);
    assert_eq!(status(&output), Some(0), "{}", complaint(&output));
    let screen = String::from_utf8_lossy(&output.stdout).into_owned();
    // On a busy machine the corrections are slow, and a later checkpoint may have been written
    // ahead.
    let time = screen.split("at time ").nth(1).and_then(|rest| rest.split(',').next());
    let time = time.and_then(|time| time.parse::<f64>().ok());
    assert!(time.is_some_and(|time| time >= 3.0), "{screen}");
    let [whole, rest] = [&directory, &elsewhere].map(|d| Scene::left_in(d, "elsewhere".into()));
    whole.assert_same(&rest, 1e-10);
}

#[test]
fn the_wall_clock_limit_stops_in_time() {
    let directory = fresh();
    let scene = reference();
    // The reserve for the end of the run is longer than that.
    let output = scene.set("limits={wall: 1 s}").launch(2, &directory, "", &["--overwrite"]);
    assert_eq!(status(&output), Some(75), "{}", complaint(&output));
    let text = complaint(&output);
    assert!(text.contains("limits.wall after 0 of 8 instants"), "{text}");
    let unbroken = fresh();
    assert_eq!(status(&scene.launch(1, &unbroken, "", &["--overwrite"])), Some(0));
    goes_on(&scene.set("limits={wall: 00:10:00}"), 3, &directory, &unbroken, "limit");
}

/// A directory with a checkpoint, the two newest of eight.
fn stopped() -> PathBuf {
    let directory = fresh();
    let scene = reference().set(EVERY);
    let output = scene.launch(2, &directory, "history:1:term:5", &["--overwrite"]);
    assert_eq!(status(&output), Some(75), "{}", complaint(&output));
    directory
}

/// Changes a byte in the last third of a file.
fn damage(file: &Path) {
    let mut bytes = fs::read(file).expect("a file");
    let at = bytes.len() - bytes.len() / 5;
    bytes[at] ^= 0x10;
    fs::write(file, bytes).expect("a writable file");
}

#[test]
fn a_damaged_checkpoint_falls_back_to_the_one_before() {
    let directory = stopped();
    let unbroken = fresh();
    assert_eq!(status(&reference().launch(1, &unbroken, "", &["--overwrite"])), Some(0));
    damage(&directory.join("checkpoint.h5"));
    let output = reference().launch(2, &directory, "", &["--restart", "latest"]);
    assert_eq!(status(&output), Some(0), "{}", complaint(&output));
    let screen = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(screen.contains("damaged; the checkpoint before it is taken"), "{screen}");
    let [whole, rest] = [&unbroken, &directory].map(|d| Scene::left_in(d, "damaged".into()));
    whole.assert_same(&rest, 1e-10);

    let directory = stopped();
    for name in ["checkpoint.h5", "checkpoint.previous.h5"] {
        damage(&directory.join(name));
    }
    let output = reference().launch(2, &directory, "", &["--restart", "latest"]);
    assert_eq!(status(&output), Some(2), "{}", complaint(&output));
    let text = complaint(&output);
    assert!(text.contains("checkpoint.previous.h5: its fields are damaged"), "{text}");
}

/// The lock of a file in another process stands for a file system that has none: the same refusal.
#[test]
fn a_lock_that_cannot_be_had_is_named() {
    let directory = stopped();
    let file = fs::File::open(directory.join("checkpoint.h5")).expect("a checkpoint");
    flock(&file, FlockOperation::LockExclusive).expect("locks");
    let scene = reference();
    let output = scene.launch(2, &directory, "", &["--restart", "latest"]);
    let text = complaint(&output);
    assert_eq!(status(&output), Some(4), "{text}");
    for words in ["checkpoint.h5: HDF5 cannot lock it", "errno = 11", "HDF5_USE_FILE_LOCKING=FALSE"]
    {
        assert!(text.contains(words), "{text}");
    }
    assert!(!text.contains("not a whole HDF5 file"), "{text}");
    // As the message says.
    let output = Command::new(PROGRAM)
        .args(scene.words(&directory))
        .args(["--restart", "latest"])
        .envs(environment())
        .env("HDF5_USE_FILE_LOCKING", "FALSE")
        .output()
        .expect("the program");
    assert_eq!(status(&output), Some(0), "{}", complaint(&output));
}

#[test]
fn another_case_is_refused_in_words() {
    let directory = stopped();
    let refused = |scene: &Scene, words: &str| {
        let output = scene.launch(2, &directory, "", &["--restart", "latest"]);
        let text = complaint(&output);
        assert_eq!(status(&output), Some(2), "{words}: {text}");
        assert!(text.contains(words), "{text}");
    };
    let case = reference();
    refused(
        &case.set("materials.rock.elastic.young_modulus=6.0e9"),
        "`materials.rock.elastic.young_modulus` is 5800000000.0 there and 6000000000.0 here",
    );
    refused(&case.set("mesh.refine=1"), "`mesh.refine` is 0 there and 1 here");
    refused(
        &case.set("time.instants=[1, 2, 3.5, 4, 8]"),
        "it has gone through the instants [1.0, 2.0",
    );
    refused(&case.set("probes.0.name=p"), "`probes.0.name` is ");
    let empty = fresh();
    let output = case.launch(1, &empty, "", &["--restart", "latest"]);
    assert_eq!(status(&output), Some(2));
    assert!(complaint(&output).contains("there is no checkpoint in"), "{}", complaint(&output));
    let file = empty.join("text.h5");
    fs::write(&file, "no checkpoint").expect("a writable directory");
    let output = case.launch(1, &empty, "", &["--restart", &file.to_string_lossy()]);
    assert_eq!(status(&output), Some(2));
    assert!(complaint(&output).contains("it is not a whole HDF5 file"), "{}", complaint(&output));
    // What was stopped is not lost by mistake.
    let output = case.launch(1, &directory, "", &[]);
    assert_eq!(status(&output), Some(2));
    assert!(complaint(&output).contains("--restart latest"), "{}", complaint(&output));
    // How it is solved and how far may change.
    let longer = case.set("solver.linear=hypre").set("time.instants=[1, 2, 3, 4, 5, 6]");
    let output = longer.launch(1, &directory, "", &["--restart", "latest"]);
    assert_eq!(status(&output), Some(0), "{}", complaint(&output));
}
