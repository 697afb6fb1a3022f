//! The pore pressure of one rank: its nodes, its cells, and their sums.
//!
//! The pressure is linear in every porous cell, whatever the order of the displacement; its nodes
//! are the corners of the cells, with the same names. Owned nodes come first, as everywhere.

mod coupling;
mod matrix;

use super::Discretization;
use super::films::Films;
use crate::bulk::{BalanceSums, FlowStep, MAX_CORNERS, PoroState, PorousCell};
use crate::comm::Comm;
use crate::space::Nodes;

/// A porous cell of this rank.
#[derive(Debug, Clone, Copy)]
pub struct PoreCell {
    /// Index among the cells of [`Discretization`].
    pub cell: u32,
    /// Index among the prototypes.
    pub prototype: u32,
    /// Local pressure nodes, in the order of the corners of the cell; those of cells with fewer
    /// stand first.
    pub nodes: [u32; MAX_CORNERS],
    /// Corners of the cell.
    pub count: u8,
}

impl PoreCell {
    /// Local pressure nodes, in the order of the corners of the cell.
    #[inline(always)]
    pub fn corners(&self) -> &[u32] {
        &self.nodes[..self.count as usize]
    }
}

/// A pressure node of a secondary lip, whose pressure follows from those of others.
#[derive(Debug, Clone)]
pub struct Tie {
    /// The local node.
    pub node: u32,
    /// Local nodes, of the primary lip and prescribed ones beside it, and their parts.
    pub follows: Vec<(u32, f64)>,
}

/// The discretisation of the pore pressure.
///
/// Where fluid flows along an interface its lips have one pressure: that of the secondary one
/// follows from the primary one by the dual mortar rows of the pressure, and the fluxes into either
/// side, which are the multipliers of that tie, cancel in the sum of the rows.
pub struct PoreSpace {
    /// Displacement components per node.
    pub dim: usize,
    /// Nodes that carry a pressure.
    pub nodes: Nodes,
    /// Cells with pores.
    pub cells: Vec<PoreCell>,
    /// What like cells have in common.
    pub prototypes: Vec<PorousCell>,
    /// Whether the pressure of each local node is prescribed.
    pub prescribed: Vec<bool>,
    /// Nodes whose pressure follows from that of others.
    pub ties: Vec<Tie>,
    /// Index into `ties` of each local node.
    pub tie_of: Vec<Option<u32>>,
    /// Fluid between the lips.
    pub films: Films,
}

impl PoreSpace {
    /// Takes the displacements of the nodes of a cell out of those of all local nodes.
    #[inline(always)]
    fn gather(&self, all: &Discretization, cell: &PoreCell, u: &[f64], out: &mut Vec<f64>) {
        out.clear();
        for node in all.cells.nodes(cell.cell as usize) {
            out.extend_from_slice(&u[*node as usize * self.dim..][..self.dim]);
        }
    }

    /// The cell's pressures above the reference.
    #[inline(always)]
    fn pressures(&self, cell: &PoreCell, p: &[f64], reference: f64) -> [f64; MAX_CORNERS] {
        let mut of = [0.0; MAX_CORNERS];
        for (of, node) in of.iter_mut().zip(cell.corners()) {
            *of = p[*node as usize] - reference;
        }
        of
    }

    /// Whether a pressure of the cell is to be found.
    #[inline(always)]
    fn is_free(&self, cell: &PoreCell) -> bool {
        cell.corners().iter().any(|n| !self.prescribed[*n as usize])
    }

    /// Adds the balance of the fluid at the end of a step at the local nodes, and the magnitudes of
    /// its parts (m3), in cells where a pressure is to be found or in `every` cell; see
    /// [`PorousCell::add_balance`]. Local.
    pub fn add_balance(
        &self,
        all: &Discretization,
        end: PoroState<'_>,
        before: &[f64],
        step: &FlowStep,
        every: bool,
        sums: BalanceSums<'_>,
    ) {
        let displacement = all.frames.displacements(end.displacement);
        self.each(all, &displacement, every, sums, |cell, like, u, sums| {
            let reference = like.medium.reference;
            let of_cell = |p| self.pressures(cell, p, reference);
            let (p, before) = (of_cell(end.pressure), of_cell(before));
            let end = PoroState { displacement: u, pressure: &p };
            like.add_balance(end, &before, step, sums);
        });
    }

