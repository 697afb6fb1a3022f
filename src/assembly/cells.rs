//! The cells of one rank and their internal forces.

use super::second_order::SecondOrderSweep;
use super::sweep::Sweep;
use crate::bulk::{Modal, Parity, SplitForm, Stiffness};

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
    /// First entry of each cell in `nodes`, and the end.
    start: Vec<u32>,
    nodes: Vec<u32>,
    prototype: Vec<u32>,
    stiffness: Vec<Stiffness>,
    layer: Vec<u32>,
    all: Sweeps,
    near: Sweeps,
}

/// The cells of a set by their order.
struct Sweeps {
    first: Sweep,
    second: SecondOrderSweep,
}

impl Cells {
    /// `nodes` gives the local nodes of a cell in the order of its shape, `prototype` the index of
    /// each cell's stiffness.
    pub fn new<'n>(
        dim: usize,
        nodes: impl Iterator<Item = Vec<u32>> + 'n,
        prototype: Vec<u32>,
        stiffness: Vec<Stiffness>,
    ) -> Self {
        let (mut start, mut list) = (vec![0], Vec::new());
        for nodes in nodes {
            list.extend(nodes);
            start.push(list.len() as u32);
        }
        let none = || Sweeps::new(dim, &stiffness, std::iter::empty());
        let (all, near) = (none(), none());
        let nodes = list;
        let mut cells = Self { dim, start, nodes, prototype, stiffness, layer: vec![], all, near };
        cells.all = cells.sweeps(0..cells.len());
        cells
    }

    fn sweeps(&self, cells: impl Iterator<Item = usize> + Clone) -> Sweeps {
        let cells = cells.map(|c| (self.nodes(c), self.prototype[c]));
        Sweeps::new(self.dim, &self.stiffness, cells)
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
        &self.nodes[self.start[cell] as usize..self.start[cell + 1] as usize]
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
            let n = s.matrix.len().isqrt();
            (0..n).map(|i| s.matrix[i * n + i]).fold(0.0, f64::max)
        };
        self.stiffness.iter().map(diagonal).fold(0.0, f64::max)
    }

    /// The cells that touch a secondary node.
    pub fn layer(&self) -> &[u32] {
        &self.layer
    }

    pub(super) fn set_layer(&mut self, layer: Vec<u32>) {
        self.near = self.sweeps(layer.iter().map(|cell| *cell as usize));
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
        let sweeps = if set == CellSet::All { &self.all } else { &self.near };
        sweeps.add_forces(&self.stiffness, u, [force, &mut []], magnitude);
    }

    /// As [`Cells::add_forces`] of all cells, with the forces at owned nodes apart from those at
    /// ghosts. Local.
    pub fn add_forces_apart(&self, u: &[f64], owned: &mut [f64], ghosts: &mut [f64]) {
        self.all.add_forces(&self.stiffness, u, [owned, ghosts], None);
    }

    /// Adds the diagonal of the stiffness (N/m), `dim` numbers per local node. Local.
    pub fn add_diagonal(&self, diagonal: &mut [f64]) {
        let dim = self.dim;
        for cell in 0..self.len() {
            let matrix = &self.stiffness(cell).matrix;
            let n = self.nodes(cell).len() * dim;
            for (a, node) in self.nodes(cell).iter().enumerate() {
                for c in 0..dim {
                    diagonal[*node as usize * dim + c] += matrix[(a * dim + c) * (n + 1)];
                }
            }
        }
    }
}

impl Sweeps {
    fn new<'a>(
        dim: usize,
        stiffness: &[Stiffness],
        cells: impl Iterator<Item = (&'a [u32], u32)> + Clone,
    ) -> Self {
        let is_first =
            |prototype: u32| matches!(stiffness[prototype as usize].form, SplitForm::First(_));
        let first = Sweep::new(dim, cells.clone().filter(|(_, p)| is_first(*p)));
        let second = SecondOrderSweep::new(dim, cells.filter(|(_, p)| !is_first(*p)));
        Self { first, second }
    }

    /// As [`Cells::add_forces`], the forces at the first nodes apart from those at the others.
    fn add_forces(
        &self,
        stiffness: &[Stiffness],
        u: &[f64],
        [first, others]: [&mut [f64]; 2],
        mut magnitude: Option<&mut [f64]>,
    ) {
        let modal = |prototype: u32| -> &Modal {
            let SplitForm::First(modal) = &stiffness[prototype as usize].form else {
                unreachable!("sorted by order");
            };
            modal
        };
        let parity = |prototype: u32| -> &Parity {
            let SplitForm::Second(parity) = &stiffness[prototype as usize].form else {
                unreachable!("sorted by order");
            };
            parity
        };
        let sizes = magnitude.as_deref_mut();
        self.first.add_forces(modal, u, [&mut *first, &mut *others], sizes);
        self.second.add_forces(parity, u, [first, others], magnitude);
    }
}
