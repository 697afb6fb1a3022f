//! Which rank owns which cell.
//!
//! Rank 0 builds the dual graph of the coarse mesh, METIS cuts it, and every rank receives the
//! names of its own cells, of the mesh of a file the cells themselves. Facing cells of an interface
//! are joined by heavy edges, so that pairs stay together where the balance allows it; a pair that
//! is cut all the same costs communication and nothing else.

mod journey;
mod method;
mod metis;
mod slabs;

pub use method::{Import, Method};

use journey::{pack, unpack};

use crate::case::Case;
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::hash::mix;
use crate::mesh::{LocalMesh, MeshFacts, MeshFamily};

/// The meshes of a case, on all ranks. A large file is read in slabs by all of them; where that
/// cannot be, or `needs_whole` says why the whole of it is needed, rank 0 reads it, as `read` does.
/// Collective.
///
/// # Errors
/// As [`MeshFamily::new`].
pub fn family(
    comm: &Comm,
    case: &Case,
    (import, method): (Import, Method),
    read: impl Fn(&Case) -> Result<MeshFamily>,
    needs_whole: impl Fn(&Case, &MeshFamily) -> Result<Option<String>>,
) -> Result<MeshFamily> {
    if case.mesh.file().is_none() {
        return comm.agree(MeshFamily::new(case));
    }
    let in_slabs = slabs::family(comm, case, import, method);
    let why = match in_slabs {
        Ok(Some(family)) => {
            let local = if comm.is_root() { needs_whole(case, &family) } else { Ok(None) };
            match comm.on_root(|| pack(&local?)).and_then(|bytes| unpack::<Option<String>>(&bytes))
            {
                Ok(None) => return Ok(family),
                Ok(Some(why)) => Some(why),
                Err(error) => Some(error.to_string()),
            }
        }
        Ok(None) => None,
        Err(error) => Some(error.to_string()),
    };
    let local = if comm.is_root() { read(case).map(Some) } else { Ok(None) };
    let mut read = comm.agree(local)?;
    if let (Some(family), Some(why)) = (&mut read, why) {
        family.remarks.push(format!("read whole by one rank, not in slabs by all: {why}"));
    }
    let facts = read.as_ref().map(|family| pack(&family.facts())).transpose();
    let facts = unpack(&comm.broadcast_bytes(comm.agree(facts)?.unwrap_or_default()));
    let facts = comm.agree(facts)?;
    Ok(read.unwrap_or_else(|| MeshFamily::known_by_its_facts(facts)))
}

/// The nested meshes of this rank, coarsest first: its part of each. Collective; rank 0 does the
/// work.
///
/// # Errors
/// `Input` when there are too many cells, `System` when METIS fails.
pub fn share_out(comm: &Comm, family: MeshFamily, method: Method) -> Result<Vec<LocalMesh>> {
    let family = match family.into_part() {
        Ok(part) => return Ok(vec![part]),
        Err(family) => *family,
    };
    let family = &family;
    let ranks = comm.size() as usize;
    let local = if comm.is_root() { ranks_of(family, ranks, method) } else { Ok(Vec::new()) };
    let rank_of = comm.agree(local)?;
    if family.is_of_file() {
        return share_out_file(comm, family, &rank_of);
    }
    let mut lists = vec![Vec::new(); ranks];
    for (cell, rank) in rank_of.iter().enumerate() {
        lists[*rank as usize].push(cell as u64);
    }
    let mut received = comm.exchange(&lists);
    let held = if comm.is_root() { family.coarse_cells() } else { 0 };
    let cells = std::mem::take(&mut received[0]);
    let meshes = family.share(cells, comm.max_u64(held));
    meshes.ok_or_else(|| Error::Bug("a column without its levels".into()))
}

/// Sends the parts of the meshes of a file from rank 0, coarsest first. Collective.
fn share_out_file(comm: &Comm, family: &MeshFamily, rank_of: &[i32]) -> Result<Vec<LocalMesh>> {
    let ranks = comm.size() as usize;
    let packed = || -> Result<Vec<Vec<u8>>> {
        if !comm.is_root() {
            return Ok(vec![Vec::new(); ranks]);
        }
        let mut of_ranks = vec![Vec::new(); ranks];
        for of_level in family.parts(rank_of, ranks)? {
            for (of_rank, mesh) in of_ranks.iter_mut().zip(of_level) {
                of_rank.push((mesh.facts.clone(), mesh));
            }
        }
        of_ranks.iter().map(pack).collect()
    };
    let packed = comm.agree(packed())?;
    let received = comm.exchange(&packed);
    let parts: Vec<(MeshFacts, LocalMesh)> = comm.agree(unpack(&received[0]))?;
    let with_facts = |(facts, mut mesh): (MeshFacts, LocalMesh)| {
        mesh.facts = facts;
        mesh
    };
    let mut meshes: Vec<LocalMesh> = parts.into_iter().map(with_facts).collect();
    if let Some(finest) = meshes.last_mut() {
        finest.facts = family.facts();
    }
    Ok(meshes)
}

/// The rank of every cell.
fn ranks_of(family: &MeshFamily, ranks: usize, method: Method) -> Result<Vec<i32>> {
    let cells = family.coarse_cells();
    if ranks == 1 {
        return Ok(vec![0; cells as usize]);
    }
    match method {
        Method::Scattered => Ok((0..cells).map(|c| (mix(c) % ranks as u64) as i32).collect()),
        Method::Metis => {
            let graph = family.dual_graph()?;
            metis::cut(&graph.start, &graph.neighbours, &graph.weights, &graph.work, ranks)
        }
    }
}
