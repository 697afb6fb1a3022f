//! Which rank owns which cell.
//!
//! Rank 0 builds the dual graph of the coarse mesh, METIS cuts it, and every rank receives the
//! names of its own cells, of the mesh of a file the cells themselves. Facing cells of an interface
//! are joined by heavy edges, so that pairs stay together where the balance allows it; a pair that
//! is cut all the same costs communication and nothing else.

mod metis;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::case::Case;
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::hash::mix;
use crate::mesh::{LocalMesh, MeshFacts, MeshFamily};

/// How the cells are shared out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// By METIS, least surface between the ranks.
    Metis,
    /// Every cell to the rank that a hash of its name gives: the worst that can happen to the
    /// parallel code, for tests.
    Scattered,
}

impl Method {
    /// The method asked for by the environment: tests set `COLUMN_HPC_PARTITION=scattered`.
    pub fn from_environment() -> Self {
        match std::env::var("COLUMN_HPC_PARTITION").as_deref() {
            Ok("scattered") => Self::Scattered,
            _ => Self::Metis,
        }
    }
}

/// The meshes of a case, on all ranks: rank 0 reads a file, as `read` does. Collective.
///
/// # Errors
/// As [`MeshFamily::new`].
pub fn family(
    comm: &Comm,
    case: &Case,
    read: impl Fn(&Case) -> Result<MeshFamily>,
) -> Result<MeshFamily> {
    if case.mesh.file().is_none() {
        return comm.agree(MeshFamily::new(case));
    }
    let local = if comm.is_root() { read(case).map(Some) } else { Ok(None) };
    let read = comm.agree(local)?;
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
pub fn share_out(comm: &Comm, family: &MeshFamily, method: Method) -> Result<Vec<LocalMesh>> {
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

fn pack<T: Serialize>(what: &T) -> Result<Vec<u8>> {
    postcard::to_stdvec(what).map_err(|error| Error::Bug(format!("a mesh cannot be sent: {error}")))
}

fn unpack<T: DeserializeOwned>(bytes: &[u8]) -> Result<T> {
    let read = postcard::from_bytes(bytes);
    read.map_err(|error| Error::Bug(format!("a mesh cannot be received: {error}")))
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
