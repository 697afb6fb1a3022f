//! The state at the start, where it is not the undeformed one.

use std::time::Duration;

use super::step_size::StepSize;
use super::{Accepted, Coupling, MOST_HALVINGS, Stepper};
use crate::error::{Error, Result};

impl Stepper<'_> {
    /// Whether the case asks for equilibrium at the start. Local.
    pub(in crate::solve) fn starts_in_equilibrium(&self) -> bool {
        self.case.flow.as_ref().is_some_and(|flow| flow.equilibrium)
    }

    /// Makes the displacements at the start those in equilibrium with the initial pressures, which
    /// stay as they are, the loads and the prescribed displacements. Stress and energy are those of
    /// loads and pressures that grow together from nothing; the fluid that is stored counts from
    /// here. Collective.
    ///
    /// # Errors
    /// `Numerics` when there is no equilibrium or it leaves a body free; `Input` when a formula
    /// gives no finite number; `Stopped` on a signal: the state is then the undeformed one.
    pub(super) fn begin_in_equilibrium(&mut self, total: &mut Accepted) -> Result<()> {
        let mut before = self.x.duplicate()?;
        before.copy_from(&self.x)?;
        let (history, work) = (self.problem.interfaces.history(), self.work.clone());
        self.grow_until(self.time)?;
        self.hold_pressures(true);
        let begun = self.load_from_rest(total);
        self.hold_pressures(false);
        self.ramp = None;
        if begun.is_err() {
            self.x.copy_from(&before)?;
            self.problem.interfaces.go_back_to(history);
            self.work = work;
            return begun;
        }
        let problem = &self.problem;
        if let Some(Coupling { flow, .. }) = &mut self.coupling {
            flow.begin(problem.comm, &problem.all, &problem.displacement);
        }
        self.has_begun = true;
        tracing::debug!("  in equilibrium with the initial pressures");
        Ok(())
    }

    /// Lets all that acts at the start grow from nothing, at once where that converges. Collective.
    fn load_from_rest(&mut self, total: &mut Accepted) -> Result<()> {
        let (start, smallest) = (self.time, 0.5_f64.powi(MOST_HALVINGS as i32));
        let (mut reached, mut step) = (0.0_f64, 1.0);
        while reached < 1.0 {
            self.stop_if_asked(Duration::ZERO)?;
            let target = (reached + step).min(1.0);
            let mut before = self.x.duplicate()?;
            before.copy_from(&self.x)?;
            self.set_load(start, target)?;
            let written = self.write_displacements(start, target);
            self.problem.comm.agree(written)?;
            self.problem.predict();
            let report = self.solve_from_here()?;
            total.count(&report);
            let converged = report.reason.is_converged();
            let mut doubt = if converged { self.doubt(start) } else { None };
            if converged
                && !doubt
                    .as_ref()
                    .is_some_and(|doubt| doubt.is_worth(StepSize { step, smallest }, false))
            {
                if let Some(doubt) = doubt.take() {
                    self.bear(doubt)?;
                }
                let problem = &mut self.problem;
                problem.convergence.accept();
                problem.interfaces.commit(&problem.all);
                self.energy = self.work.accept(&self.problem);
                (reached, step) = (target, 2.0 * step);
                continue;
            }
            let why = doubt.map_or_else(|| self.reason(&report), |doubt| doubt.words);
            self.x.copy_from(&before)?;
            self.stop_if_asked(Duration::ZERO)?;
            if step <= smallest {
                return Err(Error::Numerics(format!(
                    "no equilibrium with the initial pressures (initial.equilibrium) at time \
                     {start} beyond {reached} of the loads and pressures: {why}{}",
                    self.advice()
                )));
            }
            tracing::info!("  {target} of what acts at the start failed: {why}; halved");
            step = 0.5 * (target - reached);
        }
        Ok(())
    }

    fn hold_pressures(&self, holds: bool) {
        if let Some(coupling) = &self.coupling {
            coupling.hold_pressures(holds);
        }
    }
}
