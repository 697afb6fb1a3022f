//! One block of a preconditioner.

use crate::error::Result;
use crate::petsc::{Petsc, Snes, Vector};

/// A block of the preconditioner: a solver that is only asked for its preconditioner.
pub struct Block {
    pub(in crate::solve) solver: Snes,
    from: Vector,
    to: Vector,
}

impl Block {
    pub(in crate::solve) fn new(petsc: &Petsc, solver: Snes) -> Result<Self> {
        let (rows, width) = (solver.matrix().owned_rows(), solver.matrix().block_size());
        let (from, to) = (Vector::new(petsc, rows, width)?, Vector::new(petsc, rows, width)?);
        Ok(Self { solver, from, to })
    }

    /// z = the preconditioner times r. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub(in crate::solve) fn apply(&mut self, r: &[f64], z: &mut [f64]) -> Result<()> {
        self.from.write()?.copy_from_slice(r);
        self.solver.apply_preconditioner(&self.from, &mut self.to)?;
        z.copy_from_slice(&self.to.read()?);
        Ok(())
    }
}
