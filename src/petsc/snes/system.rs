//! What Newton's method solves: the system as its callbacks see it.

use crate::error::Result;
use crate::petsc::Matrix;
use crate::petsc::linear::LinearTolerance;

/// Whether a call of [`NonlinearSystem::tangent`] changed the matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TangentChange {
    /// No: the preconditioner and the factors are kept.
    Unchanged,
    /// Yes: the preconditioner is built again.
    Changed,
    /// Yes, but so little that the old preconditioner serves an iterative solver.
    ChangedKeepPreconditioner,
}

/// What the test of convergence says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Another correction.
    Continue,
    /// The state is the solution.
    Converged,
    /// There is no hope.
    Diverged,
}

/// What a trial of the state that a linear solve leads to says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Trial {
    /// The state needs another linearisation; more digits of this correction are no use.
    Relinearise,
    /// Go on, to these tolerances if there are any.
    GoOn(Option<LinearTolerance>),
}

/// Solves a system with the tangent of the running correction: right-hand side, then solution, both
/// of this rank's entries. Collective.
///
/// # Errors
/// `Numerics` when the linear solver fails, with the reason; the same on all ranks.
pub type FurtherSolve<'s> = dyn FnMut(&[f64], &mut [f64]) -> Result<()> + 's;

/// A system f(x) = 0 with a sparse tangent. All methods are called collectively; slices
/// hold the entries that this rank owns.
///
/// An `Err` has to be agreed on: either every rank returns it or none (see
/// [`crate::comm::Comm::agree`]).
pub trait NonlinearSystem {
    /// Writes the residual of the state `x` into `f`.
    fn residual(&mut self, x: &[f64], f: &mut [f64]) -> Result<()>;

    /// Writes the tangent at `x` into the matrix; once for each correction, before its linear
    /// solve.
    fn tangent(&mut self, x: &[f64], matrix: &mut Matrix) -> Result<TangentChange>;

    /// Whether the tangent that was written last may be indefinite or unsymmetric, and
    /// [`NonlinearSystem::stiffen`] makes a copy of it symmetric and positive definite.
    fn softens(&mut self) -> bool {
        false
    }

    /// Makes `copy`, a matrix that held the tangent of this or an earlier state, a positive
    /// definite one that is close to the present tangent.
    fn stiffen(&mut self, copy: &mut Matrix) -> Result<()> {
        let _ = copy;
        Ok(())
    }

    /// Writes the tangent into a matrix of the same rows, where its operator has no entries and it
    /// is to be eliminated.
    fn write(&mut self, copy: &mut Matrix) -> Result<()> {
        let _ = copy;
        Ok(())
    }

    /// Turns the correction that the linear solve returned into the direction d of the unknowns:
    /// x becomes x - d (times the step length of the line search). `solve` solves a further system
    /// with the same tangent.
    fn direction(
        &mut self,
        x: &[f64],
        correction: &mut [f64],
        solve: &mut FurtherSolve<'_>,
    ) -> Result<()>;

    /// Judges the state after each correction, and before the first (iteration 0); `norm` is the
    /// 2-norm of `f`.
    fn verdict(&mut self, iteration: usize, x: &[f64], f: &[f64], norm: f64) -> Result<Verdict>;

    /// Where an iterative linear solve starts: `guess` comes in as zero, `rhs` is the right-hand
    /// side.
    fn initial_guess(&mut self, rhs: &[f64], guess: &mut [f64]) -> Result<()> {
        let _ = (rhs, guess);
        Ok(())
    }

    /// At each iteration of an iterative linear solve: an error ends it.
    fn heed(&mut self) -> Result<()> {
        Ok(())
    }

    /// Whether the running linear solve gets any [`NonlinearSystem::trial`]: each costs as much as
    /// an iteration or more.
    fn has_trials(&self) -> bool {
        true
    }

    /// Whether an iterative linear solve is worth going on with: it stands at `correction`, with a
    /// residual of norm `norm`, in the unknowns of the matrix.
    fn trial(&mut self, correction: &[f64], norm: f64) -> Result<Trial> {
        let _ = (correction, norm);
        Ok(Trial::GoOn(None))
    }

    /// The tolerances of the linear solve that follows iteration `iteration`, whose residual has
    /// the given norm.
    fn linear_tolerance(&mut self, iteration: usize, norm: f64) -> LinearTolerance;
}
