//! Bodies of all ranks, and nodes that several ranks have.

use super::homes::Homes;
use super::pieces::Work;
use super::spread::Held;
use crate::comm::{Comm, first_of};
use crate::error::Result;
use crate::mesh::whole::bodies;
use crate::partition::journey::{everywhere, joined};

/// The names of all nodes, in ranges of one size.
pub fn even_homes(comm: &Comm, total: u64) -> Homes {
    let ranks = comm.size() as u64;
    Homes { firsts: (0..=ranks).map(|rank| first_of(rank, total, ranks)).collect() }
}

/// The body, of all ranks, of each body of this rank, and how many there are: bodies with a common
/// node are one, and they are numbered by their first cells. Collective.
///
/// # Arguments
/// * `nodes` with their bodies on this rank
/// * `first_cells` of the bodies of this rank
///
/// # Errors
/// `Bug` only.
fn merge(
    comm: &Comm,
    homes: &Homes,
    nodes: impl Iterator<Item = (u32, u32)>,
    first_cells: &[u32],
) -> Result<(Vec<u32>, usize)> {
    let counts = everywhere(comm, &(first_cells.len() as u32))?;
    let before = |rank: usize| counts[..rank].iter().sum::<u32>();
    let own = before(comm.rank() as usize);
    let told = homes.send(comm, nodes.map(|(name, body)| (name, own + body)));
    let of_rank = homes.firsts[comm.rank() as usize..][..2].to_vec();
    let mut seen = vec![u32::MAX; (of_rank[1] - of_rank[0]) as usize];
    let mut pairs = Vec::new();
    for (place, body) in told {
        match std::mem::replace(&mut seen[place as usize], body) {
            u32::MAX => {}
            other if other != body => pairs.push((other.min(body), other.max(body))),
            _ => {}
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    let (pairs, first_cells) = (joined(comm, &pairs)?, joined(comm, first_cells)?);
    let mut roots: Vec<u32> = (0..first_cells.len() as u32).collect();
    let root = |roots: &[u32], mut at: u32| {
        while roots[at as usize] != at {
            at = roots[at as usize];
        }
        at
    };
    for (one, other) in pairs {
        let (one, other) = (root(&roots, one), root(&roots, other));
        roots[one.max(other) as usize] = one.min(other);
    }
    let mut order: Vec<(u32, u32)> = first_cells.iter().copied().zip(0..).collect();
    order.sort_unstable();
    let mut names = vec![u32::MAX; order.len()];
    let mut count = 0;
    for (_, body) in order {
        let name = &mut names[root(&roots, body) as usize];
        if *name == u32::MAX {
            *name = count;
            count += 1;
        }
    }
    let of = |body: usize| names[root(&roots, own + body as u32) as usize];
    let of_rank = (0..counts[comm.rank() as usize] as usize).map(of).collect();
    Ok((of_rank, count as usize))
}

/// The body of each node of own cells before cutting, by the places of their names, and how many
/// bodies there are. Collective.
///
/// # Errors
/// `Bug` only.
pub fn bodies_before(
    comm: &Comm,
    homes: &Homes,
    held: &Held,
    work: &Work,
) -> Result<(Vec<u32>, usize)> {
    let place = |name: &u32| work.names.place(*name).unwrap_or_default() as u32;
    let add = |cell: usize, nodes: &mut Vec<u32>| nodes.extend(held.cell(cell).1.iter().map(place));
    let of_nodes = bodies(work.names.len(), held.cells.len(), add);
    all_bodies(comm, homes, work.names.iter(), of_nodes, &held.cells)
}

/// The bodies of all ranks in the place of those of this one, of nodes with these names.
/// Collective.
///
/// # Errors
/// `Bug` only.
pub fn all_bodies(
    comm: &Comm,
    homes: &Homes,
    names: impl Iterator<Item = u32>,
    (mut of_nodes, firsts): (Vec<u32>, Vec<u32>),
    cells: &[u32],
) -> Result<(Vec<u32>, usize)> {
    let firsts: Vec<u32> = firsts.iter().map(|cell| cells[*cell as usize]).collect();
    let nodes = names.zip(of_nodes.iter().copied()).filter(|(_, body)| *body != u32::MAX);
    let (bodies, count) = merge(comm, homes, nodes, &firsts)?;
    for body in of_nodes.iter_mut().filter(|body| **body != u32::MAX) {
        *body = bodies[*body as usize];
    }
    Ok((of_nodes, count))
}

/// How many names there are on all ranks together, each counted once. Collective.
pub fn count(comm: &Comm, homes: &Homes, names: impl Iterator<Item = u32>) -> u64 {
    let told = homes.send(comm, names.map(|name| (name, 1_u8)));
    let own = homes.firsts[comm.rank() as usize..][..2].to_vec();
    let mut is_there = vec![false; (own[1] - own[0]) as usize];
    told.iter().for_each(|(place, _)| is_there[*place as usize] = true);
    comm.sum_u64(is_there.iter().filter(|is| **is).count() as u64)
}
