//! The true residual b - A x of linear solves, whatever norm a method goes by.

#![allow(unsafe_code)]

use super::super::error::check;
use super::super::ffi;
use super::{Ksp, LinearFailure, LinearReason};
use crate::error::{Error, Result};
use std::ptr;

/// What one application of a preconditioner may leave of the residual: factors leave rounding.
const LEFT: f64 = 1e-2;
/// What a further solve may leave.
const LEFT_OF_FURTHER: f64 = 1e-6;
/// What rounding may leave, over the largest entry of the diagonal times the solution.
const ROUNDING: f64 = 1e-13;
/// Where a method has come to its last iteration, a correction that leaves this much of the
/// residual is worth taking: Newton's method corrects what is left.
pub(in crate::petsc) const WORTH: f64 = 1e-3;
/// Where a method measures something else the true residual is found each time that has fallen by
/// this much, and after so many iterations.
const FALLEN: f64 = 0.1;
/// See [`FALLEN`].
const MOST_UNSEEN: usize = 5;

/// The true residual of a running solve whose method measures something else.
#[derive(Default)]
pub(in crate::petsc) struct Watch {
    /// Iteration, norm of the method and true norm when the residual was found last.
    last: Option<(usize, f64, f64)>,
}

impl Watch {
    /// The true norm at an iteration at which the method measures `norm`, where it is time to find
    /// it: also when it may have fallen below `target`. Collective.
    pub(in crate::petsc) fn norm(
        &mut self,
        ksp: Ksp,
        iteration: usize,
        norm: f64,
        target: f64,
    ) -> Result<Option<f64>> {
        let due = self.last.is_none_or(|(when, own, truly)| {
            iteration <= when
                || iteration - when >= MOST_UNSEEN
                || norm <= FALLEN * own
                || truly * norm <= target * own
        });
        if !due {
            return Ok(None);
        }
        let truly = ksp.running_residual()?;
        self.last = Some((iteration, norm, truly));
        Ok(Some(truly))
    }
}

impl Ksp {
    /// Whether the norm that the method computes is that of the true residual. Local.
    pub(in crate::petsc) fn measures_true_residual(self) -> Result<bool> {
        let mut kind = 0;
        // SAFETY: a valid solver.
        check(unsafe { ffi::KSPGetNormType(self.raw, &mut kind) }, "KSPGetNormType")?;
        Ok(kind == ffi::KSP_NORM_UNPRECONDITIONED)
    }

    /// 2-norm of b - A x of the running solve. Collective.
    fn running_residual(self) -> Result<f64> {
        let (mut residual, mut norm) = (ptr::null_mut(), 0.0);
        let (none, nowhere) = (ptr::null_mut(), ptr::null_mut());
        // SAFETY: a valid solver with right-hand side and solution; the vector that it makes is
        // destroyed once.
        unsafe {
            let code = ffi::KSPBuildResidual(self.raw, none, nowhere, &mut residual);
            check(code, "KSPBuildResidual")?;
            check(ffi::VecNorm(residual, ffi::NORM_2, &mut norm), "VecNorm")?;
            check(ffi::VecDestroy(&mut residual), "VecDestroy")?;
        }
        Ok(norm)
    }

    /// 2-norm of b - A x of the last solve. Collective.
    pub(in crate::petsc) fn true_residual(self) -> Result<f64> {
        // `KSPBuildResidual` would add the last directions of GMRES once more.
        let [mut b, mut x, mut residual] = [ptr::null_mut(); 3];
        let [mut a, mut preconditioner] = [ptr::null_mut(); 2];
        let mut norm = 0.0;
        // SAFETY: a valid solver with operators, right-hand side and solution, which it lends; the
        // vector that is made of their layout is destroyed once.
        unsafe {
            check(ffi::KSPGetRhs(self.raw, &mut b), "KSPGetRhs")?;
            check(ffi::KSPGetSolution(self.raw, &mut x), "KSPGetSolution")?;
            let code = ffi::KSPGetOperators(self.raw, &mut a, &mut preconditioner);
            check(code, "KSPGetOperators")?;
            check(ffi::VecDuplicate(b, &mut residual), "VecDuplicate")?;
            check(ffi::MatMult(a, x, residual), "MatMult")?;
            check(ffi::VecAYPX(residual, -1.0, b), "VecAYPX")?;
            check(ffi::VecNorm(residual, ffi::NORM_2, &mut norm), "VecNorm")?;
            check(ffi::VecDestroy(&mut residual), "VecDestroy")?;
        }
        Ok(norm)
    }

