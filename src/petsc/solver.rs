//! A linear solver by itself.

#![allow(unsafe_code)]

use super::error::{c_string, check};
use super::{Matrix, Petsc, Vector, ffi};
use crate::error::Result;
use std::cell::RefCell;
use std::ptr;

/// A solver for one matrix, whose set-up follows the values of the matrix.
pub struct LinearSolver {
    /// A valid solver until drop, with a reference to the matrix.
    raw: ffi::KSP,
    /// Right-hand side and solution.
    vectors: RefCell<[Vector; 2]>,
    /// PETSc outlives its objects.
    _petsc: Petsc,
}

impl LinearSolver {
    /// For `matrix`, as the options under `prefix` say. Collective.
    ///
    /// # Errors
    /// `System` when an option has a wrong value or PETSc fails.
    pub fn new(petsc: &Petsc, prefix: &str, matrix: &Matrix) -> Result<Self> {
        let vector = || Vector::new(petsc, matrix.owned_rows(), matrix.block_size());
        let vectors = RefCell::new([vector()?, vector()?]);
        let (mut raw, prefix) = (ptr::null_mut(), c_string(prefix)?);
        // SAFETY: PETSc is initialised and the communicator is alive.
        check(unsafe { ffi::KSPCreate(petsc.comm().raw(), &mut raw) }, "KSPCreate")?;
        let solver = Self { raw, vectors, _petsc: petsc.clone() };
        let matrix = matrix.raw();
        // SAFETY: a valid solver and a matrix to which it keeps a reference; the prefix is copied.
        unsafe {
            check(ffi::KSPSetOptionsPrefix(raw, prefix.as_ptr()), "KSPSetOptionsPrefix")?;
            check(ffi::KSPSetOperators(raw, matrix, matrix), "KSPSetOperators")?;
            check(ffi::KSPSetFromOptions(raw), "KSPSetFromOptions")?;
        }
        Ok(solver)
    }

    /// x = A^-1 b at owned entries, in single precision; not a number where the solve failed.
    /// Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn solve(&self, b: &[f32], x: &mut [f32]) -> Result<()> {
        let [rhs, solution] = &mut *self.vectors.borrow_mut();
        rhs.write()?.iter_mut().zip(b).for_each(|(to, b)| *to = f64::from(*b));
        // SAFETY: a valid solver with its matrix, and two different valid vectors that fit it.
        check(unsafe { ffi::KSPSolve(self.raw, rhs.raw(), solution.raw()) }, "KSPSolve")?;
        let mut reason = 0;
        // SAFETY: a valid solver.
        let code = unsafe { ffi::KSPGetConvergedReason(self.raw, &mut reason) };
        check(code, "KSPGetConvergedReason")?;
        if reason < 0 {
            x.fill(f32::NAN);
            return Ok(());
        }
        x.iter_mut().zip(&*solution.read()?).for_each(|(x, from)| *x = *from as f32);
        Ok(())
    }
}

impl Drop for LinearSolver {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            // SAFETY: a valid solver, destroyed once.
            unsafe { ffi::KSPDestroy(&mut self.raw) };
        }
    }
}
