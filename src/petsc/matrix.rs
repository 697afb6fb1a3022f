//! Distributed sparse matrices, preallocated exactly.

#![allow(unsafe_code)]

use super::error::check;
use super::vector::petsc_int;
use super::{Petsc, Vector, ffi};
use crate::error::{Error, Result};
use std::ptr;

mod near_null_space;

/// A sparse matrix with its rows shared out over the ranks, in square blocks; symmetric unless
/// [`Matrix::declare_unsymmetric`] says otherwise.
///
/// Its pattern is fixed by the first assembly, which therefore visits every entry that will ever be
/// used (adding 0 counts). An entry outside the pattern is an error afterwards.
pub struct Matrix {
    /// A valid matrix until drop.
    raw: ffi::Mat,
    petsc: Petsc,
    /// Rows on this rank.
    owned: usize,
    /// Rows on all ranks.
    global: i32,
    block_size: usize,
}

impl Matrix {
    /// An empty matrix with `owned_rows` rows (and as many columns) on this rank. Collective.
    ///
    /// The two lists give for each owned block row the number of blocks in columns that this rank
    /// owns, and in columns of other ranks.
    ///
    /// # Errors
    /// `Bug` when the lists do not fit; `System` when PETSc fails or memory is short.
    pub fn new(
        petsc: &Petsc,
        owned_rows: usize,
        block_size: usize,
        diagonal_nnz_per_block_row: &[i32],
        off_diagonal_nnz_per_block_row: &[i32],
    ) -> Result<Self> {
        let block_rows = owned_rows.checked_div(block_size).unwrap_or(0);
        if block_rows * block_size != owned_rows
            || diagonal_nnz_per_block_row.len() != block_rows
            || off_diagonal_nnz_per_block_row.len() != block_rows
        {
            return Err(Error::Bug(format!(
                "{owned_rows} rows in blocks of {block_size} with {} and {} counts",
                diagonal_nnz_per_block_row.len(),
                off_diagonal_nnz_per_block_row.len()
            )));
        }
        let comm = petsc.comm();
        let global = comm.sum_u64(owned_rows as u64);
        let global = petsc_int(usize::try_from(global).unwrap_or(usize::MAX), "unknowns")?;
        let rows = petsc_int(owned_rows, "rows")?;
        let block = petsc_int(block_size, "rows")?;
        let mut raw = ptr::null_mut();
        // SAFETY: PETSc is initialised and the communicator is alive.
        check(unsafe { ffi::MatCreate(comm.raw(), &mut raw) }, "MatCreate")?;
        let matrix = Matrix { raw, petsc: petsc.clone(), owned: owned_rows, global, block_size };
        // SAFETY: a valid matrix; the global size is the sum of the local ones.
        let code = unsafe { ffi::MatSetSizes(raw, rows, rows, global, global) };
        check(code, "MatSetSizes")?;
        // SAFETY: a valid matrix and the name of a type.
        check(unsafe { ffi::MatSetType(raw, c"aij".as_ptr()) }, "MatSetType")?;
        // SAFETY: a valid matrix whose sizes are multiples of the block size.
        check(unsafe { ffi::MatSetBlockSize(raw, block) }, "MatSetBlockSize")?;
        let expand = |counts: &[i32]| -> Vec<i32> {
            counts.iter().flat_map(|&n| std::iter::repeat_n(n * block, block_size)).collect()
        };
        let diagonal = expand(diagonal_nnz_per_block_row);
        let off_diagonal = expand(off_diagonal_nnz_per_block_row);
        // Each of the two does nothing for a matrix of the other type.
        // SAFETY: one count per owned row, read during the call.
        let code = unsafe { ffi::MatSeqAIJSetPreallocation(raw, 0, diagonal.as_ptr()) };
        check(code, "MatSeqAIJSetPreallocation")?;
        // SAFETY: as above, for both lists.
        let code = unsafe {
            ffi::MatMPIAIJSetPreallocation(raw, 0, diagonal.as_ptr(), 0, off_diagonal.as_ptr())
        };
        check(code, "MatMPIAIJSetPreallocation")?;
        for option in [
            ffi::MAT_NEW_NONZERO_ALLOCATION_ERR,
            ffi::MAT_KEEP_NONZERO_PATTERN,
            ffi::MAT_SYMMETRIC,
            // New values do not take the symmetry away.
            ffi::MAT_SYMMETRY_ETERNAL,
        ] {
            // SAFETY: a valid matrix with its type set.
            check(unsafe { ffi::MatSetOption(raw, option, ffi::PETSC_TRUE) }, "MatSetOption")?;
        }
        Ok(matrix)
    }

