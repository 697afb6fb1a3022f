//! The discrete problem of one rank: cells, nodes, jump rows; forces and tangent from them.
//!
//! The usual tangent is that of the condensed form (docs/theory.md): no multipliers, and the
//! secondary displacement eliminated where the jump is known. The saddle-point form keeps both. The
//! graphs do not depend on the state.

mod blocks;
mod boxes;
mod cells;
mod films;
mod frames;
mod friction;
mod general;
mod node_state;
mod operator;
mod pattern;
mod pores;
mod saddle;
mod second_order;
mod sweep;
mod tangent;
mod tangent_matrix;
mod coupled_matrix;

pub use cells::{CellSet, Cells};
pub use coupled_matrix::{CoupledMatrix, CoupledValues};
pub use films::{FilmFacet, FilmNode, FilmTangent, Films, Opening};
pub use frames::{Framed, Frames};
pub use node_state::NodeState;
pub use operator::{Precision, TangentOperator};
pub use pattern::Pattern;
pub use pores::{PoreCell, PoreSpace, Tie};
pub use saddle::{LawDerivative, SaddleTangent};
pub use tangent::Tangent;
pub use tangent_matrix::TangentMatrix;

use std::cell::OnceCell;

use crate::interface::JumpRows;
use crate::space::Nodes;
use blocks::Blocks;

/// What the assembly knows of the discretisation, by local number.
pub struct Discretization {
    /// Displacement components per node.
    pub dim: usize,
    /// The cells of this rank.
    pub cells: Cells,
    /// The nodes of this rank.
    pub nodes: Nodes,
    /// The nodes whose unknowns are not their displacements.
    pub frames: Frames,
    /// Prescribed unknowns of each local node.
    pub prescribed: Vec<[bool; 3]>,
    /// Jump rows of the secondary nodes, owned ones first, by rising local number.
    pub secondary: Vec<JumpRows<u32>>,
    /// Index into `secondary` of each local node.
    pub secondary_of: Vec<Option<u32>>,
    /// The cells that are no boxes in single precision, once they are asked for.
    blocks: OnceCell<Blocks>,
}

impl Discretization {
    /// Puts the parts together; `rows` name their nodes, all of which `nodes` must hold, and are
    /// those of displacements; `prescribed` are the prescribed unknowns of each local node.
    pub fn new(
        dim: usize,
        cells: Cells,
        nodes: Nodes,
        frames: Frames,
        prescribed: Vec<[bool; 3]>,
        rows: Vec<JumpRows<u64>>,
    ) -> Self {
        let local = |name| nodes.local(name).expect("the row's nodes are held");
        let mut secondary: Vec<JumpRows<u32>> =
            rows.into_iter().map(|rows| frames.rows(rows.renamed(local))).collect();
        secondary.sort_by_key(|r| r.node);
        let mut secondary_of = vec![None; nodes.len()];
        for (index, rows) in secondary.iter().enumerate() {
            secondary_of[rows.node as usize] = Some(index as u32);
        }
        let blocks = OnceCell::new();
        let mut all =
            Self { dim, cells, nodes, frames, prescribed, secondary, secondary_of, blocks };
        all.mark_interface_cells();
        all
    }

    /// Secondary nodes that this rank owns; they stand first in `secondary`.
    pub fn owned_secondary(&self) -> usize {
        self.secondary.partition_point(|r| (r.node as usize) < self.nodes.owned)
    }

    /// Name of the node and interface of an entry of `secondary`. Local.
    pub fn name_and_interface(&self, index: usize) -> (u64, usize) {
        let rows = &self.secondary[index];
        (self.nodes.names[rows.node as usize], rows.interface)
    }

    /// Components of a local node whose row of the tangent is the identity: prescribed and stuck
    /// ones. Local.
    pub fn identity_components(&self, state: &[NodeState], node: usize) -> [bool; 3] {
        let mut identity = self.prescribed[node];
        if let Some(index) = self.secondary_of[node] {
            let rows = &self.secondary[index as usize].rows;
            for c in 0..self.dim {
                identity[c] |= rows[c].is_some() && state[index as usize].stuck[c];
            }
        }
        identity
    }

    /// The jump of a component at an entry of `secondary`, 0 where it has none (m); `u` holds the
    /// displacements of all local nodes. Local.
    pub fn jump(&self, index: usize, component: usize, u: &[f64]) -> f64 {
        let rows = &self.secondary[index];
        let Some(row) = &rows.rows[component] else { return 0.0 };
        row.trace(rows.own(component), |unknown| u[unknown as usize])
    }

    /// Adds the forces of the cells in `set` at the unknowns `u` to `force` (N), both `dim` numbers
    /// per local node; `magnitude` as for [`Cells::add_forces`]. Local.
    pub fn add_forces(
        &self,
        set: CellSet,
        u: &[f64],
        force: &mut [f64],
        magnitude: Option<&mut [f64]>,
    ) {
        if self.frames.is_empty() {
            return self.cells.add_forces(set, u, force, magnitude);
        }
        let mut of_cells = vec![0.0; force.len()];
        self.cells.add_forces(set, &self.frames.displacements(u), &mut of_cells, magnitude);
        self.frames.fold(&mut of_cells);
        force.iter_mut().zip(of_cells).for_each(|(f, of_cells)| *f += of_cells);
    }

