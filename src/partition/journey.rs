//! Things on their way between ranks.

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::comm::Comm;
use crate::error::{Error, Result};

/// As bytes. Local.
///
/// # Errors
/// `Bug` when it cannot be.
pub fn pack<T: Serialize>(what: &T) -> Result<Vec<u8>> {
    postcard::to_stdvec(what).map_err(|error| Error::Bug(format!("a mesh cannot be sent: {error}")))
}

/// Back from bytes. Local.
///
/// # Errors
/// `Bug` when they are those of something else.
pub fn unpack<T: DeserializeOwned>(bytes: &[u8]) -> Result<T> {
    let read = postcard::from_bytes(bytes);
    read.map_err(|error| Error::Bug(format!("a mesh cannot be received: {error}")))
}

/// What every rank has, by rank, on all ranks. Collective.
///
/// # Errors
/// As [`pack`].
pub fn everywhere<T: Serialize + DeserializeOwned>(comm: &Comm, what: &T) -> Result<Vec<T>> {
    let bytes = comm.agree(pack(what))?;
    let parts = comm.gather(&bytes).map(|parts| pack(&parts)).transpose();
    let parts = comm.broadcast_bytes(comm.agree(parts)?.unwrap_or_default());
    let parts: Vec<Vec<u8>> = comm.agree(unpack(&parts))?;
    comm.agree(parts.iter().map(|part| unpack(part)).collect())
}

/// The same of lists, one after the other. Collective.
///
/// # Errors
/// As [`pack`].
pub fn joined<T: Serialize + DeserializeOwned + Clone>(comm: &Comm, list: &[T]) -> Result<Vec<T>> {
    Ok(everywhere(comm, &list.to_vec())?.concat())
}

/// The same on the root only: what takes much memory stays off the other ranks. Collective.
///
/// # Errors
/// As [`pack`].
pub fn on_root<T: Serialize + DeserializeOwned + Clone>(
    comm: &Comm,
    list: &[T],
) -> Result<Option<Vec<T>>> {
    let bytes = comm.agree(pack(&list))?;
    let parts = comm.gather(&bytes);
    drop(bytes);
    let of_rank = |part: Vec<u8>| unpack::<Vec<T>>(&part);
    let lists = parts.map(|parts| parts.into_iter().map(of_rank).collect::<Result<Vec<_>>>());
    Ok(comm.agree(lists.transpose())?.map(|lists| lists.concat()))
}
