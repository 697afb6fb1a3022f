//! Distributed vectors and the views of their owned entries.

#![allow(unsafe_code)]

use super::error::check;
use super::{Petsc, ffi};
use crate::error::{Error, Result};
use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};
use std::{ptr, slice};

/// A vector whose entries are shared out over the ranks.
pub struct Vector {
    /// A valid vector until drop.
    raw: ffi::Vec,
    petsc: Petsc,
}

/// A length as PETSc wants it.
pub(super) fn petsc_int(n: usize, what: &str) -> Result<ffi::PetscInt> {
    ffi::PetscInt::try_from(n)
        .map_err(|_| Error::Input(format!("{n} {what} are more than PETSc's 32-bit numbers hold")))
}

impl Vector {
    /// A vector of zeros with `owned` entries on this rank, in blocks of `block_size`. Collective.
    ///
    /// # Errors
    /// `Bug` when the block size does not divide `owned`; `System` when PETSc fails.
    pub fn new(petsc: &Petsc, owned: usize, block_size: usize) -> Result<Self> {
        if block_size == 0 || !owned.is_multiple_of(block_size) {
            return Err(Error::Bug(format!("{owned} entries in blocks of {block_size}")));
        }
        let mut raw = ptr::null_mut();
        let (owned, block_size) = (petsc_int(owned, "entries")?, petsc_int(block_size, "entries")?);
        // SAFETY: PETSc is initialised, the communicator is alive, -1 lets PETSc sum up the size.
        let code = unsafe { ffi::VecCreateMPI(petsc.comm().raw(), owned, -1, &mut raw) };
        check(code, "VecCreateMPI")?;
        let vector = Vector { raw, petsc: petsc.clone() };
        // SAFETY: a valid vector whose length is a multiple of the block size.
        check(unsafe { ffi::VecSetBlockSize(raw, block_size) }, "VecSetBlockSize")?;
        Ok(vector)
    }

    /// The handle, for the other files of the fence. Local.
    pub(super) fn raw(&self) -> ffi::Vec {
        self.raw
    }

    /// The number of entries on this rank. Local.
    pub fn owned(&self) -> usize {
        owned(self.raw)
    }

    /// The owned entries, to be read. Local.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn read(&self) -> Result<ReadView<'_>> {
        // SAFETY: a valid vector; the view borrows it.
        unsafe { ReadView::new(self.raw) }
    }

    /// The owned entries, to be written. Local.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn write(&mut self) -> Result<WriteView<'_>> {
        // SAFETY: a valid vector; the view borrows it alone.
        unsafe { WriteView::new(self.raw) }
    }

    /// The 2-norm. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn norm2(&self) -> Result<f64> {
        let mut norm = 0.0;
        // SAFETY: a valid vector.
        check(unsafe { ffi::VecNorm(self.raw, ffi::NORM_2, &mut norm) }, "VecNorm")?;
        Ok(norm)
    }

    /// A vector of zeros with the same layout. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn duplicate(&self) -> Result<Self> {
        let mut raw = ptr::null_mut();
        // SAFETY: a valid vector.
        check(unsafe { ffi::VecDuplicate(self.raw, &mut raw) }, "VecDuplicate")?;
        let mut copy = Vector { raw, petsc: self.petsc.clone() };
        copy.zero()?;
        Ok(copy)
    }

    /// Takes the values of `other`, which has the same layout. Collective.
    ///
    /// # Errors
    /// `Bug` when the layouts differ on this rank; `System` when PETSc fails.
    pub fn copy_from(&mut self, other: &Vector) -> Result<()> {
        if self.owned() != other.owned() {
            return Err(Error::Bug(format!(
                "{} entries into a vector of {}",
                other.owned(),
                self.owned()
            )));
        }
        // SAFETY: two valid vectors of the same layout.
        check(unsafe { ffi::VecCopy(other.raw, self.raw) }, "VecCopy")
    }

    /// Sets every entry to 0. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn zero(&mut self) -> Result<()> {
        // SAFETY: a valid vector.
        check(unsafe { ffi::VecSet(self.raw, 0.0) }, "VecSet")
    }
}

impl Drop for Vector {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            // SAFETY: a valid vector, destroyed once; PETSc is still initialised, since we hold it.
            unsafe { ffi::VecDestroy(&mut self.raw) };
        }
    }
}

/// The local length of a valid vector.
fn owned(raw: ffi::Vec) -> usize {
    let mut n = 0;
    // SAFETY: private to this file, called with valid vectors only; it cannot fail on those.
    unsafe { ffi::VecGetLocalSize(raw, &mut n) };
    usize::try_from(n).unwrap_or(0)
}

/// The owned entries of a vector, read only; given back on drop.
pub struct ReadView<'a> {
    raw: ffi::Vec,
    entries: *const f64,
    len: usize,
    vector: PhantomData<&'a Vector>,
}

impl ReadView<'_> {
    /// # Safety
    /// `raw` is a valid vector during the life of the view, and nothing writes to it meanwhile.
    pub(super) unsafe fn new(raw: ffi::Vec) -> Result<Self> {
        let mut entries = ptr::null();
        // SAFETY: a valid vector by the contract.
        check(unsafe { ffi::VecGetArrayRead(raw, &mut entries) }, "VecGetArrayRead")?;
        Ok(ReadView { raw, entries, len: owned(raw), vector: PhantomData })
    }
}

impl Deref for ReadView<'_> {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        if self.len == 0 {
            return &[];
        }
        // SAFETY: PETSc lends `len` initialised entries until they are given back in drop.
        unsafe { slice::from_raw_parts(self.entries, self.len) }
    }
}

impl Drop for ReadView<'_> {
    fn drop(&mut self) {
        // SAFETY: lent by VecGetArrayRead of the same vector, given back once.
        unsafe { ffi::VecRestoreArrayRead(self.raw, &mut self.entries) };
    }
}

/// The owned entries of a vector, to be written; given back on drop.
pub struct WriteView<'a> {
    raw: ffi::Vec,
    entries: *mut f64,
    len: usize,
    vector: PhantomData<&'a mut Vector>,
}

impl WriteView<'_> {
    /// # Safety
    /// `raw` is a valid vector during the life of the view, and nothing else reads or writes it.
    pub(super) unsafe fn new(raw: ffi::Vec) -> Result<Self> {
        let mut entries = ptr::null_mut();
        // SAFETY: a valid vector by the contract.
        check(unsafe { ffi::VecGetArray(raw, &mut entries) }, "VecGetArray")?;
        Ok(WriteView { raw, entries, len: owned(raw), vector: PhantomData })
    }
}

impl Deref for WriteView<'_> {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        if self.len == 0 {
            return &[];
        }
        // SAFETY: PETSc lends `len` initialised entries until they are given back in drop.
        unsafe { slice::from_raw_parts(self.entries, self.len) }
    }
}

impl DerefMut for WriteView<'_> {
    fn deref_mut(&mut self) -> &mut [f64] {
        if self.len == 0 {
            return &mut [];
        }
        // SAFETY: as above, and by the contract of `new` nothing else refers to them.
        unsafe { slice::from_raw_parts_mut(self.entries, self.len) }
    }
}

impl Drop for WriteView<'_> {
    fn drop(&mut self) {
        // SAFETY: lent by VecGetArray of the same vector, given back once.
        unsafe { ffi::VecRestoreArray(self.raw, &mut self.entries) };
    }
}
