//! The tangent of displacement and pore pressure as one matrix, for elimination.
//!
//! A rank's displacement components come first, then its pressures, as in the vectors of the
//! coupled problem. The coupling is taken to the unknowns of the condensed form like the stiffness
//! of a cell.

use super::pattern::{count_blocks, merge_to_owners};
use super::tangent::{expand_cell, rows_of_friction};
use super::{Discretization, NodeState, Pattern, PoreCell, PoreSpace};
use crate::comm::Comm;
use crate::error::Result;
use crate::petsc::{Matrix, Petsc};

/// Numbers of the rows of one matrix for both fields.
pub struct CoupledMatrix {
    /// First component of each local displacement node.
    displacement: Vec<i32>,
    /// Each local pressure node.
    pressure: Vec<i32>,
    /// First displacement component, numbered without pressures, and first pressure of every rank.
    starts: Vec<[i32; 2]>,
    /// First row of this rank.
    first: i32,
}

/// The values beside the tangent of the displacements.
pub struct CoupledValues<'v> {
    /// State of every entry of `Discretization::secondary`.
    pub state: &'v [NodeState],
    /// C of each prototype of the pressure's cells (m3/Pa).
    pub compressibility: &'v [Vec<f64>],
    /// Pressure over its unknown (Pa/m).
    pub scale: f64,
    /// Entry of identity rows (N/m).
    pub diagonal: f64,
}

impl CoupledMatrix {
    /// The numbering. Collective.
    pub fn new(comm: &Comm, all: &Discretization, pores: &PoreSpace) -> Self {
        let (u, p, dim) = (&all.nodes, &pores.nodes, all.dim as i32);
        let starts = comm.exchange(&vec![vec![u.first * dim, p.first]; comm.size() as usize]);
        // Numbers are whole and far below 2^53.
        let shifted = |nodes: &crate::space::Nodes, width: i32, shift: i32| {
            let mut numbers: Vec<f64> =
                nodes.numbers.iter().map(|n| f64::from(n * width + shift)).collect();
            nodes.update_ghosts(&mut numbers, 1);
            numbers.into_iter().map(|n| n as i32).collect()
        };
        Self {
            displacement: shifted(u, dim, p.first),
            pressure: shifted(p, 1, (u.first + u.owned as i32) * dim),
            starts: starts.iter().map(|start| [start[0], start[1]]).collect(),
            first: u.first * dim + p.first,
        }
    }

    /// Numbers of the components of a local displacement node.
    fn components(&self, node: u32, dim: usize) -> impl Iterator<Item = i32> + use<> {
        let first = self.displacement[node as usize];
        (0..dim as i32).map(move |c| first + c)
    }

    /// Number of a local pressure node; -1, which PETSc passes over, where the pressure is
    /// prescribed.
    fn pressure(&self, pores: &PoreSpace, node: u32) -> i32 {
        if pores.prescribed[node as usize] { -1 } else { self.pressure[node as usize] }
    }

    fn pressures(&self, pores: &PoreSpace, cell: &PoreCell) -> Vec<i32> {
        cell.corners().iter().map(|n| self.pressure(pores, *n)).collect()
    }

