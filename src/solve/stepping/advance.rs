//! The steps that lead to an instant.

use std::time::{Duration, Instant};

use super::bifurcation::Consequence;
use super::doubts::Doubt;
use super::step_size::StepSize;
use super::{Accepted, MOST_HALVINGS, Stepper};
use crate::error::{Error, Result};
use crate::fault;
use crate::petsc::{SolveReport, Vector};
use crate::solve::flow::coupled::Coupling;
use crate::solve::stability::Instability;

/// The way to an instant.
struct Way {
    instant: f64,
    size: StepSize,
    /// Whether a step was cut for a doubt.
    was_doubted: bool,
    /// Where parts of a step that was cut for a doubt fail, all that is left is tried once more:
    /// whether this is that try.
    is_last: bool,
}

/// A step that was tried.
struct Tried {
    target: f64,
    report: SolveReport,
    unstable: Option<Instability>,
    consequence: Consequence,
    doubt: Option<Doubt>,
}

impl Tried {
    fn converged(&self) -> bool {
        self.report.reason.is_converged()
    }

    /// Whether its state is accepted.
    fn is_taken(&self, way: &Way) -> bool {
        let is_cut = matches!(self.consequence, Consequence::Cut);
        let doubt = self.doubt.as_ref();
        let is_doubted = doubt.is_some_and(|doubt| doubt.is_worth(way.size, way.is_last));
        self.converged() && !is_cut && !is_doubted
    }
}

