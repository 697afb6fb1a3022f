//! Runs cases under `mpirun` and reads their results.

use crate::common::mpirun_within;
use crate::{faults, served};
use column_hpc::output::history::Table;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// The program.
pub const PROGRAM: &str = env!("CARGO_BIN_EXE_column-hpc");

/// A launch alone takes seconds; beside other work on the machine it may wait for a core.
const LIMIT: Duration = Duration::from_secs(120);

/// The linear solvers that are compared.
pub const SOLVERS: [&str; 5] = ["mumps", "gamg", "hypre", "multigrid", "aggregation"];

/// A case and what of it is changed.
#[derive(Clone)]
pub struct Scene {
    case: PathBuf,
    sets: Vec<String>,
    scattered: bool,
    may_cut: bool,
    fields: bool,
    /// `reduce` of the case: the model asked for is what is tested, unless a test says otherwise.
    reduce: &'static str,
}

/// What a run left behind.
pub struct Run {
    /// Scene and ranks, for messages.
    pub label: String,
    pub directory: PathBuf,
    pub table: Table,
    pub report: serde_json::Value,
    pub screen: String,
}

/// What a run that did not end well left behind.
pub struct Failure {
    pub status: Option<i32>,
    pub complaint: String,
}

/// A directory for one file or one run, of this process alone. What the environment names in the
/// place of the build directory may be memory: runs write to disk what must not be lost, and wait.
pub fn fresh() -> PathBuf {
    static NEXT: AtomicUsize = AtomicUsize::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    let root = std::env::var_os("COLUMN_HPC_TEST_SCRATCH")
        .unwrap_or_else(|| env!("CARGO_TARGET_TMPDIR").into());
    let path = Path::new(&root).join(format!("acceptance-{}-{number}", std::process::id()));
    fs::create_dir_all(&path).expect("the build directory is writable");
    path
}

impl Scene {
    /// A case of `cases/`.
    pub fn shipped(name: &str) -> Self {
        Self::of(Path::new(env!("CARGO_MANIFEST_DIR")).join("cases").join(name))
    }

    /// A case of its own.
    pub fn new(name: &str, yaml: &str) -> Self {
        let case = fresh().join(format!("{name}.yaml"));
        fs::write(&case, yaml).expect("the build directory is writable");
        Self::of(case)
    }

    fn of(case: PathBuf) -> Self {
        let (scattered, may_cut, fields) = (false, false, false);
        Self { case, sets: Vec::new(), scattered, may_cut, fields, reduce: "never" }
    }

    /// The same with a value of the case replaced.
    pub fn set(&self, assignment: &str) -> Self {
        let mut scene = self.clone();
        scene.sets.push(assignment.into());
        scene
    }

    /// The same with every cell on a rank of its own choice.
    pub fn scattered(&self) -> Self {
        Self { scattered: true, ..self.clone() }
    }

    /// The same, whose instants need not be reached in one step.
    pub fn in_any_steps(&self) -> Self {
        Self { may_cut: true, ..self.clone() }
    }

    /// The same, which leaves field files behind.
    pub fn with_fields(&self) -> Self {
        Self { fields: true, ..self.clone() }
    }

    /// The same, for which a smaller model may serve.
    pub fn reduced(&self) -> Self {
        Self { reduce: "auto", ..self.clone() }
    }

    /// Starts the scene with a fault (or none, if empty), its results in `directory`.
    pub fn launch(&self, ranks: usize, directory: &Path, fault: &str, more: &[&str]) -> Output {
        let program = if fault.is_empty() { PROGRAM } else { faults::PROGRAM };
        let mut args: Vec<String> = vec![format!("{}={fault}", faults::VARIABLE), program.into()];
        args.extend(self.words(directory));
        args.extend(more.iter().map(|word| (*word).to_owned()));
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        mpirun_within(LIMIT, ranks, "env", &args)
    }

    /// The words of the command line, for results in `directory`.
    pub fn words(&self, directory: &Path) -> Vec<String> {
        let mut words = vec![self.case.to_string_lossy().into_owned()];
        words.extend(["--output".into(), directory.to_string_lossy().into_owned()]);
        words.extend(["--set".into(), format!("reduce={}", self.reduce)]);
        words.extend(self.sets.iter().flat_map(|s| ["--set".to_string(), s.clone()]));
        words
    }

