//! A launcher that is ended or killed: the whole run ends soon, and every file under its final name
//! is complete. `matrix` has what happens to the ranks themselves.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};
use std::{fs, io};

use column_hpc::output::history::Table;

use super::{Folder, common, faults, files};

/// The time within which every rank is gone.
const SOON: Duration = Duration::from_secs(10);

/// Every file under a final name can be read to its end.
fn assert_complete(folder: &Folder) {
    for path in files(&folder.path("out")) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if name.contains(".tmp.") {
            continue;
        }
        let text = || fs::read_to_string(&path).expect("a readable file");
        if name == "history.csv" {
            let table = Table::read(&path).expect("a complete table");
            assert!(table.rows.iter().all(|row| row.len() == table.columns.len()));
        } else if name.ends_with(".vtkhdf") {
            let file = hdf5::File::open(&path).expect("a complete file");
            let points = file.dataset("VTKHDF/Points").expect("points").read_raw::<f64>();
            assert!(points.expect("points").len() >= 12, "{name}");
        } else if name.ends_with(".h5") {
            // Where corrections are slow, on a busy machine too, a checkpoint is written ahead.
            hdf5::File::open(&path).expect("a complete file");
        } else if name.ends_with(".json") {
            serde_json::from_str::<serde_json::Value>(&text()).expect("complete JSON");
        } else {
            assert!(name.ends_with(".series"), "{name}");
            let series: serde_json::Value = serde_json::from_str(&text()).expect("complete JSON");
            for entry in series["files"].as_array().expect("a list") {
                let named = folder.path("out/fields").join(entry["name"].as_str().expect("a name"));
                assert!(named.is_file(), "{}", named.display());
            }
        }
    }
}

/// A run on two ranks that waits in its second instant.
fn waiting(folder: &Folder) -> Child {
    let fault = &format!("{}=history:0:wait:2", faults::VARIABLE);
    let place = folder.0.to_str().expect("a name of ours");
    let child = Command::new("mpirun")
        .args(["-n", "2", "--quiet", "env", "-C", place, fault, faults::PROGRAM, "case.yaml"])
        .args(["--output", &format!("{place}/out"), "--set", "output.fields=all"])
        .envs(common::environment())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("mpirun");
    let rows = || fs::read_to_string(folder.path("out/history.csv")).map(|t| t.lines().count());
    let end = Instant::now() + Duration::from_secs(120);
    while !rows().is_ok_and(|rows| rows == 3) {
        assert!(Instant::now() < end, "the run does not come to its second instant");
        sleep(Duration::from_millis(20));
    }
    child
}

/// Whether a process with this folder on its command line is left.
fn alive(folder: &Path) -> io::Result<bool> {
    let name = folder.to_string_lossy().into_owned();
    for entry in fs::read_dir("/proc")?.flatten() {
        // Processes come and go meanwhile.
        let Ok(line) = fs::read(entry.path().join("cmdline")) else { continue };
        if String::from_utf8_lossy(&line).contains(&name) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// No rank is left soon after the start.
fn assert_gone(folder: &Folder, start: Instant, after: &str) {
    while alive(&folder.0).expect("/proc") {
        assert!(start.elapsed() < SOON, "ranks are left after {after}");
        sleep(Duration::from_millis(20));
    }
    assert!(start.elapsed() < SOON, "{after} took {:?}", start.elapsed());
}

/// The same directory for another run while this one lives.
fn assert_taken(folder: &Folder) {
    let history = folder.read("out/history.csv");
    for more in [&[][..], &["--overwrite"], &["--restart", "latest"]] {
        let refused = folder.run(1, &[&["case.yaml"], more].concat());
        assert_eq!(refused.status, Some(2), "{more:?}: {}", refused.stderr);
        assert!(refused.stderr.contains("another run is writing into out"), "{}", refused.stderr);
        assert_eq!(refused.stderr.lines().count(), 1, "{}", refused.stderr);
    }
    assert_eq!(folder.read("out/history.csv"), history);
}

fn launcher_ends_by(signal: &str) {
    let folder = Folder::new();
    let mut child = waiting(&folder);
    assert_taken(&folder);
    let start = Instant::now();
    let sent = Command::new("kill").args([signal, &child.id().to_string()]).status();
    assert!(sent.is_ok_and(|status| status.success()));
    let status = child.wait().expect("a child of ours");
    assert!(!status.success(), "{signal}");
    assert_gone(&folder, start, signal);
    assert_complete(&folder);
    assert_eq!(folder.history("time").len(), 2);
    assert!(!folder.path("out/report.json").exists());
    let again = folder.run(2, &["case.yaml", "--overwrite"]);
    assert_eq!(again.status, Some(0), "nobody holds the directory: {}", again.stderr);
}

#[test]
fn ranks_end_with_their_launcher() {
    launcher_ends_by("-TERM");
    launcher_ends_by("-KILL");
}

/// What the tests of failures rely on.
#[test]
fn a_run_that_hangs_fails_its_test_with_the_state_of_its_ranks() {
    let folder = Folder::new();
    let out = folder.path("out");
    let args = ["case.yaml", "--output", out.to_str().expect("a name of ours")];
    let limit = Duration::from_secs(5);
    let watched = || faults::watch_within(limit, &folder.0, 2, "history:1:wait", &args, || {});
    let told = catch_unwind(AssertUnwindSafe(watched)).expect_err("it waits for a minute");
    let told = told.downcast::<String>().expect("words");
    assert!(told.starts_with("history:1:wait on 2 ranks of case.yaml "), "{told}");
    assert!(told.contains(" hangs after "), "{told}");
    assert_eq!(told.matches("State: ").count(), 2, "{told}");
    assert!(!alive(&folder.0).expect("/proc"), "{told}");
}
