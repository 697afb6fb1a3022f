//! Matrices of the pore pressure.

use super::PoreSpace;
use crate::assembly::films::PressureBlock;
use crate::assembly::pattern::{count_blocks, merge_to_owners};
use crate::bulk::PorousCell;
use crate::comm::Comm;
use crate::error::Result;
use crate::petsc::Matrix;

impl PoreSpace {
    /// Number of a local node among all; -1, which PETSc passes over, where the pressure is
    /// prescribed.
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
            let held = cell.corners().iter().flat_map(|n| self.unknowns(*n));
            let held: Vec<u32> = held.map(|(node, _)| node).collect();
            for row in &held {
                lists[*row as usize].extend(held.iter().map(|n| self.nodes.numbers[*n as usize]));
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

    /// Sets `matrix` to the sum of the symmetric matrices that `of_cell` gives for each prototype
    /// and of further `blocks` (m3/Pa), times `factor`, with `diagonal` at identity rows.
    /// Collective.
    ///
    /// # Errors
    /// `System` when PETSc refuses a value; on all ranks.
    pub fn assemble(
        &self,
        comm: &Comm,
        of_cell: impl Fn(&PorousCell) -> Vec<f64>,
        blocks: &[PressureBlock],
        factor: f64,
        diagonal: f64,
        matrix: &mut Matrix,
    ) -> Result<()> {
        matrix.zero()?;
        let like = self.prototypes.iter().map(of_cell);
        let like: Vec<Vec<f64>> = like.map(|m| m.iter().map(|v| factor * v).collect()).collect();
        let mut fill = || {
            for cell in &self.cells {
                self.add(cell.corners(), &like[cell.prototype as usize], matrix)?;
            }
            for PressureBlock { nodes, values } in blocks {
                let values: Vec<f64> = values.iter().map(|v| factor * v).collect();
                self.add(nodes, &values, matrix)?;
            }
            for node in (0..self.nodes.owned).filter(|node| self.is_known(*node)) {
                let number = [self.nodes.numbers[node]];
                matrix.add(&number, &number, &[diagonal])?;
            }
            Ok(())
        };
        let filled = fill();
        comm.agree(filled)?;
        comm.agree(matrix.assemble())
    }

    /// Adds the matrix of some local nodes to that of their unknowns. Local.
    fn add(&self, nodes: &[u32], values: &[f64], matrix: &mut Matrix) -> Result<()> {
        if nodes.iter().all(|node| self.tie_of[*node as usize].is_none()) {
            let numbers: Vec<i32> = nodes.iter().map(|node| self.number(*node)).collect();
            return matrix.add(&numbers, &numbers, values);
        }
        let unknowns: Vec<Vec<(u32, f64)>> =
            nodes.iter().map(|node| self.unknowns(*node)).collect();
        for (row, values) in unknowns.iter().zip(values.chunks_exact(nodes.len())) {
            for (column, value) in unknowns.iter().zip(values) {
                let numbers = |of: &[(u32, f64)]| -> Vec<i32> {
                    of.iter().map(|(n, _)| self.nodes.numbers[*n as usize]).collect()
                };
                let parts =
                    row.iter().flat_map(|(_, a)| column.iter().map(move |(_, b)| a * value * b));
                matrix.add(&numbers(row), &numbers(column), &parts.collect::<Vec<f64>>())?;
            }
        }
        Ok(())
    }
}
