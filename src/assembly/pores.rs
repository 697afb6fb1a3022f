//! The pore pressure of one rank: its nodes, its cells, and their sums.
//!
//! The pressure is linear in every porous cell, whatever the order of the displacement; its nodes are
//! those of the column with cells of first order. Owned nodes come first, as everywhere.

use super::Discretization;
use super::pattern::{count_blocks, merge_to_owners};
use crate::bulk::{FlowStep, MAX_CORNERS, PorousCell};
use crate::comm::Comm;
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
    /// Sides joined by an open interface: each local node that follows others, with what it follows.
    pub followers: Vec<(u32, Vec<(u32, f64)>)>,
}

/// Numbers of the nodes of a cell.
struct Gathered {
    u: Vec<f64>,
    p: [f64; MAX_CORNERS],
}

impl PoreSpace {
    /// The shape of a cell's part of the arrays.
    fn gather(&self, all: &Discretization, cell: &PoreCell, u: &[f64], out: &mut Gathered) {
        out.u.clear();
        for node in all.cells.nodes(cell.cell as usize) {
            out.u.extend_from_slice(&u[*node as usize * self.dim..][..self.dim]);
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
        let mut gathered = Gathered { u: Vec::new(), p: [0.0; MAX_CORNERS] };
        for cell in self.cells.iter().filter(|cell| self.is_free(cell)) {
            self.gather(all, cell, u, &mut gathered);
            gathered.p = [0.0; MAX_CORNERS];
            let like = &self.prototypes[cell.prototype as usize];
            like.add_volume(&gathered.u, &mut gathered.p[..np]);
            for (node, v) in cell.nodes[..np].iter().zip(&gathered.p) {
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
        let mut gathered = Gathered { u: Vec::new(), p: [0.0; MAX_CORNERS] };
        for cell in self.cells.iter().filter(|cell| every || self.is_free(cell)) {
            if !u.is_empty() {
                self.gather(all, cell, u, &mut gathered);
            }
            let (mut own, mut size) = ([0.0; MAX_CORNERS], [0.0; MAX_CORNERS]);
            let like = &self.prototypes[cell.prototype as usize];
            act(cell, like, &gathered.u, &mut own[..np], &mut size[..np]);
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
        let mut gathered = Gathered { u: Vec::new(), p: [0.0; MAX_CORNERS] };
        self.gather(all, cell, u, &mut gathered);
        let like = &self.prototypes[cell.prototype as usize];
        let p = self.pressures(cell, p, like.medium.reference);
        like.at_centre(&gathered.u, &p, gravity)
    }

    /// Turns owned pressures into those of all local nodes: zero where prescribed, and followers
    /// follow. Collective.
    pub fn expand(&self, p: &mut [f64]) {
        let clear = |p: &mut [f64]| {
            let prescribed = p.iter_mut().zip(&self.prescribed).filter(|(_, fixed)| **fixed);
            prescribed.for_each(|(p, _)| *p = 0.0);
        };
        clear(p);
        self.nodes.update_ghosts(p, 1);
        self.follow(p);
    }

    /// Gives every local follower the pressure that it follows. Local.
    pub fn follow(&self, p: &mut [f64]) {
        for (node, others) in &self.followers {
            p[*node as usize] = others.iter().map(|(n, c)| c * p[*n as usize]).sum();
        }
    }

    /// The transpose of [`PoreSpace::expand`]: sums of all local nodes to those of the owned unknowns,
    /// zero at identity rows. Collective.
    pub fn fold(&self, rows: &mut [f64]) {
        for (node, others) in &self.followers {
            let carried = std::mem::take(&mut rows[*node as usize]);
            others.iter().for_each(|(n, c)| rows[*n as usize] += c * carried);
        }
        self.nodes.add_to_owners(rows, 1);
        self.for_identity_rows(|node| rows[node] = 0.0);
    }

    /// Calls `act` with every owned node whose row is the identity. Local.
    pub fn for_identity_rows(&self, mut act: impl FnMut(usize)) {
        let owned = self.nodes.owned;
        (0..owned).filter(|node| self.prescribed[*node]).for_each(&mut act);
        let followers = self.followers.iter().map(|(node, _)| *node as usize);
        followers.filter(|node| *node < owned).for_each(act);
    }

    /// A pressure node over the unknowns.
    fn unknowns_of(&self, node: u32) -> Vec<(u32, f64)> {
        let free = |n: &u32| !self.prescribed[*n as usize];
        match self.followers.binary_search_by_key(&node, |f| f.0) {
            Ok(at) => self.followers[at].1.iter().filter(|(n, _)| free(n)).copied().collect(),
            Err(_) if free(&node) => vec![(node, 1.0)],
            Err(_) => Vec::new(),
        }
    }

    /// An empty matrix for [`PoreSpace::assemble`]. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn matrix(&self, comm: &Comm, petsc: &crate::petsc::Petsc) -> Result<Matrix> {
        let mut lists: Vec<Vec<i32>> = vec![Vec::new(); self.nodes.len()];
        for cell in &self.cells {
            let held = &cell.nodes[..self.corners()];
            let unknowns: Vec<u32> =
                held.iter().flat_map(|n| self.unknowns_of(*n)).map(|(n, _)| n).collect();
            for row in &unknowns {
                lists[*row as usize]
                    .extend(unknowns.iter().map(|n| self.nodes.numbers[*n as usize]));
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
                self.add_cell(cell, &like[cell.prototype as usize], factor, matrix)?;
            }
            let mut filled = Ok(());
            self.for_identity_rows(|node| {
                let number = [self.nodes.numbers[node]];
                if filled.is_ok() {
                    filled = matrix.add(&number, &number, &[diagonal]);
                }
            });
            filled
        };
        let filled = fill();
        comm.agree(filled)?;
        comm.agree(matrix.assemble())
    }

    fn add_cell(
        &self,
        cell: &PoreCell,
        values: &[f64],
        factor: f64,
        matrix: &mut Matrix,
    ) -> Result<()> {
        let np = self.corners();
        let expansions: Vec<Vec<(u32, f64)>> =
            cell.nodes[..np].iter().map(|n| self.unknowns_of(*n)).collect();
        if expansions.iter().all(|e| matches!(e[..], [(_, 1.0)])) {
            let numbers: Vec<i32> =
                cell.nodes[..np].iter().map(|n| self.nodes.numbers[*n as usize]).collect();
            let values: Vec<f64> = values.iter().map(|v| factor * v).collect();
            return matrix.add(&numbers, &numbers, &values);
        }
        for (a, rows) in expansions.iter().enumerate() {
            for (b, columns) in expansions.iter().enumerate() {
                for (row, left) in rows {
                    for (column, right) in columns {
                        let number = |n: &u32| [self.nodes.numbers[*n as usize]];
                        let value = factor * left * right * values[a * np + b];
                        matrix.add(&number(row), &number(column), &[value])?;
                    }
                }
            }
        }
        Ok(())
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