    /// An empty matrix, its rows counted exactly. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn matrix(
        &self,
        comm: &Comm,
        petsc: &Petsc,
        all: &Discretization,
        pores: &PoreSpace,
    ) -> Result<Matrix> {
        let dim = all.dim;
        let mut of_nodes: Vec<Vec<i32>> = vec![Vec::new(); all.nodes.len()];
        let mut of_pressures: Vec<Vec<i32>> = vec![Vec::new(); pores.nodes.len()];
        let mut coupled = Vec::new();
        for cell in &pores.cells {
            all.coupled_nodes(cell.cell as usize, &mut coupled);
            let columns: Vec<i32> =
                self.pressures(pores, cell).into_iter().filter(|number| *number >= 0).collect();
            for node in &coupled {
                of_nodes[*node as usize].extend_from_slice(&columns);
            }
            let free = cell.corners().iter().filter(|n| !pores.prescribed[**n as usize]);
            for node in free {
                let list = &mut of_pressures[*node as usize];
                list.extend(coupled.iter().flat_map(|n| self.components(*n, dim)));
                list.extend_from_slice(&columns);
                list.sort_unstable();
                list.dedup();
            }
        }
        for (node, list) in of_pressures.iter_mut().enumerate().take(pores.nodes.owned) {
            list.push(self.pressure[node]);
        }
        let (u, p) = (&all.nodes, &pores.nodes);
        let own = self.first..self.first + (u.owned * dim + p.owned) as i32;
        let beside = merge_to_owners(comm, u, &u.numbers, u.first, of_nodes);
        let beside = count_blocks(beside.iter().map(Vec::as_slice), own.clone());
        let below = merge_to_owners(comm, p, &p.numbers, p.first, of_pressures);
        let below = count_blocks(below.iter().map(Vec::as_slice), own);
        let bulk = Pattern::new(comm, all).counts(u.first);
        let rows = |bulk: &[i32], beside: &[i32], below: Vec<i32>| -> Vec<i32> {
            let pairs = bulk.iter().zip(beside);
            let wide = pairs.flat_map(|(b, p)| std::iter::repeat_n(b * dim as i32 + p, dim));
            wide.chain(below).collect()
        };
        let inside = rows(&bulk.0, &beside.0, below.0);
        let outside = rows(&bulk.1, &beside.1, below.1);
        Matrix::new(petsc, inside.len(), 1, &inside, &outside)
    }

    /// Sets all values, `bulk` being the assembled tangent of the displacements. Collective.
    ///
    /// # Errors
    /// `System` when PETSc refuses a value, for instance one outside the graph; on all ranks.
    pub fn assemble(
        &self,
        comm: &Comm,
        all: &Discretization,
        pores: &PoreSpace,
        bulk: &Matrix,
        values: &CoupledValues<'_>,
        matrix: &mut Matrix,
    ) -> Result<()> {
        matrix.zero()?;
        let filled = self.fill(all, pores, bulk, values, matrix);
        comm.agree(filled)?;
        comm.agree(matrix.assemble())
    }

    fn fill(
        &self,
        all: &Discretization,
        pores: &PoreSpace,
        bulk: &Matrix,
        values: &CoupledValues<'_>,
        matrix: &mut Matrix,
    ) -> Result<()> {
        let mut columns = Vec::new();
        bulk.for_each_row(|row, of, entries| {
            columns.clear();
            columns.extend(of.iter().map(|column| self.among_both(*column)));
            matrix.add(&[self.among_both(row)], &columns, entries)
        })?;
        let mut coupled = Vec::new();
        for cell in &pores.cells {
            self.add_cell(all, pores, cell, values, &mut coupled, matrix)?;
        }
        for node in (0..pores.nodes.owned).filter(|node| pores.prescribed[*node]) {
            let number = [self.pressure[node]];
            matrix.add(&number, &number, &[values.diagonal])?;
        }
        Ok(())
    }

    /// Number in both fields of a displacement component that is numbered without pressures.
    fn among_both(&self, component: i32) -> i32 {
        let rank = self.starts.partition_point(|start| start[0] <= component) - 1;
        component + self.starts[rank][1]
    }

    /// The coupling and the compressibility of a cell.
    fn add_cell(
        &self,
        all: &Discretization,
        pores: &PoreSpace,
        cell: &PoreCell,
        values: &CoupledValues<'_>,
        coupled: &mut Vec<u32>,
        matrix: &mut Matrix,
    ) -> Result<()> {
        let (dim, np, scale) = (all.dim, cell.corners().len(), values.scale);
        let numbers = self.pressures(pores, cell);
        if numbers.iter().all(|number| *number < 0) {
            return Ok(());
        }
        all.coupled_nodes(cell.cell as usize, coupled);
        let columns = expand_cell(all, values.state, cell.cell as usize, coupled);
        // The pressure is part of the traction that friction follows.
        let friction = rows_of_friction(all, values.state, cell.cell as usize, coupled, &columns);
        let equations = friction.as_ref().unwrap_or(&columns);
        let width = coupled.len() * dim;
        let mut across = vec![0.0; width * np];
        let mut back = vec![0.0; width * np];
        let like = &pores.prototypes[cell.prototype as usize];
        let (mut framed, nodes) = (Vec::new(), all.cells.nodes(cell.cell as usize));
        let forces = if all.frames.touch(nodes) {
            framed.extend_from_slice(like.forces());
            all.frames.fold_rows(nodes, &mut framed);
            &framed[..]
        } else {
            like.forces()
        };
        for (b, forces) in forces.chunks_exact(columns.len()).enumerate() {
            for (q, (equations, columns)) in forces.iter().zip(equations.iter().zip(&columns)) {
                for (equation, a) in equations {
                    across[equation * np + b] -= scale * a * q;
                }
                for (unknown, a) in columns {
                    back[b * width + unknown] -= scale * a * q;
                }
            }
        }
        let rows: Vec<i32> = coupled.iter().flat_map(|n| self.components(*n, dim)).collect();
        matrix.add(&rows, &numbers, &across)?;
        matrix.add(&numbers, &rows, &back)?;
        let own = values.compressibility[cell.prototype as usize].iter();
        let own: Vec<f64> = own.map(|c| -scale * scale * c).collect();
        matrix.add(&numbers, &numbers, &own)
    }
}
