//! Newton's method: PETSc's SNES with the callbacks of a [`NonlinearSystem`].

#![allow(unsafe_code)]

mod again;
mod callbacks;
mod context;
mod definite;
mod ran;
mod report;
mod system;
mod tangent;

pub use ran::Ran;
pub use report::{SnesReason, SolveReport};
pub use system::{FurtherSolve, NonlinearSystem, TangentChange, Trial, Verdict};
pub use tangent::TangentAt;

use super::error::{c_string, check, forget};
use super::linear::{Ksp, KspSetup, LinearFailure};
use super::{Matrix, MultigridLevel, Petsc, Smoother, Vector, ffi};
use crate::error::{Error, Result};
use context::{Context, UserSet};
use definite::Definite;
use std::ffi::c_void;
use std::ptr;

/// Newton's method with full steps; options of PETSc choose another line search, monitors and the
/// linear solver.
pub struct Snes {
    /// A valid solver until drop.
    raw: ffi::SNES,
    matrix: Matrix,
    definite: Definite,
    residual: Vector,
    ksp: Ksp,
    /// Names of the options that this solver's set-up put into the database.
    defaults: Vec<String>,
    prefix: String,
    user: UserSet,
    /// Whether the last linear solve failed.
    failed: bool,
    /// Whether the preconditioner has levels that were given to it.
    has_levels: bool,
    /// Whether MUMPS has been given more work space.
    more_work_space: bool,
    petsc: Petsc,
}

impl Snes {
    /// A solver for systems whose tangent fits `matrix`, with the options of the user under
    /// `prefix` and those of `setup` where the user has none. Collective.
    ///
    /// The linear solver measures the unpreconditioned residual unless options say otherwise.
    ///
    /// # Errors
    /// `System` when an option has a wrong value or PETSc fails.
    pub fn new(petsc: &Petsc, prefix: &str, matrix: Matrix, setup: &KspSetup) -> Result<Self> {
        Self::with_levels(petsc, prefix, matrix, setup, &[])
    }

