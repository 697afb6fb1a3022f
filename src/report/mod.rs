//! What a run tells: `report.json`, and the tables for the screen.

pub mod accuracy;
pub mod expectations;
pub mod memory;
pub mod tables;

use std::collections::BTreeMap;
use std::path::Path;
use std::slice::from_ref;

use serde::Serialize;

use crate::error::{Error, Result};
use crate::output::atomic;
use crate::output::finite::check_row;
use crate::reduce::Reduction;
use crate::timers::Timings;
use accuracy::Accuracy;
use expectations::Outcome;
use tables::Instant;

/// The content of `report.json`; the keys are a contract with users.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// How the run ended.
    pub status: Status,
    /// Why it ended so, when it did not end well.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub message: Option<String>,
    /// Title of the case.
    pub title: String,
    /// Number of MPI ranks.
    pub ranks: usize,
    /// What was modelled.
    pub model: Model,
    /// Whether a smaller model took its place, and the proof that it serves.
    pub reduction: Reduction,
    /// Number of bulk cells over all ranks.
    pub cells: u64,
    /// Number of unknowns over all ranks.
    pub unknowns: u64,
    /// Linearised corrections over all instants.
    pub newton_iterations: u64,
    /// Iterations of the linear solver over all corrections.
    pub linear_iterations: u64,
    /// 2-norm of the out-of-balance forces at every instant that was reached (N).
    pub residual_norms: Vec<f64>,
    /// The accepted states that are not stable, in words.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub instabilities: Vec<String>,
    /// The accepted states that are not unique, in words: which was taken, and what else there is.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bifurcations: Vec<String>,
    /// What else is to be said, in words: of the mesh and of the fit of its surfaces, of interfaces
    /// and steps.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<String>,
    /// How exact the results are, where that was asked for, and what it took.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Accuracy>,
    /// Whether interfaces softened on cells too large for it.
    #[serde(skip)]
    pub is_unresolved: bool,
    /// The linear solver.
    pub linear_solver: LinearSolver,
    /// Seconds by phase, of the slowest rank.
    pub timings: Timings,
    /// Sum over ranks of the largest resident memory; none where the system does not tell.
    pub peak_memory_bytes: Option<u64>,
    /// How the model was shared out.
    pub partition: Partition,
    /// The accepted instants.
    pub instants: Vec<Instant>,
    /// What the case expected, and what came.
    pub expectations: Vec<Outcome>,
    /// Versions of the program and of the libraries that it runs with.
    pub versions: BTreeMap<String, String>,
    /// The case with all defaults.
    pub case: serde_json::Value,
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// To the end, every expectation met.
    Done,
    /// To the end, an expectation missed.
    ExpectationMissed,
    /// To the end, not as exact as asked.
    AccuracyMissed,
    /// With an error.
    Failed,
    /// On a signal or the wall-clock limit.
    Stopped,
}

/// What was modelled.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Model {
    /// `mechanics` or `hydro_mechanics`.
    pub physics: String,
    /// Two (plane strain) or three.
    pub dimension: u8,
    /// Materials whose cells are not fully integrated, and why, in words.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub elements: Vec<String>,
    /// What of the case was left out, and why.
    pub left_out: Vec<LeftOut>,
}

/// A part of the case that was not modelled.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// Which part.
    pub what: String,
    /// Why nothing is lost.
    pub why: String,
}

/// The linear solver.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LinearSolver {
    /// Its name.
    pub choice: String,
    /// Why it was chosen.
    pub why: String,
    /// What PETSc solved with in the end, that of all unknowns first; none where nothing was
    /// solved.
    pub ran: Vec<Ran>,
    /// Options of PETSc from the command line, the case and the environment.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub petsc_options: Vec<String>,
}

/// A linear solver as PETSc has it at the end of a run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Ran {
    /// Prefix of its options.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub prefix: String,
    /// Type of the method (`-ksp_type`).
    pub method: String,
    /// Type of the preconditioner (`-pc_type`).
    pub preconditioner: String,
    /// The package that factors, or what of hypre is used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub package: Option<String>,
}

/// How the model was shared out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Partition {
    /// Bulk cells of each rank.
    pub cells: Vec<u64>,
    /// Interface nodes of each rank.
    pub interface_nodes: Vec<u64>,
    /// Ghost nodes of each rank: what it receives in one exchange.
    pub ghosts: Vec<u64>,
    /// Ranks that each rank exchanges values with.
    pub neighbours: Vec<u64>,
    /// Pairs of interface cells whose sides are on different ranks.
    pub cut_pairs: u64,
    /// Ghost nodes over all nodes, summed over ranks.
    pub ghost_share: f64,
    /// Cells of the largest mesh that any rank held before the distribution.
    pub cells_before_distribution: u64,
}

