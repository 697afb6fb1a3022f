//! Results as a program reads them: what a run in code gives, and what is in an output directory.
//!
//! ```no_run
//! use column_hpc::results::Directory;
//!
//! let directory = Directory::open("results/wtnv146")?;
//! let history = directory.history()?;
//! println!("{:?} Pa", history.at(3.0, "joint.normal_traction")?);
//!
//! let joint = directory.series("joint")?;
//! for time in joint.times() {
//!     let fields = joint.at(time)?;
//!     let widest = fields.at_points("jump")?.rows().map(|jump| jump[2]).fold(0.0, f64::max);
//!     println!("{time} s: {widest} m");
//! }
//! # Ok::<(), column_hpc::error::Error>(())
//! ```

mod directory;
mod fields;
mod history;

pub use directory::{Directory, Series};
pub use fields::{Array, FieldGrid, Snapshot};
pub use history::History;

use serde_json::Value;

/// What a run has given that came to its end.
#[derive(Debug, Clone, PartialEq)]
pub struct Results {
    /// A row for each instant.
    pub history: History,
    /// The content of `report.json`: what was modelled, the solver, times, expectations.
    pub report: Value,
}

impl Results {
    /// Whether every expectation of the case is met.
    pub fn meets_expectations(&self) -> bool {
        self.report["status"] == "done"
    }
}
