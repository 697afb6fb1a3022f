//! Writes the page of a run beside its report.

use std::path::Path;

use crate::case::Case;
use crate::error::{Error, Result};
use crate::output::atomic;
use crate::output::history::Table;
use crate::page::{Run, page};
use crate::report::Report;
use crate::results::Directory;

/// Draws and writes the page; complete or absent under its name. Local; rank 0 does it.
///
/// # Errors
/// `System` if the file cannot be written, `Bug` if a chart cannot be drawn.
pub fn write(
    path: &Path,
    report: &Report,
    history: &Table,
    case: &Case,
    warnings: &[String],
) -> Result<()> {
    let report =
        serde_json::to_value(report).map_err(|cause| Error::Bug(format!("page: {cause}")))?;
    let directory = path.parent().and_then(|parent| Directory::open(parent).ok());
    let directory = directory.as_ref();
    let run = Run { report: &report, history, case, directory, warnings };
    atomic::write_text(path, &page(&run)?)
}
