//! A rank that fails, panics or is killed in the middle, and a launcher that is: the whole run ends
//! soon with the right status, and every file under its final name is complete.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};
use std::{fs, io};

use column_hpc::output::history::Table;

use super::{Answer, Folder, PROGRAM, common, files};

/// The time within which every rank is gone.
const SOON: Duration = Duration::from_secs(10);

/// A run with field files that starts the program with its folder on the command line.
fn run(folder: &Folder, fault: &str) -> Answer {
    let out = folder.path("out");
    let out = out.to_str().expect("a name of ours");
    folder.run_with(fault, 2, &["case.yaml", "--set", "output.fields=all", "--output", out])
}

/// Where a rank fails: in the set-up, in the second evaluation of a residual, between two files of
/// the second instant, in the middle of a field file of the first and of the second instant.
const PLACES: [(&str, u32); 5] =
    [("distribute", 1), ("residual", 2), ("history", 2), ("output", 1), ("output", 4)];

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

fn fails(kind: &str, expected: i32, says: impl Fn(&str) -> String) {
    for (phase, count) in PLACES {
        let folder = Folder::new();
        let start = Instant::now();
        let fault = format!("COLUMN_HPC_FAULT={phase}:1:{kind}:{count}");
        let answer = run(&folder, &fault);
        assert_gone(&folder, start, &fault);
        assert_eq!(answer.status, Some(expected), "{fault}: {answer:?}");
        assert_eq!(answer.stderr, says(phase), "{fault}");
        assert_complete(&folder);
        if phase == "history" {
            assert_eq!(folder.history("time").len(), 2);
        }
        if phase == "output" {
            // The next run of the same case needs no word and leaves nothing of the one before.
            assert_eq!(run(&folder, "COLUMN_HPC_FAULT=").status, Some(0), "after {fault}");
            let left = files(&folder.path("out"));
            assert!(!left.iter().any(|f| f.to_string_lossy().contains(".tmp.")), "{left:?}");
            assert_complete(&folder);
        }
    }
}

#[test]
fn an_error_on_one_rank_ends_all_with_status_4() {
    fails("error", 4, |phase| {
        format!("error: rank 1: a test asked for an error in phase {phase}\n")
    });
}

#[test]
fn a_panic_on_one_rank_ends_all_with_status_101() {
    let line = |text: &str| text.lines().nth(1).unwrap_or_default().to_owned();
    let folder = Folder::new();
    let answer = run(&folder, "COLUMN_HPC_FAULT=residual:1:panic");
    assert_eq!(answer.status, Some(101), "{answer:?}");
    assert!(answer.stderr.starts_with("[rank 1] panicked at src"), "{}", answer.stderr);
    assert_eq!(line(&answer.stderr), "a test asked for a panic in phase residual");
    assert!(answer.stderr.ends_with("please report it with the case file.\n"));
    for (phase, count) in PLACES {
        let folder = Folder::new();
        let start = Instant::now();
        let fault = format!("COLUMN_HPC_FAULT={phase}:1:panic:{count}");
        let answer = run(&folder, &fault);
        assert_gone(&folder, start, &fault);
        assert_eq!(answer.status, Some(101), "{fault}: {answer:?}");
        assert_complete(&folder);
    }
}

#[test]
fn a_killed_rank_ends_all_with_status_137() {
    fails("kill", 137, |_| String::new());
}

/// A run on two ranks that waits in its second instant.
fn waiting(folder: &Folder) -> Child {
    let fault = "COLUMN_HPC_FAULT=history:0:wait:2";
    let place = folder.0.to_str().expect("a name of ours");
    let child = Command::new("mpirun")
        .args(["-n", "2", "--quiet", "env", "-C", place, fault, PROGRAM, "case.yaml"])
        .args(["--output", &format!("{place}/out"), "--set", "output.fields=all"])
        .envs(common::environment())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("mpirun");
    let rows = || fs::read_to_string(folder.path("out/history.csv")).map(|t| t.lines().count());
    let end = Instant::now() + Duration::from_secs(30);
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

fn launcher_ends_by(signal: &str) {
    let folder = Folder::new();
    let mut child = waiting(&folder);
    let start = Instant::now();
    let sent = Command::new("kill").args([signal, &child.id().to_string()]).status();
    assert!(sent.is_ok_and(|status| status.success()));
    let status = child.wait().expect("a child of ours");
    assert!(!status.success(), "{signal}");
    assert_gone(&folder, start, signal);
    assert_complete(&folder);
    assert_eq!(folder.history("time").len(), 2);
    assert!(!folder.path("out/report.json").exists());
}

#[test]
fn ranks_end_with_their_launcher() {
    launcher_ends_by("-TERM");
    launcher_ends_by("-KILL");
}
