//! What a checkpoint holds beside fields.

use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

use crate::error::{Error, Result};
use crate::output::history::Table;
use crate::output::series;
use crate::solve::{MOST_COUNTED, StepState};

/// Layout of the file; another one is refused.
pub const FORMAT: u32 = 3;

/// The case of a checkpoint is read up to this length (bytes): a case file of the largest size with
/// every default written out is shorter.
pub const LONGEST_CASE: usize = 1 << 23;

/// Everything of a run that is not a field.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunState {
    pub format: u32,
    /// The program that wrote it.
    pub program: String,
    /// The case with all defaults.
    pub case: Box<RawValue>,
    /// Names of nodes are below this.
    pub nodes: u64,
    /// Secondary nodes of all interfaces.
    pub secondary: u64,
    /// The digest of the mesh, where it is that of a file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<String>,
    /// Stages of the case before that of the state.
    #[serde(default)]
    pub stage: usize,
    /// The solution.
    pub step: StepState,
    /// Instants that were accepted.
    pub accepted: usize,
    /// Corrections and linear iterations up to the last instant.
    pub counts: [u64; 2],
    /// 2-norm of the out-of-balance forces at every instant (N).
    pub residual_norms: Vec<f64>,
    /// The rows of history.csv.
    pub history: Table,
    /// Those with field files.
    pub fields: Vec<series::Instant>,
}

/// What a checkpoint holds beside fields, of which `meta` is the text. Local.
///
/// # Errors
/// `Input` when no run can have written it.
pub fn parse(path: &Path, meta: &str) -> Result<RunState> {
    #[derive(Deserialize)]
    struct Layout {
        format: Option<u64>,
    }
    let wrong =
        |cause: String| Error::Input(format!("cannot go on from {}: {cause}", path.display()));
    let Layout { format } = serde_json::from_str(meta).map_err(|cause| wrong(cause.to_string()))?;
    if format != Some(u64::from(FORMAT)) {
        let found = format.map_or("none".into(), |f| f.to_string());
        return Err(wrong(format!("its format is {found}, this program reads {FORMAT}")));
    }
    let state: RunState = serde_json::from_str(meta).map_err(|cause| wrong(cause.to_string()))?;
    state.check().map_err(wrong)?;
    Ok(state)
}

impl RunState {
    /// What in it no run can have written, in words.
    fn check(&self) -> std::result::Result<(), String> {
        let (rows, columns) = (&self.history.rows, self.history.columns.len());
        let count = rows.len();
        // With stresses at the start there is a row of it.
        let instants = count.checked_sub(usize::from(self.step.has_begun && count > self.accepted));
        if instants != Some(self.accepted)
            || self.residual_norms.len() != self.accepted
            || rows
                .iter()
                .any(|row| row.len() != columns || row.first().is_none_or(Option::is_none))
        {
            return Err(format!("it has {count} rows for {} instants", self.accepted));
        }
        if let Some(count) = self.counts.iter().find(|count| **count > MOST_COUNTED) {
            return Err(format!("it counts {count} corrections"));
        }
        let steps: Vec<usize> = self.fields.iter().map(|instant| instant.step).collect();
        let rising = steps.windows(2).all(|pair| pair[0] < pair[1]);
        if !rising || steps.first() == Some(&0) || steps.last() > Some(&self.accepted) {
            return Err(format!("its field files are not those of {count} instants"));
        }
        let words = [&self.step.instabilities, &self.step.bifurcations].into_iter().flatten();
        if words.chain([&self.program]).any(|text| text.contains(char::is_control)) {
            return Err("it holds characters that are no text".into());
        }
        if self.case.get().len() > LONGEST_CASE {
            return Err(format!("its case has {} bytes", self.case.get().len()));
        }
        self.step.check()
    }
}
