//! The nested meshes of a case before any rank has its part of them.

use super::lattice::Column;
use super::{DualGraph, LocalMesh, MeshFacts};
use crate::case::Case;
use crate::error::Result;

/// Nested meshes, coarsest first, the same on every rank; the last one is that of the case. The
/// cells of the first one are shared out, and every rank refines its own.
#[derive(Debug, Clone)]
pub struct MeshFamily {
    columns: Vec<Column>,
}

impl MeshFamily {
    /// The mesh that the case describes, and that before its refinement.
    ///
    /// # Errors
    /// `Input` when a material's height range leaves a layer without a material.
    pub fn new(case: &Case) -> Result<Self> {
        let column = Column::new(case)?;
        Ok(Self { columns: vec![column.described(), column] })
    }

    /// What is known of the mesh of the case.
    pub fn facts(&self) -> MeshFacts {
        self.finest().facts()
    }

    /// The lattice of the mesh of the case, where it is one.
    pub fn lattice(&self) -> Option<&Column> {
        self.columns.last()
    }

    fn finest(&self) -> &Column {
        &self.columns[self.columns.len() - 1]
    }

    /// Takes levels for multigrid in the place of the meshes below the finest, the coarsest of at
    /// least `fewest` cells. False where there are none.
    pub fn coarsen(&mut self, fewest: u64) -> bool {
        let levels = self.finest().hierarchy(fewest);
        let has_levels = levels.len() > 1;
        if has_levels {
            self.columns = levels;
        }
        has_levels
    }

    /// Number of cells of the coarsest mesh.
    pub fn coarse_cells(&self) -> u64 {
        self.columns[0].cells()
    }

    /// The dual graph of the coarsest mesh.
    ///
    /// # Errors
    /// `Input` when it has too many cells.
    pub fn dual_graph(&self) -> Result<DualGraph> {
        self.columns[0].dual_graph()
    }

    /// The parts of a rank that gets these cells of the coarsest mesh, rising; coarsest first.
    /// `held` is the size of the largest mesh that any rank held before. Local.
    pub fn share(&self, cells: Vec<u64>, held: u64) -> Vec<LocalMesh> {
        let mut meshes = vec![LocalMesh::new(&self.columns[0], cells, held)];
        for column in &self.columns[1..] {
            meshes.push(meshes[meshes.len() - 1].refined(column));
        }
        meshes
    }

    /// The whole mesh of the case on one rank. Local.
    pub fn whole(&self) -> LocalMesh {
        let column = self.finest();
        LocalMesh::new(column, (0..column.cells()).collect(), column.cells())
    }
}
