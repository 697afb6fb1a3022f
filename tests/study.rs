//! A study of small runs, some of which fail: refused, interrupted, resumed, shared out.

use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};
use std::{env, fs};

const PROGRAM: &str = env!("CARGO_BIN_EXE_column-hpc");

const CASE: &str = "\
mesh: {column: {size: [1, 1, 5], cells: [1, 1, 6]}}
materials: {rock: {elastic: {young_modulus: 5.8e9, poisson_ratio: 0}}}
interfaces:
  - {name: joint, z: 2.5, law: {linear_softening: {strength: 1.1e6, fracture_energy: 900}}}
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}
  - {on: top, displacement: {x: 0, y: 0, z: {table: [[0, 0], [1, 1.0e-3]]}}}
time: {instants: [0.5, 1]}
";

/// Notes every launch; a run with the title `slow` waits while there is a file `wait`.
const LAUNCHER: &str = "#!/usr/bin/env bash
cd \"$(dirname \"$0\")\"
echo \"$@\" >>launches
if [ -e wait ]; then case \"$*\" in *slow*) sleep 100 ;; esac; fi
exec mpirun --quiet -n \"$@\"
";

const STUDY: &str = "\
title: Small & failing
base: case.yaml
limit: 6 s
launcher: LAUNCHER {ranks}
axes:
  - name: load
    choices:
      - {label: gentle, set: {title: gentle}}
      # A force that nothing holds once the interface is broken.
      - {label: torn, set: {boundary.1: {on: top, traction: {z: {table: [[0, 0], [1, 2.0e+6]]}}}}}
      - {label: endless, ranks: 2, set: {mesh.column.cells: [16, 16, 80], reduce: never, time.instants: [INSTANTS]}}
      - {label: slow, set: {title: slow}}
measures:
  - {name: traction_error, error: joint.normal_traction, at: last, against: {equals: 1017312.0728929385}}
charts:
  - {name: error, kind: lines, x: core_seconds, y: traction_error, series: [load], pareto: true}
  - {name: map, kind: map, x: load, y: load}
  - {name: strong, kind: strong_scaling, series: [load]}
";

struct Folder(PathBuf);

