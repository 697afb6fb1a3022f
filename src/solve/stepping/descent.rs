//! The way from an unstable state down to a stable one.

use super::bifurcation::is_less;
use super::branching::Reached;
use super::{Accepted, Stepper};
use crate::error::Result;
use crate::solve::model::interfaces::{Damping, NodeResponse};
use crate::solve::problem::energy;
use crate::solve::stability::Mode;

/// How far a state is displaced along a mode: the largest jump of the mode over the largest growth
/// of a jump in the step.
const AMPLITUDE: f64 = 0.5;
/// Damping that makes every step convex, over the steepest softening.
const CONVEX: f64 = 2.0;
/// The energy falls in so many steps at most, the last of which changes jumps by less than this
/// part of what the largest step did.
const MOST_FLOW_STEPS: usize = 100;
/// See [`MOST_FLOW_STEPS`].
const SETTLED: f64 = 1e-3;
/// An energy is exact to this part of itself.
const ROUNDING: f64 = 1e-13;
/// Unstable states that are passed on the way to a stable one.
const MOST_PASSED: usize = 4;

impl Stepper<'_> {
    /// The stable state, with less energy than `from`, to which the energy falls from where a mode
    /// leads in the direction `sign`; through further unstable states if need be. Collective.
    pub(super) fn descend(
        &mut self,
        from: &Reached,
        mode: &Mode,
        sign: f64,
        time: f64,
        total: &mut Accepted,
    ) -> Result<Option<Reached>> {
        self.go_back_to(from, total)?;
        let mut energy = from.energy;
        let mut next = None;
        for _ in 0..MOST_PASSED {
            let mode = next.as_ref().unwrap_or(mode);
            let way = sign * AMPLITUDE * self.largest_growth();
            let steepest = self.steepest_softening();
            let displacement = mode.displacement.iter();
            self.x.write()?.iter_mut().zip(displacement).for_each(|(x, m)| *x += way * m);
            let settled = self.flow(mode.softening, steepest, total);
            self.problem.interfaces.damping = None;
            if !settled? {
                return Ok(None);
            }
            let report = self.solve_from_here()?;
            total.count(&report);
            if !report.reason.is_converged() {
                return Ok(None);
            }
            let reached = self.reached_state()?;
            if !is_less(reached.energy, energy, [energy, reached.energy]) {
                return Ok(None);
            }
            if self.instability(time, true)?.is_none() {
                return Ok(Some(reached));
            }
            energy = reached.energy;
            next = Some(self.unstable_mode()?);
        }
        Ok(None)
    }

    /// Lets the energy fall step by step until the state changes little: each step minimises the
    /// energy and d/2 times the square of the change of the jumps since the step before,
    /// integrated, which is convex where d exceeds what the law softens by. While the changes decay
    /// d is halved from step to step; it is raised where Newton's method fails or leads to no
    /// minimum. Tells whether the state settled. Collective.
    ///
    /// `softening` is what the unstable mode softens by, `steepest` the law (Pa/m).
    fn flow(&mut self, softening: f64, steepest: f64, total: &mut Accepted) -> Result<bool> {
        let convex = CONVEX * steepest;
        let mut stiffness = (2.0 * softening).min(convex);
        let (mut energy, mut last, mut most) = (f64::INFINITY, 0.0_f64, 0.0_f64);
        for _ in 0..MOST_FLOW_STEPS {
            let before = self.x.read()?.to_vec();
            let from = self.jumps()?;
            self.problem.interfaces.damping = Some(Damping { stiffness, from: from.clone() });
            let report = self.solve_from_here()?;
            total.count(&report);
            let [change, square] = self.change_since(&from)?;
            let reached = energy::potential(&self.problem);
            // At a minimum the sum is below what it is without a change.
            let falls = reached + 0.5 * stiffness * square <= energy + ROUNDING * energy.abs();
            if !report.reason.is_converged() || !falls {
                if stiffness >= convex {
                    return Ok(false);
                }
                stiffness = (4.0 * stiffness).min(convex);
                self.x.write()?.copy_from_slice(&before);
                continue;
            }
            if change <= SETTLED * most {
                return Ok(true);
            }
            if change < last {
                stiffness *= 0.5;
            }
            (energy, last, most) = (reached, change, most.max(change));
        }
        Ok(false)
    }

    /// The largest change of a jump since the jumps `from` (m), and the integral of the squares of
    /// the changes. Collective.
    fn change_since(&self, from: &[[f64; 3]]) -> Result<[f64; 2]> {
        let (all, comm) = (&self.problem.all, self.problem.comm);
        let (mut largest, mut sum) = ([0.0_f64], [0.0]);
        for ((now, from), rows) in self.jumps()?.iter().zip(from).zip(&all.secondary) {
            let square: f64 = (0..3).map(|c| (now[c] - from[c]).powi(2)).sum();
            largest[0] = largest[0].max(square.sqrt());
            sum[0] += rows.law_weight(all.dim) * square;
        }
        comm.max(&mut largest);
        comm.sum(&mut sum);
        Ok([largest[0], sum[0]])
    }

    /// The jumps of the displacement at the owned secondary nodes, by component (m). Collective.
    fn jumps(&self) -> Result<Vec<[f64; 3]>> {
        let all = &self.problem.all;
        let mut u = self.x.read()?.to_vec();
        u.resize(all.nodes.len() * all.dim, 0.0);
        all.nodes.update_ghosts(&mut u, all.dim);
        let at = |index: usize| -> [f64; 3] {
            let beyond = self.problem.interfaces.beyond(index);
            let jump =
                |c: usize| if c < all.dim { all.jump(index, c, &u) + beyond[c] } else { 0.0 };
            std::array::from_fn(jump)
        };
        Ok((0..all.owned_secondary()).map(at).collect())
    }

    /// The steepest fall of a traction with its jump at the state that was evaluated last (Pa/m).
    /// Collective.
    fn steepest_softening(&self) -> f64 {
        let softening = |response: &NodeResponse| {
            let (jump, tangent) = (response.jump, response.state.tangent);
            let square: f64 = jump.iter().map(|w| w * w).sum();
            let pairs = (0..3).flat_map(|c| (0..3).map(move |d| (c, d)));
            let energy: f64 = pairs.map(|(c, d)| jump[c] * tangent[c][d] * jump[d]).sum();
            if square > 0.0 { -energy / square } else { 0.0 }
        };
        let response = self.problem.interfaces.response.iter();
        let mut steepest = [response.map(softening).fold(0.0, f64::max)];
        self.problem.comm.max(&mut steepest);
        steepest[0]
    }

    /// The largest growth of an equivalent jump since the last accepted state (m). Collective.
    fn largest_growth(&self) -> f64 {
        let state = &self.problem.interfaces;
        let growth = state.response.iter().zip(&state.committed).map(|(r, old)| r.history - old);
        let mut largest = [growth.fold(0.0, f64::max)];
        self.problem.comm.max(&mut largest);
        largest[0]
    }
}
