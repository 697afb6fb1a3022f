//! The linear solver inside a Newton correction: its set-up, and its failures in words.

#![allow(unsafe_code)]

mod failure;
mod residual;

pub(super) use failure::mumps_words;
pub use failure::{LinearFailure, LinearReason};
pub(super) use residual::{WORTH, Watch};

use super::error::{c_string, check, forget, text};
use super::ffi;
use super::vector::{ReadView, WriteView};
use crate::comm::Comm;
use crate::error::{Error, Result};
use std::ptr;

/// Reduction of the residual of further systems.
const FURTHER: f64 = 1e-12;

/// Times that a further system is solved on from where a method believes it solved.
const MOST_AGAIN: usize = 3;

/// Vectors that GMRES keeps where it takes the place of conjugate gradients.
const RESTART: i32 = 200;

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

    /// The same with another value of an option.
    pub fn with(&self, name: &str, value: &str) -> Self {
        let mut setup = self.clone();
        setup.options.retain(|(other, _)| other != name);
        setup.options.push((name.to_string(), value.to_string()));
        setup
    }
}

/// Tolerances of a linear solve, on the 2-norm of the true residual.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearTolerance {
    /// Times the norm of the right-hand side; from 0 to below 1.
    pub relative: f64,
    /// In the unit of the residual.
    pub absolute: f64,
}

impl LinearTolerance {
    /// The norm below which a residual is small enough, for a right-hand side of norm `rhs`.
    pub(super) fn target(self, rhs: f64) -> f64 {
        self.absolute.max(self.relative * rhs)
    }
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
    pub(super) fn tolerances(self) -> Result<LinearTolerance> {
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
        Ok(LinearTolerance { relative, absolute })
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

    /// The method for a tangent that is not positive definite. A preconditioner of ours rounds to
    /// single precision: what GMRES adds up must be what it has applied. Local.
    pub(super) fn indefinite_method(self) -> Result<&'static str> {
        Ok(if self.pc_type_name()? == "shell" { "fgmres" } else { "gmres" })
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
        let mut norm = 0.0;
        // SAFETY: a valid vector.
        check(unsafe { ffi::VecNorm(b, ffi::NORM_2, &mut norm) }, "VecNorm")?;
        let mut again = 0;
        loop {
            // SAFETY: a valid solver with operators, and two different valid vectors.
            check(unsafe { ffi::KSPSolve(self.raw, b, x) }, "KSPSolve")?;
            let Some(failure) = self.failure()? else {
                // What a method adds up can part from the true residual: it goes on from there.
                if again == MOST_AGAIN
                    || !self.is_iterative()?
                    || self.is_solved(self.true_residual()?, norm)?
                {
                    break;
                }
                again += 1;
                self.start_from_guess()?;
                continue;
            };
            if self.serves(&failure, norm) {
                break;
            }
            if !(failure.is_indefinite() && self.type_name()? == "cg") {
                return Err(Error::Numerics(format!(
                    "the linear solver failed: {}",
                    failure.words
                )));
            }
            let method = c_string(self.indefinite_method()?)?;
            // SAFETY: a valid solver and the name of a type.
            check(unsafe { ffi::KSPSetType(self.raw, method.as_ptr()) }, "KSPSetType")?;
            // SAFETY: a valid solver, of the type for which this is meant.
            let code = unsafe { ffi::KSPGMRESSetRestart(self.raw, RESTART) };
            check(code, "KSPGMRESSetRestart")?;
        }
        self.refuse_what_is_left(norm)?;
        // SAFETY: a valid vector that nothing else uses.
        solution.copy_from_slice(&unsafe { ReadView::new(x) }?);
        Ok(())
    }

    /// A new linear solver in the place of that of `snes`, as the options of `prefix` say: in PETSc
    /// 3.18 a preconditioner of algebraic multigrid is not as new after `KSPReset`. Collective.
    ///
    /// # Safety
    /// `snes` is a valid solver, and outlives what is returned; the solver it had is used no more.
    pub(super) unsafe fn renewed(snes: ffi::SNES, comm: &Comm, prefix: &str) -> Result<Self> {
        let (mut raw, prefix) = (ptr::null_mut(), c_string(prefix)?);
        // SAFETY: PETSc is initialised and the communicator alive; a valid solver by the contract,
        // which takes a reference to the new one; PETSc copies the prefix.
        unsafe {
            check(ffi::KSPCreate(comm.raw(), &mut raw), "KSPCreate")?;
            check(ffi::KSPSetOptionsPrefix(raw, prefix.as_ptr()), "KSPSetOptionsPrefix")?;
            check(ffi::KSPSetFromOptions(raw), "KSPSetFromOptions")?;
            check(ffi::SNESSetKSP(snes, raw), "SNESSetKSP")?;
            check(ffi::KSPDestroy(&mut raw), "KSPDestroy")?;
            Self::of(snes)
        }
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

    /// Pivots below zero of L D L^T by MUMPS, the negative eigenvalues of the tangent; `None` where
    /// there is no such factor, or where several ranks factor the last part together (`ICNTL(13)`
    /// other than 1), whose pivots MUMPS does not count.
    pub(super) fn negative_pivots(self, ranks: i32) -> Result<Option<usize>> {
        if self.pc_type_name()? != "cholesky" {
            return Ok(None);
        }
        let Some(factor) = self.mumps_factor()? else { return Ok(None) };
        let mut together = 0;
        // SAFETY: a factor by MUMPS.
        let code = unsafe { ffi::MatMumpsGetIcntl(factor, 13, &mut together) };
        check(code, "MatMumpsGetIcntl")?;
        if ranks > 1 && together != 1 {
            return Ok(None);
        }
        // INFOG(12) of L D L^T: pivots below zero.
        Ok(self.mumps_infog(12)?.map(|n| usize::try_from(n).unwrap_or(0)))
    }

    /// `INFOG(i)` of MUMPS; `None` when the preconditioner is no factor by MUMPS.
    pub(super) fn mumps_infog(self, i: i32) -> Result<Option<i32>> {
        let Some(factor) = self.mumps_factor()? else { return Ok(None) };
        let mut value = 0;
        // SAFETY: a factor by MUMPS, which PETSc checks once more.
        let code = unsafe { ffi::MatMumpsGetInfog(factor, i, &mut value) };
        check(code, "MatMumpsGetInfog")?;
        Ok(Some(value))
    }

    /// The factor by MUMPS; `None` when the preconditioner is none.
    fn mumps_factor(self) -> Result<Option<ffi::Mat>> {
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
        Ok(Some(factor))
    }
}
