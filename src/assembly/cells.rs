//! The cells of one rank and their internal forces.

use super::sweep::Sweep;
use crate::bulk::{Modal, Stiffness};

/// Which cells a loop runs over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CellSet {
    /// All cells of the rank.
    All,
    /// The cells that touch a secondary node.
    Layer,
}

/// Connectivity by local node, and the stiffness of each cell.
pub struct Cells {
    dim: usize,
    nodes_per_cell: usize,
    nodes: Vec<u32>,
    prototype: Vec<u16>,
    stiffness: Vec<Stiffness>,
    layer: Vec<u32>,
    all: Sweep,
    near: Sweep,
}

impl Cells {
    /// `nodes` holds `nodes_per_cell` local numbers per cell, `prototype` the index of each cell's
    /// stiffness.
    pub fn new(
        dim: usize,
        nodes_per_cell: usize,
        nodes: Vec<u32>,
        prototype: Vec<u16>,
        stiffness: Vec<Stiffness>,
    ) -> Self {
        let near = Sweep::new(dim, std::iter::empty());
        let cells = nodes.chunks_exact(nodes_per_cell).zip(prototype.iter().copied());
        let all = Sweep::new(dim, cells);
        Self { dim, nodes_per_cell, nodes, prototype, stiffness, layer: Vec::new(), all, near }
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.prototype.len()
    }

    /// Whether this rank has no cell.
    pub fn is_empty(&self) -> bool {
        self.prototype.is_empty()
    }

    /// Local nodes of a cell.
    pub fn nodes(&self, cell: usize) -> &[u32] {
        &self.nodes[cell * self.nodes_per_cell..][..self.nodes_per_cell]
    }

    /// Local nodes of all cells, cell by cell.
    pub fn connectivity(&self) -> &[u32] {
        &self.nodes
    }

    /// The stiffness of a cell.
    pub fn stiffness(&self, cell: usize) -> &Stiffness {
        &self.stiffness[self.prototype[cell] as usize]
    }

    /// The largest diagonal entry of any stiffness (N/m), 0 without cells.
    pub fn largest_diagonal(&self) -> f64 {
        let diagonal = |s: &Stiffness| {
            let n = self.nodes_per_cell * self.dim;
            (0..n).map(|i| s.matrix[i * n + i]).fold(0.0, f64::max)
        };
        self.stiffness.iter().map(diagonal).fold(0.0, f64::max)
    }

    /// The cells that touch a secondary node.
    pub fn layer(&self) -> &[u32] {
        &self.layer
    }

    pub(super) fn set_layer(&mut self, layer: Vec<u32>) {
        let cells = layer.iter().map(|cell| *cell as usize);
        self.near = Sweep::new(self.dim, cells.map(|c| (self.nodes(c), self.prototype[c])));
        self.layer = layer;
    }

    /// Adds the forces K u of the cells in `set` to `force` (N), both `dim` numbers per local node.
    /// `magnitude` gets the sum of the lengths of the cells' nodal forces, one per local node: a
    /// scale that does not cancel. Local.
    pub fn add_forces(
        &self,
        set: CellSet,
        u: &[f64],
        force: &mut [f64],
        magnitude: Option<&mut [f64]>,
    ) {
        let sweep = if set == CellSet::All { &self.all } else { &self.near };
        sweep.add_forces(self.modal(), u, [force, &mut []], magnitude);
    }

    /// As [`Cells::add_forces`] of all cells, with the forces at owned nodes apart from those at
    /// ghosts. Local.
    pub fn add_forces_apart(&self, u: &[f64], owned: &mut [f64], ghosts: &mut [f64]) {
        self.all.add_forces(self.modal(), u, [owned, ghosts], None);
    }

    fn modal<'s>(&'s self) -> impl Fn(u16) -> &'s Modal {
        |prototype| &self.stiffness[prototype as usize].modal
    }

    /// Adds the diagonal of the stiffness (N/m), `dim` numbers per local node. Local.
    pub fn add_diagonal(&self, diagonal: &mut [f64]) {
        let (dim, n) = (self.dim, self.nodes_per_cell * self.dim);
        for cell in 0..self.len() {
            let matrix = &self.stiffness(cell).matrix;
            for (a, node) in self.nodes(cell).iter().enumerate() {
                for c in 0..dim {
                    diagonal[*node as usize * dim + c] += matrix[(a * dim + c) * (n + 1)];
                }
            }
        }
    }
}
