//! The linear solver inside a Newton correction: its set-up, and its failures in words.

#![allow(unsafe_code)]

use super::error::{check, forget, text};
use super::ffi;
use super::vector::{ReadView, WriteView};
use crate::error::{Error, Result};
use std::fmt;
use std::ptr;

/// Reduction of the residual of further systems.
const FURTHER: f64 = 1e-12;

/// Options of PETSc (name without the dash and the prefix, value) that hold where the user has not
/// set the same option.
#[derive(Debug, Clone, Default)]
pub struct KspSetup {
    /// In the order in which they are set.
    pub options: Vec<(String, String)>,
}

impl KspSetup {
    /// A set-up from names and values; an empty value for a flag.
    pub fn new(options: &[(&str, &str)]) -> Self {
        let owned = |&(name, value): &(&str, &str)| (name.to_string(), value.to_string());
        KspSetup { options: options.iter().map(owned).collect() }
    }
}

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

/// The linear solver of a `Snes`, borrowed from it.
#[derive(Clone, Copy)]
pub(super) struct Ksp {
    /// A valid solver for as long as the `Snes` that made this.
    raw: ffi::KSP,
}

impl Ksp {
    /// # Safety
    /// `snes` is a valid solver, and outlives what is returned.
    pub(super) unsafe fn of(snes: ffi::SNES) -> Result<Self> {
        let mut raw = ptr::null_mut();
        // SAFETY: valid by the contract.
        check(unsafe { ffi::SNESGetKSP(snes, &mut raw) }, "SNESGetKSP")?;
        Ok(Ksp { raw })
    }

    pub(super) fn pc(self) -> Result<ffi::PC> {
        let mut pc = ptr::null_mut();
        // SAFETY: a valid solver.
        check(unsafe { ffi::KSPGetPC(self.raw, &mut pc) }, "KSPGetPC")?;
        Ok(pc)
    }

    /// Sets the tolerances of the next solve; `None` leaves what the options say.
    pub(super) fn set_tolerances(self, relative: Option<f64>, absolute: Option<f64>) -> Result<()> {
        let keep = f64::from(ffi::PETSC_DEFAULT);
        let (relative, absolute) = (relative.unwrap_or(keep), absolute.unwrap_or(keep));
        let iterations = ffi::PETSC_DEFAULT;
        // SAFETY: a valid solver; PETSc checks the values.
        let code = unsafe { ffi::KSPSetTolerances(self.raw, relative, absolute, keep, iterations) };
        check(code, "KSPSetTolerances")
    }

    /// Relative and absolute tolerance of the residual.
    pub(super) fn tolerances(self) -> Result<(f64, f64)> {
        let (mut relative, mut absolute, mut divergence, mut iterations) = (0.0, 0.0, 0.0, 0);
        // SAFETY: a valid solver and places for its four numbers.
        let code = unsafe {
            ffi::KSPGetTolerances(
                self.raw,
                &mut relative,
                &mut absolute,
                &mut divergence,
                &mut iterations,
            )
        };
        check(code, "KSPGetTolerances")?;
        Ok((relative, absolute))
    }

    /// Whether the solver iterates, and not only applies its preconditioner.
    pub(super) fn is_iterative(self) -> Result<bool> {
        Ok(self.type_name()? != "preonly")
    }

    /// Makes the solve start from what its solution vector holds.
    pub(super) fn start_from_guess(self) -> Result<()> {
        // SAFETY: a valid solver.
        let code = unsafe { ffi::KSPSetInitialGuessNonzero(self.raw, ffi::PETSC_TRUE) };
        check(code, "KSPSetInitialGuessNonzero")
    }

    /// The solver for calls of PETSc.
    pub(super) fn raw(self) -> ffi::KSP {
        self.raw
    }

    /// Solves one more system with the operators of the last solve, without the callbacks of the
    /// Newton solver, which are to be set again afterwards. Where conjugate gradients meet an
    /// indefinite matrix, GMRES takes their place from then on. Collective.
    ///
    /// # Safety
    /// `like` is a valid vector of the layout of the solution.
    ///
    /// # Errors
    /// `Numerics` when the solve fails, `System` when PETSc does.
    pub(super) unsafe fn solve_alone(
        self,
        like: ffi::Vec,
        rhs: &[f64],
        solution: &mut [f64],
    ) -> Result<()> {
        let mut test = ptr::null_mut();
        // SAFETY: a valid solver and a place for the context of PETSc's own test, which the solver
        // then owns.
        unsafe {
            check(ffi::KSPSetPreSolve(self.raw, None, ptr::null_mut()), "KSPSetPreSolve")?;
            check(ffi::KSPConvergedDefaultCreate(&mut test), "KSPConvergedDefaultCreate")?;
            let (usual, forget) = (ffi::KSPConvergedDefault, ffi::KSPConvergedDefaultDestroy);
            let code = ffi::KSPSetConvergenceTest(self.raw, Some(usual), test, Some(forget));
            check(code, "KSPSetConvergenceTest")?;
            let code = ffi::KSPSetInitialGuessNonzero(self.raw, ffi::PETSC_FALSE);
            check(code, "KSPSetInitialGuessNonzero")?;
        }
        self.set_tolerances(Some(FURTHER), Some(0.0))?;
        let [mut b, mut x] = [ptr::null_mut(); 2];
        // SAFETY: a valid vector by the contract.
        check(unsafe { ffi::VecDuplicate(like, &mut b) }, "VecDuplicate")?;
        // SAFETY: as above.
        check(unsafe { ffi::VecDuplicate(like, &mut x) }, "VecDuplicate")?;
        let solved = self.solve_into(b, x, rhs, solution);
        // SAFETY: two valid vectors, destroyed once.
        unsafe {
            ffi::VecDestroy(&mut b);
            ffi::VecDestroy(&mut x);
        }
        solved
    }

