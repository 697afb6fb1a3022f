//! What the user sees: rank 0 speaks, once.

use std::io::{IsTerminal, Write};
use std::path::Path;

use indicatif::{ProgressBar, ProgressStyle};
use tracing::level_filters::LevelFilter;
use tracing_subscriber::fmt::format::Writer;
use tracing_subscriber::fmt::{FmtContext, FormatEvent, FormatFields};
use tracing_subscriber::registry::LookupSpan;

use crate::case::Case;
use crate::cli::Exit;
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::reduce::Reduction;
use crate::report::{Report, Status, tables};
use crate::solve::Model;

/// Environment variables by which launchers tell a process its rank.
const RANK_VARIABLES: [&str; 4] = ["OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID"];

/// Sends the program's messages to stdout, on rank 0 only: all but the lines of Newton's
/// iterations, which `verbose` adds; none with `quiet`.
pub fn start_screen(root: bool, quiet: bool, verbose: bool) {
    let level = match (root && !quiet, verbose) {
        (false, _) => LevelFilter::OFF,
        (true, false) => LevelFilter::INFO,
        (true, true) => LevelFilter::DEBUG,
    };
    let subscriber = tracing_subscriber::fmt()
        .with_max_level(level)
        .event_format(PlainLines)
        .with_writer(std::io::stdout)
        .finish();
    // A second start in one process keeps the first, which does no harm.
    let _ = tracing::subscriber::set_global_default(subscriber);
}

/// The message alone: no time, no level.
struct PlainLines;

impl<S, N> FormatEvent<S, N> for PlainLines
where
    S: tracing::Subscriber + for<'a> LookupSpan<'a>,
    N: for<'a> FormatFields<'a> + 'static,
{
    fn format_event(
        &self,
        context: &FmtContext<'_, S, N>,
        mut writer: Writer<'_>,
        event: &tracing::Event<'_>,
    ) -> std::fmt::Result {
        context.field_format().format_fields(writer.by_ref(), event)?;
        writeln!(writer)
    }
}

/// Whether this process speaks for its launch: rank 0, or no launcher.
fn speaks() -> bool {
    let rank = RANK_VARIABLES.iter().find_map(|name| std::env::var(name).ok());
    rank.is_none_or(|rank| rank == "0")
}

/// Whether this process is a rank; a batch script of SLURM, which has a number too, is none.
pub fn is_rank() -> bool {
    RANK_VARIABLES[..3].iter().any(|name| std::env::var_os(name).is_some())
}

/// Prints an answer or a complaint once per launch, without MPI.
pub fn print_once(answer: &Result<String>) {
    match answer {
        Ok(text) => print_exit(&Exit { text: text.clone(), status: 0, to_stdout: true }),
        Err(error) if speaks() => complain(error),
        Err(_) => wait_for_the_speaker(),
    }
}

/// Launchers end the other ranks when one fails, and one that has not spoken yet never would: the
/// silent ones leave it the first word. It ends them with its own failure, long before the time is
/// up.
fn wait_for_the_speaker() {
    std::thread::sleep(std::time::Duration::from_secs(5));
}

/// Prints help, version, or what is wrong with the command line, once per launch.
pub fn print_exit(exit: &Exit) {
    if speaks() {
        let text = format!("{}\n", exit.text.trim_end());
        // A closed pipe is the reader's choice.
        drop(match exit.to_stdout {
            true => std::io::stdout().write_all(text.as_bytes()),
            false => std::io::stderr().write_all(text.as_bytes()),
        });
    } else if exit.status != 0 {
        wait_for_the_speaker();
    }
}

/// One message on stderr, in one write.
pub fn complain(error: &Error) {
    // To stop when asked is no error.
    let word = if matches!(error, Error::Stopped(_)) { "" } else { "error: " };
    let text: String = error.to_string().lines().map(|line| format!("{word}{line}\n")).collect();
    drop(std::io::stderr().write_all(text.as_bytes()));
}

