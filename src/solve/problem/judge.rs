//! How good the state is that was evaluated last.

use super::convergence::Iterate;
use super::measure::{Worst, rounding};
use super::{Problem, condensed};
use crate::error::Result;
use crate::petsc::Verdict;

impl Problem<'_> {
    /// The verdict on the state that was evaluated last, with the residual `f` of the
    /// displacements; `other` is the error of what else has to hold, over its scale. Collective.
    pub(in crate::solve) fn judge(
        &mut self,
        iteration: usize,
        f: &[f64],
        norm: f64,
        other: f64,
    ) -> Result<Verdict> {
        let other = match self.beside(other) {
            Ok(other) => other,
            Err(words) => {
                self.convergence.failure = Some(words);
                return Ok(Verdict::Diverged);
            }
        };
        let worst = self.worst_force(f);
        let free = condensed::free_components(&self.all, &self.interfaces);
        let forces = f.iter().zip(free).filter(|(_, free)| *free);
        let mut square = [forces.map(|(f, _)| f * f).sum::<f64>()];
        self.comm.sum(&mut square);
        self.residual_norm = square[0].sqrt();
        let (comm, all) = (self.comm, &self.all);
        let iterate = Iterate { corrections: iteration, norm, worst, control: other };
        let verdict = self.convergence.judge(comm, all, &self.interfaces, iterate)?;
        (self.judged_norm, self.corrections) = (norm, iteration);
        self.is_skew &= iteration > 0;
        let (smallest, since) = self.stall;
        self.stall = match iteration {
            0 => (norm, 0),
            _ if norm < 0.5 * smallest => (norm, 0),
            _ => (smallest, since + 1),
        };
        Ok(self.unless_waiting(verdict))
    }

    /// Evaluates a state with its scales; the 2-norm of its out-of-balance forces (N). Collective.
    pub(in crate::solve) fn out_of_balance(&mut self, x: &[f64]) -> Result<f64> {
        let mut f = vec![0.0; x.len()];
        self.evaluate(x, &mut f, true);
        self.judge(0, &f, 0.0, 0.0)?;
        Ok(self.residual_norm)
    }

    /// The largest out-of-balance nodal force in a residual, as the areas of the nodes count it.
    /// Local.
    pub(super) fn worst_force(&self, f: &[f64]) -> Worst {
        let (all, dim) = (&self.all, self.all.dim);
        let mut worst = Worst::default();
        for node in 0..all.nodes.owned {
            let index = all.secondary_of[node].map(|i| i as usize);
            let stuck = index.map_or([false; 3], |i| self.interfaces.response[i].state.stuck);
            // The rows of stuck components hold a displacement, which the jumps judge.
            let force = f[node * dim..][..dim].iter().zip(stuck).filter(|(_, stuck)| !stuck);
            let length = force.map(|(f, _)| f * f).sum::<f64>().sqrt();
            let moved = self.displacement[node * dim..][..dim].iter();
            let moved = moved.fold(0.0, |m: f64, u| m.max(u.abs()));
            let rounding = rounding(self.stiffness[node] * moved);
            worst.see(self.areas.count(node, length, rounding), all.nodes.names[node]);
        }
        worst
    }
}
