//! A square distributed matrix of blocks, filled by cells.

use std::cell::RefCell;
use std::rc::Rc;

use super::halo::Halo;
use super::rows::BlockRows;
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::petsc::{LinearOperator, Matrix, Petsc};

/// A symmetric matrix in square blocks, in double precision. Its pattern is fixed when it is made.
pub struct BlockMatrix {
    /// Owned block rows; columns are local entries of the halo.
    pub rows: BlockRows<f64>,
    /// Of the block columns.
    pub halo: Rc<Halo>,
    /// Blocks for rows of other ranks: row, column, values.
    stash: Vec<f64>,
    /// A vector with its ghosts.
    work: RefCell<Vec<f64>>,
}

impl BlockMatrix {
    /// A matrix of zeros with the block columns of each owned block row, as numbers that rise.
    /// Collective.
    ///
    /// # Errors
    /// `Bug` when a number is one of no rank.
    pub fn new<'r>(
        comm: &Comm,
        block: usize,
        owned: usize,
        row: impl Fn(usize) -> &'r [i32],
    ) -> Result<Self> {
        let first = comm.exscan_u64(owned as u64);
        let own = first as i32..(first + owned as u64) as i32;
        let far = (0..owned).flat_map(&row).filter(|column| !own.contains(column));
        let mut ghosts: Vec<u64> = far.map(|column| *column as u64).collect();
        ghosts.sort_unstable();
        ghosts.dedup();
        let halo = Rc::new(Halo::new(comm, owned, ghosts)?);
        let columns = (0..owned).map(|i| {
            let place = |number: &i32| halo.local(*number as u64).expect("a column of the halo");
            let mut columns: Vec<u32> = row(i).iter().map(place).collect();
            columns.sort_unstable();
            columns
        });
        let rows = BlockRows::with_columns([block, block], columns);
        let work = RefCell::new(vec![0.0; halo.len() * block]);
        Ok(Self { rows, halo, stash: Vec::new(), work })
    }

    /// Sets every block to 0. Local.
    pub fn zero(&mut self) {
        self.rows.values.fill(0.0);
    }

    /// Sets the blocks of owned block rows, by local number, to 0. Local.
    pub fn zero_rows(&mut self, rows: &[u32]) {
        rows.iter().for_each(|row| self.rows.row_mut(*row as usize).fill(0.0));
    }

    /// Adds a dense block of blocks; `values` is row by row, over all point rows. Numbers are those
    /// of blocks, on any rank; negative rows are skipped. Local.
    ///
    /// # Errors
    /// `Bug` for a block outside the pattern.
    pub fn add_blocked(&mut self, rows: &[i32], columns: &[i32], values: &[f64]) -> Result<()> {
        let block = self.rows.height;
        let stride = columns.len() * block;
        let first = self.halo.first();
        for (i, row) in rows.iter().enumerate().filter(|(_, row)| **row >= 0) {
            let values = &values[i * block * stride..];
            let number = *row as u64;
            let own = number.checked_sub(first).filter(|own| *own < self.halo.owned as u64);
            for (j, column) in columns.iter().enumerate() {
                let values = &values[j * block..];
                let Some(own) = own else {
                    self.stash.extend([f64::from(*row), f64::from(*column)]);
                    let rows = (0..block).flat_map(|h| &values[h * stride..][..block]);
                    self.stash.extend(rows);
                    continue;
                };
                self.add(own as usize, *column as u64, values, stride)?;
            }
        }
        Ok(())
    }

    fn add(&mut self, row: usize, column: u64, values: &[f64], stride: usize) -> Result<()> {
        let place = self.halo.local(column).and_then(|column| self.rows.place(row, column));
        let Some(place) = place else {
            return Err(Error::Bug(format!("block {row}, {column} outside the pattern")));
        };
        self.rows.add(row, place, values, stride);
        Ok(())
    }

    /// Sends what belongs to other ranks. Collective.
    ///
    /// # Errors
    /// `Bug` for a block outside the pattern; rank-local, so to be agreed on by the caller.
    pub fn assemble(&mut self, comm: &Comm) -> Result<()> {
        if comm.size() == 1 {
            return Ok(());
        }
        let block = self.rows.height;
        let length = 2 + block * block;
        let mut outgoing = vec![Vec::new(); comm.size() as usize];
        for entry in std::mem::take(&mut self.stash).chunks_exact(length) {
            outgoing[self.halo.owner(entry[0] as u64)].extend_from_slice(entry);
        }
        for entry in comm.exchange(&outgoing).iter().flat_map(|list| list.chunks_exact(length)) {
            let row = entry[0] as u64 - self.halo.first();
            self.add(row as usize, entry[1] as u64, &entry[2..], block)?;
        }
        Ok(())
    }

    /// A matrix of PETSc with room for these entries. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails or memory is short.
    pub fn empty_copy(&self, petsc: &Petsc) -> Result<Matrix> {
        let counts = |row: usize| {
            let columns = self.rows.row(row).columns;
            let own = columns.partition_point(|c| (*c as usize) < self.halo.owned);
            (own as i32, (columns.len() - own) as i32)
        };
        let (own, other): (Vec<_>, Vec<_>) = (0..self.rows.len()).map(counts).unzip();
        let block = self.rows.height;
        Matrix::new(petsc, self.rows.len() * block, block, &own, &other)
    }

    /// Writes all entries into a matrix made by [`BlockMatrix::empty_copy`]. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn write(&self, comm: &Comm, copy: &mut Matrix) -> Result<()> {
        let block = self.rows.height;
        let mut columns = Vec::new();
        let mut set = || -> Result<()> {
            for i in 0..self.rows.len() {
                let row = self.rows.row(i);
                columns.clear();
                for column in row.columns {
                    let first = self.halo.number(*column as usize) as i32 * block as i32;
                    columns.extend(first..first + block as i32);
                }
                let first = self.halo.number(i) as i32 * block as i32;
                for (number, values) in (first..).zip(row.values.chunks_exact(columns.len())) {
                    copy.set(&[number], &columns, values)?;
                }
            }
            Ok(())
        };
        comm.agree(set())?;
        copy.assemble()
    }
}

impl LinearOperator for BlockMatrix {
    fn multiply(&self, x: &[f64], y: &mut [f64]) {
        let work = &mut *self.work.borrow_mut();
        work[..x.len()].copy_from_slice(x);
        self.halo.update(work, self.rows.width);
        self.rows.multiply(work, y);
    }

    fn diagonal(&self, d: &mut [f64]) {
        let block = self.rows.height;
        let mut values = vec![0.0; block * block];
        for (i, d) in d.chunks_exact_mut(block).enumerate() {
            let place = self.rows.place(i, i as u32).expect("a diagonal block");
            self.rows.block(i, place, &mut values);
            d.iter_mut().zip(values.iter().step_by(block + 1)).for_each(|(d, a)| *d = *a);
        }
    }
}
