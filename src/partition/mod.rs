//! Which rank owns which cell.
//!
//! Rank 0 builds the dual graph of the coarse mesh, METIS cuts it, and every rank receives the
//! names of its own cells. Facing cells of an interface are joined by heavy edges, so that pairs
//! stay together where the balance allows it; a pair that is cut all the same costs communication
//! and nothing else.

mod metis;

use crate::comm::Comm;
use crate::error::Result;
use crate::hash::mix;
use crate::mesh::MeshFamily;

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

/// The coarse cells of this rank, rising, and the size of the mesh that was cut.
///
/// Collective; rank 0 does the work.
///
/// # Errors
/// `Input` when there are too many cells, `System` when METIS fails.
pub fn distribute(comm: &Comm, family: &MeshFamily, method: Method) -> Result<(Vec<u64>, u64)> {
    let parts = comm.size() as usize;
    let local = if comm.is_root() { lists(family, parts, method) } else { Ok(Vec::new()) };
    let mut lists = comm.agree(local)?;
    lists.resize(parts, Vec::new());
    let mut received = comm.exchange(&lists);
    let held = if comm.is_root() { family.coarse_cells() } else { 0 };
    Ok((std::mem::take(&mut received[0]), comm.max_u64(held)))
}

/// The cells of every rank.
fn lists(family: &MeshFamily, parts: usize, method: Method) -> Result<Vec<Vec<u64>>> {
    let cells = family.coarse_cells();
    let mut lists = vec![Vec::new(); parts];
    if parts == 1 {
        lists[0] = (0..cells).collect();
        return Ok(lists);
    }
    let rank_of: Vec<i32> = match method {
        Method::Scattered => (0..cells).map(|c| (mix(c) % parts as u64) as i32).collect(),
        Method::Metis => {
            let graph = family.dual_graph()?;
            metis::cut(&graph.start, &graph.neighbours, &graph.weights, &graph.work, parts)?
        }
    };
    for (cell, rank) in rank_of.iter().enumerate() {
        lists[*rank as usize].push(cell as u64);
    }
    Ok(lists)
}
