//! The tangent at an accepted state and what the solver has to precondition it, for tests of
//! stability.

#![allow(unsafe_code)]

use super::super::error::check;
use super::super::linear::mumps_words;
use super::super::{Vector, ffi};
use super::{NonlinearSystem, Snes, TangentChange};
use crate::error::{Error, Result};
use std::ptr;

/// Iterations of a further solve, and what may be left of its residual.
const MOST: usize = 200;
const REDUCTION: f64 = 1e-10;

/// The tangent at a state, with its preconditioner or factors.
pub struct TangentAt<'s> {
    snes: &'s mut Snes,
    from: Vector,
    to: Vector,
    /// Pivots below zero, where the tangent was factored: the number of negative eigenvalues.
    pub negative_pivots: Option<usize>,
}

impl Snes {
    /// Sets up the tangent of `system` at `x`, the state it evaluated last. Collective.
    ///
    /// # Errors
    /// Those of the system; `Numerics` when the set-up fails; `System` when PETSc fails.
    pub fn tangent_at<S: NonlinearSystem>(
        &mut self,
        system: &mut S,
        x: &[f64],
    ) -> Result<TangentAt<'_>> {
        let change = system.tangent(x, &mut self.matrix)?;
        self.set_up_for(system, change)
    }

    /// As [`Snes::set_up`], where the matrix is the tangent of `system`. Collective.
    ///
    /// # Errors
    /// As [`Snes::tangent_at`].
    pub fn set_up_for<S: NonlinearSystem>(
        &mut self,
        system: &mut S,
        change: TangentChange,
    ) -> Result<TangentAt<'_>> {
        if self.definite.follows(change) {
            self.definite.choose(system, &self.matrix, self.ksp)?;
        }
        self.set_up(change)
    }

    /// Sets up the preconditioner or the factors of the matrix as it is, after a `change` of it.
    /// Collective.
    ///
    /// # Errors
    /// `Numerics` when the set-up fails; `System` when PETSc fails.
    pub fn set_up(&mut self, change: TangentChange) -> Result<TangentAt<'_>> {
        let (ksp, matrix) = (self.ksp.raw(), self.matrix.raw());
        let keep = change == TangentChange::Unchanged
            || change == TangentChange::ChangedKeepPreconditioner && self.ksp.is_iterative()?;
        let keep = if keep { ffi::PETSC_TRUE } else { ffi::PETSC_FALSE };
        // SAFETY: a valid solver and its own matrix.
        unsafe {
            let of = self.definite.or(&self.matrix);
            check(ffi::KSPSetOperators(ksp, matrix, of), "KSPSetOperators")?;
            check(ffi::KSPSetReusePreconditioner(ksp, keep), "KSPSetReusePreconditioner")?;
        }
        self.factor()?;
        let negative_pivots = self.negative_pivots()?;
        let from = self.residual.duplicate()?;
        let to = self.residual.duplicate()?;
        Ok(TangentAt { snes: self, from, to, negative_pivots })
    }

    fn negative_pivots(&self) -> Result<Option<usize>> {
        self.ksp.negative_pivots(self.petsc.comm().size())
    }

    /// Builds the preconditioner or the factors of the operators that are set. Collective.
    fn factor(&self) -> Result<()> {
        // SAFETY: a valid solver with operators.
        let code = unsafe { ffi::KSPSetUp(self.ksp.raw()) };
        self.petsc.comm().agree(check(code, "KSPSetUp"))?;
        if let Some(infog) = self.ksp.mumps_infog(1)?.filter(|infog| *infog < 0) {
            return Err(Error::Numerics(format!(
                "the tangent could not be factored: MUMPS INFOG(1) = {infog}: {}",
                mumps_words(infog)
            )));
        }
        Ok(())
    }

    /// Applies the preconditioner or the factors that [`Snes::set_up`] has made. Collective.
    ///
    /// # Errors
    /// `Bug` when a length does not fit; `System` when PETSc fails.
    pub fn apply_preconditioner(&self, from: &Vector, to: &mut Vector) -> Result<()> {
        let rows = self.matrix.owned_rows();
        if from.owned() != rows || to.owned() != rows {
            return Err(Error::Bug(format!("a preconditioner of {rows} rows for other vectors")));
        }
        let pc = self.ksp.pc()?;
        // SAFETY: a preconditioner that is set up, and two different valid vectors of its layout.
        check(unsafe { ffi::PCApply(pc, from.raw(), to.raw()) }, "PCApply")
    }
}

