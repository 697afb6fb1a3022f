//! The program: reads a case, solves it instant by instant, writes and checks the results.

mod check;
mod checkpoint;
mod fields;
mod history;
mod page;
mod probes;
mod reduced;
mod resources;
mod screen;
mod session;
mod solution;
mod summary;

use std::cell::RefCell;
use std::path::Path;
use std::time::{Duration, Instant};

use crate::case::{Case, read_text};
use crate::cli::{Command, RunOptions};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::mesh::MeshFamily;
use crate::output::directory::OutputDirectory;
use crate::output::lock::Lock;
use crate::partition::{self, Method};
use crate::reduce::Situation;
use crate::runtime::Runtime;
use crate::solve::{self, BoundaryValueProblem, LinearChoice, MULTIGRID, Model};
use crate::study::{self, Request};
use crate::timers::{Phase, Timers};
use crate::{fault, signals};
use checkpoint::Restart;
use session::Session;
use solution::Solution;

pub use check::describe;
pub use screen::print_exit;

/// Carries out a command; returns the exit status. `check`, `schema` and `study` need no MPI.
///
/// Collective for `run`: the same on every rank.
pub fn execute(command: &Command) -> u8 {
    let answer = match command {
        Command::Schema => Ok(check::schema()),
        Command::Check(options) => check::check(&options.case, &options.overrides),
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

/// A mesh of fewer cells per rank is not worth a level, and too few for an even partition.
const COARSEST_CELLS: u64 = 64;

/// What the checkpoint and the end of a run may take of its wall-clock time (s).
const RESERVE: f64 = 2.0;

/// Starts MPI and PETSc, runs the case, and ends with one message if it fails.
fn run(options: &RunOptions) -> u8 {
    let timers = Timers::new();
    let runtime = match Runtime::start(&options.petsc_options) {
        Ok(runtime) => runtime,
        Err(error) => {
            screen::print_once(&Err(error.clone()));
            return error.exit_status();
        }
    };
    screen::start_screen(runtime.comm.is_root(), options.quiet, options.verbose);
    log_phases(&runtime, &timers);
    let result = run_case(&runtime, &timers, options);
    timers.unwatch();
    let status = match &result {
        Ok(true) => 0,
        Ok(false) => 1,
        Err(error) => error.exit_status(),
    };
    if runtime.comm.is_root()
        && let Err(error) = &result
    {
        screen::complain(error);
    }
    drop(result);
    runtime.exit(status)
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
///
/// # Errors
/// What is wrong with the input, the numerics or the machine; the same on all ranks.
pub fn run_case(runtime: &Runtime, timers: &Timers, options: &RunOptions) -> Result<bool> {
    let comm = &runtime.comm;
    let started = Instant::now();
    let case = read_case(comm, &options.case, &options.overrides)?;
    if let Some(seconds) = case.wall {
        signals::stop_at(started + Duration::from_secs_f64((seconds - RESERVE).max(0.0)));
    }
    runtime.petsc.insert_options(&case.solver.petsc_options)?;
    let directory = options.output.as_deref().unwrap_or(&case.output.directory);
    let resolved = case.resolved();
    let resolved = resolved.to_string();
    let _lock = Lock::take(comm, directory)?;
    let restart = match &options.restart {
        Some(word) => Some(Restart::open(comm, word, directory, &case)?),
        None => {
            OutputDirectory::examine(comm, directory, &resolved, options.overwrite)?;
            None
        }
    };

    let (mut model, solution) = build(runtime, timers, &case, directory, restart.is_some())?;
    let state = restart.map(|restart| restart.resume(comm, &case, &mut model)).transpose()?;
    let directory = match &state {
        Some(state) => {
            let last = state.fields.last().map_or(0, |instant| instant.step);
            OutputDirectory::resume(comm, directory, &resolved, last)?
        }
        None => OutputDirectory::open(comm, directory, &resolved, options.overwrite)?,
    };
    screen::describe(comm, &case, &model, solution.reduction());
    let unresolved = solution.unresolved_zones(&case, &model);
    unresolved.iter().for_each(|words| tracing::warn!("warning: {words}"));
    model.stepper.remarks.extend(unresolved);
    let mut session = Session::new(comm, timers, &case, directory, state, solution);
    let solved = session.solve(&mut model);
    session.close(runtime, &model, solved, options.report)
}

/// The case as every rank sees it; rank 0 reads the file. Collective.
fn read_case(comm: &Comm, path: &Path, overrides: &[String]) -> Result<Case> {
    let text = comm.on_root(|| read_text(path).map(String::into_bytes))?;
    fault::strike(comm, "case")?;
    comm.agree(Case::read(&String::from_utf8_lossy(&text), path, overrides))
}

/// The model that was asked for, and where its states come from. Collective.
fn build<'a>(
    runtime: &'a Runtime,
    timers: &'a Timers,
    case: &'a Case,
    directory: &Path,
    goes_on: bool,
) -> Result<(Model<'a>, Solution)> {
    let comm = &runtime.comm;
    let mut family = {
        let _phase = timers.enter(Phase::Mesh);
        comm.agree(MeshFamily::new(case))?
    };
    fault::strike(comm, "mesh")?;
    let facts = family.facts();
    let mut choice = LinearChoice::new(case, &facts);
    let fewest = COARSEST_CELLS * comm.size() as u64;
    if choice.preset == MULTIGRID && !family.coarsen(fewest) {
        choice = choice.without_levels();
    }
    resources::check(comm, case, &facts, &choice, directory)?;
    let (cells, before) = {
        let _phase = timers.enter(Phase::Partition);
        partition::distribute(comm, &family, Method::from_environment())?
    };
    let mut meshes = {
        let _phase = timers.enter(Phase::Mesh);
        family.share(cells, before)
    };
    fault::strike(comm, "distribute")?;
    let phase = timers.enter(Phase::Assembly);
    let finest = meshes.pop().ok_or_else(|| Error::Bug("no mesh".into()))?;
    let problem = BoundaryValueProblem::new(comm, case, finest)?;
    drop(phase);
    let has_options = runtime.petsc.has_options();
    let unknowns = problem.all.nodes.total * case.dim as u64;
    let situation = Situation { unknowns, goes_on, has_options };
    let solution = Solution::choose(runtime, timers, case, &problem, situation)?;
    let _phase = timers.enter(Phase::Assembly);
    let choice = solution.linear_choice(choice);
    let model = solve::build(runtime, timers, case, choice, problem, meshes)?;
    Ok((model, solution))
}