    /// As [`Snes::new`], preconditioned by multigrid over `levels`, coarsest first; the finest one
    /// has the solver's matrix. Collective.
    ///
    /// # Errors
    /// As [`Snes::new`].
    pub fn with_levels(
        petsc: &Petsc,
        prefix: &str,
        matrix: Matrix,
        setup: &KspSetup,
        levels: &[MultigridLevel<'_>],
    ) -> Result<Self> {
        let mut raw = ptr::null_mut();
        // SAFETY: PETSc is initialised and the communicator is alive.
        check(unsafe { ffi::SNESCreate(petsc.comm().raw(), &mut raw) }, "SNESCreate")?;
        let residual = Vector::new(matrix.petsc(), matrix.owned_rows(), matrix.block_size());
        // SAFETY: a valid solver, which the struct below owns together with what is returned.
        let ksp = unsafe { Ksp::of(raw) };
        let (residual, ksp) = match (residual, ksp) {
            (Ok(residual), Ok(ksp)) => (residual, ksp),
            (Err(error), _) | (_, Err(error)) => {
                // SAFETY: a valid solver, destroyed once.
                unsafe { ffi::SNESDestroy(&mut raw) };
                return Err(error);
            }
        };
        let (defaults, prefix) = (Vec::new(), prefix.to_string());
        let petsc = petsc.clone();
        let user = UserSet::default();
        let (failed, has_levels) = (false, !levels.is_empty());
        let more_work_space = false;
        let mut snes = Snes {
            raw,
            matrix,
            definite: Definite::default(),
            residual,
            ksp,
            defaults,
            prefix,
            user,
            failed,
            has_levels,
            more_work_space,
            petsc,
        };
        if has_levels {
            ksp.use_multigrid(levels)?;
        }
        snes.configure(setup)?;
        Ok(snes)
    }

    fn configure(&mut self, setup: &KspSetup) -> Result<()> {
        let norm = ("ksp_norm_type".to_string(), "unpreconditioned".to_string());
        for (name, value) in setup.options.iter().chain([&norm]) {
            self.set_unless_fixed(name, value)?;
        }
        let prefix = self.prefix.as_str();
        let fixed = |name: &str| -> Result<bool> {
            let name = format!("{prefix}{name}");
            Ok(!self.defaults.contains(&name) && self.petsc.has_option(&name)?)
        };
        self.user = UserSet {
            relative: fixed("ksp_rtol")?,
            absolute: fixed("ksp_atol")?,
            preconditioner: fixed("snes_lag_preconditioner")?,
        };

        let raw = self.raw;
        let prefix = c_string(prefix)?;
        // SAFETY: a valid solver; PETSc copies the prefix.
        let code = unsafe { ffi::SNESSetOptionsPrefix(raw, prefix.as_ptr()) };
        check(code, "SNESSetOptionsPrefix")?;
        // SAFETY: a valid solver and the name of a type.
        check(unsafe { ffi::SNESSetType(raw, c"newtonls".as_ptr()) }, "SNESSetType")?;
        let mut search = ptr::null_mut();
        // SAFETY: a valid solver.
        check(unsafe { ffi::SNESGetLineSearch(raw, &mut search) }, "SNESGetLineSearch")?;
        // SAFETY: the line search of a valid solver and the name of a type.
        let code = unsafe { ffi::SNESLineSearchSetType(search, c"basic".as_ptr()) };
        check(code, "SNESLineSearchSetType")?;
        // The verdict decides; the numbers of corrections and evaluations are not bounded here.
        // SAFETY: a valid solver.
        let code = unsafe { ffi::SNESSetTolerances(raw, 0.0, 0.0, 0.0, 10_000, -1) };
        check(code, "SNESSetTolerances")?;
        let matrix = self.matrix.raw();
        // SAFETY: a valid solver and matrix; `solve` sets the function before it is called.
        let code = unsafe { ffi::SNESSetJacobian(raw, matrix, matrix, None, ptr::null_mut()) };
        check(code, "SNESSetJacobian")?;
        // SAFETY: a valid solver.
        check(unsafe { ffi::SNESSetFromOptions(raw) }, "SNESSetFromOptions")
    }

    /// Sets an option that holds where the user has not set it, now or in the place of one that was
    /// set so before. Local, alike on all ranks.
    fn set_unless_fixed(&mut self, name: &str, value: &str) -> Result<()> {
        let name = format!("{}{name}", self.prefix);
        if self.defaults.contains(&name) {
            return self.petsc.set_option(&name, value);
        }
        if self.petsc.set_default(&name, value)? {
            self.defaults.push(name);
        }
        Ok(())
    }

    /// The preconditioner, for the other files of the fence. Local.
    pub(super) fn pc(&self) -> Result<ffi::PC> {
        self.ksp.pc()
    }

    /// PETSc, for objects of the same ranks. Local.
    pub fn petsc(&self) -> &Petsc {
        &self.petsc
    }

    /// The matrix of the tangent. Local.
    pub fn matrix(&self) -> &Matrix {
        &self.matrix
    }

    /// The matrix of the tangent, for its first assembly and its near null space. Local.
    pub fn matrix_mut(&mut self) -> &mut Matrix {
        &mut self.matrix
    }

    /// Solves f(x) = 0 from the start `x`, which becomes the last state. Collective.
    ///
    /// A solve that does not converge is no `Err`: the report says why.
    ///
    /// # Errors
    /// That of the callback which failed, unchanged, with `x` at the last accepted state; `Bug`
    /// when `x` does not fit; `System` when PETSc fails.
    pub fn solve<S: NonlinearSystem>(
        &mut self,
        system: &mut S,
        x: &mut Vector,
    ) -> Result<SolveReport> {
        if x.owned() != self.matrix.owned_rows() {
            return Err(Error::Bug(format!(
                "a start of {} entries for {} unknowns",
                x.owned(),
                self.matrix.owned_rows()
            )));
        }
        if std::mem::take(&mut self.failed) {
            // MUMPS refuses to use a factor again after a failure.
            self.forget_factors()?;
        }
        let ranks = self.petsc.comm().size();
        let (matrix, definite) = (&mut self.matrix, &mut self.definite);
        let mut context = Context::new(system, matrix, definite, self.ksp, ranks, self.user);
        let address = (&raw mut context).cast::<c_void>();
        // SAFETY: the context lives until `uninstall`, and only callbacks use it meanwhile.
        let installed = unsafe { install::<S>(self.raw, &self.residual, address) };
        let code = match &installed {
            // SAFETY: a valid solver with its callbacks set; no right-hand side.
            Ok(()) => unsafe { ffi::SNESSolve(self.raw, ptr::null_mut(), x.raw()) },
            Err(_) => 0,
        };
        // SAFETY: as above; a callback without a context does nothing but fail.
        let uninstalled = unsafe { install::<S>(self.raw, &self.residual, ptr::null_mut()) };
        let Context { error, stopped, negative_pivots, unsolved, .. } = context;
        if let Some(error) = error {
            // PETSc's own account of it says only that a callback failed.
            forget();
            return Err(error);
        }
        let solved = installed.and(check(code, "SNESSolve")).and(uninstalled);
        // What follows from the solve is decided by all ranks or none.
        self.petsc.comm().agree(solved)?;
        self.report(stopped, negative_pivots, unsolved)
    }

    fn report(
        &mut self,
        stopped: bool,
        negative_pivots: Option<usize>,
        unsolved: Option<LinearFailure>,
    ) -> Result<SolveReport> {
        let (mut code, mut iterations, mut linear) = (0, 0, 0);
        // SAFETY: a valid solver.
        let status = unsafe { ffi::SNESGetConvergedReason(self.raw, &mut code) };
        check(status, "SNESGetConvergedReason")?;
        // SAFETY: as above.
        let status = unsafe { ffi::SNESGetIterationNumber(self.raw, &mut iterations) };
        check(status, "SNESGetIterationNumber")?;
        // SAFETY: as above.
        let status = unsafe { ffi::SNESGetLinearSolveIterations(self.raw, &mut linear) };
        check(status, "SNESGetLinearSolveIterations")?;
        let reason = SnesReason::from_code(code, stopped);
        let failing_linear = match unsolved {
            None if reason == SnesReason::LinearSolve => self.ksp.failure()?,
            unsolved => unsolved,
        };
        self.failed = failing_linear.is_some();
        Ok(SolveReport {
            reason,
            iterations: usize::try_from(iterations).unwrap_or(0),
            linear_iterations: usize::try_from(linear).unwrap_or(0),
            failing_linear,
            negative_pivots,
        })
    }

    /// The smoothers of multigrid, from the level above the coarsest. Local.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn smoothers(&self) -> Result<Vec<Smoother>> {
        self.ksp.smoothers(&self.petsc, &self.prefix)
    }

