//! The fence around HDF5: one file written by all ranks at once.
//!
//! Files, groups and attributes go through the safe crate. Rows of data go through `H5Dwrite` with
//! a collective transfer list, for which the safe crate has no type: its own writes are
//! independent and leave out ranks without rows, which a collective write must not.
#![allow(unsafe_code)]

use std::path::Path;

use crate::comm::Comm;
use ::hdf5::plist::dataset_create::FillTime;
use ::hdf5::{Datatype, File, FileBuilder, Group, H5Type, Result, h5check};
use hdf5_sys::h5::hsize_t;
use hdf5_sys::h5d::H5Dwrite;
use hdf5_sys::h5i::hid_t;
use hdf5_sys::h5p::{
    H5FD_mpio_xfer_t, H5P_CLS_DATASET_XFER, H5Pclose, H5Pcreate, H5Pset_dxpl_mpio,
};
use hdf5_sys::h5s::{
    H5S_seloper_t, H5Sclose, H5Screate_simple, H5Sselect_hyperslab, H5Sselect_none,
};

/// Which rows of a dataset this rank writes, and how many there are over all ranks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rows {
    /// Number of this rank's first row.
    pub first: u64,
    /// Number of rows of all ranks.
    pub total: u64,
}

/// An HDF5 file open for writing on every rank of a communicator.
pub struct CollectiveFile {
    // Declared before the file: both go before MPI does, the list first.
    transfer: Transfer,
    file: File,
}

impl CollectiveFile {
    /// Creates the file, or empties the one that is there.
    ///
    /// # Errors
    /// The library's, when the file cannot be created.
    ///
    /// # Parallel
    /// Collective.
    pub fn create(comm: &Comm, path: &Path) -> Result<Self> {
        let transfer = Transfer::collective()?;
        // Metadata reads stay independent: collective ones are broken in releases around 1.10.5.
        let file = FileBuilder::new()
            .with_fapl(|list| list.mpio(comm.raw(), None).coll_metadata_write(true))
            .create(path)?;
        Ok(Self { transfer, file })
    }

    /// Creates a group at the top of the file.
    ///
    /// # Parallel
    /// Collective, with the same name on every rank.
    pub fn create_group(&self, name: &str) -> Result<Group> {
        self.file.create_group(name)
    }

    /// Creates a dataset of shape (`rows.total`) for one component, else (`rows.total`,
    /// components), and writes this rank's rows, whose number may be zero.
    ///
    /// # Arguments
    /// * `values` this rank's rows one after the other, shape (own rows, `components`)
    ///
    /// # Errors
    /// The library's; it can differ between ranks, so agree on it before the next collective call.
    ///
    /// # Parallel
    /// Collective, with the same group, name, total and components on every rank.
    pub fn write_rows<T: H5Type>(
        &self,
        group: &Group,
        name: &str,
        rows: Rows,
        components: usize,
        values: &[T],
    ) -> Result<()> {
        // The safe crate makes datasets without rows of chunks, unless it is told not to.
        let builder = group.new_dataset::<T>().no_chunk().fill_time(FillTime::Never);
        let total = rows.total as usize;
        let (dataset, rank) = if components == 1 {
            (builder.shape(total).create(name)?, 1)
        } else {
            (builder.shape((total, components)).create(name)?, 2)
        };
        if total == 0 {
            return Ok(());
        }
        let own = values.len() / components;
        let start: [hsize_t; 2] = [rows.first, 0];
        let count: [hsize_t; 2] = [own as hsize_t, components as hsize_t];
        let datatype = Datatype::from_type::<T>()?;
        let in_file = dataset.space()?;
        ::hdf5::sync::sync(|| {
            let in_memory = MemorySpace::new(rank, [count[0].max(1), count[1]])?;
            if own == 0 {
                // SAFETY: both ids are dataspaces alive until the end of this closure.
                h5check(unsafe { H5Sselect_none(in_file.id()) })?;
                // SAFETY: as above.
                h5check(unsafe { H5Sselect_none(in_memory.0) })?;
            } else {
                // SAFETY: `start` and `count` hold at least as many numbers as the file space has
                // dimensions (1 or 2); null stride and block mean one.
                h5check(unsafe {
                    H5Sselect_hyperslab(
                        in_file.id(),
                        H5S_seloper_t::H5S_SELECT_SET,
                        start.as_ptr(),
                        std::ptr::null(),
                        count.as_ptr(),
                        std::ptr::null(),
                    )
                })?;
            }
            // SAFETY: the memory space selects exactly `own * components` values of type T, which
            // `values` holds; all ids are alive.
            h5check(unsafe {
                H5Dwrite(
                    dataset.id(),
                    datatype.id(),
                    in_memory.0,
                    in_file.id(),
                    self.transfer.0,
                    values.as_ptr().cast(),
                )
            })?;
            Ok(())
        })
    }

    /// Closes the file; every group of it must have been dropped before.
    ///
    /// # Errors
    /// The library's, when the last of the file could not be written.
    ///
    /// # Parallel
    /// Collective.
    pub fn close(self) -> Result<()> {
        self.file.flush()?;
        self.file.close()
    }
}

/// A transfer property list with collective MPI-IO.
struct Transfer(hid_t);

impl Transfer {
    fn collective() -> Result<Self> {
        ::hdf5::sync::sync(|| {
            // SAFETY: the class id is initialised by the library before the lock is given.
            let list = Self(h5check(unsafe { H5Pcreate(*H5P_CLS_DATASET_XFER) })?);
            // SAFETY: `list` is an open transfer property list.
            h5check(unsafe { H5Pset_dxpl_mpio(list.0, H5FD_mpio_xfer_t::H5FD_MPIO_COLLECTIVE) })?;
            Ok(list)
        })
    }
}

impl Drop for Transfer {
    fn drop(&mut self) {
        // SAFETY: the id is open and owned by this value alone.
        ::hdf5::sync::sync(|| unsafe { H5Pclose(self.0) });
    }
}

/// A simple dataspace in memory.
struct MemorySpace(hid_t);

impl MemorySpace {
    fn new(rank: i32, dimensions: [hsize_t; 2]) -> Result<Self> {
        // SAFETY: `dimensions` holds at least `rank` (1 or 2) numbers; null means fixed extents.
        let id = unsafe { H5Screate_simple(rank, dimensions.as_ptr(), std::ptr::null()) };
        Ok(Self(h5check(id)?))
    }
}

impl Drop for MemorySpace {
    fn drop(&mut self) {
        // SAFETY: the id is open and owned by this value alone.
        ::hdf5::sync::sync(|| unsafe { H5Sclose(self.0) });
    }
}
