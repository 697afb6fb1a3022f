//! What PETSc calls during a solve, and how it reaches the system.
//!
//! The functions are `extern "C"`: a panic in one aborts the process instead of unwinding through
//! C, after the panic hook has told why and ended the job. An error is kept in the context and
//! answered with a code of PETSc, which makes `SNESSolve` return; since the ranks agree on errors,
//! it returns on all of them.

#![allow(unsafe_code)]

use super::definite::{Definite, precondition_by};
use super::system::{NonlinearSystem, TangentChange, Trial, Verdict};
use crate::error::{Error, Result};
use crate::petsc::error::check;
use crate::petsc::linear::{Ksp, LinearFailure, WORTH, Watch};
use crate::petsc::{Matrix, ReadView, WriteView, ffi};
use std::ffi::c_void;
use std::ptr;

/// The state that a linear solve leads to is tried when the residual has fallen by this, and again
/// each time it has fallen by the second.
const TRIAL: [f64; 2] = [1e-2, 1e-3];

/// A linear residual that has grown to this times the right-hand side will not come back.
const DIVERGED: f64 = 1e5;

/// What the user's options fix and the system therefore does not change.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct UserSet {
    /// The relative tolerance of the linear solves.
    pub(super) relative: bool,
    /// The absolute tolerance of the linear solves.
    pub(super) absolute: bool,
    /// When the preconditioner is built again.
    pub(super) preconditioner: bool,
}

/// What the callbacks of one solve share.
pub(super) struct Context<'a, S> {
    system: &'a mut S,
    matrix: &'a mut Matrix,
    definite: &'a mut Definite,
    ksp: Ksp,
    ranks: i32,
    user: UserSet,
    /// Number and residual norm of the state that was judged last.
    judged: (usize, f64),
    /// Most negative pivots that MUMPS has met in a factorisation of the running solve; `None`
    /// where nothing tells of them.
    pub(super) negative_pivots: Option<usize>,
    /// The true residual of a method that goes by another norm.
    watch: Watch,
    /// How a linear solve failed that only applied its preconditioner.
    pub(super) unsolved: Option<LinearFailure>,
    /// Norm of the linear residual at which the next trial of the state is due.
    next_trial: f64,
    /// The error of the callback that failed.
    pub(super) error: Option<Error>,
    /// Whether the verdict was `Diverged`.
    pub(super) stopped: bool,
}

impl<'a, S> Context<'a, S> {
    pub(super) fn new(
        system: &'a mut S,
        (matrix, definite): (&'a mut Matrix, &'a mut Definite),
        (ksp, ranks): (Ksp, i32),
        user: UserSet,
    ) -> Self {
        Context {
            system,
            matrix,
            definite,
            ksp,
            ranks,
            user,
            judged: (0, 0.0),
            negative_pivots: Some(0),
            watch: Watch::default(),
            unsolved: None,
            next_trial: 0.0,
            error: None,
            stopped: false,
        }
    }

    /// Counts the pivots of the solve that has just ended. Conjugate gradients tell an indefinite
    /// tangent themselves. Local.
    fn count_pivots(&mut self) -> Result<()> {
        if self.ksp.pc_type_name()? == "cholesky" || self.ksp.type_name()? != "cg" {
            let counts = self.negative_pivots.zip(self.ksp.negative_pivots(self.ranks)?);
            self.negative_pivots = counts.map(|(most, count)| most.max(count));
        }
        Ok(())
    }
}

