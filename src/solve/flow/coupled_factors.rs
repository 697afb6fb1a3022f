//! Displacement and pore pressure eliminated together, as the preconditioner of the coupled
//! problem.

use super::block::Block;
use crate::assembly::{CoupledMatrix, CoupledValues, Discretization, PoreSpace};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::petsc::{Matrix, TangentChange};

/// The factors of the matrix of both fields.
pub struct CoupledFactors {
    pub(in crate::solve) numbers: CoupledMatrix,
    pub(in crate::solve) block: Block,
    /// Whether the matrix could not be factored.
    failed: bool,
}

impl CoupledFactors {
    /// Nothing is factored yet; `block` has the matrix that `numbers` made.
    pub(in crate::solve) fn new(numbers: CoupledMatrix, block: Block) -> Self {
        Self { numbers, block, failed: false }
    }

    /// Assembles and eliminates. A matrix that cannot be factored ends the next linear solve.
    /// Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub(in crate::solve) fn set_up(
        &mut self,
        comm: &Comm,
        all: &Discretization,
        pores: &PoreSpace,
        bulk: &Matrix,
        values: &CoupledValues<'_>,
    ) -> Result<()> {
        let solver = &mut self.block.solver;
        self.numbers.assemble(comm, all, pores, bulk, values, solver.matrix_mut())?;
        if self.failed {
            solver.forget_factors()?;
        }
        let mut factored = solver.set_up(TangentChange::Changed).map(drop);
        let infog = solver.mumps_infog(1);
        if factored.is_err() && solver.give_more_work_space(infog)? {
            tracing::info!("  MUMPS gets more work space");
            solver.forget_factors()?;
            factored = solver.set_up(TangentChange::Changed).map(drop);
        }
        self.failed = match factored {
            Ok(()) => false,
            Err(Error::Numerics(words)) => {
                tracing::debug!("  {words}");
                true
            }
            Err(other) => return Err(other),
        };
        Ok(())
    }

    /// z = the factors times r; not numbers where there are none, which ends the linear solve.
    /// Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub(in crate::solve) fn apply(&mut self, r: &[f64], z: &mut [f64]) -> Result<()> {
        if !self.failed {
            return self.block.apply(r, z);
        }
        z.fill(f64::NAN);
        Ok(())
    }
}
