//! The part of the mesh that one rank holds.

use super::Column;

/// A cell that stands for all its like: cells of one size, material and order are identical up to
/// translation, and share one stiffness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prototype {
    /// Edge lengths along x, y, z (m; y is 1 in 2D).
    pub size: [f64; 3],
    /// Index of the material.
    pub material: usize,
    /// 1 or 2.
    pub order: usize,
}

/// The cells of one rank, with their nodes by local number.
///
/// Local nodes are numbered by rising name; the numbering of the unknowns reorders them later.
#[derive(Debug, Clone)]
pub struct LocalMesh {
    /// The lattice of these cells.
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
    /// The mesh of the given cells of `column`, rising. Local.
    pub fn new(column: &Column, cells: Vec<u64>, coarse_cells: u64) -> Self {
        let mut prototypes: Vec<Prototype> = Vec::new();
        let cell_prototype = cells
            .iter()
            .map(|cell| {
                let place = column.cell_place(*cell);
                let (size, material) = column.cell_size(place);
                let order = column.order(place.body);
                let same = |s: &Prototype| {
                    (s.material, s.order) == (material, order)
                        && (0..3).all(|i| (s.size[i] - size[i]).abs() <= 1e-12 * size[i])
                };
                let index = prototypes.iter().position(same).unwrap_or_else(|| {
                    prototypes.push(Prototype { size, material, order });
                    prototypes.len() - 1
                });
                index as u16
            })
            .collect();
        let mut nodes: Vec<u64> =
            cells.iter().flat_map(|c| column.cell_nodes(column.cell_place(*c))).collect();
        nodes.sort_unstable();
        nodes.dedup();
        Self { column: column.clone(), cells, cell_prototype, prototypes, nodes, coarse_cells }
    }

    /// The cells of the finer lattice `fine` that this rank's cells consist of. Local.
    pub fn refined(&self, fine: &Column) -> Self {
        let children = |cell: &u64| self.column.children(self.column.cell_place(*cell), fine);
        let mut cells: Vec<u64> =
            self.cells.iter().flat_map(children).map(|place| fine.cell(place)).collect();
        cells.sort_unstable();
        Self::new(fine, cells, self.coarse_cells)
    }

    /// Displacement components per node.
    pub fn dim(&self) -> usize {
        self.column.dim
    }
}
