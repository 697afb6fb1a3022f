//! What the callbacks of one solve share, and what they ask of its linear solves.

#![allow(unsafe_code)]

use super::definite::Definite;
use super::system::{NonlinearSystem, Trial};
use crate::error::{Error, Result};
use crate::petsc::error::check;
use crate::petsc::linear::{Ksp, LinearFailure, LinearTolerance, WORTH, Watch};
use crate::petsc::{Matrix, ReadView, ffi};
use std::ptr;

/// The state that a linear solve leads to is tried when the residual has fallen by this, and again
/// each time it has fallen by the second or to what the trial before asked for.
const TRIAL: [f64; 2] = [1e-2, 1e-3];

/// A linear residual that has grown to this times the right-hand side will not come back.
const DIVERGED: f64 = 1e5;

/// What the user's options fix and the system therefore does not change.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct UserSet {
    /// The relative tolerance of the linear solves.
    pub(super) relative: bool,
    /// The absolute tolerance of the linear solves.
    pub(super) absolute: bool,
    /// When the preconditioner is built again.
    pub(super) preconditioner: bool,
}

/// The state that was judged last.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Judged {
    /// Its number.
    pub(super) iteration: usize,
    /// Of its residual.
    pub(super) norm: f64,
}

/// What the callbacks of one solve share.
pub(super) struct Context<'a, S> {
    pub(super) system: &'a mut S,
    pub(super) matrix: &'a mut Matrix,
    pub(super) definite: &'a mut Definite,
    pub(super) ksp: Ksp,
    ranks: i32,
    pub(super) user: UserSet,
    pub(super) judged: Judged,
    /// Most negative pivots that MUMPS has met in a factorisation of the running solve; `None`
    /// where nothing tells of them.
    pub(super) negative_pivots: Option<usize>,
    /// The true residual of a method that goes by another norm.
    watch: Watch,
    /// How a linear solve failed that only applied its preconditioner.
    pub(super) unsolved: Option<LinearFailure>,
    /// Norm of the linear residual at which the next trial of the state is due.
    next_trial: f64,
    /// The error of the callback that failed.
    pub(super) error: Option<Error>,
    /// Whether the verdict was `Diverged`.
    pub(super) stopped: bool,
}

impl<'a, S> Context<'a, S> {
    pub(super) fn new(
        system: &'a mut S,
        matrix: &'a mut Matrix,
        definite: &'a mut Definite,
        ksp: Ksp,
        ranks: i32,
        user: UserSet,
    ) -> Self {
        Context {
            system,
            matrix,
            definite,
            ksp,
            ranks,
            user,
            judged: Judged::default(),
            negative_pivots: Some(0),
            watch: Watch::default(),
            unsolved: None,
            next_trial: 0.0,
            error: None,
            stopped: false,
        }
    }

    /// Counts the pivots of the solve that has just ended. Conjugate gradients tell an indefinite
    /// tangent themselves. Local.
    pub(super) fn count_pivots(&mut self) -> Result<()> {
        if self.ksp.pc_type_name()? == "cholesky" || self.ksp.type_name()? != "cg" {
            let counts = self.negative_pivots.zip(self.ksp.negative_pivots(self.ranks)?);
            self.negative_pivots = counts.map(|(most, count)| most.max(count));
        }
        Ok(())
    }

    /// Sets the tolerances of the linear solve where the user has set none. Local.
    fn set_tolerances(&self, tolerance: LinearTolerance) -> Result<()> {
        self.ksp.set_tolerances(
            (!self.user.relative).then_some(tolerance.relative),
            (!self.user.absolute).then_some(tolerance.absolute),
        )
    }

    /// The true norm of a linear residual, whatever norm the method goes by; none where it is not
    /// yet time to find it. Collective.
    fn true_norm(&mut self, iteration: usize, norm: f64, target: f64) -> Result<Option<f64>> {
        if self.ksp.measures_true_residual()? || !norm.is_finite() {
            return Ok(Some(norm));
        }
        self.watch.norm(self.ksp, iteration, norm, target)
    }
}

impl<S: NonlinearSystem> Context<'_, S> {
    /// Prepares the linear solve of the state that was judged last: its tolerances, and when the
    /// state it leads to is tried first. Collective.
    pub(super) fn ask_of_linear_solve(&mut self) -> Result<()> {
        let Judged { iteration, norm } = self.judged;
        self.next_trial = if self.system.has_trials() { TRIAL[0] * norm } else { 0.0 };
        let tolerance = self.system.linear_tolerance(iteration, norm);
        self.set_tolerances(tolerance)
    }

    /// Whether a linear solve has converged: the usual test on the true residual, and the system's
    /// opinion of the state that the correction so far leads to. Collective.
    ///
    /// # Safety
    /// `ksp` is the solver that asks, and runs.
    pub(super) unsafe fn judge_linear(
        &mut self,
        ksp: ffi::KSP,
        iteration: usize,
        norm: f64,
    ) -> Result<ffi::KSPConvergedReason> {
        self.system.heed()?;
        let rhs = self.judged.norm;
        let mut target = self.ksp.tolerances()?.target(rhs);
        let Some(norm) = self.true_norm(iteration, norm, target)? else {
            return Ok(ffi::KSP_CONVERGED_ITERATING);
        };
        if !norm.is_finite() {
            return Ok(ffi::KSP_DIVERGED_NANORINF);
        }
        if norm > DIVERGED * rhs {
            return Ok(ffi::KSP_DIVERGED_DTOL);
        }
        if norm <= self.next_trial {
            self.next_trial = TRIAL[1] * norm;
            // SAFETY: by the contract.
            match unsafe { self.try_state(ksp, norm) }? {
                Trial::Relinearise => return Ok(ffi::KSP_CONVERGED_ITS),
                Trial::GoOn(None) => {}
                Trial::GoOn(Some(tolerance)) => {
                    self.set_tolerances(tolerance)?;
                    target = self.ksp.tolerances()?.target(rhs);
                    self.next_trial = self.next_trial.max(target);
                }
            }
        }
        if norm <= target {
            return Ok(ffi::KSP_CONVERGED_RTOL);
        }
        let is_last = iteration >= self.ksp.most_iterations()?;
        let is_worth_it = is_last && norm <= WORTH * rhs;
        Ok(if is_worth_it { ffi::KSP_CONVERGED_ITS } else { ffi::KSP_CONVERGED_ITERATING })
    }

    /// What the system says of the state that the correction so far leads to, with a residual of
    /// norm `norm`. Collective.
    ///
    /// # Safety
    /// As [`Context::judge_linear`].
    unsafe fn try_state(&mut self, ksp: ffi::KSP, norm: f64) -> Result<Trial> {
        let mut correction = ptr::null_mut();
        // SAFETY: the solver that asks; it lends its solution.
        let code = unsafe { ffi::KSPBuildSolution(ksp, ptr::null_mut(), &mut correction) };
        check(code, "KSPBuildSolution")?;
        // SAFETY: a valid vector that nothing writes to during the call.
        let correction = unsafe { ReadView::new(correction) }?;
        self.system.trial(&correction, norm)
    }
}