/// Runs a callback's work and turns its error into a code.
///
/// # Safety
/// `context` is null or the `Context<S>` of the running solve, to which nothing else refers.
unsafe fn run<S>(
    context: *mut c_void,
    work: impl FnOnce(&mut Context<'_, S>) -> Result<()>,
) -> ffi::PetscErrorCode {
    let failed = ffi::PETSC_ERR_USER as ffi::PetscErrorCode;
    // SAFETY: by the contract.
    let Some(context) = (unsafe { context.cast::<Context<'_, S>>().as_mut() }) else {
        return failed;
    };
    match work(context) {
        Ok(()) => 0,
        Err(error) => {
            context.error = Some(error);
            failed
        }
    }
}

/// f(x). Collective.
///
/// # Safety
/// To be called by PETSc only, with two vectors of the solve and the context that was installed.
pub(super) unsafe extern "C" fn residual<S: NonlinearSystem>(
    _snes: ffi::SNES,
    x: ffi::Vec,
    f: ffi::Vec,
    context: *mut c_void,
) -> ffi::PetscErrorCode {
    let work = |context: &mut Context<'_, S>| {
        // SAFETY: PETSc lends two different valid vectors for the length of the call.
        let (x, mut f) = (unsafe { ReadView::new(x) }?, unsafe { WriteView::new(f) }?);
        context.system.residual(&x, &mut f)
    };
    // SAFETY: the context that was installed; callbacks do not nest.
    unsafe { run::<S>(context, work) }
}

/// The tangent at x, then the tolerances and the preconditioner of the linear solve. Collective.
///
/// # Safety
/// As [`residual`]; the matrix is that of the context.
pub(super) unsafe extern "C" fn tangent<S: NonlinearSystem>(
    snes: ffi::SNES,
    x: ffi::Vec,
    _matrix: ffi::Mat,
    _preconditioner: ffi::Mat,
    context: *mut c_void,
) -> ffi::PetscErrorCode {
    let work = |context: &mut Context<'_, S>| {
        // SAFETY: PETSc lends a valid vector for the length of the call.
        let x = unsafe { ReadView::new(x) }?;
        let change = context.system.tangent(&x, context.matrix)?;
        if change == TangentChange::Changed {
            let of = context.definite.choose(context.system, context.matrix, context.ksp)?;
            // SAFETY: the solver that calls, and its own matrix or the copy of it.
            unsafe { precondition_by(snes, of) }?;
        }
        if !context.user.preconditioner {
            // SNES decides on the preconditioner after this call, by its lag: 1 builds it again
            // each time, -1 never.
            let keep = match change {
                TangentChange::Unchanged => true,
                TangentChange::Changed => false,
                TangentChange::ChangedKeepPreconditioner => context.ksp.is_iterative()?,
            };
            let lag = if keep { -1 } else { 1 };
            // SAFETY: the solver that calls.
            let code = unsafe { ffi::SNESSetLagPreconditioner(snes, lag) };
            check(code, "SNESSetLagPreconditioner")?;
        }
        let (iteration, norm) = context.judged;
        context.next_trial = if context.system.has_trials() { TRIAL[0] * norm } else { 0.0 };
        let tolerance = context.system.linear_tolerance(iteration, norm);
        context.ksp.set_tolerances(
            (!context.user.relative).then_some(tolerance.relative),
            (!context.user.absolute).then_some(tolerance.absolute),
        )
    };
    // SAFETY: as in `residual`.
    unsafe { run::<S>(context, work) }
}