    /// Stopped by `fault` on some ranks (status 75), it goes on to its end on others.
    pub fn stopped(&self, from: usize, fault: &str, to: usize) -> Run {
        let (directory, label) = (fresh(), format!("{fault}, {from} to {to} ranks"));
        for (ranks, fault, word, status) in
            [(from, fault, vec!["--overwrite"], 75), (to, "", vec!["--restart", "latest"], 0)]
        {
            let output = self.launch(ranks, &directory, fault, &word);
            let words = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(status), "{label}: {words}");
        }
        Self::left_in(&directory, label)
    }

    /// What a run left in a directory.
    pub fn left_in(directory: &Path, label: String) -> Run {
        let table = Table::read(&directory.join("history.csv")).expect("a complete history");
        let report = fs::read_to_string(directory.join("report.json")).expect("a report");
        let report = serde_json::from_str(&report).expect("valid JSON");
        Run { label, directory: directory.into(), table, report, screen: String::new() }
    }

    /// Runs the scene; it has to end well, every instant in one step unless more are allowed.
    pub fn on(&self, ranks: usize) -> Run {
        let run = match self.attempt(ranks) {
            Ok(run) => run,
            Err(failure) => panic!("status {:?}: {}", failure.status, failure.complaint),
        };
        let cut = run.screen.contains("halved");
        assert!(self.may_cut || !cut, "{}: a step was cut\n{}", run.label, run.screen);
        run
    }

    /// Runs the scene, which may fail.
    pub fn attempt(&self, ranks: usize) -> Result<Run, Failure> {
        let directory = fresh();
        let name = self.case.file_stem().map(|s| s.to_string_lossy()).unwrap_or_default();
        let folder = self.case.parent().and_then(Path::file_name).unwrap_or_default();
        let label = format!(
            "{}/{name} {} on {ranks} ranks{}",
            folder.display(),
            self.sets.join(" "),
            if self.scattered { ", scattered" } else { "" }
        );
        let fields = if self.fields { "all" } else { "none" };
        let mut args = vec![format!("--set=output.fields={fields}")];
        args.extend(["--verbose".into(), "--overwrite".into()]);
        args.extend(self.words(&directory));
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        let output = served::run(ranks, self.scattered, &args, LIMIT);
        let screen = String::from_utf8_lossy(&output.stdout).into_owned();
        if output.status.code() != Some(0) {
            let complaint = String::from_utf8_lossy(&output.stderr);
            let complaint = format!("{label}\n{screen}\n{complaint}");
            return Err(Failure { status: output.status.code(), complaint });
        }
        let table = Table::read(&directory.join("history.csv")).expect("a complete history");
        let report = fs::read_to_string(directory.join("report.json")).expect("a report");
        let report = serde_json::from_str(&report).expect("valid JSON");
        Ok(Run { label, directory, table, report, screen })
    }
}

impl Run {
    /// The values of a column, one per instant.
    pub fn column(&self, name: &str) -> Vec<f64> {
        let index = self.table.column(name).unwrap_or_else(|| panic!("no column {name}"));
        let value =
            |row: &Vec<Option<f64>>| row[index].unwrap_or_else(|| panic!("{name} is empty"));
        self.table.rows.iter().map(value).collect()
    }

    /// The sentences of a list of the report.
    pub fn told(&self, list: &str) -> Vec<String> {
        let list = self.report[list].as_array();
        let text = |value: &serde_json::Value| value.as_str().expect("a sentence").to_owned();
        list.map_or_else(Vec::new, |list| list.iter().map(text).collect())
    }

    /// Corrections of every instant.
    pub fn corrections(&self) -> Vec<f64> {
        self.column("newton_iterations")
    }

    /// A column has these values, each within `absolute + relative |value|`; a quantity of an
    /// interface with both its least and its largest value.
    pub fn assert_column(&self, name: &str, values: &[f64], relative: f64, absolute: f64) {
        let whole = self.table.column(name).is_some();
        let names = if whole {
            vec![name.to_string()]
        } else {
            vec![format!("{name}.min"), format!("{name}.max"), format!("{name}.mean")]
        };
        for name in names {
            let computed = self.column(&name);
            assert_eq!(computed.len(), values.len(), "{}: {name}", self.label);
            for (row, (value, exact)) in computed.iter().zip(values).enumerate() {
                assert!(
                    (value - exact).abs() <= absolute + relative * exact.abs(),
                    "{}: {name} in row {row} is {value:e}, exact {exact:e}, error {:e}",
                    self.label,
                    value - exact
                );
            }
        }
    }