    /// The failure of a method that only applies its preconditioner, where that is no solution for
    /// a right-hand side of norm `rhs`. Collective.
    pub(in crate::petsc) fn unsolved(self, rhs: f64) -> Result<Option<LinearFailure>> {
        if self.is_iterative()? {
            return Ok(None);
        }
        let left = self.true_residual()?;
        if left <= LEFT * rhs { Ok(None) } else { self.not_solved(left, rhs).map(Some) }
    }

    /// Whether a further solve that failed has come far enough for a right-hand side of norm `rhs`.
    /// Local.
    pub(super) fn serves(self, failure: &LinearFailure, rhs: f64) -> bool {
        let slow = matches!(failure.reason, LinearReason::Iterations | LinearReason::Breakdown);
        slow && failure.residual <= LEFT_OF_FURTHER * rhs
    }

    /// Iterations after which the method gives up. Local.
    pub(in crate::petsc) fn most_iterations(self) -> Result<usize> {
        let (none, mut most) = (ptr::null_mut(), 0);
        // SAFETY: a valid solver; the tolerances are not asked for.
        let code = unsafe { ffi::KSPGetTolerances(self.raw, none, none, none, &mut most) };
        check(code, "KSPGetTolerances")?;
        Ok(usize::try_from(most).unwrap_or(usize::MAX))
    }

    /// Whether a further solve has left little enough of its right-hand side, or no more than
    /// rounding where the solution is large, as beside a singular tangent. Collective.
    pub(super) fn is_solved(self, left: f64, rhs: f64) -> Result<bool> {
        Ok(left <= LEFT_OF_FURTHER * rhs || left <= ROUNDING * self.size_of_product()?)
    }

    /// The largest entry of the diagonal times the 2-norm of the solution. Collective.
    fn size_of_product(self) -> Result<f64> {
        let [mut x, mut diagonal] = [ptr::null_mut(); 2];
        let ([mut a, mut preconditioner], nowhere) = ([ptr::null_mut(); 2], ptr::null_mut());
        let (mut norm, mut low, mut high) = (0.0, 0.0, 0.0);
        // SAFETY: a valid solver with operators and solution, which it lends; the vector that is
        // made of their layout is destroyed once.
        unsafe {
            check(ffi::KSPGetSolution(self.raw, &mut x), "KSPGetSolution")?;
            let code = ffi::KSPGetOperators(self.raw, &mut a, &mut preconditioner);
            check(code, "KSPGetOperators")?;
            check(ffi::VecNorm(x, ffi::NORM_2, &mut norm), "VecNorm")?;
            check(ffi::VecDuplicate(x, &mut diagonal), "VecDuplicate")?;
            check(ffi::MatGetDiagonal(a, diagonal), "MatGetDiagonal")?;
            check(ffi::VecMax(diagonal, nowhere, &mut high), "VecMax")?;
            check(ffi::VecMin(diagonal, nowhere, &mut low), "VecMin")?;
            check(ffi::VecDestroy(&mut diagonal), "VecDestroy")?;
        }
        Ok(norm * f64::max(high, -low))
    }

    /// Refuses a further solve that left too much of its right-hand side. Collective.
    pub(super) fn refuse_what_is_left(self, rhs: f64) -> Result<()> {
        let left = self.true_residual()?;
        if self.is_solved(left, rhs)? {
            return Ok(());
        }
        let words = if self.is_iterative()? {
            let (kind, left) = (self.type_name()?, left / rhs);
            format!(
                "{kind} stopped in the norm that it goes by (-ksp_norm_type), with {left:.1e} of the true residual left"
            )
        } else {
            self.not_solved(left, rhs)?.words
        };
        Err(Error::Numerics(format!("the linear solver failed: {words}")))
    }
}
