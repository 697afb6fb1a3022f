//! The pore pressure of one rank: its nodes, its cells, and their sums.
//!
//! The pressure is linear in every porous cell, whatever the order of the displacement; its nodes are
//! those of the column with cells of first order. Owned nodes come first, as everywhere.

use super::Discretization;
use super::pattern::{count_blocks, merge_to_owners};
use crate::bulk::{FlowStep, MAX_CORNERS, PorousCell};
use crate::comm::Comm;
use crate::element::Shape;
use crate::error::Result;
use crate::petsc::Matrix;
use crate::space::Nodes;

/// A porous cell of this rank.
#[derive(Debug, Clone, Copy)]
pub struct PoreCell {
    /// Index among the cells of [`Discretization`].
    pub cell: u32,
    /// Index among the prototypes.
    pub prototype: u16,
    /// Local pressure nodes, in the order of the corners of the cell.
    pub nodes: [u32; MAX_CORNERS],
}

/// The discretisation of the pore pressure.
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
    /// Names of the displacement nodes at the owned pressure nodes.
    pub displacement_names: Vec<u64>,
}

impl PoreSpace {
    /// Takes the displacements of the nodes of a cell out of those of all local nodes.
    fn gather(&self, all: &Discretization, cell: &PoreCell, u: &[f64], out: &mut Vec<f64>) {
        out.clear();
        for node in all.cells.nodes(cell.cell as usize) {
            out.extend_from_slice(&u[*node as usize * self.dim..][..self.dim]);
        }
    }

    fn corners(&self) -> usize {
        1 << self.dim
    }

    /// The cell's pressures above the reference.
    fn pressures(&self, cell: &PoreCell, p: &[f64], reference: f64) -> [f64; MAX_CORNERS] {
        let mut of = [0.0; MAX_CORNERS];
        for (of, node) in of.iter_mut().zip(&cell.nodes[..self.corners()]) {
            *of = p[*node as usize] - reference;
        }
        of
    }

    /// Adds the forces of the pressures `p` of all local nodes (Pa) on the local displacement nodes (N);
    /// above the references where `absolute`. Local.
    pub fn add_forces(&self, all: &Discretization, p: &[f64], absolute: bool, force: &mut [f64]) {
        let np = self.corners();
        let mut of_cell = Vec::new();
        for cell in &self.cells {
            let like = &self.prototypes[cell.prototype as usize];
            let reference = if absolute { like.medium.reference } else { 0.0 };
            let p = self.pressures(cell, p, reference);
            if p[..np].iter().all(|p| *p == 0.0) {
                continue;
            }
            let nodes = all.cells.nodes(cell.cell as usize);
            of_cell.clear();
            of_cell.resize(nodes.len() * self.dim, 0.0);
            like.add_force(&p[..np], &mut of_cell);
            for (node, f) in nodes.iter().zip(of_cell.chunks_exact(self.dim)) {
                let target = &mut force[*node as usize * self.dim..][..self.dim];
                target.iter_mut().zip(f).for_each(|(t, f)| *t += f);
            }
        }
    }

    /// Adds b times the volume that displacements make at the shares of the local pressure nodes (m3):
    /// the transpose of [`PoreSpace::add_forces`]. Local.
    pub fn add_volumes(&self, all: &Discretization, u: &[f64], volume: &mut [f64]) {
        let np = self.corners();
        let mut of_cell = Vec::new();
        for cell in self.cells.iter().filter(|cell| self.is_free(cell)) {
            self.gather(all, cell, u, &mut of_cell);
            let mut own = [0.0; MAX_CORNERS];
            let like = &self.prototypes[cell.prototype as usize];
            like.add_volume(&of_cell, &mut own[..np]);
            for (node, v) in cell.nodes[..np].iter().zip(&own) {
                volume[*node as usize] += v;
            }
        }
    }

    /// Whether a pressure of the cell is to be found.
    fn is_free(&self, cell: &PoreCell) -> bool {
        cell.nodes[..self.corners()].iter().any(|n| !self.prescribed[*n as usize])
    }

