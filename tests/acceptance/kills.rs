//! Kills at random moments: every file under a final name is whole, and the run goes on from the
//! latest checkpoint as if nothing had happened.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use column_hpc::hash::mix;
use column_hpc::output::history::Table;

use crate::common::environment;
use crate::faults::ranks_in;
use crate::scene::{PROGRAM, Scene, fresh};

/// A column that writes fields and a checkpoint at every one of many instants.
fn scene() -> Scene {
    let instants: Vec<String> = (1..=40).map(|i| format!("{}", 0.2 * f64::from(i))).collect();
    Scene::shipped("wtnv146/case.yaml")
        .set("mesh.column.cells=[6, 6, 12]")
        .set("expect=[]")
        .set("output.checkpoint={every: 1 instant}")
        .set(&format!("time.instants=[{}]", instants.join(", ")))
}

fn start(ranks: usize, directory: &Path, scene: &Scene) -> Child {
    Command::new("mpirun")
        .args(["-n", &ranks.to_string(), "--quiet", PROGRAM])
        .args(scene.words(directory))
        .envs(environment())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("mpirun is on the PATH")
}

fn kill(process: i32) {
    let _ = Command::new("kill").args(["-9", &process.to_string()]).stderr(Stdio::null()).status();
}

/// Opens every file under a final name, to its end.
fn assert_whole(directory: &Path, label: &str) {
    let list = |path: &Path| -> Vec<_> {
        fs::read_dir(path).into_iter().flatten().flatten().map(|e| e.path()).collect()
    };
    for path in list(directory).into_iter().chain(list(&directory.join("fields"))) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if name.contains(".tmp.") || path.is_dir() {
            continue;
        }
        let whole = |ok: bool| assert!(ok, "{label}: {name} is not whole");
        if name == "history.csv" {
            let table = Table::read(&path).expect("a table");
            whole(table.rows.iter().all(|row| row.len() == table.columns.len()));
        } else if name.ends_with(".vtkhdf") {
            let file = hdf5::File::open(&path).expect("a whole file");
            let points = file.dataset("VTKHDF/Points").expect("points").shape()[0];
            if !name.contains("_mesh") && name.starts_with("bulk") {
                let field = file.dataset("VTKHDF/PointData/displacement").expect("a field");
                whole(field.read_raw::<f64>().expect("numbers").len() == 3 * points);
            }
        } else if name.ends_with(".h5") {
            whole(hdf5::File::open(&path).is_ok());
        } else if name.ends_with(".json") || name.ends_with(".series") {
            let text = fs::read_to_string(&path).expect("a text");
            let value: serde_json::Value = serde_json::from_str(&text).expect("whole JSON");
            for entry in value["files"].as_array().into_iter().flatten() {
                whole(
                    directory
                        .join("fields")
                        .join(entry["name"].as_str().expect("a name"))
                        .is_file(),
                );
            }
        } else {
            panic!("{label}: {name} is a file that nobody knows");
        }
    }
}

/// Kills a rank or the launcher `count` times, each time at another moment of a run.
fn random_kills(count: u64) {
    let scene = scene();
    let unbroken = fresh();
    let begin = Instant::now();
    let output = scene.launch(2, &unbroken, "", &["--overwrite"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let length = begin.elapsed();
    let whole = Scene::left_in(&unbroken, "unbroken".into());
    let mut restarted = 0;
    for number in 0..count {
        let directory = fresh();
        let part = (mix(number) % 1000) as f64 / 1000.0;
        let mut launcher = start(2, &directory, &scene);
        if number % 2 == 0 {
            sleep(length.mul_f64(part));
        } else {
            // At any pace of the machine there is something to go on from.
            let first = directory.join("checkpoint.h5");
            while !first.is_file() && matches!(launcher.try_wait(), Ok(None)) {
                sleep(Duration::from_millis(5));
            }
            sleep(length.mul_f64(0.3 * part));
        }
        let ranks = ranks_in(&directory, PROGRAM);
        let launched = launcher.id() as i32;
        let victim = match mix(number + count) % 3 {
            2 => launched,
            rank => ranks.get(rank as usize).copied().unwrap_or(launched),
        };
        kill(victim);
        let end = Instant::now() + Duration::from_secs(10);
        while !ranks_in(&directory, PROGRAM).is_empty() {
            assert!(Instant::now() < end, "kill {number}: a rank is left after 10 s");
            sleep(Duration::from_millis(20));
        }
        // Where a rank is killed while it starts, Open MPI's launcher can wait for ever for one
        // that is gone.
        while Instant::now() < end && matches!(launcher.try_wait(), Ok(None)) {
            sleep(Duration::from_millis(20));
        }
        let _ = launcher.kill();
        let _ = launcher.wait();
        let label = format!("kill {number} after {part} of {length:?}");
        assert_whole(&directory, &label);
        let there =
            ["checkpoint.h5", "checkpoint.previous.h5"].map(|n| directory.join(n).is_file());
        let words: &[&str] =
            if there.contains(&true) { &["--restart", "latest"] } else { &["--overwrite"] };
        restarted += u64::from(words.len() == 2);
        let output = scene.launch(1 + number as usize % 3, &directory, "", words);
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{label}: {text}");
        whole.assert_same(&Scene::left_in(&directory, label.clone()), 1e-10);
        assert_whole(&directory, &label);
        let _ = fs::remove_dir_all(&directory);
    }
    assert!(2 * restarted >= count, "only {restarted} of {count} kills came after a checkpoint");
}

#[test]
fn a_few_random_kills() {
    random_kills(6);
}

/// Takes minutes: `cargo test --release --test acceptance kills -- --ignored`.
#[test]
#[ignore = "takes minutes"]
fn two_hundred_random_kills() {
    random_kills(200);
}
