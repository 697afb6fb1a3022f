//! How a nonlinear solve ended.

use crate::petsc::{LinearFailure, ffi};
use std::fmt;

/// Why a nonlinear solve ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SnesReason {
    /// The system's verdict was `Converged`.
    Converged,
    /// The system's verdict was `Diverged`.
    Stopped,
    /// A linear solve failed; the report says how.
    LinearSolve,
    /// The residual is not a number.
    NotANumber,
    /// The limit of corrections was reached (`-snes_max_it`).
    Iterations,
    /// The line search found no better state.
    LineSearch,
    /// Another reason of PETSc that means convergence.
    ConvergedOther(i32),
    /// Another reason of PETSc that means failure.
    Other(i32),
}

impl SnesReason {
    pub(super) fn from_code(code: ffi::SNESConvergedReason, stopped: bool) -> Self {
        match code {
            _ if stopped => SnesReason::Stopped,
            ffi::SNES_CONVERGED_FNORM_ABS => SnesReason::Converged,
            ffi::SNES_DIVERGED_LINEAR_SOLVE => SnesReason::LinearSolve,
            ffi::SNES_DIVERGED_FNORM_NAN => SnesReason::NotANumber,
            ffi::SNES_DIVERGED_MAX_IT | ffi::SNES_DIVERGED_FUNCTION_COUNT => SnesReason::Iterations,
            ffi::SNES_DIVERGED_LINE_SEARCH | ffi::SNES_DIVERGED_LOCAL_MIN => SnesReason::LineSearch,
            code if code > 0 => SnesReason::ConvergedOther(code),
            code => SnesReason::Other(code),
        }
    }

    /// Whether the last state is a solution.
    pub fn is_converged(self) -> bool {
        matches!(self, SnesReason::Converged | SnesReason::ConvergedOther(_))
    }
}

impl fmt::Display for SnesReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            SnesReason::Converged => "converged",
            SnesReason::Stopped => "stopped by the test of convergence",
            SnesReason::LinearSolve => "the linear solve failed",
            SnesReason::NotANumber => "the residual is not a number",
            SnesReason::Iterations => "the limit of iterations was reached",
            SnesReason::LineSearch => "the line search found no better state",
            SnesReason::ConvergedOther(code) => return write!(f, "converged (reason {code})"),
            SnesReason::Other(code) => return write!(f, "PETSc's reason {code}"),
        })
    }
}

/// The end of a nonlinear solve.
#[derive(Debug, Clone, PartialEq)]
pub struct SolveReport {
    /// Why it ended.
    pub reason: SnesReason,
    /// Corrections made.
    pub iterations: usize,
    /// Iterations of all linear solves.
    pub linear_iterations: usize,
    /// The linear solve that failed, when that was the reason.
    pub failing_linear: Option<LinearFailure>,
    /// Most negative pivots that MUMPS met in L D L^T of a tangent; above 0 it was indefinite.
    /// `None` where a tangent was eliminated without their count.
    pub negative_pivots: Option<usize>,
}

impl SolveReport {
    /// The reason in words, with that of the linear solve.
    pub fn words(&self) -> String {
        match &self.failing_linear {
            Some(linear) => format!("{}: {}", self.reason, linear.words),
            None => self.reason.to_string(),
        }
    }
}