/// Whether a linear solve has converged: the usual test on the true residual, whatever norm the
/// method goes by, and the system's opinion of the state that the correction so far leads to.
/// Collective.
///
/// # Safety
/// As [`residual`]; `reason` is a valid place for the answer.
pub(super) unsafe extern "C" fn linear_verdict<S: NonlinearSystem>(
    ksp: ffi::KSP,
    iteration: ffi::PetscInt,
    norm: f64,
    reason: *mut ffi::KSPConvergedReason,
    context: *mut c_void,
) -> ffi::PetscErrorCode {
    // SAFETY: a valid place by the contract.
    unsafe { *reason = ffi::KSP_CONVERGED_ITERATING };
    let work = |context: &mut Context<'_, S>| {
        context.system.heed()?;
        let rhs = context.judged.1;
        let target = |(relative, absolute): (f64, f64)| absolute.max(relative * rhs);
        let mut tolerances = context.ksp.tolerances()?;
        let mut norm = norm;
        if !context.ksp.measures_true_residual()? && norm.is_finite() {
            let (ksp, iteration) = (context.ksp, usize::try_from(iteration).unwrap_or(0));
            match context.watch.norm(ksp, iteration, norm, target(tolerances))? {
                Some(truly) => norm = truly,
                None => return Ok(()),
            }
        }
        let reached = |tolerances| norm <= target(tolerances);
        let mut answer = if !norm.is_finite() {
            ffi::KSP_DIVERGED_NANORINF
        } else if norm > DIVERGED * rhs {
            ffi::KSP_DIVERGED_DTOL
        } else {
            ffi::KSP_CONVERGED_ITERATING
        };
        let due = answer == ffi::KSP_CONVERGED_ITERATING && norm <= context.next_trial;
        if due && !reached(tolerances) {
            context.next_trial = TRIAL[1] * norm;
            let mut correction = ptr::null_mut();
            // SAFETY: the solver that calls; it lends its solution.
            let code = unsafe { ffi::KSPBuildSolution(ksp, ptr::null_mut(), &mut correction) };
            check(code, "KSPBuildSolution")?;
            // SAFETY: a valid vector that nothing writes to during the call.
            let correction = unsafe { ReadView::new(correction) }?;
            match context.system.trial(&correction, norm)? {
                Trial::Relinearise => answer = ffi::KSP_CONVERGED_ITS,
                Trial::GoOn(None) => {}
                Trial::GoOn(Some(tolerance)) => {
                    context.ksp.set_tolerances(
                        (!context.user.relative).then_some(tolerance.relative),
                        (!context.user.absolute).then_some(tolerance.absolute),
                    )?;
                    tolerances = context.ksp.tolerances()?;
                }
            }
        }
        if answer == ffi::KSP_CONVERGED_ITERATING && reached(tolerances) {
            answer = ffi::KSP_CONVERGED_RTOL;
        }
        let is_last = usize::try_from(iteration).unwrap_or(0) >= context.ksp.most_iterations()?;
        if answer == ffi::KSP_CONVERGED_ITERATING && is_last && norm <= WORTH * rhs {
            answer = ffi::KSP_CONVERGED_ITS;
        }
        // SAFETY: a valid place by the contract.
        unsafe { *reason = answer };
        Ok(())
    };
    // SAFETY: as in `residual`.
    unsafe { run::<S>(context, work) }
}

/// The start of an iterative linear solve. Collective.
///
/// # Safety
/// As [`residual`].
pub(super) unsafe extern "C" fn initial_guess<S: NonlinearSystem>(
    _ksp: ffi::KSP,
    rhs: ffi::Vec,
    guess: ffi::Vec,
    context: *mut c_void,
) -> ffi::PetscErrorCode {
    let work = |context: &mut Context<'_, S>| {
        if !context.ksp.is_iterative()? {
            return Ok(());
        }
        // SAFETY: PETSc lends two different valid vectors for the length of the call.
        let (rhs, mut guess) = (unsafe { ReadView::new(rhs) }?, unsafe { WriteView::new(guess) }?);
        guess.fill(0.0);
        context.system.initial_guess(&rhs, &mut guess)?;
        context.ksp.start_from_guess()
    };
    // SAFETY: as in `residual`.
    unsafe { run::<S>(context, work) }
}

