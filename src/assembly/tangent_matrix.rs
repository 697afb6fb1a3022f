//! The matrices that take the values of a tangent.

use crate::comm::Comm;
use crate::error::Result;
use crate::petsc::Matrix;
use crate::sparse::BlockMatrix;

/// A matrix that takes the values of a tangent.
pub trait TangentMatrix {
    /// Sets every entry to 0. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    fn clear(&mut self) -> Result<()>;

    /// Sets the block rows of these owned nodes to 0; `numbers` are those of local nodes among all.
    /// Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    fn clear_rows(&mut self, nodes: &[u32], numbers: &[i32]) -> Result<()>;

    /// Adds a dense block of blocks, row by row; negative rows are skipped. Local.
    ///
    /// # Errors
    /// For an entry outside the graph.
    fn add(&mut self, rows: &[i32], columns: &[i32], values: &[f64]) -> Result<()>;

    /// Sends what belongs to other ranks. Collective.
    ///
    /// # Errors
    /// For an entry outside the graph; rank-local.
    fn finish(&mut self, comm: &Comm) -> Result<()>;
}

impl TangentMatrix for Matrix {
    fn clear(&mut self) -> Result<()> {
        self.zero()
    }

    fn clear_rows(&mut self, nodes: &[u32], numbers: &[i32]) -> Result<()> {
        let block = self.block_size() as i32;
        let blocks = nodes.iter().map(|node| numbers[*node as usize] * block);
        let rows: Vec<i32> = blocks.flat_map(|first| first..first + block).collect();
        self.zero_rows_keep_pattern(&rows)
    }

    fn add(&mut self, rows: &[i32], columns: &[i32], values: &[f64]) -> Result<()> {
        self.add_blocked(rows, columns, values)
    }

    fn finish(&mut self, _comm: &Comm) -> Result<()> {
        self.assemble()
    }
}

impl TangentMatrix for BlockMatrix {
    fn clear(&mut self) -> Result<()> {
        self.zero();
        Ok(())
    }

    fn clear_rows(&mut self, nodes: &[u32], _numbers: &[i32]) -> Result<()> {
        self.zero_rows(nodes);
        Ok(())
    }

    fn add(&mut self, rows: &[i32], columns: &[i32], values: &[f64]) -> Result<()> {
        self.add_blocked(rows, columns, values)
    }

    fn finish(&mut self, comm: &Comm) -> Result<()> {
        self.assemble(comm)
    }
}
