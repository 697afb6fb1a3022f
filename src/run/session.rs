//! A run from instant to instant: solves, writes, and tells how it ended.

use std::time::Duration;

use super::checkpoint::{Keeper, Progress, RunState};
use super::fields::FieldWriter;
use super::reduced::Reduced;
use super::{history, page, probes, screen};
use crate::case::{Case, Fields};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::fault;
use crate::output::directory::OutputDirectory;
use crate::output::finite::check_row;
use crate::output::history::{History, Table};
use crate::output::publisher::Publisher;
use crate::output::series::Instant;
use crate::reduce::Reduction;
use crate::report::expectations::{Outcome, evaluate};
use crate::report::{LeftOut, LinearSolver, Model as Modelled, Partition, Ran, Report, Status};
use crate::report::{memory, tables, versions};
use crate::runtime::Runtime;
use crate::signals;
use crate::solve::{Accepted, Model};
use crate::timers::{Phase, Timers};

/// What a run carries from instant to instant.
pub struct Session<'a> {
    comm: &'a Comm,
    timers: &'a Timers,
    case: &'a Case,
    directory: OutputDirectory,
    /// Columns and earlier rows, until the history is made.
    table: Table,
    /// On rank 0.
    history: Option<History>,
    /// Corrections and linear iterations so far.
    counts: [u64; 2],
    /// 2-norm of the out-of-balance forces at every instant (N).
    residual_norms: Vec<f64>,
    /// Instants that are on disk.
    accepted: usize,
    fields: FieldWriter,
    /// Gives files their names, on rank 0.
    publisher: Publisher,
    keeper: Keeper,
    solution: Solution,
}

/// Whether the states come from a smaller model.
pub struct Solution {
    /// Why, or why not.
    pub reduction: Reduction,
    /// The smaller model, if they do.
    pub reduced: Option<Reduced>,
}

impl<'a> Session<'a> {
    /// Starts, or goes on from the state of an earlier run.
    pub fn new(
        comm: &'a Comm,
        timers: &'a Timers,
        case: &'a Case,
        directory: OutputDirectory,
        state: Option<RunState>,
        solution: Solution,
    ) -> Self {
        let fresh = Table { columns: case.columns(), rows: Vec::new() };
        let keeper = Keeper::new(case.output.checkpoint);
        let (table, counts, residual_norms, accepted, fields) = match state {
            Some(s) => (s.history, s.counts, s.residual_norms, s.accepted, s.fields),
            None => (fresh, [0; 2], Vec::new(), 0, Vec::new()),
        };
        let fields = FieldWriter::new(case, &directory, fields);
        let publisher = Publisher::default();
        let history = None;
        Self {
            comm,
            timers,
            case,
            directory,
            table,
            history,
            fields,
            publisher,
            keeper,
            counts,
            residual_norms,
            accepted,
            solution,
        }
    }

    /// Solves and writes every instant that is left. Collective.
    pub fn solve(&mut self, model: &mut Model<'_>) -> Result<()> {
        let created = if self.comm.is_root() {
            let table = std::mem::take(&mut self.table);
            History::resume(self.directory.history(), table).map(Some)
        } else {
            Ok(None)
        };
        self.history = self.comm.agree(created)?;
        let solved = self.instants(model);
        let _phase = self.timers.enter(Phase::Output);
        let stopped = matches!(solved, Err(Error::Stopped(_)));
        if stopped && !self.keeper.is_current(self.last_time(model)) {
            self.write_checkpoint(model)?;
        }
        let flushed = self.history.as_ref().map_or(Ok(()), History::flush);
        let published = self.comm.agree(self.publisher.finish().and(flushed));
        // What ended the run is told, not what came of it; a stop promises a checkpoint.
        if stopped { published.and(solved) } else { solved.and(published) }
    }

