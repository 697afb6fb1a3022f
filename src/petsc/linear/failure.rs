//! Failures of the linear solver in words.

#![allow(unsafe_code)]

use super::super::error::check;
use super::super::ffi;
use super::Ksp;
use crate::error::Result;
use std::fmt;

/// Why a linear solve failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinearReason {
    /// The limit of iterations was reached.
    Iterations,
    /// The residual grew.
    Grew,
    /// The Krylov method broke down.
    Breakdown,
    /// The method needs a symmetric matrix.
    NotSymmetric,
    /// Conjugate gradients met a direction of no or negative curvature.
    IndefiniteMatrix,
    /// The preconditioner has a negative or zero direction.
    IndefinitePreconditioner,
    /// The residual is not a number.
    NotANumber,
    /// The preconditioner or the factorisation could not be built or applied.
    Preconditioner,
    /// The factors do not solve the system.
    Singular,
    /// An iterative preconditioner was applied once, which is no solution.
    NotSolved,
    /// A code of PETSc that has no name here.
    Other(i32),
}

impl LinearReason {
    fn from_code(code: ffi::KSPConvergedReason) -> Self {
        match code {
            ffi::KSP_DIVERGED_ITS => LinearReason::Iterations,
            ffi::KSP_DIVERGED_DTOL => LinearReason::Grew,
            ffi::KSP_DIVERGED_BREAKDOWN | ffi::KSP_DIVERGED_BREAKDOWN_BICG => {
                LinearReason::Breakdown
            }
            ffi::KSP_DIVERGED_NONSYMMETRIC => LinearReason::NotSymmetric,
            ffi::KSP_DIVERGED_INDEFINITE_PC => LinearReason::IndefinitePreconditioner,
            ffi::KSP_DIVERGED_NANORINF => LinearReason::NotANumber,
            ffi::KSP_DIVERGED_INDEFINITE_MAT => LinearReason::IndefiniteMatrix,
            ffi::KSP_DIVERGED_PC_FAILED => LinearReason::Preconditioner,
            other => LinearReason::Other(other),
        }
    }
}

impl fmt::Display for LinearReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            LinearReason::Iterations => "the limit of iterations was reached",
            LinearReason::Grew => "the residual grew instead of falling",
            LinearReason::Breakdown => "the Krylov method broke down",
            LinearReason::NotSymmetric => "the tangent is not symmetric",
            LinearReason::IndefiniteMatrix => "the tangent is indefinite",
            LinearReason::IndefinitePreconditioner => "the preconditioner is indefinite",
            LinearReason::NotANumber => "the residual is not a number",
            LinearReason::Preconditioner => "the preconditioner or factorisation failed",
            LinearReason::Singular => "the tangent is singular within rounding",
            LinearReason::NotSolved => "the system is not solved",
            LinearReason::Other(code) => return write!(f, "PETSc's reason {code}"),
        })
    }
}

/// A linear solve that failed.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearFailure {
    /// Why.
    pub reason: LinearReason,
    /// Why, in words, with what the preconditioner and MUMPS say.
    pub words: String,
    /// Iterations of this solve.
    pub iterations: usize,
    /// Last residual norm that the method computed.
    pub residual: f64,
    /// `INFOG(1)` of MUMPS, where its factors are the preconditioner.
    pub mumps: Option<i32>,
}

impl LinearFailure {
    /// Whether conjugate gradients met what they cannot be used for.
    pub fn is_indefinite(&self) -> bool {
        use LinearReason::{IndefiniteMatrix, IndefinitePreconditioner};
        matches!(self.reason, IndefiniteMatrix | IndefinitePreconditioner)
    }

    /// Whether the solve would fail for a step of any size: the memory for the factors could not be
    /// had, or the options choose what solves nothing.
    pub fn is_final(&self) -> bool {
        self.wants_memory() || self.reason == LinearReason::NotSolved
    }

    /// Whether the memory for the factors could not be had.
    pub fn wants_memory(&self) -> bool {
        self.mumps.is_some_and(|infog| NO_MEMORY.contains(&infog))
    }
}

/// `INFOG(1)` of MUMPS where memory was refused, by the system or by a limit that was set.
const NO_MEMORY: [i32; 4] = [-5, -7, -13, -19];