    /// Adds the change of the stored fluid since the undeformed state at every local node (m3).
    /// Local.
    pub fn add_stored(
        &self,
        all: &Discretization,
        state: PoroState<'_>,
        lumped: bool,
        rows: &mut [f64],
    ) {
        let mut sizes = vec![0.0; rows.len()];
        let sums = BalanceSums { rows, sizes: &mut sizes };
        let displacement = all.frames.displacements(state.displacement);
        self.each(all, &displacement, true, sums, |cell, like, u, sums| {
            let p = self.pressures(cell, state.pressure, like.medium.reference);
            like.add_stored(PoroState { displacement: u, pressure: &p }, lumped, sums);
        });
    }

    /// Adds what flows off every local node per second (m3/s). Local.
    pub fn add_flow(&self, all: &Discretization, p: &[f64], gravity: &[f64; 3], rows: &mut [f64]) {
        let mut sizes = vec![0.0; rows.len()];
        let sums = BalanceSums { rows, sizes: &mut sizes };
        self.each(all, &[], true, sums, |cell, like, _, sums| {
            let p = self.pressures(cell, p, like.medium.reference);
            like.add_flow(&p, gravity, 1.0, sums);
        });
    }

    fn each(
        &self,
        all: &Discretization,
        u: &[f64],
        every: bool,
        sums: BalanceSums<'_>,
        act: impl Fn(&PoreCell, &PorousCell, &[f64], BalanceSums<'_>),
    ) {
        let BalanceSums { rows, sizes } = sums;
        let mut of_cell = Vec::new();
        for cell in self.cells.iter().filter(|cell| every || self.is_free(cell)) {
            let np = cell.corners().len();
            if !u.is_empty() {
                self.gather(all, cell, u, &mut of_cell);
            }
            let (mut own, mut size) = ([0.0; MAX_CORNERS], [0.0; MAX_CORNERS]);
            let like = &self.prototypes[cell.prototype as usize];
            let sums = BalanceSums { rows: &mut own[..np], sizes: &mut size[..np] };
            act(cell, like, &of_cell, sums);
            for (node, (own, size)) in cell.corners().iter().zip(own.iter().zip(&size)) {
                rows[*node as usize] += own;
                sizes[*node as usize] += size;
            }
        }
    }

    /// Flux (kg/m2/s by component), pressure above the reference (Pa) and porosity at the centre of
    /// a cell; `state` has displacements, not unknowns, and pressures of all local nodes. Local.
    pub fn at_centre(
        &self,
        all: &Discretization,
        cell: &PoreCell,
        state: PoroState<'_>,
        gravity: &[f64; 3],
    ) -> ([f64; 3], f64, f64) {
        let mut of_cell = Vec::new();
        self.gather(all, cell, state.displacement, &mut of_cell);
        let like = &self.prototypes[cell.prototype as usize];
        let p = self.pressures(cell, state.pressure, like.medium.reference);
        like.at_centre(PoroState { displacement: &of_cell, pressure: &p }, gravity)
    }

    /// Pressures of all local nodes at every owned displacement node of porous cells (Pa), linear
    /// between the corners of a cell; 0 at others. Collective.
    pub fn at_nodes(&self, all: &Discretization, pressure: &[f64]) -> Vec<f64> {
        // Value and number of ranks that know it.
        let mut at = vec![[0.0; 2]; all.nodes.len()];
        for cell in &self.cells {
            let nodes = all.cells.nodes(cell.cell as usize);
            let shape = self.prototypes[cell.prototype as usize].shape();
            for (node, xi) in nodes.iter().zip(shape.node_points()) {
                let mut values = [0.0; MAX_CORNERS];
                shape.corners().values(*xi, &mut values);
                let corners = cell.nodes.iter().zip(&values);
                let p = corners.map(|(n, v)| v * pressure[*n as usize]).sum();
                at[*node as usize] = [p, 1.0];
            }
        }
        let mut packed: Vec<f64> = at.into_iter().flatten().collect();
        all.nodes.add_to_owners(&mut packed, 2);
        let owned = packed.chunks_exact(2).take(all.nodes.owned);
        owned.map(|at| at[0] / at[1].max(1.0)).collect()
    }

    /// Turns owned pressures into those of all local nodes, zero where prescribed. Collective.
    pub fn expand(&self, p: &mut [f64]) {
        self.for_identity_rows(|node| p[node] = 0.0);
        self.nodes.update_ghosts(p, 1);
        self.follow(p);
    }

    /// Gives tied nodes the pressure that follows from those of the others. Local: `p` is that of
    /// all local nodes.
    pub fn follow(&self, p: &mut [f64]) {
        for tie in &self.ties {
            p[tie.node as usize] = tie.follows.iter().map(|(n, a)| a * p[*n as usize]).sum();
        }
    }

    /// The transpose of [`PoreSpace::expand`]: sums of all local nodes to those of the owned
    /// unknowns, zero at identity rows. Collective.
    pub fn fold(&self, rows: &mut [f64]) {
        self.sum(rows);
        self.for_identity_rows(|node| rows[node] = 0.0);
    }

    /// Sums of all local nodes to those of the owned ones, those of tied nodes to what they follow.
    /// Collective.
    pub fn sum(&self, rows: &mut [f64]) {
        for tie in &self.ties {
            let carried = std::mem::take(&mut rows[tie.node as usize]);
            for (node, a) in &tie.follows {
                rows[*node as usize] += a * carried;
            }
        }
        self.nodes.add_to_owners(rows, 1);
    }

    /// Whether the pressure of a local node is no unknown.
    fn is_known(&self, node: usize) -> bool {
        self.prescribed[node] || self.tie_of[node].is_some()
    }

    /// Calls `act` with every owned node whose row is the identity. Local.
    pub fn for_identity_rows(&self, act: impl FnMut(usize)) {
        (0..self.nodes.owned).filter(|node| self.is_known(*node)).for_each(act);
    }

    /// The unknowns that make up the pressure of a local node: itself, what it follows, or none.
    fn unknowns(&self, node: u32) -> Vec<(u32, f64)> {
        match self.tie_of[node as usize] {
            _ if self.prescribed[node as usize] => Vec::new(),
            None => vec![(node, 1.0)],
            Some(tie) => {
                let follows = self.ties[tie as usize].follows.iter().copied();
                follows.filter(|(n, _)| !self.prescribed[*n as usize]).collect()
            }
        }
    }

    /// Whether any pressure of any rank is to be found. Collective.
    pub fn has_unknowns(&self, comm: &Comm) -> bool {
        let mut known = 0;
        self.for_identity_rows(|_| known += 1);
        comm.any(known < self.nodes.owned)
    }

    /// Adds the product of the matrices that [`PoreSpace::assemble`] would add, `like` by
    /// prototype, with expanded pressures, at all local nodes. Local.
    pub fn add_product(&self, like: &[Vec<f64>], p: &[f64], rows: &mut [f64]) {
        for cell in self.cells.iter().filter(|cell| self.is_free(cell)) {
            let (of, nodes) = (self.pressures(cell, p, 0.0), cell.corners());
            let matrix = &like[cell.prototype as usize];
            for (row, node) in matrix.chunks_exact(nodes.len()).zip(nodes) {
                rows[*node as usize] += row.iter().zip(&of).map(|(k, p)| k * p).sum::<f64>();
            }
        }
    }
}