    fn instants(&mut self, model: &mut Model<'_>) -> Result<()> {
        let probes = probes::locate(self.case, &model.mesh);
        let names: Vec<String> = self.case.interfaces.iter().map(|i| i.name.clone()).collect();
        tracing::info!("{}", tables::instant_header(&names));
        let progress = screen::Progress::new(self.comm.is_root(), self.case.time.len());
        for (number, time) in self.case.time.iter().enumerate().skip(self.accepted) {
            let accepted = self.advance(model, number, *time)?;
            self.counts[0] += accepted.newton_iterations as u64;
            self.counts[1] += accepted.linear_iterations as u64;
            self.residual_norms.push(accepted.residual_norm);
            let _phase = self.timers.enter(Phase::Output);
            let mut row = match &self.solution.reduced {
                Some(reduced) => reduced.instant(number).1,
                None => history::row(self.case, model, &probes, *time, &accepted, self.comm),
            };
            fault::strike_values(self.comm, "row", row.iter_mut().flatten())?;
            self.check_row(*time, &row)?;
            let pushed = match &mut self.history {
                Some(history) => history.push(row),
                None => Ok(()),
            };
            self.comm.agree(pushed)?;
            fault::strike(self.comm, "history")?;
            if self.writes_fields(*time) {
                let instant = Instant { step: number + 1, time: *time };
                if let Some(reduced) = &self.solution.reduced {
                    reduced.show(model, number);
                }
                self.fields.write(self.comm, &mut self.publisher, self.case, model, instant)?;
            }
            self.accepted = number + 1;
            if let Some(history) = &self.history {
                let instants = tables::instants(history.table(), &names, number);
                let line = instants.last().map(|i| tables::instant_line(i, &names));
                progress.pass(&line.unwrap_or_default());
            }
            if self.keeper.is_due(self.comm) {
                self.write_checkpoint(model)?;
            } else {
                self.write_ahead(model)?;
            }
        }
        Ok(())
    }

    /// Reaches the next instant. Collective.
    fn advance(&mut self, model: &mut Model<'_>, number: usize, time: f64) -> Result<Accepted> {
        let timers = self.timers;
        let _phase = timers.enter(Phase::Solve);
        if let Some(reduced) = &self.solution.reduced {
            return match signals::stop(self.comm, Duration::ZERO) {
                Some(reason) => Err(signals::stopped(reason)),
                None => Ok(reduced.instant(number).0),
            };
        }
        loop {
            if let Some(accepted) = model.stepper.advance(time)? {
                return Ok(accepted);
            }
            let _phase = timers.enter(Phase::Output);
            self.write_ahead(model)?;
        }
    }

    /// Writes a checkpoint where the next step may be too slow for one. Collective.
    fn write_ahead(&mut self, model: &mut Model<'_>) -> Result<()> {
        let slow = model.stepper.problem.pulse.is_slow();
        if slow && self.keeper.is_worth_it(self.comm) {
            self.write_checkpoint(model)
        } else {
            Ok(())
        }
    }

    /// Time of the last accepted state (s).
    fn last_time(&self, model: &Model<'_>) -> f64 {
        match (&self.solution.reduced, self.accepted.checked_sub(1)) {
            (Some(_), Some(last)) => self.case.time[last],
            _ => model.stepper.time(),
        }
    }

    /// Refuses a row that is not finite on some rank. Collective.
    fn check_row(&self, time: f64, row: &[Option<f64>]) -> Result<()> {
        let (file, when) = (self.directory.history(), format!("at time {time}"));
        self.comm.agree(check_row(&file, &when, &self.case.columns(), row))
    }

    /// Collective.
    fn write_checkpoint(&mut self, model: &mut Model<'_>) -> Result<()> {
        if let (Some(reduced), Some(last)) = (&self.solution.reduced, self.accepted.checked_sub(1))
        {
            reduced.adopt(model, last)?;
        }
        let progress = Progress {
            accepted: self.accepted,
            counts: self.counts,
            residual_norms: &self.residual_norms,
            history: self.history.as_ref().map(History::table),
            fields: &self.fields.written,
        };
        let (directory, publisher) = (self.directory.path(), &mut self.publisher);
        self.keeper.write(self.comm, publisher, directory, self.case, model, &progress)
    }

    fn writes_fields(&self, time: f64) -> bool {
        match &self.case.output.fields {
            Fields::All => true,
            Fields::None => false,
            Fields::Times(times) => times.contains(&time),
        }
    }