impl Report {
    /// Writes the report; complete or absent under its name.
    ///
    /// # Errors
    /// [`Error::System`] if the file cannot be written, [`Error::Numerics`] when a number of the
    /// solution is not finite, which JSON cannot say.
    ///
    /// # Parallel
    /// Local; rank 0 does it.
    pub fn write(&self, path: &Path) -> Result<()> {
        self.check(path)?;
        let text = serde_json::to_string_pretty(self)
            .map_err(|cause| Error::Bug(format!("report: {cause}")))?;
        atomic::write_text(path, &(text + "\n"))
    }

    /// Whether states were not stable or not unique, or the mesh did not resolve what softened.
    pub fn has_doubts(&self) -> bool {
        !self.instabilities.is_empty() || !self.bifurcations.is_empty() || self.is_unresolved
    }

    /// Refuses what JSON cannot say; `path` is for the message. Local.
    ///
    /// # Errors
    /// [`Error::Numerics`] when a number of the solution is not finite.
    pub fn check(&self, path: &Path) -> Result<()> {
        for (instant, norm) in self.residual_norms.iter().enumerate() {
            let when = format!("at instant {}", instant + 1);
            check_row(path, &when, &["residual_norms".into()], &[Some(*norm)])?;
        }
        for outcome in &self.expectations {
            let when = format!("at time {}", outcome.at);
            check_row(path, &when, from_ref(&outcome.quantity), &[outcome.value])?;
        }
        Ok(())
    }
}

/// Versions of the program, of PETSc (as built against), and of the running MPI and HDF5.
///
/// # Parallel
/// Local; MPI need not be initialised.
pub fn versions() -> BTreeMap<String, String> {
    let program = format!("{} ({})", env!("CARGO_PKG_VERSION"), env!("COLUMN_HPC_GIT"));
    let mpi = mpi::environment::library_version().unwrap_or_else(|_| "unknown".into());
    // Open MPI's text goes on with package and build names after the first comma.
    let mpi = mpi.split(',').next().unwrap_or_default().trim_end_matches('\0').trim().to_string();
    let (major, minor, patch) = hdf5::library_version();
    [
        ("column-hpc", program),
        ("PETSc", env!("COLUMN_HPC_PETSC_VERSION").to_string()),
        ("MPI", mpi),
        ("HDF5", format!("{major}.{minor}.{patch}")),
    ]
    .map(|(name, version)| (name.to_string(), version))
    .into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_keys_are_those_of_the_contract() {
        let report = Report {
            status: Status::ExpectationMissed,
            message: None,
            title: "column".into(),
            ranks: 2,
            model: Model {
                physics: "mechanics".into(),
                dimension: 3,
                elements: Vec::new(),
                left_out: vec![LeftOut { what: "flow".into(), why: "pressure is 0".into() }],
            },
            reduction: Reduction::none("small".into()),
            cells: 4,
            unknowns: 60,
            newton_iterations: 9,
            linear_iterations: 9,
            residual_norms: vec![],
            instabilities: Vec::new(),
            bifurcations: Vec::new(),
            remarks: Vec::new(),
            accuracy: None,
            is_unresolved: false,
            linear_solver: LinearSolver {
                choice: "mumps".into(),
                why: "small".into(),
                ran: Vec::new(),
                petsc_options: Vec::new(),
            },
            timings: Timings::default(),
            peak_memory_bytes: Some(1),
            partition: Partition {
                cells: vec![2, 2],
                ghosts: vec![0],
                neighbours: vec![0],
                interface_nodes: vec![4, 0],
                cut_pairs: 0,
                ghost_share: 0.1,
                cells_before_distribution: 4,
            },
            instants: vec![],
            expectations: vec![],
            versions: versions(),
            case: json!({"title": "column"}),
        };
        let value = serde_json::to_value(&report).unwrap();
        let mut keys: Vec<_> = value.as_object().unwrap().keys().cloned().collect();
        keys.sort();
        let expected = "case cells expectations instants linear_iterations linear_solver model \
            newton_iterations partition peak_memory_bytes ranks reduction residual_norms status timings title unknowns versions";
        assert_eq!(keys, expected.split_whitespace().collect::<Vec<_>>());
        assert_eq!(value["status"], "expectation_missed");
        let timings: Vec<_> = value["timings"].as_object().unwrap().keys().cloned().collect();
        for name in ["mesh", "partition", "assembly", "solve", "output", "total"] {
            assert!(timings.iter().any(|t| t == name), "{timings:?}");
        }
        assert!(value["versions"]["HDF5"].as_str().unwrap().starts_with(char::is_numeric));
        assert!(!value["versions"]["MPI"].as_str().unwrap().is_empty());
    }
}