    /// Adds the balance of the fluid at the end of a step at the local nodes, and the magnitudes of its
    /// parts (m3), in cells where a pressure is to be found or in `every` cell; see
    /// [`PorousCell::add_balance`]. Local.
    pub fn add_balance(
        &self,
        all: &Discretization,
        (u, p, before): (&[f64], &[f64], &[f64]),
        step: &FlowStep,
        every: bool,
        (rows, sizes): (&mut [f64], &mut [f64]),
    ) {
        self.each(all, u, every, (rows, sizes), |cell, like, u, rows, sizes| {
            let reference = like.medium.reference;
            let (p, before) =
                (self.pressures(cell, p, reference), self.pressures(cell, before, reference));
            like.add_balance((u, &p, &before), step, rows, sizes);
        });
    }

    /// Adds the change of the stored fluid since the undeformed state at every local node (m3). Local.
    pub fn add_stored(
        &self,
        all: &Discretization,
        (u, p): (&[f64], &[f64]),
        lumped: bool,
        rows: &mut [f64],
    ) {
        let mut sizes = vec![0.0; rows.len()];
        self.each(all, u, true, (rows, &mut sizes), |cell, like, u, rows, sizes| {
            let p = self.pressures(cell, p, like.medium.reference);
            like.add_stored(u, &p, lumped, rows, sizes);
        });
    }

    /// Adds what flows off every local node per second (m3/s). Local.
    pub fn add_flow(&self, all: &Discretization, p: &[f64], gravity: &[f64; 3], rows: &mut [f64]) {
        let mut sizes = vec![0.0; rows.len()];
        self.each(all, &[], true, (rows, &mut sizes), |cell, like, _, rows, sizes| {
            let p = self.pressures(cell, p, like.medium.reference);
            like.add_flow(&p, gravity, 1.0, rows, sizes);
        });
    }

    fn each(
        &self,
        all: &Discretization,
        u: &[f64],
        every: bool,
        (rows, sizes): (&mut [f64], &mut [f64]),
        act: impl Fn(&PoreCell, &PorousCell, &[f64], &mut [f64], &mut [f64]),
    ) {
        let np = self.corners();
        let mut of_cell = Vec::new();
        for cell in self.cells.iter().filter(|cell| every || self.is_free(cell)) {
            if !u.is_empty() {
                self.gather(all, cell, u, &mut of_cell);
            }
            let (mut own, mut size) = ([0.0; MAX_CORNERS], [0.0; MAX_CORNERS]);
            let like = &self.prototypes[cell.prototype as usize];
            act(cell, like, &of_cell, &mut own[..np], &mut size[..np]);
            for (node, (own, size)) in cell.nodes[..np].iter().zip(own.iter().zip(&size)) {
                rows[*node as usize] += own;
                sizes[*node as usize] += size;
            }
        }
    }

    /// Flux (kg/m2/s by component), pressure above the reference (Pa) and porosity at the centre of a
    /// cell; `u` and `p` are those of all local nodes. Local.
    pub fn at_centre(
        &self,
        all: &Discretization,
        cell: &PoreCell,
        (u, p): (&[f64], &[f64]),
        gravity: &[f64; 3],
    ) -> ([f64; 3], f64, f64) {
        let mut of_cell = Vec::new();
        self.gather(all, cell, u, &mut of_cell);
        let like = &self.prototypes[cell.prototype as usize];
        let p = self.pressures(cell, p, like.medium.reference);
        like.at_centre(&of_cell, &p, gravity)
    }

