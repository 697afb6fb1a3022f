//! The end of a run: expectations, the report and the page.

use std::path::Path;

use super::{Ended, Session};
use crate::error::{Error, Result};
use crate::fault;
use crate::output::directory::{OutputDirectory, REPORT};
use crate::output::history::History;
use crate::report::expectations::{Outcome, evaluate};
use crate::report::{Report, Status, tables, versions};
use crate::run::summary::{Measured, linear_solver, modelled, unused_options};
use crate::run::{page, screen, zones};
use crate::runtime::Runtime;
use crate::solve::Model;

impl Session<'_> {
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
        let unresolved = self.unresolved(model);
        for words in &unresolved {
            tracing::warn!("warning: {words}");
        }
        let message = solved.as_ref().err().map(ToString::to_string);
        let ending = Ending { status: status(&solved, met), message, outcomes, unresolved };
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
            is_unresolved: !ending.unresolved.is_empty(),
            accuracy: None,
            remarks: [stepper.remarks(), ending.unresolved].concat(),
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

    /// The interfaces that have softened unevenly on cells too large for it, in words. Collective.
    fn unresolved(&self, model: &Model<'_>) -> Vec<String> {
        if !self.solution.is_asked() {
            return Vec::new();
        }
        let history = self.history.as_ref().map(History::table);
        zones::unresolved(self.comm, self.case, model, history)
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
    /// The cohesive zones that were not resolved, in words.
    unresolved: Vec<String>,
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