    fn solve_into(self, b: ffi::Vec, x: ffi::Vec, rhs: &[f64], solution: &mut [f64]) -> Result<()> {
        // SAFETY: a valid vector that nothing else uses.
        unsafe { WriteView::new(b) }?.copy_from_slice(rhs);
        loop {
            // SAFETY: a valid solver with operators, and two different valid vectors.
            check(unsafe { ffi::KSPSolve(self.raw, b, x) }, "KSPSolve")?;
            let Some(failure) = self.failure()? else { break };
            let indefinite = matches!(
                failure.reason,
                LinearReason::IndefiniteMatrix | LinearReason::IndefinitePreconditioner
            );
            if !(indefinite && self.type_name()? == "cg") {
                return Err(Error::Numerics(format!(
                    "the linear solver failed: {}",
                    failure.words
                )));
            }
            // SAFETY: a valid solver and the name of a type.
            check(unsafe { ffi::KSPSetType(self.raw, c"gmres".as_ptr()) }, "KSPSetType")?;
        }
        // SAFETY: a valid vector that nothing else uses.
        solution.copy_from_slice(&unsafe { ReadView::new(x) }?);
        Ok(())
    }

    /// Forgets preconditioner and factors; the options stay.
    pub(super) fn reset(self) -> Result<()> {
        // SAFETY: a valid solver; SNES gives it its matrix again before the next solve.
        check(unsafe { ffi::KSPReset(self.raw) }, "KSPReset")
    }

    pub(super) fn iterations(self) -> Result<usize> {
        let mut n = 0;
        // SAFETY: a valid solver.
        let code = unsafe { ffi::KSPGetIterationNumber(self.raw, &mut n) };
        check(code, "KSPGetIterationNumber")?;
        Ok(usize::try_from(n).unwrap_or(0))
    }

    pub(super) fn type_name(self) -> Result<String> {
        let mut name = ptr::null();
        // SAFETY: a valid solver.
        check(unsafe { ffi::KSPGetType(self.raw, &mut name) }, "KSPGetType")?;
        // SAFETY: PETSc's own string, or null before a type is set.
        Ok(unsafe { text(name) })
    }

    pub(super) fn pc_type_name(self) -> Result<String> {
        let (pc, mut name) = (self.pc()?, ptr::null());
        // SAFETY: the valid preconditioner of a valid solver.
        check(unsafe { ffi::PCGetType(pc, &mut name) }, "PCGetType")?;
        // SAFETY: PETSc's own string, or null before a type is set.
        Ok(unsafe { text(name) })
    }

    /// `INFOG(i)` of MUMPS; `None` when the preconditioner is no factor by MUMPS.
    pub(super) fn mumps_infog(self, i: i32) -> Result<Option<i32>> {
        if !matches!(self.pc_type_name()?.as_str(), "lu" | "cholesky") {
            return Ok(None);
        }
        let (pc, mut package) = (self.pc()?, ptr::null());
        // SAFETY: a valid preconditioner that factors.
        let code = unsafe { ffi::PCFactorGetMatSolverType(pc, &mut package) };
        check(code, "PCFactorGetMatSolverType")?;
        // SAFETY: PETSc's own string, or null.
        if unsafe { text(package) } != "mumps" {
            return Ok(None);
        }
        let mut factor = ptr::null_mut();
        // SAFETY: a valid preconditioner that factors.
        let code = unsafe { ffi::PCFactorGetMatrix(pc, &mut factor) };
        if code != 0 || factor.is_null() {
            // There is no factor yet.
            forget();
            return Ok(None);
        }
        let mut value = 0;
        // SAFETY: a factor by MUMPS, which PETSc checks once more.
        let code = unsafe { ffi::MatMumpsGetInfog(factor, i, &mut value) };
        check(code, "MatMumpsGetInfog")?;
        Ok(Some(value))
    }

    /// How the last solve failed, if it did.
    pub(super) fn failure(self) -> Result<Option<LinearFailure>> {
        let (mut code, mut residual) = (0, 0.0);
        // SAFETY: a valid solver.
        let status = unsafe { ffi::KSPGetConvergedReason(self.raw, &mut code) };
        check(status, "KSPGetConvergedReason")?;
        if code >= 0 {
            return Ok(None);
        }
        // SAFETY: a valid solver.
        let status = unsafe { ffi::KSPGetResidualNorm(self.raw, &mut residual) };
        check(status, "KSPGetResidualNorm")?;
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
fn mumps_words(infog: i32) -> &'static str {
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