    /// Takes over a valid matrix.
    pub(super) fn from_raw(
        raw: ffi::Mat,
        petsc: &Petsc,
        owned: usize,
        global: i32,
        block_size: usize,
    ) -> Self {
        Matrix { raw, petsc: petsc.clone(), owned, global, block_size }
    }

    /// A matrix with the same pattern and values, symmetric, with the same motions for algebraic
    /// multigrid. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn duplicate(&self) -> Result<Self> {
        let (mut raw, mut motions) = (ptr::null_mut(), ptr::null_mut());
        // SAFETY: a valid, assembled matrix.
        let code = unsafe { ffi::MatDuplicate(self.raw, ffi::MAT_COPY_VALUES, &mut raw) };
        check(code, "MatDuplicate")?;
        let copy = Self::from_raw(raw, &self.petsc, self.owned, self.global, self.block_size);
        for option in [ffi::MAT_KEEP_NONZERO_PATTERN, ffi::MAT_SYMMETRIC, ffi::MAT_SYMMETRY_ETERNAL]
        {
            // SAFETY: a valid matrix.
            check(unsafe { ffi::MatSetOption(raw, option, ffi::PETSC_TRUE) }, "MatSetOption")?;
        }
        // SAFETY: a valid matrix, which lends its motions or null.
        let code = unsafe { ffi::MatGetNearNullSpace(self.raw, &mut motions) };
        check(code, "MatGetNearNullSpace")?;
        // SAFETY: a valid matrix, which takes a reference of its own.
        check(unsafe { ffi::MatSetNearNullSpace(raw, motions) }, "MatSetNearNullSpace")?;
        Ok(copy)
    }

    /// Takes back that the matrix is symmetric. Collective, before the first values.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn declare_unsymmetric(&mut self) -> Result<()> {
        for option in [ffi::MAT_SYMMETRY_ETERNAL, ffi::MAT_SYMMETRIC] {
            // SAFETY: a valid matrix with its type set.
            let code = unsafe { ffi::MatSetOption(self.raw, option, ffi::PETSC_FALSE) };
            check(code, "MatSetOption")?;
        }
        Ok(())
    }

    /// The handle, for the other files of the fence. Local.
    pub(super) fn raw(&self) -> ffi::Mat {
        self.raw
    }

    /// PETSc, for objects of the same layout. Local.
    pub(super) fn petsc(&self) -> &Petsc {
        &self.petsc
    }

    /// The number of rows on this rank. Local.
    pub fn owned_rows(&self) -> usize {
        self.owned
    }

    /// The number of rows in a block. Local.
    pub fn block_size(&self) -> usize {
        self.block_size
    }

    /// Checks numbers against the matrix; PETSc's own checks are compiled out.
    fn check_indices(
        &self,
        rows: &[i32],
        cols: &[i32],
        values: &[f64],
        width: usize,
    ) -> Result<()> {
        if values.len() != rows.len() * cols.len() * width * width {
            return Err(Error::Bug(format!(
                "{} values for {} by {} entries of {width}x{width}",
                values.len(),
                rows.len(),
                cols.len()
            )));
        }
        self.check_range(rows, width)?;
        self.check_range(cols, width)
    }

    fn check_range(&self, indices: &[i32], width: usize) -> Result<()> {
        let end = self.global / i32::try_from(width).unwrap_or(i32::MAX);
        match indices.iter().find(|&&i| i >= end) {
            Some(index) => Err(Error::Bug(format!("row or column {index} of a matrix of {end}"))),
            None => Ok(()),
        }
    }

    /// Adds a dense block of blocks; `values` is row by row, over all point rows. Local.
    ///
    /// `rows` and `cols` are global numbers of blocks, on any rank; negative ones are skipped.
    ///
    /// # Errors
    /// `Bug` for numbers outside the matrix; `System` for an entry outside the pattern.
    pub fn add_blocked(&mut self, rows: &[i32], cols: &[i32], values: &[f64]) -> Result<()> {
        self.check_indices(rows, cols, values, self.block_size)?;
        let (m, n) = (petsc_int(rows.len(), "rows")?, petsc_int(cols.len(), "columns")?);
        // SAFETY: m rows, n columns and m*n blocks, within the matrix (checked above).
        let code = unsafe {
            ffi::MatSetValuesBlocked(
                self.raw,
                m,
                rows.as_ptr(),
                n,
                cols.as_ptr(),
                values.as_ptr(),
                ffi::ADD_VALUES,
            )
        };
        check(code, "MatSetValuesBlocked")
    }

    /// Adds a dense block of entries; numbers are those of single rows. Local.
    ///
    /// # Errors
    /// As [`Matrix::add_blocked`].
    pub fn add(&mut self, rows: &[i32], cols: &[i32], values: &[f64]) -> Result<()> {
        self.insert(rows, cols, values, ffi::ADD_VALUES)
    }

    /// Sets a dense block of entries; not to be mixed with adding before [`Matrix::assemble`].
    /// Local.
    ///
    /// # Errors
    /// As [`Matrix::add_blocked`].
    pub fn set(&mut self, rows: &[i32], cols: &[i32], values: &[f64]) -> Result<()> {
        self.insert(rows, cols, values, ffi::INSERT_VALUES)
    }

    fn insert(
        &mut self,
        rows: &[i32],
        cols: &[i32],
        values: &[f64],
        mode: ffi::InsertMode,
    ) -> Result<()> {
        self.check_indices(rows, cols, values, 1)?;
        let (m, n) = (petsc_int(rows.len(), "rows")?, petsc_int(cols.len(), "columns")?);
        // SAFETY: m rows, n columns and m*n values, within the matrix (checked above).
        let code = unsafe {
            ffi::MatSetValues(self.raw, m, rows.as_ptr(), n, cols.as_ptr(), values.as_ptr(), mode)
        };
        check(code, "MatSetValues")
    }

    /// Sends what belongs to other ranks and makes the matrix ready for use. Collective.
    ///
    /// # Errors
    /// `System` for an entry outside the pattern; rank-local, so to be agreed on by the caller.
    pub fn assemble(&mut self) -> Result<()> {
        // SAFETY: a valid matrix.
        let code = unsafe { ffi::MatAssemblyBegin(self.raw, ffi::MAT_FINAL_ASSEMBLY) };
        check(code, "MatAssemblyBegin")?;
        // SAFETY: as above.
        let code = unsafe { ffi::MatAssemblyEnd(self.raw, ffi::MAT_FINAL_ASSEMBLY) };
        check(code, "MatAssemblyEnd")
    }

    /// Sets every entry of the pattern to 0. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn zero(&mut self) -> Result<()> {
        // SAFETY: a valid, preallocated matrix.
        check(unsafe { ffi::MatZeroEntries(self.raw) }, "MatZeroEntries")
    }

    /// Sets the entries of the given rows (global numbers, on any rank) to 0 and keeps them in the
    /// pattern. The matrix is assembled. Collective.
    ///
    /// # Errors
    /// `Bug` for numbers outside the matrix; `System` when PETSc fails.
    pub fn zero_rows_keep_pattern(&mut self, rows: &[i32]) -> Result<()> {
        self.check_range(rows, 1)?;
        let n = petsc_int(rows.len(), "rows")?;
        let none = ptr::null_mut();
        // SAFETY: n rows within the matrix; no solution or right-hand side is to be changed.
        let code = unsafe { ffi::MatZeroRows(self.raw, n, rows.as_ptr(), 0.0, none, none) };
        check(code, "MatZeroRows")
    }

    /// Calls `act` with the global number, columns and values of every row of this rank. Local.
    ///
    /// # Errors
    /// That of `act`; `System` when PETSc fails.
    pub fn for_each_row(
        &self,
        mut act: impl FnMut(i32, &[i32], &[f64]) -> Result<()>,
    ) -> Result<()> {
        let (mut first, mut end) = (0, 0);
        // SAFETY: a valid matrix.
        let code = unsafe { ffi::MatGetOwnershipRange(self.raw, &mut first, &mut end) };
        check(code, "MatGetOwnershipRange")?;
        for row in first..end {
            let (mut n, mut columns, mut values) = (0, ptr::null(), ptr::null());
            // SAFETY: a valid, assembled matrix and one of its own rows.
            let code = unsafe { ffi::MatGetRow(self.raw, row, &mut n, &mut columns, &mut values) };
            check(code, "MatGetRow")?;
            let acted = if n > 0 {
                // SAFETY: PETSc lends n columns and values until the row is given back.
                let (columns, values) = unsafe {
                    (
                        std::slice::from_raw_parts(columns, n as usize),
                        std::slice::from_raw_parts(values, n as usize),
                    )
                };
                act(row, columns, values)
            } else {
                Ok(())
            };
            // SAFETY: the row that was lent.
            let code =
                unsafe { ffi::MatRestoreRow(self.raw, row, &mut n, &mut columns, &mut values) };
            check(code, "MatRestoreRow")?;
            acted?;
        }
        Ok(())
    }

    /// `y` = matrix times `x`. Collective.
    ///
    /// # Errors
    /// `Bug` when a length does not fit; `System` when PETSc fails.
    pub fn multiply(&self, x: &Vector, y: &mut Vector) -> Result<()> {
        if x.owned() != self.owned || y.owned() != self.owned {
            return Err(Error::Bug(format!(
                "a matrix of {} rows times {} entries into {}",
                self.owned,
                x.owned(),
                y.owned()
            )));
        }
        // SAFETY: valid objects that fit; `x` and `y` differ, as one is borrowed alone.
        check(unsafe { ffi::MatMult(self.raw, x.raw(), y.raw()) }, "MatMult")
    }

    fn info(&self) -> Result<ffi::MatInfo> {
        let mut info = std::mem::MaybeUninit::zeroed();
        // SAFETY: a valid, assembled matrix; `info` has room for the result.
        let code = unsafe { ffi::MatGetInfo(self.raw, ffi::MAT_GLOBAL_SUM, info.as_mut_ptr()) };
        check(code, "MatGetInfo")?;
        // SAFETY: numbers only, for which zero bytes are valid, and filled by PETSc.
        Ok(unsafe { info.assume_init() })
    }

    /// The number of stored entries on all ranks. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn nonzeros(&self) -> Result<u64> {
        Ok(self.info()?.nz_used as u64)
    }

    /// The memory of the matrix on all ranks, in bytes: entries, their columns and the starts of
    /// the rows. (PETSc's own count is 0 unless it logs.) Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn memory(&self) -> Result<u64> {
        let entries = self.info()?.nz_allocated as u64;
        let rows = u64::try_from(self.global).unwrap_or(0);
        Ok(12 * entries + 4 * rows)
    }
}

impl Drop for Matrix {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            // SAFETY: a valid matrix, destroyed once; PETSc is still initialised, since we hold it.
            unsafe { ffi::MatDestroy(&mut self.raw) };
        }
    }
}
