//! The program: reads a case, solves it instant by instant, writes and checks the results.

mod check;
mod fields;
mod history;
mod probes;
mod screen;

use std::cell::RefCell;
use std::path::Path;

use crate::case::{Case, Fields, read_text};
use crate::cli::{Command, RunOptions};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::fault;
use crate::mesh::{Column, LocalMesh};
use crate::output::directory::OutputDirectory;
use crate::output::history::History;
use crate::partition::{self, Method};
use crate::report::expectations::{Outcome, evaluate};
use crate::report::{LeftOut, LinearSolver, Model as Modelled, Partition, Report, Status};
use crate::report::{memory, tables, versions};
use crate::runtime::Runtime;
use crate::solve::{self, LinearChoice, MULTIGRID, Model};
use crate::timers::{Phase, Timers};
use fields::FieldWriter;

pub use screen::print_exit;

/// Carries out a command; returns the exit status. `check` and `schema` need no MPI.
///
/// Collective for `run`: the same on every rank.
pub fn execute(command: &Command) -> u8 {
    let answer = match command {
        Command::Schema => Ok(check::schema()),
        Command::Check(options) => check::check(&options.case, &options.overrides),
        Command::Run(options) => return run(options),
    };
    screen::print_once(&answer);
    answer.map_or_else(|error| error.exit_status(), |_| 0)
}

/// A lattice of fewer cells per rank is not worth a level, and too few for an even partition.
const COARSEST_CELLS: u64 = 64;

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

/// Everything between the start and the end of MPI. True when every expectation is met.
fn run_case(runtime: &Runtime, timers: &Timers, options: &RunOptions) -> Result<bool> {
    let comm = &runtime.comm;
    let case = read_case(comm, &options.case, &options.overrides)?;
    runtime.petsc.insert_options(&case.solver.petsc_options)?;
    let directory = options.output.as_deref().unwrap_or(&case.output.directory);
    let resolved = case.resolved();
    let resolved = resolved.to_string();
    OutputDirectory::examine(comm, directory, &resolved, options.overwrite)?;

    let mut model = build(runtime, timers, &case)?;
    let directory = OutputDirectory::open(comm, directory, &resolved, options.overwrite)?;
    screen::describe(comm, &case, &model);
    let mut session = Session {
        comm,
        timers,
        case: &case,
        directory,
        history: None,
        counts: [0; 2],
        residual_norms: Vec::new(),
        accepted: 0,
    };
    let solved = session.solve(&mut model);
    session.close(runtime, &model, solved)
}

/// The case as every rank sees it; rank 0 reads the file. Collective.
fn read_case(comm: &Comm, path: &Path, overrides: &[String]) -> Result<Case> {
    let text = comm.on_root(|| read_text(path).map(String::into_bytes))?;
    comm.agree(Case::read(&String::from_utf8_lossy(&text), path, overrides))
}

fn build<'a>(runtime: &'a Runtime, timers: &'a Timers, case: &'a Case) -> Result<Model<'a>> {
    let comm = &runtime.comm;
    let column = {
        let _phase = timers.enter(Phase::Mesh);
        comm.agree(Column::new(case))?
    };
    let mut choice = LinearChoice::new(case, &column);
    let mut columns = vec![column.described(), column];
    if choice.preset == MULTIGRID {
        let levels = columns[1].hierarchy(COARSEST_CELLS * comm.size() as u64);
        if levels.len() > 1 {
            columns = levels;
        } else {
            choice = choice.without_levels();
        }
    }
    let (cells, before) = {
        let _phase = timers.enter(Phase::Partition);
        partition::distribute(comm, &columns[0], Method::from_environment())?
    };
    let meshes = {
        let _phase = timers.enter(Phase::Mesh);
        let mut meshes = vec![LocalMesh::new(&columns[0], cells, before)];
        for column in &columns[1..] {
            meshes.push(meshes[meshes.len() - 1].refined(column));
        }
        meshes
    };
    fault::strike(comm, "distribute")?;
    let _phase = timers.enter(Phase::Assembly);
    solve::build(runtime, timers, case, choice, meshes)
}

