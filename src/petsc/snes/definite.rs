//! What an indefinite tangent is preconditioned by.

#![allow(unsafe_code)]

use super::super::error::check;
use super::super::linear::Ksp;
use super::super::{Matrix, ffi};
use super::system::{NonlinearSystem, TangentChange};
use crate::error::Result;
use std::ptr;

/// A copy of the tangent that is positive definite, where a system makes one: algebraic multigrid
/// understands nothing else.
#[derive(Default)]
pub(super) struct Definite {
    copy: Option<Matrix>,
    /// Whether the preconditioner is made of it.
    is_used: bool,
    /// Whether the copy is the tangent itself, whose operator has no entries, to be eliminated.
    is_eliminated: bool,
}

impl Definite {
    /// The matrix for the preconditioner of `ksp`, which is built again, after `system` has written
    /// its tangent into `matrix`. Collective.
    ///
    /// # Errors
    /// Those of the system; `System` when PETSc fails.
    pub(super) fn choose<S: NonlinearSystem>(
        &mut self,
        system: &mut S,
        matrix: &Matrix,
        ksp: Ksp,
    ) -> Result<ffi::Mat> {
        if let Some(copy) = self.copy.as_mut().filter(|_| self.is_eliminated) {
            system.write(copy)?;
            return Ok(copy.raw());
        }
        let serves = ksp.is_iterative()? && matches!(&*ksp.pc_type_name()?, "gamg" | "hypre");
        self.is_used = serves && system.softens();
        if self.is_used {
            let mut copy = match self.copy.take() {
                Some(copy) => copy,
                None => matrix.duplicate()?,
            };
            system.stiffen(&mut copy)?;
            self.copy = Some(copy);
        }
        Ok(self.or(matrix))
    }

    /// Whether the preconditioner is to be built again for a tangent that changed in this way.
    /// Local.
    pub(super) fn follows(&self, change: TangentChange) -> bool {
        match change {
            TangentChange::Unchanged => false,
            TangentChange::Changed => true,
            TangentChange::ChangedKeepPreconditioner => self.is_eliminated,
        }
    }

    /// From now on `copy` takes the entries of the tangent, and is factored. Local.
    pub(super) fn eliminate(&mut self, copy: Matrix) {
        *self = Self { copy: Some(copy), is_used: true, is_eliminated: true };
    }

    /// From now on the preconditioner is made of the tangent. Local.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    /// The matrix that was chosen last, `matrix` being the tangent. Local.
    pub(super) fn or(&self, matrix: &Matrix) -> ffi::Mat {
        self.copy.as_ref().filter(|_| self.is_used).unwrap_or(matrix).raw()
    }
}

/// Hands the matrix of the preconditioner to the linear solver, from the next correction on. Local.
///
/// # Safety
/// `snes` is a valid solver, `matrix` a valid matrix of its layout.
pub(super) unsafe fn precondition_by(snes: ffi::SNES, matrix: ffi::Mat) -> Result<()> {
    let (tangent, context) = (ptr::null_mut(), ptr::null_mut());
    // SAFETY: valid by the contract; null and none keep the tangent, its function and the context.
    check(unsafe { ffi::SNESSetJacobian(snes, tangent, matrix, None, context) }, "SNESSetJacobian")
}
