//! A run from instant to instant: solves, writes, and tells how it ended.

use std::path::Path;

use super::checkpoint::{Keeper, Progress};
use super::fields::FieldWriter;
use super::probes::LocatedProbe;
use super::run_state::RunState;
use super::solution::Solution;
use super::summary::{Measured, linear_solver, modelled, unused_options};
use super::{history, page, probes, screen};
use crate::case::{Case, Fields};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::fault;
use crate::output::directory::{HISTORY, OutputDirectory, REPORT};
use crate::output::finite::check_row;
use crate::output::history::{History, Table};
use crate::output::publisher::Publisher;
use crate::output::series::Instant;
use crate::report::expectations::{Outcome, evaluate};
use crate::report::{Report, Status, tables, versions};
use crate::runtime::Runtime;
use crate::solve::{Accepted, Model};
use crate::timers::{Phase, Timers};

/// What a run carries from instant to instant.
pub struct Session<'a> {
    comm: &'a Comm,
    timers: &'a Timers,
    case: &'a Case,
    /// None where the results stay in memory.
    directory: Option<OutputDirectory>,
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

/// How a run has ended that came to its end.
pub struct Ended {
    /// Whether every expectation is met.
    pub met: bool,
    /// On rank 0.
    pub told: Option<(Report, Table)>,
}