    /// Elastic and dissipated energy add up to the external work at every instant.
    pub fn assert_energy_balance(&self, relative: f64) {
        let [elastic, dissipated, external] =
            ["elastic", "dissipated", "external"].map(|n| self.column(&format!("energy.{n}")));
        let scale = external.iter().fold(0.0_f64, |m, e| m.max(e.abs()));
        assert!(scale > 0.0, "{}: nothing did work", self.label);
        for row in 0..external.len() {
            let held = elastic[row] + dissipated[row];
            // Where everything is back at zero there is nothing to be relative to.
            let allowed = relative * held.abs() + 1e-12 * scale;
            assert!(
                (external[row] - held).abs() <= allowed,
                "{}: in row {row} the external work is {:e}, {:e} elastic + {:e} dissipated",
                self.label,
                external[row],
                elastic[row],
                dissipated[row]
            );
        }
    }

    /// The same history as `other`, every value within `tolerance` of the largest of its kind;
    /// `scale` gives the factor from the units of `self` to those of `other`.
    pub fn assert_same_in_units(&self, other: &Run, tolerance: f64, scale: fn(Kind) -> f64) {
        assert_eq!(self.table.columns, other.table.columns, "{}", other.label);
        assert_eq!(self.table.rows.len(), other.table.rows.len(), "{}", other.label);
        for (index, name) in self.table.columns.iter().enumerate() {
            let Some(kind) = Kind::of(name) else { continue };
            let largest = self.largest(kind);
            for (row, (mine, others)) in self.table.rows.iter().zip(&other.table.rows).enumerate() {
                let (Some(mine), Some(others)) = (mine[index], others[index]) else {
                    assert_eq!(mine[index], others[index], "{}: {name}", other.label);
                    continue;
                };
                let error = (others / scale(kind) - mine).abs();
                assert!(
                    error <= tolerance * largest,
                    "{name} in row {row}: {mine:e} ({}), {others:e} ({}): {error:e} of {largest:e}",
                    self.label,
                    other.label
                );
            }
        }
    }

    /// As [`Self::assert_same_in_units`], in the same units.
    pub fn assert_same(&self, other: &Run, tolerance: f64) {
        self.assert_same_in_units(other, tolerance, |_| 1.0);
    }

    /// The largest difference of any value, relative to the largest of its kind.
    pub fn difference(&self, other: &Run) -> f64 {
        self.difference_above(other, |_| f64::MIN_POSITIVE)
    }

    /// The same, where a kind that is all rounding has the scale that `least` gives.
    pub fn difference_above(&self, other: &Run, least: impl Fn(Kind) -> f64) -> f64 {
        let mut worst = 0.0_f64;
        for (index, name) in self.table.columns.iter().enumerate() {
            let Some(kind) = Kind::of(name) else { continue };
            let largest = self.largest(kind).max(least(kind));
            for (mine, others) in self.table.rows.iter().zip(&other.table.rows) {
                if let (Some(mine), Some(others)) = (mine[index], others[index]) {
                    worst = worst.max((others - mine).abs() / largest);
                }
            }
        }
        worst
    }

    /// The largest value of a kind.
    pub fn largest(&self, kind: Kind) -> f64 {
        let columns = self.table.columns.iter().enumerate().filter(|c| Kind::of(c.1) == Some(kind));
        let values = columns.flat_map(|(i, _)| self.table.rows.iter().filter_map(move |r| r[i]));
        values.fold(0.0, |largest, v| largest.max(v.abs()))
    }
}

/// What a column holds: values of a kind are comparable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Traction,
    Pressure,
    Flux,
    Mass,
    Length,
    Angle,
    Damage,
    Reaction,
    Moment,
    Area,
    Energy,
    Time,
}

impl Kind {
    /// None for counts of iterations.
    fn of(column: &str) -> Option<Self> {
        let kinds = [
            ("traction", Self::Traction),
            ("pressure", Self::Pressure),
            ("flux", Self::Flux),
            ("mass", Self::Mass),
            ("jump", Self::Length),
            ("sliding", Self::Length),
            ("slip", Self::Length),
            ("displacement", Self::Length),
            ("rotation", Self::Angle),
            ("damage", Self::Damage),
            ("reaction", Self::Reaction),
            ("force", Self::Reaction),
            ("moment", Self::Moment),
            ("area", Self::Area),
            ("energy", Self::Energy),
            ("time", Self::Time),
            ("load_factor", Self::Time),
        ];
        let kind = kinds.iter().find(|(word, _)| column.contains(word)).map(|k| k.1);
        assert_eq!(kind.is_none(), column.ends_with("_iterations"), "{column}");
        kind
    }
}