impl Folder {
    /// With a case, a launcher, and a study, in which the words are replaced.
    fn new(study: &str) -> Self {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path =
            env::temp_dir().join(format!("column-hpc-study-{}-{number}", std::process::id()));
        fs::create_dir_all(&path).expect("the temporary directory is writable");
        let folder = Self(path);
        let launcher = folder.path("launch.sh");
        fs::write(&launcher, LAUNCHER).expect("a folder of ours");
        fs::set_permissions(&launcher, fs::Permissions::from_mode(0o755)).expect("a file of ours");
        let instants: Vec<String> =
            (1..=4000).map(|i| format!("{}", f64::from(i) / 4000.0)).collect();
        let text = study
            .replace("LAUNCHER", launcher.to_str().expect("a name of ours"))
            .replace("INSTANTS", &instants.join(", "))
            .replace("joint.normal_traction,", "joint.normal_traction.mean,");
        fs::write(folder.path("case.yaml"), CASE).expect("a folder of ours");
        fs::write(folder.path("study.yaml"), text).expect("a folder of ours");
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).expect(name)
    }

    fn command(&self, options: &[&str]) -> Command {
        let mut command = Command::new(PROGRAM);
        command.arg("study").arg(self.path("study.yaml")).arg("--output").arg(self.path("out"));
        command.args(options).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    fn study(&self, options: &[&str]) -> Output {
        self.command(options).output().expect("the program")
    }

    fn launches(&self) -> usize {
        fs::read_to_string(self.path("launches")).map_or(0, |text| text.lines().count())
    }

    /// The status of each run by its label.
    fn statuses(&self) -> Vec<(String, String)> {
        let text = self.read("out/study.csv");
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let head = reader.headers().expect("names").clone();
        let place = |name: &str| head.iter().position(|column| column == name).expect(name);
        let (load, status) = (place("load"), place("status"));
        let rows = reader.records().map(|row| row.expect("a row"));
        rows.map(|row| (row[load].to_owned(), row[status].to_owned())).collect()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Whether a process with this folder on its command line is left.
fn alive(folder: &Path) -> bool {
    let name = folder.to_string_lossy().into_owned();
    let entries = fs::read_dir("/proc").expect("/proc").flatten();
    entries.into_iter().any(|entry| {
        let line = fs::read(entry.path().join("cmdline")).unwrap_or_default();
        String::from_utf8_lossy(&line).contains(&name)
    })
}

fn wait_until(what: &str, mut met: impl FnMut() -> bool) {
    let end = Instant::now() + Duration::from_secs(40);
    while !met() {
        assert!(Instant::now() < end, "{what}");
        sleep(Duration::from_millis(20));
    }
}

fn interrupted(child: Child) -> Output {
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(sent.is_ok_and(|status| status.success()));
    child.wait_with_output().expect("a child of ours")
}

#[test]
fn mistakes_are_told_before_anything_is_run() {
    let wrong = STUDY
        .replace("{title: gentle}", "{mesh.ordr: 2}")
        .replace("error: joint.normal_traction,", "error: joint.normal_tracton,");
    let folder = Folder::new(&wrong);
    let answer = folder.study(&[]);
    let told = text(&answer.stderr);
    assert_eq!(answer.status.code(), Some(2), "{told}");
    for words in [
        "study.yaml:8:31: mesh.ordr is not a known key; did you mean `order`?",
        "(run load=gentle)",
        "study.yaml:14:28: `joint.normal_tracton` is no column of history.csv; did you mean `joint.normal_traction",
    ] {
        assert!(told.contains(words), "{words}\n{told}");
    }
    assert_eq!(folder.launches(), 0);

    let misspelt = STUDY
        .replace("series: [load], pareto", "series: [laod], pareto")
        .replace("limit:", "limt:");
    let folder = Folder::new(&misspelt);
    let told = text(&folder.study(&[]).stderr);
    assert!(
        told.contains("study.yaml:3:1: limt is not a known key; did you mean `limit`?"),
        "{told}"
    );
    let folder = Folder::new(&STUDY.replace("series: [load], pareto", "series: [laod], pareto"));
    let told = text(&folder.study(&[]).stderr);
    assert!(told.contains("`laod` is no axis; did you mean `load`?"), "{told}");
}

#[test]
fn an_interrupted_study_goes_on_and_runs_nothing_twice() {
    let folder = Folder::new(STUDY);
    fs::write(folder.path("wait"), "").expect("a folder of ours");
    let child = folder.command(&[]).spawn().expect("the program");
    wait_until("the last run is not launched", || folder.launches() == 4);
    let answer = interrupted(child);
    let told = text(&answer.stderr);
    assert_eq!(answer.status.code(), Some(75), "{told}");
    assert!(told.contains("go on with --resume"), "{told}");
    wait_until("processes are left", || !alive(&folder.path("out")));

    let answer = folder.study(&[]);
    assert_eq!(answer.status.code(), Some(2), "{}", text(&answer.stderr));
    assert!(text(&answer.stderr).contains("--resume"), "{}", text(&answer.stderr));

    fs::remove_file(folder.path("wait")).expect("a file of ours");
    let answer = folder.study(&["--resume"]);
    assert_eq!(answer.status.code(), Some(0), "{}", text(&answer.stderr));
    assert_eq!(folder.launches(), 5);
    let expected = [
        ("gentle", "done"),
        ("torn", "not_converged"),
        ("endless", "time_limit"),
        ("slow", "done"),
    ];
    let expected = expected.map(|(load, status)| (load.to_owned(), status.to_owned()));
    assert_eq!(folder.statuses(), expected);
    assert!(text(&answer.stdout).contains("load=torn, 1 rank: kept, not converged"));

    // Again: nothing is left to do.
    assert_eq!(folder.study(&["--resume"]).status.code(), Some(0));
    assert_eq!(folder.launches(), 5);
    let everything: serde_json::Value =
        serde_json::from_str(&folder.read("out/study.json")).expect("complete JSON");
    let runs = everything["runs"].as_array().expect("runs");
    assert!(runs[0]["measures"]["traction_error"].as_f64().expect("a number") < 1e-9);
    assert!(runs[1]["message"].as_str().expect("words").contains("joint"), "{}", runs[1]);
    assert_eq!(runs[2]["message"], "ended after 6 s");
    assert!(
        everything["versions"]["column-hpc"].is_string() && everything["machine"]["cores"].is_u64()
    );

    let page = folder.read("out/study.html");
    for word in ["http:", "https:", "src=", "href=", "@import", "url("] {
        assert!(!page.contains(word), "{word}");
    }
    for word in ["<svg", "Small &amp; failing", "load=torn: not converged", "★"] {
        assert!(page.contains(word), "{word}");
    }
    for name in ["error", "map", "strong"] {
        let svg = folder.read(&format!("out/charts/{name}.svg"));
        assert!(svg.starts_with("<svg") && svg.contains("</svg>"), "{name}");
        let png = fs::read(folder.path(&format!("out/charts/{name}.png"))).expect(name);
        assert!(png.len() > 1000 && png[1..4] == *b"PNG", "{name}");
    }
}

#[test]
fn shares_of_a_study_add_up() {
    let quick = STUDY.replace(
        "endless, ranks: 2, set: {mesh.column.cells: [16, 16, 80], reduce: never, time.instants: [INSTANTS]}",
        "two, ranks: 2",
    );
    let folder = Folder::new(&quick);
    for share in ["1/2", "2/2"] {
        let answer = folder.study(&["--part", share]);
        assert_eq!(answer.status.code(), Some(0), "{}", text(&answer.stderr));
    }
    assert_eq!(folder.launches(), 4);
    assert!(!folder.path("out/study.html").exists());
    assert_eq!(folder.study(&["--charts-only"]).status.code(), Some(0));
    assert_eq!(folder.launches(), 4);
    assert_eq!(folder.statuses()[2], ("two".to_owned(), "done".to_owned()));
    assert!(folder.path("out/study.html").exists());
}