/// What a run carries from instant to instant.
struct Session<'a> {
    comm: &'a Comm,
    timers: &'a Timers,
    case: &'a Case,
    directory: OutputDirectory,
    /// On rank 0.
    history: Option<History>,
    /// Corrections and linear iterations so far.
    counts: [u64; 2],
    /// 2-norm of the out-of-balance forces at every instant (N).
    residual_norms: Vec<f64>,
    /// Instants that are on disk.
    accepted: usize,
}

impl Session<'_> {
    /// Solves and writes every instant. Collective.
    fn solve(&mut self, model: &mut Model<'_>) -> Result<()> {
        let created = if self.comm.is_root() {
            History::create(self.directory.history(), self.case.columns()).map(Some)
        } else {
            Ok(None)
        };
        self.history = self.comm.agree(created)?;
        let mut fields = FieldWriter::new(self.case, &self.directory);
        let probes = probes::locate(self.case, &model.mesh);
        let names: Vec<String> = self.case.interfaces.iter().map(|i| i.name.clone()).collect();
        tracing::info!("{}", tables::instant_header(&names));
        let progress = screen::Progress::new(self.comm.is_root(), self.case.time.len());
        for (number, time) in self.case.time.iter().enumerate() {
            let accepted = {
                let _phase = self.timers.enter(Phase::Solve);
                model.stepper.advance(*time)?
            };
            self.counts[0] += accepted.newton_iterations as u64;
            self.counts[1] += accepted.linear_iterations as u64;
            self.residual_norms.push(accepted.residual_norm);
            let _phase = self.timers.enter(Phase::Output);
            let row = history::row(self.case, model, &probes, *time, &accepted, self.comm);
            let pushed = match &mut self.history {
                Some(history) => history.push(row),
                None => Ok(()),
            };
            self.comm.agree(pushed)?;
            fault::strike(self.comm, "history")?;
            if self.writes_fields(*time) {
                fields.write(self.comm, self.case, model, number + 1, *time)?;
            }
            self.accepted = number + 1;
            if let Some(history) = &self.history {
                let instants = tables::instants(history.table(), &names);
                let line = instants.last().map(|i| tables::instant_line(i, &names));
                progress.pass(&line.unwrap_or_default());
            }
        }
        let _phase = self.timers.enter(Phase::Output);
        fields.finish(self.comm)
    }

    fn writes_fields(&self, time: f64) -> bool {
        match &self.case.output.fields {
            Fields::All => true,
            Fields::None => false,
            Fields::Times(times) => times.contains(&time),
        }
    }

    /// Compares with the expectations and writes the report, also when the solution failed.
    /// Collective.
    fn close(self, runtime: &Runtime, model: &Model<'_>, solved: Result<()>) -> Result<bool> {
        let outcomes = if solved.is_ok() { self.outcomes() } else { Ok(Vec::new()) };
        let outcomes = self.comm.agree(outcomes)?;
        let met = !self.comm.any(outcomes.iter().any(|o| !o.met));
        let status = match (&solved, met) {
            (Err(_), _) => Status::Failed,
            (Ok(()), false) => Status::ExpectationMissed,
            (Ok(()), true) => Status::Done,
        };
        let partition = partition_of(self.comm, model);
        let timings = self.timers.slowest(self.comm);
        let memory = memory::peak(self.comm);
        let cells = self.comm.sum_u64(model.mesh.cells.len() as u64);
        let names: Vec<String> = self.case.interfaces.iter().map(|i| i.name.clone()).collect();
        for option in runtime.petsc.unused_options()? {
            tracing::warn!("warning: the PETSc option {option} was not used");
        }
        let mut written = Ok(());
        if let Some(history) = &self.history {
            let report = Report {
                status,
                message: solved.as_ref().err().map(ToString::to_string),
                title: self.case.title.clone(),
                ranks: self.comm.size() as usize,
                model: modelled(self.case),
                cells,
                unknowns: model.unknowns,
                newton_iterations: self.counts[0],
                linear_iterations: self.counts[1],
                residual_norms: self.residual_norms.clone(),
                instabilities: {
                    let found = model.stepper.instabilities.iter();
                    found.map(|instability| instability.words(self.case)).collect()
                },
                bifurcations: {
                    let found = model.stepper.bifurcations.iter();
                    found.map(|bifurcation| bifurcation.words(self.case)).collect()
                },
                linear_solver: LinearSolver {
                    choice: model.choice.preset.into(),
                    why: model.choice.why.clone(),
                },
                timings,
                peak_memory_bytes: memory,
                partition,
                instants: tables::instants(history.table(), &names),
                expectations: outcomes,
                versions: versions(),
                case: self.case.resolved(),
            };
            written = report.write(&self.directory.report());
            screen::close(&report, self.directory.path());
            screen::complain_of_missed(&report, self.directory.path());
        }
        self.comm.agree(written)?;
        solved.map(|()| met).map_err(|error| self.with_place(error))
    }

    /// Adds to a failure of the numerics what of the results is valid.
    fn with_place(&self, error: Error) -> Error {
        let Error::Numerics(text) = error else { return error };
        let time = &self.case.time[..self.accepted];
        let place = self.directory.path().display();
        Error::Numerics(match time.last() {
            None => format!("{text}\nno instant was reached"),
            Some(last) => format!("{text}\nthe results up to time {last} are valid, in {place}"),
        })
    }

    /// The verdict on every expectation, on rank 0. Local.
    fn outcomes(&self) -> Result<Vec<Outcome>> {
        let Some(history) = &self.history else { return Ok(Vec::new()) };
        let expect = self.case.expect.iter();
        expect
            .map(|e| evaluate(history.table(), &e.quantity, e.at, e.equals, e.relative, e.absolute))
            .collect()
    }
}

