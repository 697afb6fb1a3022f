//! A run from instant to instant: solves, writes, and tells how it ended.

mod close;

use super::checkpoint::{Keeper, Progress};
use super::fields::FieldWriter;
use super::probes::LocatedProbe;
use super::run_state::RunState;
use super::same_model::with_columns;
use super::solution::Solution;
use super::{history, probes, screen};
use crate::case::{Case, Fields};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::fault;
use crate::output::directory::{HISTORY, OutputDirectory};
use crate::output::finite::check_row;
use crate::output::history::{History, Table};
use crate::output::publisher::Publisher;
use crate::output::series::Instant;
use crate::report::{Report, tables};
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
    table: Option<Table>,
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
            Some(s) => (rows(s.history, case), s.counts, s.residual_norms, s.accepted, s.fields),
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
            table: Some(table),
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

    /// Solves and writes the instants that are left of the first `end` ones; the last of them
    /// leaves a checkpoint. Collective.
    pub fn solve(&mut self, model: &mut Model<'_>, end: usize) -> Result<()> {
        self.open()?;
        let solved = self.instants(model, end);
        let _phase = self.timers.enter(Phase::Output);
        let stopped = matches!(solved, Err(Error::Stopped(_)));
        let last = self.solution.last_time(self.case, model, self.accepted);
        if (stopped || solved.is_ok()) && !self.keeper.is_current(last) {
            self.write_checkpoint(model)?;
        }
        if solved.is_ok() && end < self.case.time.len() {
            return Ok(());
        }
        let published = self.finish();
        // What ended the run is told, not what came of it; a stop promises a checkpoint.
        if stopped { published.and(solved) } else { solved.and(published) }
    }

    /// Makes the history, once. Collective.
    fn open(&mut self) -> Result<()> {
        let Some(table) = self.table.take() else { return Ok(()) };
        let created = match &self.directory {
            _ if !self.comm.is_root() => Ok(None),
            Some(directory) => History::resume(directory.history(), table).map(Some),
            None => Ok(Some(History::in_memory(table))),
        };
        self.history = self.comm.agree(created)?;
        Ok(())
    }

    /// Brings all that was written to the disk. Collective.
    fn finish(&mut self) -> Result<()> {
        let flushed = self.history.as_ref().map_or(Ok(()), History::flush);
        self.comm.agree(self.publisher.finish().and(flushed))
    }

    /// Goes on with the model of the next stage, whose states come from `solution`. Local.
    pub fn enter(&mut self, solution: Solution) {
        let folder = self.directory.as_ref().map(OutputDirectory::fields).unwrap_or_default();
        let written = std::mem::take(&mut self.fields.written);
        self.fields = FieldWriter::new(self.case, &folder, written);
        self.solution = solution;
    }

    /// Ends between two stages, where `error` keeps the next one from beginning: that error, with
    /// what of the results is valid. Collective.
    pub fn leave(mut self, error: Error) -> Error {
        if let Err(cause) = self.finish() {
            tracing::warn!("warning: {cause}");
        }
        self.with_place(error)
    }

    fn instants(&mut self, model: &mut Model<'_>, end: usize) -> Result<()> {
        let probes = probes::locate(self.comm, self.case, &model.mesh)?;
        let names: Vec<String> = self.case.interfaces.iter().map(|i| i.name.clone()).collect();
        tracing::info!("{}", tables::instant_header(&names));
        self.begin(model, &probes, &names)?;
        let progress = screen::Progress::new(self.comm.is_root(), self.case.time.len());
        for (number, time) in self.case.time.iter().enumerate().take(end).skip(self.accepted) {
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
}

/// The rows of an earlier run under the columns of the case.
fn rows(history: Table, case: &Case) -> Table {
    if history.rows.is_empty() {
        return Table { columns: case.columns(), rows: Vec::new() };
    }
    with_columns(&history, case).unwrap_or(history)
}
