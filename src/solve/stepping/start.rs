//! The state at the start, where it is not the undeformed one.

use std::time::Duration;

use super::{Accepted, Coupling, Stepper};
use crate::error::{Error, Result};

impl Stepper<'_> {
    /// Whether the case asks for equilibrium at the start. Local.
    pub(in crate::solve) fn starts_in_equilibrium(&self) -> bool {
        self.case.flow.as_ref().is_some_and(|flow| flow.equilibrium)
    }

    /// Makes the displacements at the start those in equilibrium with the initial pressures, which stay as
    /// they are, the loads and the prescribed displacements. Stress and energy are those of loads and
    /// pressures that grow together from nothing; the fluid that is stored counts from here. Collective.
    ///
    /// # Errors
    /// `Numerics` when there is no equilibrium or it leaves a body free; `Input` when a formula gives no
    /// finite number; `Stopped` on a signal: the state is then the undeformed one.
    pub(super) fn begin_in_equilibrium(&mut self, total: &mut Accepted) -> Result<()> {
        self.stop_if_asked(Duration::ZERO)?;
        let start = self.time;
        self.problem.set_load(start)?;
        let mut before = self.x.duplicate()?;
        before.copy_from(&self.x)?;
        let written = self.write_displacements(start);
        self.problem.comm.agree(written)?;
        self.hold_pressures(true);
        let solved = self.solve();
        let solved = solved.and_then(|report| self.persist(report));
        self.hold_pressures(false);
        let report = solved?;
        total.newton_iterations += report.iterations;
        total.linear_iterations += report.linear_iterations;
        if !report.reason.is_converged() {
            let why = self.reason(&report);
            self.x.copy_from(&before)?;
            self.stop_if_asked(Duration::ZERO)?;
            return Err(Error::Numerics(format!(
                "no equilibrium with the initial pressures (initial.equilibrium) at time {start}: {why}{}",
                self.advice()
            )));
        }
        self.refuse_freed_bodies(start)?;
        let problem = &mut self.problem;
        problem.convergence.accept(problem.comm);
        problem.interfaces.commit(&problem.all);
        if let Some(Coupling { flow, .. }) = &mut self.coupling {
            flow.begin(problem.comm, &problem.all, &problem.displacement);
        }
        self.energy = self.work.accept(&self.problem);
        self.has_begun = true;
        tracing::debug!(
            "  in equilibrium with the initial pressures after {} corrections",
            report.iterations
        );
        Ok(())
    }

    fn hold_pressures(&self, holds: bool) {
        if let Some(coupling) = &self.coupling {
            coupling.hold_pressures(holds);
        }
    }
}
