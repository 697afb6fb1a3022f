//! Numbering, graph and tangent of the saddle-point form: displacements and multipliers together.
//!
//! Each secondary node has a block of multipliers beside its block of displacements; a rank's
//! multiplier blocks follow its displacement blocks, so that its rows are contiguous. To give all
//! entries one size and one unit, the unknown of a row of the jump is weight times multiplier over
//! `scale`, and the equations of the law are multiplied by `scale` (N/m). Components without a
//! multiplier, and prescribed ones, have identity rows. Set anew as a whole whenever a law's
//! derivative changes: this form is a cross-check, not the fast way.

use super::Discretization;
use super::pattern::{count_blocks, merge_to_owners};
use crate::comm::Comm;
use crate::error::Result;
use crate::petsc::Matrix;

/// Derivative of the law at a secondary node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LawDerivative {
    /// A, the derivative of the jump by the augmented traction, by component (m/Pa).
    pub compliance: [[f64; 3]; 3],
    /// Augmentation r (Pa/m).
    pub augmentation: f64,
}

/// Sets the values of the tangent of the saddle-point form.
pub struct SaddleTangent {
    /// Block number of the displacements of each local node.
    numbers: Vec<i32>,
    /// Block number of the multipliers of the first owned secondary node.
    first_multiplier: i32,
    /// Diagonal entry of identity rows, and factor of the equations of the law (N/m).
    pub scale: f64,
}

impl SaddleTangent {
    /// The numbering; `scale` must be the same on all ranks. Collective.
    pub fn new(comm: &Comm, all: &Discretization, scale: f64) -> Self {
        let nodes = &all.nodes;
        let shift = comm.exscan_u64(all.owned_secondary() as u64) as i32;
        // Block numbers are whole and far below 2^53.
        let mut numbers: Vec<f64> = nodes.numbers.iter().map(|n| f64::from(n + shift)).collect();
        nodes.update_ghosts(&mut numbers, 1);
        Self {
            numbers: numbers.into_iter().map(|n| n as i32).collect(),
            first_multiplier: nodes.first + shift + nodes.owned as i32,
            scale,
        }
    }

    /// Blocks per owned block row whose column is owned, and is not: exact. Collective.
    pub fn counts(&self, comm: &Comm, all: &Discretization) -> (Vec<i32>, Vec<i32>) {
        let mut lists: Vec<Vec<i32>> = vec![Vec::new(); all.nodes.len()];
        for cell in 0..all.cells.len() {
            let nodes = all.cells.nodes(cell);
            for row in nodes {
                lists[*row as usize].extend(nodes.iter().map(|n| self.numbers[*n as usize]));
            }
        }
        let owned = all.owned_secondary();
        let mut multiplier_rows: Vec<Vec<i32>> = Vec::with_capacity(owned);
        for (index, rows) in all.secondary[..owned].iter().enumerate() {
            let multiplier = self.first_multiplier + index as i32;
            let mut list = vec![multiplier];
            for node in rows.nodes() {
                lists[node as usize].push(multiplier);
                list.push(self.numbers[node as usize]);
            }
            multiplier_rows.push(list);
        }
        let first = self.first_multiplier - all.nodes.owned as i32;
        let mut rows = merge_to_owners(comm, &all.nodes, &self.numbers, first, lists);
        rows.extend(multiplier_rows);
        count_blocks(rows.iter().map(Vec::as_slice), first..self.first_multiplier + owned as i32)
    }

    /// Sets all values; `law` holds the derivative at each owned secondary node. Collective.
    ///
    /// # Errors
    /// `System` when PETSc refuses a value, for instance one outside the graph; on all ranks.
    pub fn assemble(
        &self,
        comm: &Comm,
        all: &Discretization,
        law: &[LawDerivative],
        matrix: &mut Matrix,
    ) -> Result<()> {
        matrix.zero()?;
        let filled = self.fill(all, law, matrix);
        comm.agree(filled)?;
        let assembled = matrix.assemble();
        comm.agree(assembled)
    }

