//! The cells of one rank and their internal forces.

use crate::bulk::Stiffness;

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
        Self { dim, nodes_per_cell, nodes, prototype, stiffness, layer: Vec::new() }
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
        mut magnitude: Option<&mut [f64]>,
    ) {
        let dim = self.dim;
        let n = self.nodes_per_cell * dim;
        let (mut cell_u, mut cell_f) = (vec![0.0; n], vec![0.0; n]);
        let count = if set == CellSet::All { self.len() } else { self.layer.len() };
        for i in 0..count {
            let cell = if set == CellSet::All { i } else { self.layer[i] as usize };
            let nodes = self.nodes(cell);
            for (a, node) in nodes.iter().enumerate() {
                cell_u[a * dim..][..dim].copy_from_slice(&u[*node as usize * dim..][..dim]);
            }
            self.stiffness(cell).force(&cell_u, &mut cell_f);
            for (a, node) in nodes.iter().enumerate() {
                let own = &cell_f[a * dim..][..dim];
                let target = &mut force[*node as usize * dim..][..dim];
                target.iter_mut().zip(own).for_each(|(t, f)| *t += f);
                if let Some(magnitude) = &mut magnitude {
                    magnitude[*node as usize] += own.iter().map(|f| f * f).sum::<f64>().sqrt();
                }
            }
        }
    }
}
