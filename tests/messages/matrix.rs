//! Every phase of a run x every rank x every kind of failure: the run ends soon with its status and
//! one message, and what is on disk is whole and that of an unbroken run.

use std::collections::BTreeMap;
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};
use std::{fs, thread};

use super::faults::{Ended, watch};
use super::{Folder, files};

/// A small column in 2D that writes fields and a checkpoint at each of its two instants.
pub const SCENE: &str = "\
title: matrix of faults
mesh: {column: {size: [1, 5], cells: [2, 6]}}
materials: {rock: {elastic: {young_modulus: 5.8e9, poisson_ratio: 0.2}}}
interfaces:
  - {name: joint, z: 2.5, law: {linear_softening: {strength: 1.1e6, fracture_energy: 900}}}
boundary:
  - {on: bottom, displacement: {x: 0, z: 0}}
  - {on: top, displacement: {x: 0, z: {formula: \"1.2e-3*t*(1 + 0.2*x)\"}}}
time: {instants: [0.5, 1]}
output: {fields: all, directory: out, checkpoint: {every: 1 instant}}
";

/// A place at which a run fails, and what stands on disk by then.
struct Place {
    phase: &'static str,
    /// How often the run has come there: in its second instant, where it has instants.
    count: u32,
    /// Rows of the history.
    rows: usize,
    /// Whether there are numbers there to spoil.
    nan: bool,
}

const fn place(phase: &'static str, count: u32, rows: usize, nan: bool) -> Place {
    Place { phase, count, rows, nan }
}

const PLACES: [Place; 16] = [
    place("case", 1, 0, false),
    place("mesh", 1, 0, false),
    place("distribute", 1, 0, false),
    place("setup", 1, 0, false),
    place("residual", 4, 1, true),
    place("tangent", 3, 1, false),
    place("linear", 3, 1, true),
    place("step", 2, 1, true),
    place("row", 2, 1, true),
    place("history", 2, 2, false),
    place("fields", 2, 2, true),
    // In the middle of the file of the bulk: each series begins with the file of its mesh.
    place("output", 5, 2, false),
    place("state", 2, 2, true),
    place("checkpoint", 2, 2, false),
    place("report", 1, 2, true),
    place("page", 1, 2, false),
];

const KINDS: [&str; 4] = ["error", "panic", "kill", "nan"];

/// Ranks, and the one that fails.
const PAIRS: [(usize, usize); 6] = [(1, 0), (2, 0), (2, 1), (3, 0), (3, 1), (3, 2)];

#[derive(Clone, Copy)]
struct Fault {
    place: &'static Place,
    kind: &'static str,
    ranks: usize,
    rank: usize,
}

impl Fault {
    /// Whether it strikes while files are written.
    fn is_late(&self) -> bool {
        matches!(self.place.phase, "output" | "checkpoint" | "report" | "page")
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { place: Place { phase, count, .. }, kind, rank, .. } = self;
        // A number that is none once in a residual is left behind by a shorter step.
        let again = if *kind == "nan" { "+" } else { "" };
        write!(f, "{phase}:{rank}:{kind}:{count}{again}")
    }
}

/// Every phase with every kind it can have and every pair of ranks; or with half the kinds, by
/// turns, and one pair for each.
fn faults(all: bool) -> Vec<Fault> {
    let mut found = Vec::new();
    for (p, place) in PLACES.iter().enumerate() {
        let kinds = KINDS.into_iter().enumerate().filter(|(_, k)| *k != "nan" || place.nan);
        for (k, kind) in kinds.filter(|(k, _)| all || (p + k) % 2 == 0) {
            // Rank 0 alone has a report.
            let mut pairs = PAIRS.to_vec();
            pairs.retain(|(_, rank)| place.phase != "report" || kind != "nan" || *rank == 0);
            let one = (p + k / 2) % pairs.len();
            let chosen = pairs.into_iter().enumerate().filter(|(i, _)| all || *i == one);
            found.extend(chosen.map(|(_, (ranks, rank))| Fault { place, kind, ranks, rank }));
        }
    }
    found
}

/// The numbers in the files of a run, by the name of a file: those of a checkpoint under the number
/// of its instant.
pub type Contents = BTreeMap<String, Vec<Vec<f64>>>;

/// Reads every file under a final name to its end.
pub fn contents(out: &Path, label: &str) -> Contents {
    let mut found = Contents::new();
    for path in files(out) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let text = || fs::read_to_string(&path).expect("a readable file");
        let json = || -> serde_json::Value {
            serde_json::from_str(&text()).unwrap_or_else(|e| panic!("{label}: {name}: {e}"))
        };
        let open = || hdf5::File::open(&path).unwrap_or_else(|e| panic!("{label}: {name}: {e}"));
        let numbers = |file: &hdf5::File, list: &[&str]| -> Vec<Vec<f64>> {
            let read = |place: &&str| file.dataset(place).and_then(|set| set.read_raw::<f64>());
            list.iter()
                .map(|place| read(place).unwrap_or_else(|e| panic!("{label}: {name} {place}: {e}")))
                .collect()
        };
        if name.contains(".tmp.") || name == "history.csv" {
            continue;
        } else if name.contains("_mesh") {
            found.insert(name.clone(), numbers(&open(), &["VTKHDF/Points"]));
        } else if name.ends_with(".vtkhdf") {
            let fields: &[&str] = if name.starts_with("bulk") {
                &["VTKHDF/Points", "VTKHDF/PointData/displacement", "VTKHDF/CellData/stress"]
            } else {
                &["VTKHDF/Points", "VTKHDF/PointData/traction", "VTKHDF/PointData/jump"]
            };
            found.insert(name.clone(), numbers(&open(), fields));
        } else if name.ends_with(".h5") {
            let file = open();
            let meta = file.dataset("checkpoint/meta").and_then(|set| set.read_raw::<u8>());
            let meta: serde_json::Value =
                serde_json::from_slice(&meta.expect("a description")).expect("whole JSON");
            let fields = numbers(&file, &["checkpoint/nodal", "checkpoint/interface"]);
            found.insert(format!("checkpoint {}", meta["accepted"]), fields);
        } else if name.ends_with(".series") {
            for entry in json()["files"].as_array().expect("a list") {
                let named = out.join("fields").join(entry["name"].as_str().expect("a name"));
                assert!(named.is_file(), "{label}: {}", named.display());
            }
        } else if name == "report.html" {
            assert!(text().ends_with("</html>\n"), "{label}: {name} is cut off");
        } else {
            assert!(name.ends_with(".json"), "{label}: {name} is a file that nobody knows");
            json();
        }
    }
    let finite = found.values().flatten().flatten().all(|value| value.is_finite());
    assert!(finite, "{label}: a number in a file is none");
    found
}

/// An unbroken run.
pub struct Unbroken {
    pub history: Vec<String>,
    pub contents: Contents,
}

impl Unbroken {
    fn on(ranks: usize) -> Self {
        let folder = Folder::with(SCENE);
        let ended = run(&folder, ranks, "", &[]);
        assert_eq!((ended.status, ended.stderr.as_str()), (Some(0), ""), "{ranks} ranks");
        let history: Vec<String> =
            folder.read("out/history.csv").lines().map(str::to_owned).collect();
        assert_eq!(history.len(), 3);
        let contents = contents(&folder.path("out"), "unbroken");
        assert_eq!(contents.len(), 8, "{:?}", contents.keys());
        Self { history, contents }
    }
}

fn run(folder: &Folder, ranks: usize, fault: &str, more: &[&str]) -> Ended {
    let [case, out] = ["case.yaml", "out"].map(|name| folder.path(name));
    let mut args = vec![case.to_str().expect("a name of ours"), "--output"];
    args.push(out.to_str().expect("a name of ours"));
    args.extend(more);
    watch(&folder.0, ranks, fault, &args, || {})
}

/// Fails as asked, looks at what is left, and goes on from there if asked.
fn scene(fault: Fault, unbroken: &Unbroken, goes_on: bool) -> Duration {
    let Fault { place, kind, ranks, .. } = fault;
    let folder = Folder::with(SCENE);
    let page: &[&str] = if place.phase == "page" { &["--report"] } else { &[] };
    let ended = run(&folder, ranks, &fault.to_string(), page);
    let label = format!("{fault} on {ranks} ranks: {ended:?}");
    assert_message(&fault, &ended, &label);

    let rows = fs::read_to_string(folder.path("out/history.csv")).unwrap_or_default();
    let rows: Vec<&str> = rows.lines().collect();
    let expected = if place.rows == 0 { 0 } else { 1 + place.rows };
    assert_eq!(rows, unbroken.history[..expected], "{label}");
    let left = contents(&folder.path("out"), &label);
    for (name, numbers) in &left {
        assert_eq!(Some(numbers), unbroken.contents.get(name), "{label}: {name}");
    }
    let temporary = |folder: &Folder| {
        files(&folder.0).iter().any(|file| file.to_string_lossy().contains(".tmp."))
    };
    let ordered = matches!(kind, "error" | "nan");
    if ordered {
        assert!(!temporary(&folder), "{label}: {:?}", files(&folder.0));
        // A file of an instant is complete when the next one begins.
        let first = ["bulk_000001.vtkhdf", "joint_000001.vtkhdf", "checkpoint 1"];
        assert!(expected == 0 || first.iter().all(|name| left.contains_key(*name)), "{label}");
    }
    let report = folder.path("out/report.json").is_file();
    // The page comes after a whole report.
    let comes = ordered && expected > 0 && place.phase != "report" || !page.is_empty();
    assert_eq!(report, comes, "{label}");
    assert!(!folder.path("out/report.html").exists(), "{label}");

    if !goes_on {
        return ended.took;
    }
    // The next run leaves nothing of this one.
    let goes_on = left.keys().any(|name| name.starts_with("checkpoint"));
    let words: &[&str] = if goes_on { &["--restart", "latest"] } else { &[] };
    let again = run(&folder, ranks, "", words);
    assert_eq!((again.status, again.stderr.as_str()), (Some(0), ""), "after {label}: {again:?}");
    assert!(!temporary(&folder), "after {label}: {:?}", files(&folder.0));
    let after = contents(&folder.path("out"), "after");
    let fields = unbroken.contents.keys().filter(|name| name.contains("_00000"));
    assert!(fields.clone().count() == 4 && fields.clone().all(|name| after.contains_key(name)));
    assert_eq!(folder.history("time").len(), 2, "after {label}");
    ended.took
}

/// The documented status, and one message that tells the cause.
fn assert_message(fault: &Fault, ended: &Ended, label: &str) {
    let Fault { place: Place { phase, .. }, kind, ranks, rank } = fault;
    let who = if *ranks > 1 { format!("rank {rank}: ") } else { String::new() };
    let text = &ended.stderr;
    let lines: Vec<&str> = text.lines().collect();
    match *kind {
        "error" => {
            assert_eq!(ended.status, Some(4), "{label}");
            assert_eq!(*text, format!("error: {who}a test asked for an error in phase {phase}\n"));
        }
        "panic" => {
            assert_eq!(ended.status, Some(101), "{label}");
            assert!(
                text.starts_with(&format!("[rank {rank}] panicked at tests/faults/")),
                "{label}"
            );
            assert_eq!(lines[1], format!("a test asked for a panic in phase {phase}"), "{label}");
            assert!(lines[2].ends_with("please report it with the case file."), "{label}");
            assert_eq!(lines.len(), 3, "{label}");
        }
        "kill" => {
            // None: the launcher hung.
            assert!(matches!(ended.status, Some(137) | None), "{label}");
            assert_eq!(text, "", "{label}");
        }
        _ => {
            assert_eq!(ended.status, Some(3), "{label}");
            assert!(lines[0].starts_with("error: "), "{label}");
            let told = text.matches(" is NaN ").count() + text.matches("is not a number").count();
            assert_eq!(told, 1, "{label}");
            // Corrections and energies that are none are so on all ranks.
            let who = if matches!(*phase, "linear" | "step") { "" } else { who.as_str() };
            assert!(text.contains(who), "{label}");
            let valid = if *phase == "report" { 1 } else { 2 };
            assert_eq!(lines.len(), valid, "{label}");
        }
    }
}

/// Goes through scenes, two at a time, and says how long it took.
fn run_all(all: bool) {
    let faults = faults(all);
    let begin = Instant::now();
    let unbroken = [1, 2, 3].map(Unbroken::on);
    let next = AtomicUsize::new(0);
    let (times, failed) = (Mutex::new(Vec::new()), Mutex::new(Vec::new()));
    let work = || {
        while let Some(fault) = faults.get(next.fetch_add(1, Ordering::Relaxed)) {
            let name = format!("{fault} on {} ranks", fault.ranks);
            // The other scenes are of interest all the same.
            match catch_unwind(AssertUnwindSafe(|| {
                scene(*fault, &unbroken[fault.ranks - 1], all || fault.is_late())
            })) {
                Ok(took) => times.lock().expect("no panic here").push((took, name)),
                Err(_) => failed.lock().expect("no panic here").push(name),
            }
        }
    };
    thread::scope(|scope| {
        scope.spawn(work);
        scope.spawn(work);
    });
    let (times, failed) = (times.into_inner(), failed.into_inner().expect("no panic here"));
    let times = times.expect("no panic here");
    assert!(failed.is_empty(), "{} of {} failed: {failed:#?}", failed.len(), faults.len());
    assert_eq!(times.len(), faults.len());
    let longest = times.iter().max().expect("a scene");
    eprintln!(
        "{} scenes in {:.0} s, the longest {:.1} s: {}",
        times.len(),
        begin.elapsed().as_secs_f64(),
        longest.0.as_secs_f64(),
        longest.1
    );
}

#[test]
fn every_phase_with_kinds_of_failure_by_turns() {
    run_all(false);
}

/// Takes minutes: `cargo test --release --test messages matrix -- --ignored`.
#[test]
#[ignore = "takes minutes"]
fn every_phase_on_every_rank_with_every_kind_of_failure() {
    run_all(true);
}

/// Once is no failure: the step is cut, and the result is that of two steps.
#[test]
fn a_residual_that_is_not_a_number_once_cuts_the_step() {
    for (ranks, form) in [(1, "condensed"), (3, "condensed"), (2, "saddle_point")] {
        let folder = Folder::with(SCENE);
        let form = format!("solver.form={form}");
        let ended = run(&folder, ranks, "residual:0:nan:4", &["--set", &form]);
        assert_eq!((ended.status, ended.stderr.as_str()), (Some(0), ""), "{ended:?}");
        let cut = "  step from 0.5 to 1 failed: the residual is not a number (";
        assert_eq!(ended.stdout.matches(cut).count(), 1, "{}", ended.stdout);
        assert_eq!(contents(&folder.path("out"), "cut").len(), 8);
        assert_eq!(folder.history("time").len(), 2);
    }
}