fn modelled(case: &Case) -> Modelled {
    Modelled {
        physics: case.physics.name().into(),
        dimension: case.dim as u8,
        elements: case.formulations(),
        left_out: case
            .left_out
            .iter()
            .map(|sentence| {
                let (what, why) = sentence.split_once(": ").unwrap_or((sentence, ""));
                LeftOut { what: what.into(), why: why.into() }
            })
            .collect(),
    }
}

/// How cells and interface nodes are shared out. Collective.
fn partition_of(comm: &Comm, model: &Model<'_>) -> Partition {
    let (mesh, all) = (&model.mesh, &model.stepper.problem.all);
    let column = &mesh.column;
    let mut cut = 0;
    for cell in &mesh.cells {
        let place = column.cell_place(*cell);
        for side in model.sides.iter().filter(|s| s.cell_is_secondary(column, place)) {
            let facing = side.facing_cells(column, place);
            let elsewhere = |c: &&u64| mesh.cells.binary_search(c).is_err();
            cut += facing.iter().filter(elsewhere).count() as u64;
        }
    }
    let gather = |n: usize| -> Vec<u64> {
        comm.gather(&[n as u64]).map_or_else(Vec::new, |lists| lists.concat())
    };
    let held = all.nodes.len() - all.nodes.owned;
    let ghosts = comm.sum_u64(held as u64);
    Partition {
        cells: gather(mesh.cells.len()),
        interface_nodes: gather(all.owned_secondary()),
        ghosts: gather(held),
        neighbours: gather(all.nodes.neighbours()),
        cut_pairs: comm.sum_u64(cut),
        ghost_share: ghosts as f64 / all.nodes.total as f64,
        cells_before_distribution: mesh.coarse_cells,
    }
}
