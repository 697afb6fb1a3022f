//! Results on disk: the output directory, field files and the history table.
//!
//! Every file is complete or absent under its name, also when the run is killed: it is written
//! under a temporary name beside its place, flushed to the disk and renamed.

pub mod atomic;
pub mod directory;
pub mod hdf5;
pub mod history;
pub mod vtkhdf;

use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives, Root};

use crate::error::{Error, Result};

/// Gives every rank the error of the first rank that failed, or each rank its own value.
///
/// # Parallel
/// Collective: one all-reduce; two broadcasts more only when a rank failed.
pub(crate) fn agree<T>(comm: &SimpleCommunicator, result: Result<T>) -> Result<T> {
    let size = comm.size();
    let failed = if result.is_err() { comm.rank() } else { size };
    let mut first = size;
    comm.all_reduce_into(&failed, &mut first, SystemOperation::min());
    if first == size {
        return result;
    }
    let own = result.err().filter(|_| comm.rank() == first);
    let root = comm.process_at_rank(first);
    let mut head = [0u64; 2];
    let mut text = Vec::new();
    if let Some(error) = &own {
        let (Error::Input(t) | Error::Numerics(t) | Error::System(t) | Error::Bug(t)) = error;
        text = t.clone().into_bytes();
        head = [u64::from(error.exit_status()), text.len() as u64];
    }
    root.broadcast_into(&mut head[..]);
    text.resize(head[1] as usize, 0);
    root.broadcast_into(&mut text[..]);
    let text = String::from_utf8_lossy(&text).into_owned();
    Err(match head[0] {
        2 => Error::Input(text),
        3 => Error::Numerics(text),
        4 => Error::System(text),
        _ => Error::Bug(text),
    })
}