    /// Compares with the expectations and writes the report, and the page if it is wanted, also
    /// when the solution failed. Collective.
    pub fn close(
        mut self,
        runtime: &Runtime,
        model: &Model<'_>,
        solved: Result<()>,
        wants_page: bool,
    ) -> Result<bool> {
        let outcomes = if solved.is_ok() { self.outcomes() } else { Ok(Vec::new()) };
        let outcomes = self.comm.agree(outcomes)?;
        let met = !self.comm.any(outcomes.iter().any(|o| !o.met));
        let status = match (&solved, met) {
            (Err(Error::Stopped(_)), _) => Status::Stopped,
            (Err(_), _) => Status::Failed,
            (Ok(()), false) => Status::ExpectationMissed,
            (Ok(()), true) => Status::Done,
        };
        let partition = partition_of(self.comm, model);
        let timings = self.timers.slowest(self.comm);
        let memory = memory::peak(self.comm);
        let cells = self.comm.sum_u64(model.mesh.cells.len() as u64);
        let names: Vec<String> = self.case.interfaces.iter().map(|i| i.name.clone()).collect();
        let unused = runtime.petsc.unused_options()?.into_iter();
        let warnings: Vec<String> =
            unused.map(|option| format!("the PETSc option {option} was not used")).collect();
        for warning in &warnings {
            tracing::warn!("warning: {warning}");
        }
        let linear_solver = linear_solver(runtime, model)?;
        fault::strike_values(self.comm, "report", &mut self.residual_norms)?;
        let report = self.history.as_ref().map(|history| Report {
            status,
            message: solved.as_ref().err().map(ToString::to_string),
            title: self.case.title.clone(),
            ranks: self.comm.size() as usize,
            model: modelled(self.case),
            reduction: self.solution.reduction.clone(),
            cells,
            unknowns: model.unknowns,
            newton_iterations: self.counts[0],
            linear_iterations: self.counts[1],
            residual_norms: self.residual_norms.clone(),
            instabilities: model.stepper.instabilities_in_words(),
            bifurcations: model.stepper.bifurcations_in_words(),
            remarks: model.stepper.remarks(),
            linear_solver: linear_solver.clone(),
            timings,
            peak_memory_bytes: memory,
            partition,
            instants: tables::instants(history.table(), &names, 0),
            expectations: outcomes,
            versions: versions(),
            case: self.case.resolved(),
        });
        let written = report.as_ref().map_or(Ok(()), |r| r.write(&self.directory.report()));
        let mut written = self.comm.agree(written);
        if wants_page && written.is_ok() {
            written = self.write_page(report.as_ref(), &warnings);
        }
        if let (Some(report), Ok(())) = (&report, &written) {
            screen::close(report, self.directory.path());
            screen::complain_of_missed(report, self.directory.path());
        }
        if let (Err(_), Err(error)) = (&solved, &written) {
            tracing::warn!("warning: {error}");
        }
        solved.map_err(|error| self.with_place(error)).and(written).map(|()| met)
    }

    /// Collective; rank 0 has a report.
    fn write_page(&self, report: Option<&Report>, warnings: &[String]) -> Result<()> {
        fault::strike(self.comm, "page")?;
        let written = match (report, &self.history) {
            (Some(report), Some(history)) => {
                let path = self.directory.page();
                page::write(&path, report, history.table(), self.case, warnings)
            }
            _ => Ok(()),
        };
        self.comm.agree(written)
    }

    /// Adds to a failure of the numerics what of the results is valid.
    fn with_place(&self, error: Error) -> Error {
        let time = &self.case.time[..self.accepted];
        let place = self.directory.path().display();
        let valid = match time.last() {
            None => "no instant was reached".to_owned(),
            Some(last) => format!("the results up to time {last} are valid, in {place}"),
        };
        match error {
            Error::Numerics(text) => Error::Numerics(format!("{text}\n{valid}")),
            Error::Stopped(text) => Error::Stopped(format!(
                "{text} after {} of {} instants; {valid}; go on with --restart latest",
                self.accepted,
                self.case.time.len()
            )),
            other => other,
        }
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

/// The linear solver that was chosen, and what ran. Local.
fn linear_solver(runtime: &Runtime, model: &Model<'_>) -> Result<LinearSolver> {
    let nothing = model.choice.options.is_empty();
    let ran = if nothing { Vec::new() } else { model.stepper.ran()? };
    let ran = ran.into_iter().map(|r| Ran {
        prefix: r.prefix,
        method: r.method,
        preconditioner: r.preconditioner,
        package: r.package,
    });
    Ok(LinearSolver {
        choice: model.choice.preset.into(),
        why: model.choice.why.clone(),
        ran: ran.collect(),
        petsc_options: runtime.petsc.user_options()?,
    })
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