    fn fill(&self, all: &Discretization, law: &[LawDerivative], matrix: &mut Matrix) -> Result<()> {
        let (mut buffer, mut values) = (Vec::new(), Vec::new());
        for cell in 0..all.cells.len() {
            values.clear();
            values.extend_from_slice(all.cell_matrix(cell, &mut buffer));
            self.add_cell(all, cell, &mut values, matrix)?;
        }
        for (node, prescribed) in all.prescribed[..all.nodes.owned].iter().enumerate() {
            self.add_identity(all.dim, self.numbers[node], *prescribed, matrix)?;
        }
        for (index, law) in law.iter().enumerate() {
            self.add_multipliers(all, index, law, matrix)?;
        }
        Ok(())
    }

    /// The stiffness of a cell, which `values` hold, without the rows and columns of prescribed
    /// components.
    fn add_cell(
        &self,
        all: &Discretization,
        cell: usize,
        values: &mut [f64],
        matrix: &mut Matrix,
    ) -> Result<()> {
        let (nodes, dim) = (all.cells.nodes(cell), all.dim);
        let width = nodes.len() * dim;
        let fixed = |i: usize| all.prescribed[nodes[i / dim] as usize][i % dim];
        for i in (0..width).filter(|i| fixed(*i)) {
            for j in 0..width {
                values[i * width + j] = 0.0;
                values[j * width + i] = 0.0;
            }
        }
        let numbers: Vec<i32> = nodes.iter().map(|n| self.numbers[*n as usize]).collect();
        matrix.add_blocked(&numbers, &numbers, values)
    }

    fn add_identity(
        &self,
        dim: usize,
        number: i32,
        identity: [bool; 3],
        matrix: &mut Matrix,
    ) -> Result<()> {
        if !identity[..dim].contains(&true) {
            return Ok(());
        }
        let mut block = vec![0.0; dim * dim];
        for c in (0..dim).filter(|c| identity[*c]) {
            block[c * dim + c] = self.scale;
        }
        matrix.add_blocked(&[number], &[number], &block)
    }

    /// The columns of the multipliers of an owned secondary node, and their rows
    /// (1 - r A) dg - A d(lambda).
    fn add_multipliers(
        &self,
        all: &Discretization,
        index: usize,
        law: &LawDerivative,
        matrix: &mut Matrix,
    ) -> Result<()> {
        let (rows, dim) = (&all.secondary[index], all.dim);
        let multiplier = [self.first_multiplier + index as i32];
        let has_row = |c: usize| rows.rows[c].is_some();
        let by_jump = |c: usize, d: usize| {
            f64::from(u8::from(c == d)) - law.augmentation * law.compliance[c][d]
        };
        for node in rows.nodes() {
            let (mut column, mut row) = (vec![0.0; dim * dim], vec![0.0; dim * dim]);
            for d in (0..dim).filter(|d| !all.prescribed[node as usize][*d]) {
                let unknown = node * dim as u32 + d as u32;
                for e in 0..dim {
                    let entry = self.scale * rows.coefficient(e, unknown);
                    column[d * dim + e] = entry;
                    for c in (0..dim).filter(|c| has_row(*c)) {
                        row[c * dim + d] += by_jump(c, e) * entry;
                    }
                }
            }
            let number = [self.numbers[node as usize]];
            matrix.add_blocked(&number, &multiplier, &column)?;
            matrix.add_blocked(&multiplier, &number, &row)?;
        }
        let mut own = vec![0.0; dim * dim];
        for c in (0..dim).filter(|c| has_row(*c)) {
            for (d, row) in rows.rows[..dim].iter().enumerate() {
                if let Some(row) = row {
                    own[c * dim + d] = -self.scale * law.compliance[c][d] * self.scale / row.weight;
                }
            }
        }
        matrix.add_blocked(&multiplier, &multiplier, &own)?;
        self.add_identity(dim, multiplier[0], std::array::from_fn(|c| !has_row(c)), matrix)
    }
}