/// Turns a correction into a direction. Collective.
///
/// # Safety
/// As [`residual`]; `changed` is a valid place for the answer.
pub(super) unsafe extern "C" fn direction<S: NonlinearSystem>(
    _search: ffi::SNESLineSearch,
    x: ffi::Vec,
    correction: ffi::Vec,
    changed: *mut ffi::PetscBool,
    context: *mut c_void,
) -> ffi::PetscErrorCode {
    let address = context;
    let work = |context: &mut Context<'_, S>| {
        // SAFETY: PETSc lends two different valid vectors for the length of the call.
        let (x, mut y) = (unsafe { ReadView::new(x) }?, unsafe { WriteView::new(correction) }?);
        context.count_pivots()?;
        let ksp = context.ksp;
        context.unsolved = ksp.unsolved(context.judged.1)?;
        if context.unsolved.is_some() {
            // The verdict ends the solve at the state where it is.
            y.fill(0.0);
            // SAFETY: a valid place by the contract.
            unsafe { *changed = ffi::PETSC_TRUE };
            return Ok(());
        }
        let mut further = |rhs: &[f64], solution: &mut [f64]| {
            // SAFETY: the callbacks that would reach the context stay away from this solve.
            let solved = unsafe { ksp.solve_alone(correction, rhs, solution) };
            // SAFETY: the context is that of the running solve.
            let restored = unsafe { watch_linear::<S>(ksp.raw(), address) };
            solved.and(restored)
        };
        context.system.direction(&x, &mut y, &mut further)?;
        // SAFETY: a valid place by the contract.
        unsafe { *changed = ffi::PETSC_TRUE };
        Ok(())
    };
    // SAFETY: as in `residual`.
    unsafe { run::<S>(context, work) }
}

/// Judges a state. Collective.
///
/// # Safety
/// As [`residual`]; `reason` is a valid place for the answer.
pub(super) unsafe extern "C" fn verdict<S: NonlinearSystem>(
    snes: ffi::SNES,
    iteration: ffi::PetscInt,
    _x_norm: f64,
    _step_norm: f64,
    norm: f64,
    reason: *mut ffi::SNESConvergedReason,
    context: *mut c_void,
) -> ffi::PetscErrorCode {
    let work = |context: &mut Context<'_, S>| {
        if context.unsolved.is_some() {
            // SAFETY: a valid place by the contract.
            unsafe { *reason = ffi::SNES_DIVERGED_LINEAR_SOLVE };
            return Ok(());
        }
        let (mut x, mut f) = (ptr::null_mut(), ptr::null_mut());
        // SAFETY: the solver that calls.
        check(unsafe { ffi::SNESGetSolution(snes, &mut x) }, "SNESGetSolution")?;
        let (no_function, no_context) = (ptr::null_mut(), ptr::null_mut());
        // SAFETY: as above; function and context are not asked for.
        let code = unsafe { ffi::SNESGetFunction(snes, &mut f, no_function, no_context) };
        check(code, "SNESGetFunction")?;
        // SAFETY: two valid vectors of the solver, which writes to neither during the call.
        let (x, f) = (unsafe { ReadView::new(x) }?, unsafe { ReadView::new(f) }?);
        let iteration = usize::try_from(iteration).unwrap_or(0);
        context.judged = (iteration, norm);
        let verdict = context.system.verdict(iteration, &x, &f, norm)?;
        context.stopped = verdict == Verdict::Diverged;
        let answer = match verdict {
            Verdict::Continue => ffi::SNES_CONVERGED_ITERATING,
            Verdict::Converged => ffi::SNES_CONVERGED_FNORM_ABS,
            Verdict::Diverged => ffi::SNES_DIVERGED_DTOL,
        };
        // SAFETY: a valid place by the contract.
        unsafe { *reason = answer };
        Ok(())
    };
    // SAFETY: as in `residual`.
    unsafe { run::<S>(context, work) }
}

/// Sets the callbacks of linear solves and their context.
///
/// # Safety
/// `ksp` is valid; `context` is null or a `Context<S>` that outlives every
/// use of the solver before the next call of this function.
pub(super) unsafe fn watch_linear<S: NonlinearSystem>(
    ksp: ffi::KSP,
    context: *mut c_void,
) -> Result<()> {
    // SAFETY: a valid solver, the context by the contract.
    let code = unsafe { ffi::KSPSetPreSolve(ksp, Some(initial_guess::<S>), context) };
    check(code, "KSPSetPreSolve")?;
    let test = Some(linear_verdict::<S> as _);
    // SAFETY: as above; the context is not PETSc's to free.
    let code = unsafe { ffi::KSPSetConvergenceTest(ksp, test, context, None) };
    check(code, "KSPSetConvergenceTest")
}
