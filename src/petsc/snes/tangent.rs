//! The tangent at an accepted state and what the solver has to precondition it, for tests of
//! stability.

#![allow(unsafe_code)]

use super::super::error::check;
use super::super::{Vector, ffi};
use super::{NonlinearSystem, Snes, TangentChange};
use crate::error::{Error, Result};

/// The tangent at a state, with its preconditioner or factors.
pub struct TangentAt<'s> {
    snes: &'s Snes,
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
            check(ffi::KSPSetOperators(ksp, matrix, matrix), "KSPSetOperators")?;
            check(ffi::KSPSetReusePreconditioner(ksp, keep), "KSPSetReusePreconditioner")?;
            check(ffi::KSPSetUp(ksp), "KSPSetUp")?;
        }
        if let Some(infog) = self.ksp.mumps_infog(1)?.filter(|infog| *infog < 0) {
            return Err(Error::Numerics(format!(
                "the tangent could not be factored: MUMPS INFOG(1) = {infog}"
            )));
        }
        // INFOG(12) of L D L^T: pivots below zero.
        let factored = self.ksp.pc_type_name()? == "cholesky";
        let pivots = if factored { self.ksp.mumps_infog(12)? } else { None };
        let negative_pivots = pivots.map(|n| usize::try_from(n).unwrap_or(0));
        let from = self.residual.duplicate()?;
        let to = self.residual.duplicate()?;
        Ok(TangentAt { snes: self, from, to, negative_pivots })
    }

    /// Gives MUMPS several times as much work space from now on where `INFOG(1)` says that it had too
    /// little, unless the user has said how much or it has it already. Tells whether it did. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn give_more_work_space(&mut self, infog: Option<i32>) -> Result<bool> {
        let name = format!("{}mat_mumps_icntl_14", self.prefix);
        let short = matches!(infog, Some(-8 | -9 | -14 | -15 | -17 | -20));
        if !short || !self.defaults.contains(&name) || self.more_work_space {
            return Ok(false);
        }
        self.more_work_space = true;
        self.petsc.set_option(&name, "500")?;
        Ok(true)
    }

    /// Forgets preconditioner and factors: MUMPS refuses to use a factor again after a failure.
    /// Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn forget_factors(&mut self) -> Result<()> {
        self.ksp.reset()
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
    /// The product with the tangent; owned entries. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn multiply(&mut self, x: &[f64]) -> Result<Vec<f64>> {
        self.from.write()?.copy_from_slice(x);
        self.snes.matrix.multiply(&self.from, &mut self.to)?;
        Ok(self.to.read()?.to_vec())
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
