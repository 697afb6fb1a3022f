//! Runs cases and reads what they leave.

use crate::case::Case;
use column_hpc::output::history::Table;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

pub const PROGRAM: &str = env!("CARGO_BIN_EXE_column-hpc");

/// The largest scenes take a few seconds beside other work.
const LIMIT: Duration = Duration::from_secs(100);

/// How a case is run.
#[derive(Clone)]
pub struct Setting {
    pub ranks: usize,
    /// Values that replace those of the case.
    pub sets: Vec<String>,
    pub fields: bool,
    /// It stops after that many instants, and goes on by `--restart`.
    pub stop: Option<usize>,
}

impl Setting {
    pub const PLAIN: Self = Self { ranks: 1, sets: Vec::new(), fields: false, stop: None };

    pub fn with(set: &str) -> Self {
        Self { sets: vec![set.into()], ..Self::PLAIN }
    }

    /// The words before and after the case on a command line.
    fn words(&self, case: &Case) -> Vec<Vec<String>> {
        let mut sets = self.sets.clone();
        if !self.fields {
            sets.push("output.fields=none".into());
        }
        let Some(stop) = self.stop else { return vec![words_of(&sets)] };
        let first: Vec<String> = case.instants[..stop].iter().map(|t| format!("{t:e}")).collect();
        let mut cut = sets.clone();
        cut.push(format!("time.instants=[{}]", first.join(", ")));
        cut.push("output.checkpoint={every: 1 instants}".into());
        let mut rest = words_of(&sets);
        rest.extend(["--restart".into(), "latest".into()]);
        vec![words_of(&cut), rest]
    }

    /// The command lines, for whoever looks at it again.
    pub fn commands(&self, case: &Case, file: &str) -> Vec<String> {
        let launcher = match self.ranks {
            1 => String::new(),
            n => format!("mpirun -n {n} "),
        };
        let quoted = |word: &String| match word.contains(['[', '{', ' ']) {
            true => format!("'{word}'"),
            false => word.clone(),
        };
        let line = |words: &Vec<String>| {
            let words: Vec<String> = words.iter().map(quoted).collect();
            format!("{launcher}column-hpc {file} {}", words.join(" "))
        };
        self.words(case).iter().map(line).collect()
    }
}

fn words_of(sets: &[String]) -> Vec<String> {
    sets.iter().flat_map(|set| ["--set".into(), set.clone()]).collect()
}

/// What became of a run.
pub enum Outcome {
    Done(Box<Run>),
    /// Status, none for one that hung or was killed; last words.
    Ended(Option<i32>, String),
}

pub struct Run {
    pub table: Table,
    /// Steps that were halved.
    pub cuts: Vec<String>,
    /// It told of states that are not stable or not unique.
    pub doubtful: bool,
    /// Why the model asked for was not replaced, if it was not.
    pub not_reduced: Option<String>,
    /// Removed with it.
    pub place: Place,
}

/// A directory of its own.
pub struct Place(pub PathBuf);

impl Place {
    pub fn fresh() -> Self {
        static NEXT: AtomicUsize = AtomicUsize::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let memory = Path::new("/dev/shm");
        let root = if memory.is_dir() { memory.into() } else { std::env::temp_dir() };
        let path = root.join(format!("column-hpc-scenes-{}-{number}", std::process::id()));
        fs::create_dir_all(&path).expect("a place for temporary files");
        Self(path)
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

pub fn run(case: &Case, setting: &Setting) -> Outcome {
    let place = Place::fresh();
    let file = place.0.join("case.yaml");
    fs::write(&file, case.yaml()).expect("the place is writable");
    let output = place.0.join("results");
    let mut cuts = Vec::new();
    for words in setting.words(case) {
        let mut args = vec![file.to_string_lossy().into_owned()];
        args.extend(["--output".into(), output.to_string_lossy().into_owned()]);
        args.extend(words);
        match launch(setting.ranks, &args, &place.0) {
            (Some(0), _) => {
                let screen = fs::read_to_string(place.0.join("stdout")).unwrap_or_default();
                let halved = screen.lines().filter(|line| line.ends_with("halved"));
                cuts.extend(halved.map(|l| l.split(" failed").next().unwrap_or(l).to_owned()));
            }
            (status, words) => return Outcome::Ended(status, words),
        }
    }
    let table = Table::read(&output.join("history.csv")).expect("a complete history");
    let report = fs::read_to_string(output.join("report.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&report).expect("valid JSON");
    let told = |list: &str| report[list].as_array().is_some_and(|l| !l.is_empty());
    let doubtful = told("instabilities") || told("bifurcations");
    let reduction = &report["reduction"];
    let why = || reduction["why"].as_str().unwrap_or_default().to_owned();
    let not_reduced = (reduction["applied"] != true).then(why);
    Outcome::Done(Box::new(Run { table, cuts, doubtful, not_reduced, place }))
}

/// Status and last words of a run; a run on one rank needs no launcher.
fn launch(ranks: usize, args: &[String], place: &Path) -> (Option<i32>, String) {
    let mut command = match ranks {
        1 => Command::new(PROGRAM),
        _ => {
            let mut command = Command::new("mpirun");
            command.args(["-n", &ranks.to_string(), "--quiet", PROGRAM]);
            command
        }
    };
    let said = place.join("stderr");
    let errors = fs::File::create(&said).expect("the place is writable");
    let screen = fs::File::create(place.join("stdout")).expect("the place is writable");
    let _cores = crate::common::Cores::wait(ranks);
    let mut child = command
        .args(args)
        .envs(crate::common::environment())
        .stdin(Stdio::null())
        .stdout(screen)
        .stderr(errors)
        .spawn()
        .expect("mpirun is on the PATH (Debian: openmpi-bin)");
    let end = Instant::now() + LIMIT;
    let status = loop {
        if let Some(status) = child.try_wait().expect("a child of ours") {
            break status.code();
        }
        if Instant::now() > end {
            // mpirun hands it on to its ranks.
            let _ = Command::new("kill").args(["-TERM", &child.id().to_string()]).status();
            thread::sleep(Duration::from_secs(4));
            let _ = child.kill();
            let _ = child.wait();
            return (None, format!("no end within {} s", LIMIT.as_secs()));
        }
        thread::sleep(Duration::from_millis(5));
    };
    let text = fs::read_to_string(&said).unwrap_or_default();
    let mut errors = text.lines().filter(|l| l.starts_with("error"));
    let mut error = errors.next().unwrap_or(text.trim()).to_owned();
    if let Some(more) = errors.find(|l| l.contains("rounding alone leaves")) {
        error = format!("{error}; {more}");
    }
    (status, error.replace(&format!("{}/", place.display()), ""))
}
