//! What PETSc calls during a solve, and how it reaches the system.
//!
//! The functions are `extern "C"`: a panic in one aborts the process instead of unwinding through
//! C, after the panic hook has told why and ended the job. An error is kept in the context and
//! answered with a code of PETSc, which makes `SNESSolve` return; since the ranks agree on errors,
//! it returns on all of them.

#![allow(unsafe_code)]

use super::context::{Context, Judged};
use super::definite::precondition_by;
use super::system::{NonlinearSystem, TangentChange, Verdict};
use crate::error::Result;
use crate::petsc::error::check;
use crate::petsc::{ReadView, WriteView, ffi};
use std::ffi::c_void;
use std::ptr;

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
        if context.definite.follows(change) {
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
        context.ask_of_linear_solve()
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
        let iteration = usize::try_from(iteration).unwrap_or(0);
        // SAFETY: the solver that calls.
        let answer = unsafe { context.judge_linear(ksp, iteration, norm) }?;
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
        context.unsolved = ksp.unsolved(context.judged.norm)?;
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
        context.judged = Judged { iteration, norm };
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