impl TangentAt<'_> {
    /// Eigenvalues below -`bound`, where the tangent is factored and pivots are counted: the pivots
    /// below zero of the tangent with `bound` added to its diagonal. Motions that nothing resists,
    /// whose pivots are rounding of either sign, do not count. Collective.
    ///
    /// # Errors
    /// `Numerics` when the set-up fails; `System` when PETSc fails.
    pub fn eigenvalues_below(&mut self, bound: f64) -> Result<Option<usize>> {
        if self.negative_pivots.is_none() {
            return Ok(None);
        }
        let (ksp, matrix) = (self.snes.ksp.raw(), self.snes.matrix.raw());
        let of = self.snes.definite.or(&self.snes.matrix);
        let mut shifted = ptr::null_mut();
        // SAFETY: a valid matrix; the copy is destroyed once, the solver holds a reference of its
        // own.
        unsafe {
            let code = ffi::MatDuplicate(of, ffi::MAT_COPY_VALUES, &mut shifted);
            check(code, "MatDuplicate")?;
            check(ffi::MatShift(shifted, bound), "MatShift")?;
            check(ffi::KSPSetOperators(ksp, shifted, shifted), "KSPSetOperators")?;
            let code = ffi::KSPSetReusePreconditioner(ksp, ffi::PETSC_FALSE);
            check(code, "KSPSetReusePreconditioner")?;
            check(ffi::MatDestroy(&mut shifted), "MatDestroy")?;
        }
        let counted = self.snes.factor().and_then(|()| self.snes.negative_pivots());
        // SAFETY: a valid solver and its own matrix.
        check(unsafe { ffi::KSPSetOperators(ksp, matrix, of) }, "KSPSetOperators")?;
        self.snes.factor()?;
        counted
    }

    /// The product with the tangent; owned entries. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn multiply(&mut self, x: &[f64]) -> Result<Vec<f64>> {
        self.from.write()?.copy_from_slice(x);
        self.snes.matrix.multiply(&self.from, &mut self.to)?;
        Ok(self.to.read()?.to_vec())
    }

    /// Solves with the tangent by conjugate gradients, as far as it is positive definite and that
    /// leads: with factors in one iteration. Owned entries. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn solve(&mut self, rhs: &[f64], solution: &mut [f64]) -> Result<()> {
        let comm = self.snes.petsc.comm().clone();
        let product = |a: &[f64], b: &[f64]| {
            let mut sum = [a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>()];
            comm.sum(&mut sum);
            sum[0]
        };
        solution.fill(0.0);
        let (mut r, start) = (rhs.to_vec(), product(rhs, rhs));
        let mut z = self.precondition(&r)?;
        let (mut p, mut size) = (z.clone(), product(&r, &z));
        for _ in 0..MOST {
            let image = self.multiply(&p)?;
            let step = size / product(&p, &image);
            if !(step.is_finite() && step > 0.0) {
                break;
            }
            solution.iter_mut().zip(&p).for_each(|(x, p)| *x += step * p);
            r.iter_mut().zip(&image).for_each(|(r, image)| *r -= step * image);
            if product(&r, &r) <= REDUCTION * REDUCTION * start {
                break;
            }
            z = self.precondition(&r)?;
            let before = std::mem::replace(&mut size, product(&r, &z));
            p.iter_mut().zip(&z).for_each(|(p, z)| *p = z + size / before * *p);
        }
        Ok(())
    }

    /// Applies the preconditioner or the factors; owned entries. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn precondition(&mut self, r: &[f64]) -> Result<Vec<f64>> {
        self.from.write()?.copy_from_slice(r);
        self.snes.apply_preconditioner(&self.from, &mut self.to)?;
        Ok(self.to.read()?.to_vec())
    }
}