    /// Pressures of all local nodes at every owned displacement node of porous cells (Pa), linear between
    /// the corners of a cell; 0 at others. Collective.
    pub fn at_nodes(&self, all: &Discretization, pressure: &[f64]) -> Vec<f64> {
        // Value and number of ranks that know it.
        let mut at = vec![[0.0; 2]; all.nodes.len()];
        for cell in &self.cells {
            let nodes = all.cells.nodes(cell.cell as usize);
            let order = if nodes.len() > 1 << all.dim { 2 } else { 1 };
            let shape = Shape::of(all.dim, order);
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
    }

    /// The transpose of [`PoreSpace::expand`]: sums of all local nodes to those of the owned unknowns,
    /// zero at identity rows. Collective.
    pub fn fold(&self, rows: &mut [f64]) {
        self.nodes.add_to_owners(rows, 1);
        self.for_identity_rows(|node| rows[node] = 0.0);
    }

    /// Calls `act` with every owned node whose row is the identity. Local.
    pub fn for_identity_rows(&self, act: impl FnMut(usize)) {
        (0..self.nodes.owned).filter(|node| self.prescribed[*node]).for_each(act);
    }

    /// Whether any pressure of any rank is to be found. Collective.
    pub fn has_unknowns(&self, comm: &Comm) -> bool {
        let mut known = 0;
        self.for_identity_rows(|_| known += 1);
        comm.any(known < self.nodes.owned)
    }

    /// Number of a local node among all; -1, which PETSc passes over, where the pressure is prescribed.
    fn number(&self, node: u32) -> i32 {
        if self.prescribed[node as usize] { -1 } else { self.nodes.numbers[node as usize] }
    }

    /// An empty matrix for [`PoreSpace::assemble`]. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn matrix(&self, comm: &Comm, petsc: &crate::petsc::Petsc) -> Result<Matrix> {
        let mut lists: Vec<Vec<i32>> = vec![Vec::new(); self.nodes.len()];
        for cell in &self.cells {
            let held = &cell.nodes[..self.corners()];
            let numbers = || held.iter().map(|n| self.number(*n)).filter(|number| *number >= 0);
            for row in held.iter().filter(|n| !self.prescribed[**n as usize]) {
                lists[*row as usize].extend(numbers());
            }
        }
        for (node, list) in lists.iter_mut().enumerate().take(self.nodes.owned) {
            list.push(self.nodes.numbers[node]);
        }
        for list in &mut lists {
            list.sort_unstable();
            list.dedup();
        }
        let first = self.nodes.first;
        let rows = merge_to_owners(comm, &self.nodes, &self.nodes.numbers, first, lists);
        let owned = self.nodes.owned;
        let own = first..first + owned as i32;
        let (inside, outside) = count_blocks(rows.iter().map(Vec::as_slice), own);
        Matrix::new(petsc, owned, 1, &inside, &outside)
    }

    /// Sets `matrix` to the sum of the symmetric matrices that `of_cell` gives for each prototype (m3/Pa),
    /// times `factor`, with `diagonal` at identity rows. Collective.
    ///
    /// # Errors
    /// `System` when PETSc refuses a value; on all ranks.
    pub fn assemble(
        &self,
        comm: &Comm,
        of_cell: impl Fn(&PorousCell) -> Vec<f64>,
        (factor, diagonal): (f64, f64),
        matrix: &mut Matrix,
    ) -> Result<()> {
        matrix.zero()?;
        let like: Vec<Vec<f64>> = self.prototypes.iter().map(of_cell).collect();
        let mut fill = || {
            for cell in &self.cells {
                let numbers: Vec<i32> =
                    cell.nodes[..self.corners()].iter().map(|n| self.number(*n)).collect();
                let values = like[cell.prototype as usize].iter().map(|v| factor * v);
                matrix.add(&numbers, &numbers, &values.collect::<Vec<f64>>())?;
            }
            for node in (0..self.nodes.owned).filter(|node| self.prescribed[*node]) {
                let number = [self.nodes.numbers[node]];
                matrix.add(&number, &number, &[diagonal])?;
            }
            Ok(())
        };
        let filled = fill();
        comm.agree(filled)?;
        comm.agree(matrix.assemble())
    }

    /// Adds the product of the matrices that [`PoreSpace::assemble`] would add, `like` by prototype,
    /// with expanded pressures, at all local nodes. Local.
    pub fn add_product(&self, like: &[Vec<f64>], p: &[f64], rows: &mut [f64]) {
        let np = self.corners();
        for cell in self.cells.iter().filter(|cell| self.is_free(cell)) {
            let of = self.pressures(cell, p, 0.0);
            let matrix = &like[cell.prototype as usize];
            for (row, node) in matrix.chunks_exact(np).zip(&cell.nodes) {
                rows[*node as usize] += row.iter().zip(&of).map(|(k, p)| k * p).sum::<f64>();
            }
        }
    }
}
