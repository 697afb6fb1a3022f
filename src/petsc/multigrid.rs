//! Geometric multigrid: levels of a hierarchy as PETSc's PCMG.

#![allow(unsafe_code)]

use super::error::check;
use super::linear::Ksp;
use super::vector::petsc_int;
use super::{Matrix, ffi};
use crate::error::Result;
use std::ptr;

/// One level, with the matrices that PCMG keeps references to.
pub struct MultigridLevel<'a> {
    /// The operator; none on the finest level, which has the matrix of the solver.
    pub matrix: Option<&'a Matrix>,
    /// From the next coarser level to this one; none on the coarsest.
    pub interpolation: Option<&'a Matrix>,
    /// Interval of the eigenvalues of the operator over its diagonal which the smoother damps.
    pub damped: [f64; 2],
}

impl Ksp {
    /// Makes the preconditioner a V-cycle over `levels`, coarsest first: Chebyshev iterations over
    /// the diagonal as smoother, elimination on the coarsest level. Options of the user override
    /// all but the levels themselves. Collective.
    pub(super) fn use_multigrid(self, levels: &[MultigridLevel<'_>]) -> Result<()> {
        let pc = self.pc()?;
        // SAFETY: a valid preconditioner and the name of a type.
        check(unsafe { ffi::PCSetType(pc, c"mg".as_ptr()) }, "PCSetType")?;
        let count = petsc_int(levels.len(), "levels")?;
        // SAFETY: as above; without communicators of their own the levels share that of the solver.
        check(unsafe { ffi::PCMGSetLevels(pc, count, ptr::null_mut()) }, "PCMGSetLevels")?;
        for (number, level) in (0..count).zip(levels) {
            let mut smoother = ptr::null_mut();
            // SAFETY: a multigrid preconditioner that has this level.
            let code = unsafe { ffi::PCMGGetSmoother(pc, number, &mut smoother) };
            check(code, "PCMGGetSmoother")?;
            if let Some(raw) = level.matrix.map(Matrix::raw) {
                // SAFETY: valid objects; the solver takes references to the matrix.
                check(unsafe { ffi::KSPSetOperators(smoother, raw, raw) }, "KSPSetOperators")?;
            }
            let Some(interpolation) = level.interpolation else { continue };
            // SAFETY: as above; PCMG takes a reference.
            let code = unsafe { ffi::PCMGSetInterpolation(pc, number, interpolation.raw()) };
            check(code, "PCMGSetInterpolation")?;
            // SAFETY: a valid solver and the name of a type.
            let code = unsafe { ffi::KSPSetType(smoother, c"chebyshev".as_ptr()) };
            check(code, "KSPSetType")?;
            let [low, high] = level.damped;
            // SAFETY: a solver of the right type.
            let code = unsafe { ffi::KSPChebyshevSetEigenvalues(smoother, high, low) };
            check(code, "KSPChebyshevSetEigenvalues")?;
            let mut jacobi = ptr::null_mut();
            // SAFETY: a valid solver.
            check(unsafe { ffi::KSPGetPC(smoother, &mut jacobi) }, "KSPGetPC")?;
            // SAFETY: a valid preconditioner and the name of a type.
            check(unsafe { ffi::PCSetType(jacobi, c"jacobi".as_ptr()) }, "PCSetType")?;
        }
        Ok(())
    }
}
