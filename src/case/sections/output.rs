//! What is written, and what the results are compared with.

use std::path::PathBuf;

use crate::case::checks::Every;

/// Where results go, and at which instants fields are written.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputSpec {
    /// The output directory.
    pub directory: PathBuf,
    /// The instants of the field files.
    pub fields: Fields,
    /// How often a checkpoint is written.
    pub checkpoint: Every,
}

/// The instants at which field files are written.
#[derive(Debug, Clone, PartialEq)]
pub enum Fields {
    /// Every instant.
    All,
    /// Never.
    None,
    /// These instants, rising.
    Times(Vec<f64>),
}

/// A named point whose displacement is recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// Its name, the prefix of its columns in `history.csv`.
    pub name: String,
    /// Its place in m; y is 0 in 2D.
    pub at: [f64; 3],
}

/// A value that the results must have.
#[derive(Debug, Clone, PartialEq)]
pub struct Expectation {
    /// A column of `history.csv`, or one without its `.min`, `.max`.
    pub quantity: String,
    /// The instant.
    pub at: f64,
    /// The expected value.
    pub equals: f64,
    /// Allowed error over |equals|.
    pub relative: f64,
    /// Allowed error.
    pub absolute: f64,
}