impl Ksp {
    /// How the last solve failed, if it did.
    pub(in crate::petsc) fn failure(self) -> Result<Option<LinearFailure>> {
        let (mut code, mut residual) = (0, 0.0);
        // SAFETY: a valid solver.
        let status = unsafe { ffi::KSPGetConvergedReason(self.raw, &mut code) };
        check(status, "KSPGetConvergedReason")?;
        if code >= 0 {
            return Ok(None);
        }
        if self.measures_true_residual()? {
            // SAFETY: a valid solver.
            let status = unsafe { ffi::KSPGetResidualNorm(self.raw, &mut residual) };
            check(status, "KSPGetResidualNorm")?;
        } else {
            residual = self.true_residual()?;
        }
        let reason = LinearReason::from_code(code);
        let iterations = self.iterations()?;
        let words = match reason {
            LinearReason::Preconditioner => format!("{reason}: {}", self.preconditioner_words()?),
            LinearReason::Iterations => {
                format!("{reason} ({iterations}, residual {residual:.3e}): -ksp_max_it raises it")
            }
            LinearReason::NotANumber => match self.mumps_infog(1)? {
                Some(infog) if infog < 0 => format!("{reason}: {}", self.preconditioner_words()?),
                _ => reason.to_string(),
            },
            _ => format!("{reason} (iteration {iterations}, residual {residual:.3e})"),
        };
        let mumps = self.mumps_infog(1)?;
        Ok(Some(LinearFailure { reason, words, iterations, residual, mumps }))
    }

    /// How the last solve failed where its preconditioner was applied once and left `residual` of
    /// `rhs`.
    pub(in crate::petsc) fn not_solved(self, residual: f64, rhs: f64) -> Result<LinearFailure> {
        let mumps = self.mumps_infog(1)?;
        let (kind, left) = (self.pc_type_name()?, residual / rhs);
        let is_exact = matches!(kind.as_str(), "lu" | "cholesky" | "redundant" | "svd");
        let reason = if is_exact { LinearReason::Singular } else { LinearReason::NotSolved };
        let words = if is_exact {
            format!(
                "the tangent is singular within rounding: its factors ({kind}) leave {left:.1e} of the \
                 residual"
            )
        } else {
            format!(
                "-ksp_type preonly applies the preconditioner {kind} once, which leaves {left:.1e} of the \
                 residual: an iterative preconditioner needs -ksp_type cg or gmres"
            )
        };
        Ok(LinearFailure { reason, words, iterations: 1, residual, mumps })
    }

    fn preconditioner_words(self) -> Result<String> {
        let (pc, mut reason) = (self.pc()?, 0);
        // SAFETY: a valid preconditioner.
        check(unsafe { ffi::PCGetFailedReason(pc, &mut reason) }, "PCGetFailedReason")?;
        let words = match reason {
            ffi::PC_FACTOR_STRUCT_ZEROPIVOT => "the tangent is singular (by its pattern)",
            ffi::PC_FACTOR_NUMERIC_ZEROPIVOT => "the tangent is singular (zero pivot)",
            ffi::PC_FACTOR_OUTMEMORY => "not enough memory for the factors",
            ffi::PC_FACTOR_OTHER => "the factorisation failed",
            ffi::PC_SUBPC_ERROR => "a part of the preconditioner failed",
            ffi::PC_INCONSISTENT_RHS => "the right-hand side does not fit a singular tangent",
            _ => "it could not be set up",
        };
        let kind = self.pc_type_name()?;
        let mumps = match (self.mumps_infog(1)?, self.mumps_infog(2)?) {
            (Some(first), Some(second)) if first < 0 => {
                format!("; MUMPS INFOG(1) = {first}, INFOG(2) = {second}: {}", mumps_words(first))
            }
            _ => String::new(),
        };
        Ok(format!("{words} ({kind}{mumps})"))
    }
}

/// MUMPS's error codes (MUMPS 5.5 users' guide, section 8).
pub(in crate::petsc) fn mumps_words(infog: i32) -> &'static str {
    match infog {
        -6 => "the matrix is structurally singular; INFOG(2) is its rank",
        -10 => "the matrix is numerically singular; INFOG(2) pivots were found",
        -8 | -9 | -14 | -15 | -17 | -20 => {
            "a work array is too small: raise -mat_mumps_icntl_14 (percent of extra space)"
        }
        -5 | -7 | -13 => {
            "memory could not be had; INFOG(2) is the size (if negative, in millions): use more \
             nodes, or an iterative solver"
        }
        -19 => "the limit of memory in -mat_mumps_icntl_23 is too low",
        -40 => "the matrix is not positive definite",
        -90 => "an error in out-of-core files",
        _ => "see the users' guide of MUMPS, section on error codes",
    }
}
