//! One run writes into a directory at a time.

use std::fs::{self, File};
use std::io;
use std::path::Path;

use rustix::fs::{FlockOperation, flock};
use rustix::io::Errno;

use crate::comm::Comm;
use crate::error::{Error, Result};

/// What is locked where the file system has no locks of directories.
const FILE: &str = ".lock";

/// A lock on an output directory, for as long as this lives. The system takes it back when the
/// process ends, however it ends.
#[derive(Debug)]
pub struct Lock {
    /// On rank 0, where the file system has locks.
    _held: Option<File>,
}

impl Lock {
    /// Locks a directory, which is created if there is none. A file system without locks is told
    /// with a warning.
    ///
    /// # Errors
    /// [`Error::Input`] while another run holds it; [`Error::System`] if the directory cannot be
    /// created.
    ///
    /// # Parallel
    /// Collective; rank 0 does the work.
    pub fn take(comm: &Comm, path: &Path) -> Result<Self> {
        let held = comm.agree(if comm.is_root() { lock(path) } else { Ok(None) })?;
        Ok(Self { _held: held })
    }
}

fn lock(path: &Path) -> Result<Option<File>> {
    fs::create_dir_all(path)
        .map_err(|cause| Error::file("cannot create the output directory", path, cause))?;
    // Network file systems lock files that are open for writing only.
    let file = || File::options().write(true).create(true).truncate(false).open(path.join(FILE));
    let ways: [&dyn Fn() -> io::Result<File>; 2] = [&|| File::open(path), &file];
    let mut cause = Errno::OPNOTSUPP;
    for opened in ways {
        // What cannot be opened cannot be written either, which is told then.
        let Ok(file) = opened() else { continue };
        match flock(&file, FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => return Ok(Some(file)),
            Err(Errno::WOULDBLOCK) => {
                return Err(Error::Input(format!(
                    "another run is writing into {}: wait for its end, or choose another directory \
                     with --output DIR",
                    path.display()
                )));
            }
            Err(other) => cause = other,
        }
    }
    tracing::warn!(
        "warning: the file system of {} has no locks ({cause}): see to it that no other run writes there",
        path.display()
    );
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_has_one_holder_at_a_time_and_no_file_of_it() {
        let name = format!("column-hpc-lock-{}", std::process::id());
        let dir = std::env::temp_dir().join(name);
        let held = lock(&dir).unwrap();
        assert!(held.is_some());
        let refused = lock(&dir).unwrap_err();
        assert_eq!(refused.exit_status(), 2);
        assert!(refused.to_string().contains("another run is writing into"), "{refused}");
        drop(held);
        assert!(lock(&dir).unwrap().is_some());
        assert_eq!(fs::read_dir(&dir).unwrap().count(), 0);
        fs::remove_dir_all(dir).unwrap();
    }
}
