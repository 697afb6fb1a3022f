//! Geometric multigrid: levels of a hierarchy as PETSc's PCMG.

#![allow(unsafe_code)]

use super::error::{check, text};
use super::linear::Ksp;
use super::vector::petsc_int;
use super::{Matrix, Petsc, ffi};
use crate::error::Result;
use std::ptr;

/// One level, with the matrices that PCMG keeps references to.
pub struct MultigridLevel<'a> {
    /// The operator; none on the finest level, which has the matrix of the solver.
    pub matrix: Option<&'a Matrix>,
    /// From the next coarser level to this one; none on the coarsest.
    pub interpolation: Option<&'a Matrix>,
}

/// The smoother of one level.
pub struct Smoother {
    /// A valid solver, which this holds a reference to.
    raw: ffi::KSP,
    /// Whether options fix its interval.
    fixed: bool,
    /// PETSc outlives its objects.
    _petsc: Petsc,
}

impl Smoother {
    /// Makes it damp the eigenvalues of this interval, unless options of the user say otherwise.
    /// Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn damp(&self, [low, high]: [f64; 2]) -> Result<()> {
        let mut name = ptr::null();
        // SAFETY: a valid solver.
        check(unsafe { ffi::KSPGetType(self.raw, &mut name) }, "KSPGetType")?;
        // SAFETY: PETSc's own string, or null before a type is set.
        if self.fixed || unsafe { text(name) } != "chebyshev" {
            return Ok(());
        }
        // SAFETY: a solver of the right type.
        let code = unsafe { ffi::KSPChebyshevSetEigenvalues(self.raw, high, low) };
        check(code, "KSPChebyshevSetEigenvalues")
    }
}

impl Drop for Smoother {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            // SAFETY: the reference that was taken is given back once.
            unsafe { ffi::KSPDestroy(&mut self.raw) };
        }
    }
}

impl Ksp {
    /// The smoothers of the multigrid preconditioner, from the level above the coarsest. Local.
    pub(super) fn smoothers(self, petsc: &Petsc, prefix: &str) -> Result<Vec<Smoother>> {
        let (pc, mut levels) = (self.pc()?, 0);
        // SAFETY: a valid preconditioner.
        check(unsafe { ffi::PCMGGetLevels(pc, &mut levels) }, "PCMGGetLevels")?;
        let option = format!("{prefix}mg_levels_ksp_chebyshev_eigenvalues");
        let fixed = petsc.has_option(&option)?;
        let smoother = |level| {
            let mut raw = ptr::null_mut();
            // SAFETY: a multigrid preconditioner that has this level.
            check(unsafe { ffi::PCMGGetSmoother(pc, level, &mut raw) }, "PCMGGetSmoother")?;
            // SAFETY: a valid object of PETSc.
            let code = unsafe { ffi::PetscObjectReference(raw.cast()) };
            check(code, "PetscObjectReference")?;
            Ok(Smoother { raw, fixed, _petsc: petsc.clone() })
        };
        (1..levels).map(smoother).collect()
    }

    /// Makes the preconditioner a V-cycle over `levels`, coarsest first: Chebyshev iterations over
    /// the diagonal as smoother (their interval is set by [`Smoother::damp`]), elimination on the
    /// coarsest level. Options of the user override all but the levels themselves. Collective.
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
            let mut jacobi = ptr::null_mut();
            // SAFETY: a valid solver.
            check(unsafe { ffi::KSPGetPC(smoother, &mut jacobi) }, "KSPGetPC")?;
            // SAFETY: a valid preconditioner and the name of a type.
            check(unsafe { ffi::PCSetType(jacobi, c"jacobi".as_ptr()) }, "PCSetType")?;
        }
        Ok(())
    }
}