impl<'a> Session<'a> {
    /// Starts, or goes on from the state of an earlier run.
    pub fn new(
        comm: &'a Comm,
        timers: &'a Timers,
        case: &'a Case,
        directory: Option<OutputDirectory>,
        state: Option<RunState>,
        solution: Solution,
    ) -> Self {
        let fresh = Table { columns: case.columns(), rows: Vec::new() };
        let keeper = Keeper::new(case.output.checkpoint);
        let (table, counts, residual_norms, accepted, fields) = match state {
            Some(s) => (s.history, s.counts, s.residual_norms, s.accepted, s.fields),
            None => (fresh, [0; 2], Vec::new(), 0, Vec::new()),
        };
        let folder = directory.as_ref().map(OutputDirectory::fields).unwrap_or_default();
        let fields = FieldWriter::new(case, &folder, fields);
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
            match &self.directory {
                Some(directory) => History::resume(directory.history(), table).map(Some),
                None => Ok(Some(History::in_memory(table))),
            }
        } else {
            Ok(None)
        };
        self.history = self.comm.agree(created)?;
        let solved = self.instants(model);
        let _phase = self.timers.enter(Phase::Output);
        let stopped = matches!(solved, Err(Error::Stopped(_)));
        let last = self.solution.last_time(self.case, model, self.accepted);
        if stopped && !self.keeper.is_current(last) {
            self.write_checkpoint(model)?;
        }
        let flushed = self.history.as_ref().map_or(Ok(()), History::flush);
        let published = self.comm.agree(self.publisher.finish().and(flushed));
        // What ended the run is told, not what came of it; a stop promises a checkpoint.
        if stopped { published.and(solved) } else { solved.and(published) }
    }

    fn instants(&mut self, model: &mut Model<'_>) -> Result<()> {
        let probes = probes::locate(self.comm, self.case, &model.mesh)?;
        let names: Vec<String> = self.case.interfaces.iter().map(|i| i.name.clone()).collect();
        tracing::info!("{}", tables::instant_header(&names));
        self.begin(model, &probes, &names)?;
        let progress = screen::Progress::new(self.comm.is_root(), self.case.time.len());
        for (number, time) in self.case.time.iter().enumerate().skip(self.accepted) {
            let accepted = self.advance(model, number)?;
            self.counts[0] += accepted.newton_iterations as u64;
            self.counts[1] += accepted.linear_iterations as u64;
            self.residual_norms.push(accepted.residual_norm);
            let _phase = self.timers.enter(Phase::Output);
            let (comm, case) = (self.comm, self.case);
            let row = self.solution.row(comm, case, model, &probes, number, &accepted);
            self.push(*time, row)?;
            fault::strike(self.comm, "history")?;
            if self.writes_fields(*time) {
                let instant = Instant { step: number + 1, time: *time };
                self.solution.show(model, number);
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

    /// Adds the row of a state that is finite. Collective.
    fn push(&mut self, time: f64, mut row: Vec<Option<f64>>) -> Result<()> {
        fault::strike_values(self.comm, "row", row.iter_mut().flatten())?;
        self.check_row(time, &row)?;
        let pushed = match &mut self.history {
            Some(history) => history.push(row),
            None => Ok(()),
        };
        self.comm.agree(pushed)
    }

    /// Finds the state at the start where stresses are there before, and adds its row. Collective.
    fn begin(
        &mut self,
        model: &mut Model<'_>,
        probes: &[LocatedProbe],
        names: &[String],
    ) -> Result<()> {
        let timers = self.timers;
        let begun = {
            let _phase = timers.enter(Phase::Solve);
            model.stepper.begin()?
        };
        let Some(accepted) = begun else { return Ok(()) };
        self.counts[0] += accepted.newton_iterations as u64;
        self.counts[1] += accepted.linear_iterations as u64;
        let _phase = timers.enter(Phase::Output);
        let (comm, case) = (self.comm, self.case);
        let row = history::row(case, model, probes, case.start, &accepted, comm);
        self.push(case.start, row)?;
        let instants = self.history.iter().flat_map(|h| tables::instants(h.table(), names, 0));
        instants.for_each(|instant| tracing::info!("{}", tables::instant_line(&instant, names)));
        Ok(())
    }

    /// Reaches the next instant. Collective.
    fn advance(&mut self, model: &mut Model<'_>, number: usize) -> Result<Accepted> {
        let timers = self.timers;
        let _phase = timers.enter(Phase::Solve);
        loop {
            if let Some(accepted) = self.solution.advance(self.comm, self.case, model, number)? {
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

    /// Refuses a row that is not finite on some rank. Collective.
    fn check_row(&self, time: f64, row: &[Option<f64>]) -> Result<()> {
        let file = self.directory.as_ref().map_or(HISTORY.into(), OutputDirectory::history);
        let when = format!("at time {time}");
        self.comm.agree(check_row(&file, &when, &self.case.columns(), row))
    }

    /// Collective.
    fn write_checkpoint(&mut self, model: &mut Model<'_>) -> Result<()> {
        let Some(directory) = &self.directory else { return Ok(()) };
        self.solution.adopt(model, self.accepted)?;
        let progress = Progress {
            accepted: self.accepted,
            counts: self.counts,
            residual_norms: &self.residual_norms,
            history: self.history.as_ref().map(History::table),
            fields: &self.fields.written,
        };
        let (directory, publisher) = (directory.path(), &mut self.publisher);
        self.keeper.write(self.comm, publisher, directory, self.case, model, &progress)
    }

    fn writes_fields(&self, time: f64) -> bool {
        self.directory.is_some()
            && match &self.case.output.fields {
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
    ) -> Result<Ended> {
        let outcomes = if solved.is_ok() { self.outcomes() } else { Ok(Vec::new()) };
        let outcomes = self.comm.agree(outcomes)?;
        let met = !self.comm.any(outcomes.iter().any(|o| !o.met));
        let measured = Measured::of(self.comm, self.timers, model);
        let warnings = unused_options(runtime)?;
        for warning in &warnings {
            tracing::warn!("warning: {warning}");
        }
        let message = solved.as_ref().err().map(ToString::to_string);
        let ending = Ending { status: status(&solved, met), message, outcomes };
        let report = self.report(runtime, model, ending, measured)?;
        let written = self.write(report.as_ref(), wants_page.then_some(&warnings[..]));
        if let (Some(report), Ok(())) = (&report, &written) {
            screen::close(report, self.directory.as_ref().map(OutputDirectory::path));
        }
        if let (Err(_), Err(error)) = (&solved, &written) {
            tracing::warn!("warning: {error}");
        }
        solved.map_err(|error| self.with_place(error)).and(written)?;
        Ok(Ended { met, told: report.zip(self.history.map(History::into_table)) })
    }

    /// The report, on rank 0. Collective.
    fn report(
        &mut self,
        runtime: &Runtime,
        model: &Model<'_>,
        ending: Ending,
        measured: Measured,
    ) -> Result<Option<Report>> {
        let linear_solver = linear_solver(runtime, model)?;
        fault::strike_values(self.comm, "report", &mut self.residual_norms)?;
        let Some(history) = &self.history else { return Ok(None) };
        let stepper = &model.stepper;
        let names: Vec<String> = self.case.interfaces.iter().map(|i| i.name.clone()).collect();
        Ok(Some(Report {
            status: ending.status,
            message: ending.message,
            title: self.case.title.clone(),
            ranks: self.comm.size() as usize,
            model: modelled(self.case),
            reduction: self.solution.reduction().clone(),
            cells: measured.cells,
            unknowns: model.unknowns,
            newton_iterations: self.counts[0],
            linear_iterations: self.counts[1],
            residual_norms: self.residual_norms.clone(),
            instabilities: stepper.instabilities_in_words(),
            bifurcations: stepper.bifurcations_in_words(),
            remarks: stepper.remarks(),
            linear_solver,
            timings: measured.timings,
            peak_memory_bytes: measured.memory,
            partition: measured.partition,
            instants: tables::instants(history.table(), &names, 0),
            expectations: ending.outcomes,
            versions: versions(),
            case: self.case.resolved(),
        }))
    }

    /// Writes the report and, with the `warnings` that it is to hold, the page. Collective; rank 0
    /// has a report.
    fn write(&self, report: Option<&Report>, warnings: Option<&[String]>) -> Result<()> {
        let written = match (report, &self.directory) {
            (Some(report), Some(directory)) => report.write(&directory.report()),
            (Some(report), None) => report.check(Path::new(REPORT)),
            (None, _) => Ok(()),
        };
        self.comm.agree(written)?;
        warnings.map_or(Ok(()), |warnings| self.write_page(report, warnings))
    }

    /// Collective; rank 0 has a report.
    fn write_page(&self, report: Option<&Report>, warnings: &[String]) -> Result<()> {
        fault::strike(self.comm, "page")?;
        let written = match (report, &self.history, &self.directory) {
            (Some(report), Some(history), Some(directory)) => {
                let path = directory.page();
                page::write(&path, report, history.table(), self.case, warnings)
            }
            _ => Ok(()),
        };
        self.comm.agree(written)
    }

    /// Adds to a failure of the numerics what of the results is valid.
    fn with_place(&self, error: Error) -> Error {
        let Some(directory) = &self.directory else { return error };
        let time = &self.case.time[..self.accepted];
        let place = directory.path().display();
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

/// How a run ended.
struct Ending {
    status: Status,
    /// Why, when it did not end well.
    message: Option<String>,
    outcomes: Vec<Outcome>,
}

/// The status of a run in which all expectations were `met` or not.
fn status(solved: &Result<()>, met: bool) -> Status {
    match (solved, met) {
        (Err(Error::Stopped(_)), _) => Status::Stopped,
        (Err(_), _) => Status::Failed,
        (Ok(()), false) => Status::ExpectationMissed,
        (Ok(()), true) => Status::Done,
    }
}