    /// As [`Discretization::add_forces`] of all cells without magnitudes, with the forces at owned
    /// nodes apart from those at ghosts. Local.
    pub fn add_forces_apart(&self, u: &[f64], owned: &mut [f64], ghosts: &mut [f64]) {
        if self.frames.is_empty() {
            return self.cells.add_forces_apart(u, owned, ghosts);
        }
        let mut force = vec![0.0; u.len()];
        self.add_forces(CellSet::All, u, &mut force, None);
        let (own, far) = force.split_at(owned.len());
        owned.iter_mut().zip(own).for_each(|(f, of_cells)| *f += of_cells);
        ghosts.iter_mut().zip(far).for_each(|(f, of_cells)| *f += of_cells);
    }

    /// As [`Discretization::add_forces_apart`] in single precision. Local.
    pub fn add_single_forces_apart(&self, u: &[f32], owned: &mut [f32], ghosts: &mut [f32]) {
        self.cells.add_single_forces_apart(u, owned, ghosts);
        let blocks = self.blocks.get_or_init(|| {
            Blocks::new(self.dim, self.nodes.len(), &self.cells, &|cell, see| {
                see(self.cell_matrix(cell, &mut Vec::new()));
            })
        });
        blocks.add_forces_apart(u, owned, ghosts);
    }

    /// The stiffness of a cell between the unknowns of its nodes, row by row (N/m), in `buffer`
    /// where it is not at hand. Local.
    pub fn cell_matrix<'m>(&'m self, cell: usize, buffer: &'m mut Vec<f64>) -> &'m [f64] {
        let nodes = self.cells.nodes(cell);
        if !self.frames.touch(nodes) {
            return self.cells.matrix(cell, buffer);
        }
        let mut framed = self.cells.matrix(cell, buffer).to_vec();
        self.frames.fold_matrix(nodes, &mut framed);
        *buffer = framed;
        buffer
    }

    /// Adds the diagonal of the cells' stiffness (N/m), `dim` numbers per local node. Local.
    pub fn add_diagonal(&self, diagonal: &mut [f64]) {
        if self.frames.is_empty() {
            return self.cells.add_diagonal(diagonal);
        }
        let (dim, mut buffer) = (self.dim, Vec::new());
        for cell in 0..self.cells.len() {
            let nodes = self.cells.nodes(cell);
            let matrix = self.cell_matrix(cell, &mut buffer);
            for (i, entry) in matrix.iter().step_by(nodes.len() * dim + 1).enumerate() {
                diagonal[nodes[i / dim] as usize * dim + i % dim] += entry;
            }
        }
    }

    /// Calls `act` with node and component of every owned prescribed component. Local.
    ///
    /// # Errors
    /// The first of `act`.
    pub fn for_prescribed(
        &self,
        mut act: impl FnMut(usize, usize) -> crate::error::Result<()>,
    ) -> crate::error::Result<()> {
        for node in 0..self.nodes.owned {
            for component in (0..self.dim).filter(|c| self.prescribed[node][*c]) {
                act(node, component)?;
            }
        }
        Ok(())
    }

    /// The nodes whose rows of the tangent a cell contributes to: its own, and those over which the
    /// jump rows of its secondary nodes extend and that are not prescribed.
    pub fn coupled_nodes(&self, cell: usize, out: &mut Vec<u32>) {
        out.clear();
        out.extend_from_slice(self.cells.nodes(cell));
        for i in 0..out.len() {
            let Some(index) = self.secondary_of[out[i] as usize] else { continue };
            for row in self.secondary[index as usize].rows.iter().flatten() {
                for (unknown, _) in &row.others {
                    let node = unknown / self.dim as u32;
                    if !out.contains(&node) {
                        out.push(node);
                    }
                }
            }
        }
    }

    /// Adds the forces of tractions on the interfaces to `force` (N, `dim` numbers per local node),
    /// which is then complete at owned nodes; `traction` gives component c at the owned secondary
    /// node of an index (Pa). Collective.
    pub fn add_tractions(&self, traction: impl Fn(usize, usize) -> f64, force: &mut [f64]) {
        force[self.nodes.owned * self.dim..].fill(0.0);
        for (index, rows) in self.secondary[..self.owned_secondary()].iter().enumerate() {
            for (c, row) in rows.rows[..self.dim].iter().enumerate() {
                let Some(row) = row else { continue };
                let traction = row.weight * traction(index, c);
                row.spread(rows.own(c), traction, |unknown, f| force[unknown as usize] += f);
            }
        }
        self.nodes.add_to_owners(force, self.dim);
    }

    fn mark_interface_cells(&mut self) {
        let touches = |cell: usize| {
            self.cells.nodes(cell).iter().any(|n| self.secondary_of[*n as usize].is_some())
        };
        let layer: Vec<u32> =
            (0..self.cells.len()).filter(|c| touches(*c)).map(|c| c as u32).collect();
        self.cells.set_layer(layer);
    }
}
