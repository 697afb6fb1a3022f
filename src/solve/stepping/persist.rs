//! What is done about linear solves that fail, and which solvers ran in the end.

use super::Stepper;
use crate::error::{Error, Result};
use crate::petsc::{Ran, SolveReport};
use crate::solve::model::linear::LinearChoice;
use crate::solve::problem::PlatenSystem;

impl Stepper<'_> {
    /// The linear solvers as PETSc has them, that of all unknowns first. Local.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn ran(&self) -> Result<Vec<Ran>> {
        let mut ran = vec![self.snes.ran()?];
        if let Some(coupling) = &self.coupling {
            ran.extend(coupling.ran()?);
        }
        Ok(ran)
    }

    /// Solves on where the linear solver failed for a reason that another set-up of it removes.
    pub(super) fn persist(&mut self, mut report: SolveReport) -> Result<SolveReport> {
        if self.snes.try_more_work_space(&report)? {
            let why = self.reason(&report);
            tracing::info!("  {why}: MUMPS gets more work space");
            report = self.go_on(&report)?;
        }
        let renewed = self.snes.is_suspicious(&report)?
            && self.problem.forget_kept_preconditioner()
            || self.snes.try_new_preconditioner(&report)?;
        if renewed {
            // Collective, while what is told is not worked out on ranks that are silent.
            let why = self.reason(&report);
            tracing::debug!("  {why}: again with a new preconditioner");
            report = self.go_on(&report)?;
        }
        if self.snes.try_indefinite(&report)? {
            self.is_indefinite = true;
            let why = self.reason(&report);
            tracing::info!("  {why}: GMRES takes the place of conjugate gradients");
            report = self.go_on(&report)?;
        }
        let on_path = self.problem.path.as_ref().is_some_and(|path| path.is_unsolved);
        let platens = self.problem.platens.as_ref().is_some_and(|of| of.is_unsolved);
        let unsolved = on_path || platens;
        let unknowns = self.problem.all.nodes.total * self.problem.all.dim as u64;
        // A system of two fields has a preconditioner of its own, whose parts go on by themselves.
        if self.coupling.is_none()
            && (unsolved || report.failing_linear.is_some())
            && let Some(options) = LinearChoice::elimination(self.case, unknowns)
            && let entries = self.problem.matrix_of_blocks(self.snes.petsc())?
            && self.snes.try_elimination(options, entries)?
        {
            self.problem.leave_to_elimination();
            let why = self.reason(&report);
            tracing::info!("  {why}: MUMPS takes the place of iterations");
            if let Some(path) = &mut self.problem.path {
                path.forget_failure();
            }
            self.problem.platens.iter_mut().for_each(PlatenSystem::forget_failure);
            report = self.go_on(&report)?;
        }
        if let Some(failure) = report.failing_linear.as_ref().filter(|f| f.is_final()) {
            let words = format!("the linear solver failed: {}", failure.words);
            let kind = if failure.wants_memory() { Error::System } else { Error::Numerics };
            return Err(kind(words));
        }
        Ok(report)
    }

    /// Solves on from the state at which a solve failed: its corrections are not lost.
    fn go_on(&mut self, from: &SolveReport) -> Result<SolveReport> {
        let mut report = self.solve()?;
        report.iterations += from.iterations;
        report.linear_iterations += from.linear_iterations;
        Ok(report)
    }
}
