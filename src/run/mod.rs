//! The program: reads a case, solves it instant by instant, writes and checks the results.
//!
//! From code a case is run by [`Run`], within [`program`].

mod accuracy;
mod carry_out;
mod check;
mod checkpoint;
mod fields;
mod from_code;
mod history;
mod interface_values;
mod page;
mod probes;
mod reduced;
mod resources;
mod run_state;
mod same_model;
mod screen;
mod session;
mod solution;
mod summary;
mod whole;
mod zones;

use std::cell::RefCell;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use crate::case::{Case, read_text};
use crate::cli::{Command, RunOptions};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::fault;
use crate::runtime::Runtime;
use crate::scene::plot;
use crate::study::{self, Request};
use crate::timers::Timers;
use carry_out::Output;
use whole::whole;

pub use check::describe;
pub use from_code::Run;
pub use screen::{complain, print_exit};

/// Carries out a command; returns the exit status. All but `run` need no MPI.
///
/// Collective for `run`: the same on every rank.
pub fn execute(command: &Command) -> u8 {
    let answer = match command {
        Command::Schema => Ok(check::schema()),
        Command::Check(options) => check::check(&options.case, &options.overrides),
        Command::Plot(request) => plot::plot(request)
            .map(|[drawing, image]| format!("{}\n{}", drawing.display(), image.display())),
        Command::Run(options) => return run(options),
        Command::Study(request) => return study(request),
    };
    screen::print_once(&answer);
    answer.map_or_else(|error| error.exit_status(), |_| 0)
}

/// Carries out a study, which starts no MPI itself.
fn study(request: &Request) -> u8 {
    let result = if screen::is_rank() {
        let text = "a study launches its runs itself: start it without mpirun or srun";
        Err(Error::Input(text.to_owned()))
    } else {
        screen::start_screen(true, false, false);
        study::run(request)
    };
    match result {
        Ok(()) => 0,
        Err(error) => {
            let status = error.exit_status();
            screen::print_once(&Err(error));
            status
        }
    }
}

/// Starts MPI and PETSc, runs the case, and ends with one message if it fails.
fn run(options: &RunOptions) -> u8 {
    let timers = Timers::new();
    start(&options.petsc_options, |runtime| {
        log_phases(runtime, &timers);
        let result = run_case(runtime, &timers, options);
        timers.unwatch();
        result.map(|met| if met { 0 } else { 1 })
    })
}

/// The whole of a program that runs cases, under a launcher of MPI or alone: starts MPI and PETSc,
/// does `work` on every rank, and ends the process. An error is told once, on standard error, and
/// the process ends with its exit status ([`Error::exit_status`]), else with 0. Collective, once in
/// a process.
///
/// ```no_run
/// use column_hpc::run::{self, Run};
/// # fn case() -> column_hpc::error::Result<column_hpc::case::Case> { unimplemented!() }
///
/// fn main() -> std::process::ExitCode {
///     run::program(|runtime| {
///         let results = Run::of(&case()?).start(runtime)?;
///         if runtime.comm.is_root() {
///             println!("{:?}", results.history.column("joint.normal_traction")?);
///         }
///         Ok(())
///     })
/// }
/// ```
pub fn program(work: impl FnOnce(&Runtime) -> Result<()>) -> ExitCode {
    start(&[], |runtime| runtime.comm.agree_alike(work(runtime)).map(|()| 0)).into()
}

/// Starts MPI and PETSc, does `work`, tells its error, and ends the process with its status;
/// returns where they do not start.
fn start(petsc_options: &[String], work: impl FnOnce(&Runtime) -> Result<u8>) -> u8 {
    let runtime = match Runtime::start(petsc_options) {
        Ok(runtime) => runtime,
        Err(error) => {
            screen::print_once(&Err(error.clone()));
            return error.exit_status();
        }
    };
    let result = work(&runtime);
    if runtime.comm.is_root()
        && let Err(error) = &result
    {
        screen::complain(error);
    }
    runtime.exit(result.unwrap_or_else(|error| error.exit_status()))
}

/// Gives the stages of PETSc's log (`-log_view`) the names of the phases.
fn log_phases(runtime: &Runtime, timers: &Timers) {
    let (petsc, stage) = (runtime.petsc.clone(), RefCell::new(None));
    timers.watch(move |phase| {
        // The stage before ends first. A log that PETSc refuses is no reason to stop.
        stage.borrow_mut().take();
        *stage.borrow_mut() = phase.and_then(|phase| petsc.stage(phase.name()).ok());
    });
}

/// Everything between the start and the end of MPI. True when every expectation is met. Collective.
/// How much is said is for the first run of a process to choose.
///
/// # Errors
/// What is wrong with the input, the numerics or the machine; the same on all ranks.
pub fn run_case(runtime: &Runtime, timers: &Timers, options: &RunOptions) -> Result<bool> {
    let comm = &runtime.comm;
    screen::start_screen(comm.is_root(), options.quiet, options.verbose);
    let started = Instant::now();
    let case = read_case(comm, &options.case, &options.overrides)?;
    let directory = options.output.as_deref().unwrap_or(&case.output.directory);
    let output = Output {
        directory,
        overwrite: options.overwrite,
        restart: options.restart.as_deref(),
        page: options.report,
    };
    let ended = whole(runtime, timers, &case, started, Some(output))?;
    if let Some((report, _)) = &ended.told {
        screen::complain_of_missed(report, directory);
    }
    Ok(ended.met)
}

/// The case as every rank sees it; rank 0 reads the file. Collective.
fn read_case(comm: &Comm, path: &Path, overrides: &[String]) -> Result<Case> {
    let text = comm.on_root(|| read_text(path).map(String::into_bytes))?;
    fault::strike(comm, "case")?;
    comm.agree(Case::read(&String::from_utf8_lossy(&text), path, overrides))
}
