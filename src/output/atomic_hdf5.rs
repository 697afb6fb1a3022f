//! HDF5 files that all ranks write together and that are complete or absent under their name.

use std::fs;
use std::path::Path;

use super::atomic;
use super::hdf5::{CollectiveFile, Rows};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::runtime::leave_libraries;
use ::hdf5::{Group, H5Type};

/// A file that is to be written.
pub struct AtomicFile<'a> {
    /// Who writes it.
    pub comm: &'a Comm,
    /// The name it gets.
    pub path: &'a Path,
}

impl AtomicFile<'_> {
    /// Writes the file under a temporary name, `fill` what is in its one group, and lets `publish`
    /// give it its name on rank 0. `size` bounds its bytes.
    ///
    /// # Errors
    /// `System` with the path and the reason, and what `fill` and `publish` give; the same on all
    /// ranks, with no file left behind.
    ///
    /// # Parallel
    /// Collective.
    pub fn write(
        &self,
        group: &str,
        size: u64,
        publish: impl FnOnce(&Path) -> Result<()>,
        fill: impl FnOnce(&CollectiveFile, &Group) -> Result<()>,
    ) -> Result<()> {
        let (comm, root) = (self.comm, self.comm.is_root());
        let process = comm.max_u64(if root { u64::from(std::process::id()) } else { 0 }) as u32;
        let temporary = atomic::temporary(self.path, process);
        // The library does not pass on why a file cannot be created; the operating system does.
        let create =
            || fs::File::create(&temporary).and_then(|_| atomic::reserve(&temporary, size));
        let created = if root { create() } else { atomic::within_limit(size) };
        let created = comm.agree(self.explain(created, size));
        if root && created.is_err() {
            atomic::discard(&temporary);
        }
        created?;

        let mut outcome = self.write_temporary(&temporary, group, size, fill);
        if root {
            match outcome {
                Ok(()) => outcome = publish(&temporary),
                Err(_) => atomic::discard(&temporary),
            }
        }
        comm.agree(outcome)
    }

    fn explain(&self, outcome: std::io::Result<()>, size: u64) -> Result<()> {
        outcome.map_err(|cause| {
            Error::file("cannot write", self.path, format!("{cause} (its size is {size} bytes)"))
        })
    }

    fn write_temporary(
        &self,
        temporary: &Path,
        group: &str,
        size: u64,
        fill: impl FnOnce(&CollectiveFile, &Group) -> Result<()>,
    ) -> Result<()> {
        let file = self.agreed(CollectiveFile::create(self.comm, temporary))?;
        // Creating the file gave back the room that was made for it.
        let root = self.comm.is_root();
        let room = if root { atomic::reserve(temporary, size) } else { Ok(()) };
        let written = self.comm.agree(self.explain(room, size)).and_then(|()| {
            let group = self.agreed(file.create_group(group))?;
            fill(&file, &group)
        });
        // Closing is collective and every rank is here, whether the writes went well or not.
        let closed = self.agreed(file.close()).inspect_err(|_| leave_libraries());
        written.and(closed)
    }

    /// Writes this rank's rows of a dataset.
    ///
    /// # Errors
    /// `System` with the path and the reason; the same on all ranks.
    ///
    /// # Parallel
    /// Collective, as [`CollectiveFile::write_rows`].
    pub fn rows<T: H5Type>(
        &self,
        file: &CollectiveFile,
        group: &Group,
        name: &str,
        rows: Rows,
        components: usize,
        values: &[T],
    ) -> Result<()> {
        self.agreed(file.write_rows(group, name, rows, components, values))
    }

    /// The library's outcome, the same on all ranks, with the path.
    ///
    /// # Parallel
    /// Collective.
    pub fn agreed<T>(&self, result: ::hdf5::Result<T>) -> Result<T> {
        self.comm.agree(result.map_err(|cause| Error::file("cannot write", self.path, cause)))
    }
}
