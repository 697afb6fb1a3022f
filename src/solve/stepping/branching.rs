//! Where a state is not stable: what the case asks for, and the way along the mode to one that is.

use super::bifurcation::{Bifurcation, Consequence, is_less};
use super::step_size::StepSize;
use super::{Accepted, Stepper};
use crate::case::Stability;
use crate::error::{Error, Result};
use crate::law::Branch;
use crate::petsc::{SolveReport, Vector};
use crate::solve::model::interfaces::NodeResponse;
use crate::solve::problem::energy;
use crate::solve::problem::path::OVERSTRESS;
use crate::solve::problem::platens::SofteningPlatens;
use crate::solve::stability::{self, Instability, Mode};

/// Steps are cut for unstable states down to so many of the smallest ones.
const WORTH: f64 = 64.0;
/// Jumps that differ by less than this part of themselves are the same.
const SAME_JUMP: f64 = 1e-6;

/// Why a state is not tested.
const UNTESTED: &str = "lips slide with friction, which makes the tangent unsymmetric";

/// A state with its potential energy.
pub(super) struct Reached {
    x: Vec<f64>,
    pub energy: f64,
}

impl Stepper<'_> {
    /// The instability of the state that was reached, where the case asks and something softens.
    /// Path following goes through unstable states by its nature. Collective.
    pub(super) fn instability(&mut self, time: f64, alarm: bool) -> Result<Option<Instability>> {
        let softens =
            |r: &NodeResponse| matches!(r.branch, Branch::Softening | Branch::SofteningClosed);
        let problem = &mut self.problem;
        let softening = problem.interfaces.response.iter().any(softens);
        let softens = problem.comm.any(softening) && self.coupling.is_none();
        // Columns of the saddle-point form hold multipliers too.
        let known = match softens && self.saddle.is_none() {
            true => problem.softening_of_platens(None)?,
            false => None,
        };
        let tested = match self.case.solver.stability {
            Stability::Off => false,
            Stability::Auto => (alarm || known.is_some()) && self.saddle.is_none(),
            Stability::Warn | Stability::Stop | Stability::Follow => true,
        } && problem.path.is_none()
            && self.coupling.is_none();
        if !tested || !softens {
            return Ok(None);
        }
        if problem.is_unsymmetric() {
            self.tell_untested(time);
            return Ok(None);
        }
        let x = self.x.read()?.to_vec();
        let mut tangent = self.snes.tangent_at(problem, &x)?;
        let (comm, all, state) = (problem.comm, &problem.all, &problem.interfaces);
        let mut found = stability::test(comm, all, state, &mut tangent, problem.stiffness())?;
        let mut solve = |rhs: &[f64], x: &mut [f64]| tangent.solve(rhs, x);
        if let Some(of) = problem.softening_of_platens(Some(&mut solve))? {
            let SofteningPlatens { count, lowest, mode } = of;
            let (all, state) = (&problem.all, &problem.interfaces);
            found = found.with_platens(comm, all, state, count, (lowest, mode));
        }
        Ok((!found.is_stable()).then_some(Instability { time, found }))
    }

    /// Says once that states in which lips slide with friction are not tested: their tangent is not
    /// symmetric, and a potential that eigenvalues would tell of does not exist.
    fn tell_untested(&mut self, time: f64) {
        if self.remarks.iter().any(|told| told.contains(UNTESTED)) {
            return;
        }
        let words = format!(
            "stability at time {time}: {UNTESTED}, so that its eigenvalues do not tell; whether this \
             state and later ones like it are stable, or the only ones, is not known"
        );
        tracing::warn!("warning: {words}");
        self.remarks.push(words);
    }

    /// A step to `target`, and the instability of the state that it leads to. With `follow` a step
    /// that fails or leads to an unstable state is tried again from `before` with what softened
    /// before softening on: from the secant, on which steps start, the load passes over the
    /// strength of what has not softened yet. Collective.
    pub(super) fn attempt(
        &mut self,
        target: f64,
        before: &Vector,
        total: &mut Accepted,
    ) -> Result<(SolveReport, Option<Instability>)> {
        let mut step = |stepper: &mut Self| {
            let report = stepper.try_step(target)?;
            total.count(&report);
            // Where pivots are not counted the test itself has to tell.
            let alarm = report.negative_pivots != Some(0) || stepper.is_indefinite;
            let converged = report.reason.is_converged();
            let unstable = if converged { stepper.instability(target, alarm)? } else { None };
            Ok((report, unstable))
        };
        let first = step(self)?;
        let is_good = first.0.reason.is_converged() && first.1.is_none();
        let is_damaged = self.problem.interfaces.committed.iter().any(|kappa| *kappa > 0.0);
        let follows = self.case.solver.stability == Stability::Follow;
        if is_good || !follows || !self.problem.comm.any(is_damaged) {
            return Ok(first);
        }
        let reached = self.reached_state()?;
        self.x.copy_from(before)?;
        self.problem.interfaces.overstress = 1.0 + OVERSTRESS;
        let second = step(self)?;
        self.problem.interfaces.overstress = 1.0;
        if !second.0.reason.is_converged() && first.0.reason.is_converged() {
            self.go_back_to(&reached, total)?;
            return Ok(first);
        }
        Ok(second)
    }

    /// What follows from the unstable state that a step of such a size has led to. Smaller steps
    /// are tried first where they may lead elsewhere, since a path that starts closer to where it
    /// leaves the unstable one leaves it on the right side; not where the sides are each other's
    /// mirror image. Collective.
    pub(super) fn consequence(
        &mut self,
        unstable: &Instability,
        size: StepSize,
        total: &mut Accepted,
    ) -> Result<Consequence> {
        let StepSize { step, smallest } = size;
        let may_depend = self.tries_smaller_steps && unstable.may_depend_on_the_step();
        match self.case.solver.stability {
            Stability::Stop => Ok(Consequence::Cut),
            Stability::Follow if may_depend && self.is_cutting && step > WORTH * smallest => {
                Ok(Consequence::Cut)
            }
            Stability::Follow => {
                let is_worth = self.tries_smaller_steps && step > WORTH * smallest;
                match self.leave(unstable, total)? {
                    Some(found) if found.is_symmetric() || !(is_worth && may_depend) => {
                        Ok(Consequence::Left(Box::new(found)))
                    }
                    None if !is_worth => Ok(Consequence::Taken),
                    _ => {
                        self.is_cutting = true;
                        Ok(Consequence::Cut)
                    }
                }
            }
            _ => {
                // An imperfection selects a branch, also of modes that tilt, if the step does not
                // pass over where it does.
                let imperfect = self.tries_smaller_steps && !self.case.imperfections.is_empty();
                let is_worth = step > if imperfect { smallest } else { WORTH * smallest };
                Ok(if (may_depend || imperfect) && is_worth {
                    Consequence::Cut
                } else {
                    Consequence::Taken
                })
            }
        }
    }

    /// Takes note of what an accepted state came from.
    pub(super) fn keep(&mut self, unstable: Option<Instability>, consequence: Consequence) {
        self.is_cutting = false;
        let Some(unstable) = unstable else { return };
        if let Consequence::Left(found) = consequence {
            tracing::warn!("warning: {}", found.words(self.case));
            self.bifurcations.push(*found);
            return;
        }
        // Where a small step did not help, the next would not either.
        let follows = self.case.solver.stability == Stability::Follow;
        let tried = follows || !self.case.imperfections.is_empty();
        self.tries_smaller_steps &= !(tried || unstable.may_depend_on_the_step());
        tracing::warn!("warning: {}", unstable.words(self.case));
        self.instabilities.push(unstable);
    }

    /// Goes from the unstable state that was reached to the stable one with the lower energy of
    /// those that the two directions of its mode lead to; to the first direction if they are the
    /// same. Stays at the unstable state if there is none. Collective.
    fn leave(
        &mut self,
        unstable: &Instability,
        total: &mut Accepted,
    ) -> Result<Option<Bifurcation>> {
        let from = self.reached_state()?;
        let mode = self.unstable_mode()?;
        let first = self.descend(&from, &mode, 1.0, unstable.time, total)?;
        let second = self.descend(&from, &mode, -1.0, unstable.time, total)?;
        let (taken, other) = match (first, second) {
            (Some(first), Some(second)) => {
                let energies = [from.energy, first.energy];
                let swapped = is_less(second.energy, first.energy, energies);
                if swapped { (second, Some(first)) } else { (first, Some(second)) }
            }
            (Some(one), None) | (None, Some(one)) => (one, None),
            (None, None) => {
                self.go_back_to(&from, total)?;
                return Ok(None);
            }
        };
        self.go_back_to(&taken, total)?;
        let mut unstable = unstable.clone();
        unstable.found.mode = Some(mode.kind);
        let energy = [from.energy, taken.energy];
        let opposite = other.map(|other| other.energy);
        Ok(Some(Bifurcation { unstable, energy, opposite, largest: self.largest_jump() }))
    }

    pub(super) fn solve_from_here(&mut self) -> Result<SolveReport> {
        let report = self.solve()?;
        self.persist(report)
    }

    /// The lowest mode of the state that was evaluated last. Collective.
    pub(super) fn unstable_mode(&mut self) -> Result<Mode> {
        let x = self.x.read()?.to_vec();
        let problem = &mut self.problem;
        let mut tangent = self.snes.tangent_at(problem, &x)?;
        let mut solve = |rhs: &[f64], x: &mut [f64]| tangent.solve(rhs, x);
        let of_platens = problem.answers_to_platens(&mut solve)?;
        let (comm, all, state) = (problem.comm, &problem.all, &problem.interfaces);
        stability::lowest_mode(comm, all, state, &mut tangent, of_platens)
    }

    /// The state that was evaluated last. Collective.
    pub(super) fn reached_state(&self) -> Result<Reached> {
        let x = self.x.read()?.to_vec();
        Ok(Reached { x, energy: energy::potential(&self.problem) })
    }

    /// Makes a state the one that was evaluated last; as it converged once it takes no correction.
    /// Collective.
    pub(super) fn go_back_to(&mut self, state: &Reached, total: &mut Accepted) -> Result<()> {
        self.x.write()?.copy_from_slice(&state.x);
        let report = self.solve_from_here()?;
        total.count(&report);
        if !report.reason.is_converged() {
            let words = self.reason(&report);
            return Err(Error::Bug(format!("a state that converged does so no more: {words}")));
        }
        Ok(())
    }

    /// Interface and place of the largest equivalent jump so far; of equal ones the lowest node's.
    /// Collective.
    fn largest_jump(&self) -> (usize, String) {
        let problem = &self.problem;
        let (all, response) = (&problem.all, &problem.interfaces.response);
        let mut largest = [response.iter().map(|r| r.history).fold(0.0, f64::max)];
        problem.comm.max(&mut largest);
        let least = (1.0 - SAME_JUMP) * largest[0];
        let named = all.secondary.iter().zip(response).filter(|(_, r)| r.history >= least);
        let mine =
            named.map(|(rows, _)| (all.nodes.names[rows.node as usize], rows.interface)).min();
        // The maximum of the complements is the minimum.
        let name = u64::MAX - problem.comm.max_u64(u64::MAX - mine.map_or(u64::MAX, |m| m.0));
        let interface = mine.filter(|m| m.0 == name).map_or(0, |m| m.1);
        let interface = problem.comm.max_u64(interface as u64) as usize;
        (interface, all.nodes.place_in_words(problem.comm, name))
    }
}

impl Accepted {
    /// Counts what a solve took.
    pub(super) fn count(&mut self, report: &SolveReport) {
        self.newton_iterations += report.iterations;
        self.linear_iterations += report.linear_iterations;
    }
}