impl Stepper<'_> {
    /// Solves for the state at `instant`. A step that fails is halved; the instant itself, and the
    /// times before at which a table bends, are always reached exactly. None after a step that did
    /// not reach it and took long, where a checkpoint may be due: to be called again. Collective.
    ///
    /// # Errors
    /// `Numerics` when the smallest step fails, with the reason and the place, and when a rupture
    /// leaves a body free; `Input` when a formula gives no finite number.
    pub fn advance(&mut self, instant: f64) -> Result<Option<Accepted>> {
        let mut total = std::mem::take(&mut self.since_instant);
        if self.starts_in_equilibrium() && !self.has_begun {
            let begun = self.begin_in_equilibrium(&mut total);
            if begun.is_err() {
                self.since_instant = total;
                begun?;
            }
        }
        while self.time < instant {
            let passed = self.breakpoints.partition_point(|time| *time <= self.time);
            let next = self.breakpoints.get(passed).map_or(instant, |time| time.min(instant));
            let advanced = self.advance_without_bends(next, &mut total);
            if self.breakpoints.contains(&self.time)
                && let Some(pace) = self.coupling.as_mut().and_then(|c| c.flow.pace.as_mut())
            {
                pace.jump();
            }
            if advanced.is_err() {
                self.since_instant = total;
                advanced?;
            }
            if self.paused.is_some() {
                self.since_instant = total;
                return Ok(None);
            }
        }
        total.energy = self.energy;
        total.residual_norm = self.problem.residual_norm;
        Ok(Some(total))
    }

    /// As [`Stepper::advance`], to the next time at which a table bends.
    fn advance_without_bends(&mut self, instant: f64, total: &mut Accepted) -> Result<()> {
        let mut way = self.way_to(instant);
        while self.time < instant {
            self.stop_if_asked(self.longest)?;
            let (started, counts) = (Instant::now(), *total);
            let target = self.next_target(&way);
            let mut before = self.x.duplicate()?;
            before.copy_from(&self.x)?;
            // The step is made again by the run that goes on.
            let tried = self.try_to(target, &before, &way, total);
            let Some(tried) = tried.inspect_err(|_| *total = counts)? else {
                tracing::debug!("  step from {} to {target} was too long for flow", self.time);
                self.x.copy_from(&before)?;
                continue;
            };
            if tried.is_taken(&way) {
                self.take(tried)?;
                total.steps += 1;
                self.longest = self.longest.max(started.elapsed());
                // Errors of steps grow with their length.
                way.size.step *= if self.excess > 0.5 { 1.0 } else { 2.0 };
                if self.time < instant && self.problem.pulse.is_slow() {
                    self.paused = Some(way.size);
                    return Ok(());
                }
                continue;
            }
            let why = self.why_not(&tried);
            self.x.copy_from(&before)?;
            self.stop_if_asked(Duration::ZERO).inspect_err(|_| *total = counts)?;
            self.shorten(&mut way, &tried, &why)?;
        }
        if self.step.is_finite() {
            self.step = way.size.step;
        }
        Ok(())
    }

    /// The way to `instant`, or what is left of it after a pause.
    fn way_to(&mut self, instant: f64) -> Way {
        let smallest = (instant - self.time) / f64::from(1 << MOST_HALVINGS);
        let size = StepSize { step: self.step.min(instant - self.time), smallest };
        let size = self.paused.take().unwrap_or(size);
        Way { instant, size, was_doubted: false, is_last: false }
    }

    /// The end of the next step.
    fn next_target(&self, way: &Way) -> f64 {
        let (instant, step) = (way.instant, way.size.step);
        // Halving is exact, so the last step ends at the instant to the last bit.
        let target = if instant - self.time <= 1.5 * step { instant } else { self.time + step };
        let pace = self.coupling.as_ref().and_then(|coupling| coupling.flow.pace.as_ref());
        pace.map_or(target, |pace| pace.target(self.time, target))
    }

    /// Tries the step to `target`, on a `way` on which it may be cut, from `before`; none where it
    /// was too long for the flow. Collective.
    fn try_to(
        &mut self,
        target: f64,
        before: &Vector,
        way: &Way,
        total: &mut Accepted,
    ) -> Result<Option<Tried>> {
        let (report, unstable) = self.attempt(target, before, total)?;
        let converged = report.reason.is_converged();
        if let Some(Coupling { flow, .. }) = &mut self.coupling
            && converged
            && !flow.is_accurate(self.problem.comm)
        {
            return Ok(None);
        }
        let consequence = match &unstable {
            Some(found) => self.consequence(found, way.size, total)?,
            None => Consequence::Taken,
        };
        let is_cut = matches!(consequence, Consequence::Cut);
        let mut doubt = if converged && !is_cut { self.doubt(target) } else { None };
        let is_cut = is_cut || doubt.as_ref().is_some_and(|of| of.is_worth(way.size, way.is_last));
        if converged && !is_cut {
            doubt = self.without_pressed_lips(doubt, total)?;
        }
        Ok(Some(Tried { target, report, unstable, consequence, doubt }))
    }

    /// Makes the state that a step led to the accepted one, in spite of a doubt that is not worth
    /// cutting it. Collective.
    fn take(&mut self, tried: Tried) -> Result<()> {
        if let Some(doubt) = tried.doubt {
            self.bear(doubt)?;
        }
        let problem = &mut self.problem;
        let owned = problem.all.nodes.owned * problem.all.dim;
        fault::strike_values(problem.comm, "step", &mut problem.displacement[..owned])?;
        self.accept(self.reached(tried.target)?);
        self.keep(tried.unstable, tried.consequence);
        Ok(())
    }

    /// Why a step was not taken, in words. Collective.
    fn why_not(&self, tried: &Tried) -> String {
        match (&tried.doubt, &tried.unstable) {
            (Some(doubt), _) => doubt.words.clone(),
            (None, Some(found)) => found.words(self.case),
            (None, None) => self.reason(&tried.report),
        }
    }

    /// Makes the next step shorter than one that was not taken; where parts of a step that was cut
    /// for a doubt fail, as long as all that is left, once. Collective.
    ///
    /// # Errors
    /// `Numerics` where none smaller is tried.
    fn shorten(&mut self, way: &mut Way, tried: &Tried, why: &str) -> Result<()> {
        let (time, target, step) = (self.time, tried.target, way.size.step);
        if way.size.is_smallest() && tried.converged() {
            return Err(Error::Numerics(format!(
                "{why}; a step of {step:e} from {time} changes nothing (solver.stability: warn \
                 goes on)"
            )));
        }
        way.was_doubted |= tried.doubt.as_ref().is_some_and(Doubt::can_be_borne);
        if way.size.is_smallest() && way.was_doubted && !way.is_last {
            let instant = way.instant;
            tracing::info!("  step from {time} to {target} failed: {why}; {instant} at once");
            (way.is_last, way.size.step) = (true, instant - time);
            return Ok(());
        }
        if way.size.is_smallest() {
            return Err(Error::Numerics(format!(
                "no solution at time {target}, reached from {time} with the smallest step {step:e} \
                 (after {MOST_HALVINGS} halvings): {why}{}{}",
                self.rounding_words(),
                self.advice()
            )));
        }
        tracing::info!("  step from {time} to {target} failed: {why}; halved");
        let begins = self.stage > 0 || !self.has_begun;
        if time == self.case.start && begins && self.ramp.is_none() {
            self.grow_until(way.instant)?;
        }
        way.size.step = 0.5 * (target - time);
        self.step = way.size.step;
        Ok(())
    }
}