    /// Iterations of the last linear solve. Local.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn last_linear_iterations(&self) -> Result<usize> {
        self.ksp.iterations()
    }

    /// The type of the linear solver, as PETSc names it (`cg`, `preonly`). Local.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn ksp_type(&self) -> Result<String> {
        self.ksp.type_name()
    }

    /// The type of the preconditioner, as PETSc names it (`cholesky`, `gamg`). Local.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn pc_type(&self) -> Result<String> {
        self.ksp.pc_type_name()
    }

    /// `INFOG(i)` of MUMPS (from 1); `None` when there is no factor by MUMPS. Local.
    pub fn mumps_infog(&self, i: i32) -> Option<i32> {
        self.ksp.mumps_infog(i).ok().flatten()
    }
}

impl Drop for Snes {
    fn drop(&mut self) {
        for name in &self.defaults {
            // A failure leaves an option behind, which is no reason to stop.
            let _ = self.petsc.clear_default(name);
        }
        if !std::thread::panicking() {
            // SAFETY: a valid solver, destroyed once; it holds references to matrix and vector.
            unsafe { ffi::SNESDestroy(&mut self.raw) };
        }
    }
}

/// Sets the callbacks and their context.
///
/// # Safety
/// `snes` is valid; `context` is null or a `Context<S>` that outlives every use of the solver
/// before the next call of this function.
unsafe fn install<S: NonlinearSystem>(
    snes: ffi::SNES,
    residual: &Vector,
    context: *mut c_void,
) -> Result<()> {
    let f = residual.raw();
    // SAFETY: valid objects and context by the contract.
    let code = unsafe { ffi::SNESSetFunction(snes, f, Some(callbacks::residual::<S>), context) };
    check(code, "SNESSetFunction")?;
    let none = ptr::null_mut();
    // SAFETY: as above; null matrices keep those that are set.
    let code =
        unsafe { ffi::SNESSetJacobian(snes, none, none, Some(callbacks::tangent::<S>), context) };
    check(code, "SNESSetJacobian")?;
    // SAFETY: as above; the context is not PETSc's to free.
    let code =
        unsafe { ffi::SNESSetConvergenceTest(snes, Some(callbacks::verdict::<S>), context, None) };
    check(code, "SNESSetConvergenceTest")?;
    let mut search = ptr::null_mut();
    // SAFETY: a valid solver.
    check(unsafe { ffi::SNESGetLineSearch(snes, &mut search) }, "SNESGetLineSearch")?;
    // SAFETY: the line search of a valid solver, the context as above.
    let code =
        unsafe { ffi::SNESLineSearchSetPreCheck(search, Some(callbacks::direction::<S>), context) };
    check(code, "SNESLineSearchSetPreCheck")?;
    let mut ksp = ptr::null_mut();
    // SAFETY: a valid solver.
    check(unsafe { ffi::SNESGetKSP(snes, &mut ksp) }, "SNESGetKSP")?;
    // SAFETY: the linear solver of a valid solver, the context as above.
    unsafe { callbacks::watch_linear::<S>(ksp, context) }
}
