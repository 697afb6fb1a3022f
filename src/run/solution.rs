//! Where the states of a run come from: the model asked for, or a smaller one in its place.

use std::time::Duration;

use super::history;
use super::probes::LocatedProbe;
use super::reduced::{Reduced, serves};
use crate::case::Case;
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::reduce::{NONE_OF_USE, Reduction, Situation, candidates, refusal};
use crate::runtime::Runtime;
use crate::signals;
use crate::solve::{Accepted, BoundaryValueProblem, LinearChoice, Model};
use crate::timers::{Phase, Timers};

/// Which model gives the states. Instants are numbered by their places in the list of the case.
pub enum Solution {
    /// The one asked for, which goes from instant to instant.
    Asked {
        /// Why no smaller one serves.
        reduction: Reduction,
    },
    /// A smaller one, which has gone through all instants.
    Smaller {
        /// The proof that it serves.
        reduction: Reduction,
        /// Its states.
        reduced: Box<Reduced>,
    },
}

impl Solution {
    /// Solves a smaller model and proves that it serves; else tells why the model asked for is
    /// needed. Collective.
    ///
    /// # Errors
    /// `Stopped` on a signal, `System` when PETSc fails.
    pub fn choose(
        runtime: &Runtime,
        timers: &Timers,
        case: &Case,
        asked: &BoundaryValueProblem,
        situation: Situation,
    ) -> Result<Self> {
        let asked_for = |why: String| Ok(Self::Asked { reduction: Reduction::none(why) });
        if let Some(why) = refusal(case, situation) {
            return asked_for(why);
        }
        let _phase = timers.enter(Phase::Solve);
        let mut why = NONE_OF_USE.to_owned();
        for candidate in candidates(case, &asked.mesh) {
            match serves(runtime, timers, case, asked, &candidate) {
                Ok(Ok((certificate, reduced))) => {
                    let (applied, why) = (true, candidate.left_out.to_owned());
                    let reduction = Reduction { applied, why, certificate: Some(certificate) };
                    return Ok(Self::Smaller { reduction, reduced: Box::new(reduced) });
                }
                Ok(Err(reason)) => why = reason,
                // No other model would do better.
                Err(Error::Numerics(reason)) => return asked_for(reason),
                Err(error) => return Err(error),
            }
        }
        asked_for(why)
    }

    /// Why a smaller model serves, or why none does.
    pub fn reduction(&self) -> &Reduction {
        match self {
            Self::Asked { reduction } | Self::Smaller { reduction, .. } => reduction,
        }
    }

    /// The linear solver of the model asked for, `choice` if it is solved.
    pub fn linear_choice(&self, choice: LinearChoice) -> LinearChoice {
        match self {
            Self::Asked { .. } => choice,
            Self::Smaller { reduced, .. } => LinearChoice::none(reduced.why_no_solver()),
        }
    }

    /// Whether the model asked for gives the states: what a smaller one is proven to give needs no
    /// resolution.
    pub fn is_asked(&self) -> bool {
        matches!(self, Self::Asked { .. })
    }

    /// A step towards an instant; what it took once it is reached. Collective.
    ///
    /// # Errors
    /// `Stopped` on a signal; those of the solution.
    pub fn advance(
        &self,
        comm: &Comm,
        case: &Case,
        model: &mut Model<'_>,
        number: usize,
    ) -> Result<Option<Accepted>> {
        match self {
            Self::Asked { .. } => model.stepper.advance(case.time[number]),
            Self::Smaller { reduced, .. } => match signals::stop(comm, Duration::ZERO) {
                Some(reason) => Err(signals::stopped(reason)),
                None => Ok(Some(reduced.instant(number).0)),
            },
        }
    }

    /// The row of the history of the instant that was reached last. Collective; complete on every
    /// rank.
    pub fn row(
        &self,
        comm: &Comm,
        case: &Case,
        model: &Model<'_>,
        probes: &[LocatedProbe],
        number: usize,
        accepted: &Accepted,
    ) -> Vec<Option<f64>> {
        match self {
            Self::Asked { .. } => {
                history::row(case, model, probes, case.time[number], accepted, comm)
            }
            Self::Smaller { reduced, .. } => reduced.instant(number).1,
        }
    }

    /// Gives the fields of `model` the values of the instant that was reached last. Local.
    pub fn show(&self, model: &mut Model<'_>, number: usize) {
        match self {
            Self::Asked { .. } => {}
            Self::Smaller { reduced, .. } => reduced.show(model, number),
        }
    }

    /// Time of the last accepted state (s), where so many instants are done.
    pub fn last_time(&self, case: &Case, model: &Model<'_>, done: usize) -> f64 {
        match (self, done.checked_sub(1)) {
            (Self::Smaller { .. }, Some(last)) => case.time[last],
            _ => model.stepper.time(),
        }
    }

    /// Makes the last of so many instants the accepted state of `model`, so that a checkpoint can
    /// be written. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn adopt(&self, model: &mut Model<'_>, done: usize) -> Result<()> {
        match (self, done.checked_sub(1)) {
            (Self::Smaller { reduced, .. }, Some(last)) => reduced.adopt(model, last),
            _ => Ok(()),
        }
    }
}
