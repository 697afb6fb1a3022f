//! Runs from code.

use std::path::{Path, PathBuf};
use std::time::Instant;

use super::carry_out::Output;
use super::whole::whole;
use crate::case::Case;
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::hash::mix;
use crate::results::Results;
use crate::runtime::Runtime;
use crate::timers::Timers;

/// A run of a case from code, as the command `column-hpc` does it; any number of them, one after
/// the other, within one process. Its results stay in memory unless it is given an output
/// directory. Nothing is printed: a subscriber of `tracing` gets what the program would say.
///
/// ```no_run
/// # use column_hpc::{case::Case, error::Result, run::Run, runtime::Runtime};
/// # fn run(runtime: &Runtime, case: &Case) -> Result<()> {
/// let in_memory = Run::of(case).start(runtime)?;
/// let on_disk = Run::of(case).output("results/mine").overwrite().start(runtime)?;
/// assert_eq!(in_memory.history.times(), on_disk.history.times());
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
#[must_use = "a run does nothing before it is started"]
pub struct Run<'a> {
    case: &'a Case,
    directory: Option<PathBuf>,
    overwrite: bool,
    restart: Option<String>,
    page: bool,
}

impl<'a> Run<'a> {
    /// A run in memory: no fields, no checkpoints, no file of any kind; `output` of the case does
    /// not count.
    pub fn of(case: &'a Case) -> Self {
        Self { case, directory: None, overwrite: false, restart: None, page: false }
    }

    /// Writes into a directory what the command `column-hpc` writes: history, report, and the
    /// fields and checkpoints that the case asks for. Results of the same case that are there are
    /// replaced; those of another case are refused. The directory of rank 0 counts.
    pub fn output(mut self, directory: impl AsRef<Path>) -> Self {
        self.directory = Some(directory.as_ref().to_path_buf());
        self
    }

    /// Replaces the results of another case in the output directory.
    pub fn overwrite(mut self) -> Self {
        self.overwrite = true;
        self
    }

    /// Goes on from a checkpoint: a file, or the `latest` one of the output directory. Needs an
    /// output directory.
    pub fn restart(mut self, checkpoint: impl Into<String>) -> Self {
        self.restart = Some(checkpoint.into());
        self
    }

    /// Writes a page with charts, `report.html`, into the output directory too.
    pub fn report(mut self) -> Self {
        self.page = true;
        self
    }

    /// Runs the case to its end; the results are the same on all ranks. Collective, with the same
    /// case on all ranks.
    ///
    /// A run that misses an expectation of its case has come to its end: ask
    /// [`Results::meets_expectations`]. What a run that fails has reached is in its output
    /// directory, if it has one.
    ///
    /// # Errors
    /// [`Error::Input`] when the case does not fit the machine or the directory, or is not the same
    /// on all ranks; [`Error::Numerics`] when it is not solved; [`Error::Stopped`] on a signal or
    /// the limit of the case; [`Error::System`] when a file or a library fails. The same on all
    /// ranks.
    pub fn start(&self, runtime: &Runtime) -> Result<Results> {
        let (comm, started) = (&runtime.comm, Instant::now());
        check_agreement(comm, self.case)?;
        let directory = directory_of_root(comm, self.directory.as_deref());
        if directory.is_none() && (self.restart.is_some() || self.page) {
            let what = "a restart and a page need an output directory";
            return Err(Error::Input(what.to_owned()));
        }
        let output = directory.as_deref().map(|directory| Output {
            directory,
            overwrite: self.overwrite,
            restart: self.restart.as_deref(),
            page: self.page,
        });
        let ended = whole(runtime, &Timers::new(), self.case, started, output)?;
        let bug = |cause: serde_json::Error| Error::Bug(format!("results: {cause}"));
        let text = comm.on_root(|| match &ended.told {
            Some(told) => serde_json::to_vec(told).map_err(bug),
            None => Err(Error::Bug("a run without a report".into())),
        })?;
        let (report, history) = comm.agree(serde_json::from_slice(&text).map_err(bug))?;
        Ok(Results { history, report })
    }
}

/// Refuses cases that differ between ranks, which would wait for each other. Collective.
fn check_agreement(comm: &Comm, case: &Case) -> Result<()> {
    let text = case.resolved().to_string();
    let sum = text.bytes().fold(0, |sum, byte| mix(sum ^ u64::from(byte)));
    let (most, least) = (comm.max_u64(sum), !comm.max_u64(!sum));
    if most == least {
        return Ok(());
    }
    Err(Error::Input("the case is not the same on all ranks".to_owned()))
}

/// The directory that rank 0 has been given, on all ranks. Collective.
fn directory_of_root(comm: &Comm, directory: Option<&Path>) -> Option<PathBuf> {
    use std::os::unix::ffi::{OsStrExt, OsStringExt};
    let bytes = directory.map_or(Vec::new(), |path| path.as_os_str().as_bytes().to_vec());
    let bytes = comm.broadcast_bytes(bytes);
    (!bytes.is_empty()).then(|| PathBuf::from(std::ffi::OsString::from_vec(bytes)))
}