/// One message on stderr when expectations were missed.
pub fn complain_of_missed(report: &Report, directory: &Path) {
    if report.status != Status::ExpectationMissed {
        return;
    }
    let mut missed = report.expectations.iter().filter(|outcome| !outcome.met);
    let Some(first) = missed.next() else { return };
    let (quantity, at) = (&first.quantity, first.at);
    let (equals, tolerance) = (first.equals, first.tolerance);
    let found = match (&first.note, first.value) {
        (Some(note), _) => note.clone(),
        (None, value) => format!("it is {:e}", value.unwrap_or(f64::NAN)),
    };
    let text = format!(
        "error: {} of {} expectations missed; the first: {quantity} at {at} should be {equals:e} \
         within {tolerance:e}, but {found}; all of them are in {}\n",
        1 + missed.count(),
        report.expectations.len(),
        directory.join("report.json").display()
    );
    drop(std::io::stderr().write_all(text.as_bytes()));
}

/// Says what is modelled and how it is solved. Collective.
pub fn describe(comm: &Comm, case: &Case, model: &Model<'_>, reduction: &Reduction) {
    let cells = comm.sum_u64(model.mesh.cells.len() as u64);
    let ranks = comm.size();
    let s = |n: i32| if n == 1 { "" } else { "s" };
    tracing::info!("{}", case.title);
    tracing::info!("model      {}, {}D", case.physics.name(), case.dim);
    for sentence in &case.left_out {
        tracing::info!("left out   {sentence}");
    }
    tracing::info!(
        "mesh       {cells} cells{}, {} unknowns, {ranks} rank{}",
        case.mesh.order_words(),
        model.unknowns,
        s(ranks)
    );
    for sentence in case.formulations() {
        tracing::info!("elements   {sentence}");
    }
    for (interface, side) in case.interfaces.iter().zip(&model.sides) {
        let secondary = side.secondary.name();
        tracing::info!(
            "interface  {} {}: {}{}, multipliers on the {secondary} side",
            interface.name,
            interface.place(),
            interface.law.name(),
            interface.start_words()
        );
    }
    tracing::info!("reduced    {}", reduction.words());
    tracing::info!("linear     {}: {}", model.choice.preset, model.choice.why);
    tracing::info!("");
}

/// The closing tables, and where the results are if they were written.
pub fn close(report: &Report, directory: Option<&Path>) {
    tracing::info!("");
    if !report.expectations.is_empty() {
        tracing::info!("{}", tables::expectations(&report.expectations));
    }
    tracing::info!("{}", tables::times(&report.timings));
    if let Some(bytes) = report.peak_memory_bytes {
        tracing::info!("peak memory of all ranks: {:.1} MB", bytes as f64 / 1e6);
    }
    let met = report.expectations.iter().filter(|o| o.met).count();
    match report.status {
        Status::Done if met == 1 => tracing::info!("the one expectation met"),
        Status::Done if met > 0 => tracing::info!("all {met} expectations met"),
        Status::ExpectationMissed => tracing::info!(
            "{} of {} expectations missed",
            report.expectations.len() - met,
            report.expectations.len()
        ),
        _ => {}
    }
    if let Some(directory) = directory {
        tracing::info!("results in {}", directory.display());
    }
}

/// A bar on a terminal that is not under a launcher, if something is to be said at all; lines of
/// instants everywhere.
pub struct Progress(Option<ProgressBar>);

impl Progress {
    /// For `instants` instants.
    pub fn new(root: bool, instants: usize) -> Self {
        let launched = RANK_VARIABLES.iter().any(|name| std::env::var_os(name).is_some());
        let terminal = std::io::stderr().is_terminal() && std::io::stdout().is_terminal();
        let speaks = LevelFilter::current() >= LevelFilter::INFO;
        let bar = (root && terminal && !launched && speaks).then(|| {
            let style = ProgressStyle::with_template("{bar:30} {pos}/{len} instants, {elapsed}");
            ProgressBar::new(instants as u64)
                .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        });
        Self(bar)
    }

    /// Another instant is done.
    pub fn pass(&self, line: &str) {
        match &self.0 {
            Some(bar) => bar.suspend(|| tracing::info!("{line}")),
            None => tracing::info!("{line}"),
        }
        if let Some(bar) = &self.0 {
            bar.inc(1);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}
