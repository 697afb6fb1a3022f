//! The part of the mesh that one rank holds.

use super::{Column, axes};

/// A cell that stands for all its like: cells of one size and material are identical up to
/// translation, and share one stiffness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prototype {
    /// Edge lengths along x, y, z (m; y is 1 in 2D).
    pub size: [f64; 3],
    /// Index of the material.
    pub material: usize,
}

/// The cells of one rank, with their nodes by local number.
///
/// Local nodes are numbered by rising name; the numbering of the unknowns reorders them later.
#[derive(Debug, Clone)]
pub struct LocalMesh {
    /// The whole column, at the level of these cells.
    pub column: Column,
    /// Cell names, rising.
    pub cells: Vec<u64>,
    /// Index into `prototypes` of each cell.
    pub cell_prototype: Vec<u16>,
    /// The prototypes that occur on this rank.
    pub prototypes: Vec<Prototype>,
    /// Names of the nodes of the cells, rising.
    pub nodes: Vec<u64>,
    /// Cells that the largest mesh held by any rank before the distribution had.
    pub coarse_cells: u64,
}

impl LocalMesh {
    /// The mesh of the given cells of `coarse`, refined `levels` times. Local.
    pub fn refine(coarse: &Column, cells: &[u64], levels: u32, coarse_cells: u64) -> Self {
        let column = coarse.refined(levels);
        let mut fine: Vec<u64> = cells
            .iter()
            .flat_map(|c| coarse.descendants(coarse.cell_place(*c), levels))
            .map(|place| column.cell(place))
            .collect();
        fine.sort_unstable();
        let mut prototypes: Vec<Prototype> = Vec::new();
        let cell_prototype = fine
            .iter()
            .map(|cell| {
                let (size, material) = column.cell_size(column.cell_place(*cell));
                let same = |s: &Prototype| {
                    s.material == material
                        && (0..3).all(|i| (s.size[i] - size[i]).abs() <= 1e-12 * size[i])
                };
                let index = prototypes.iter().position(same).unwrap_or_else(|| {
                    prototypes.push(Prototype { size, material });
                    prototypes.len() - 1
                });
                index as u16
            })
            .collect();
        let mut nodes: Vec<u64> =
            fine.iter().flat_map(|c| column.cell_nodes(column.cell_place(*c))).collect();
        nodes.sort_unstable();
        nodes.dedup();
        Self { column, cells: fine, cell_prototype, prototypes, nodes, coarse_cells }
    }

    /// Displacement components per node.
    pub fn dim(&self) -> usize {
        self.column.dim
    }

    /// Nodes per cell.
    pub fn nodes_per_cell(&self) -> usize {
        1 << axes(self.dim()).len()
    }
}
