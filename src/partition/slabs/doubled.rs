//! Nodes of any ranks at one place that are not one node.

use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::mesh::Places;
use crate::mesh::whole::{Boxes, pairs_of_box};

/// The nodes of a rank that are looked at in a round, about, so that no rank has many of others at
/// once.
const OF_ROUND: u64 = 1 << 14;

/// Refuses pairs of nodes at one place, unless both are `known`: names of nodes on interfaces
/// between two groups, rising. Collective.
///
/// # Arguments
/// * `nodes` with the `shortest` edge (m) at each, of which those from the name `end` on are not
///   looked at
/// * `low`: the least coordinates (m)
///
/// # Errors
/// `Input` on all ranks.
pub fn check(
    comm: &Comm,
    (nodes, shortest, end): (&Places, &[f32], u64),
    low: [f64; 3],
    known: &[u32],
) -> Result<()> {
    let count = nodes.names.partition_point(|name| *name < end);
    let longest = shortest[..count].iter().copied().fold(0.0, f32::max);
    let mut longest = [f64::from(longest)];
    comm.max(&mut longest);
    let boxes = Boxes::new(longest[0], low);
    let rounds = comm.max_u64(count as u64).div_ceil(OF_ROUND);
    let (start, of_rounds) = by_round(&nodes.points[..count], &boxes, rounds);
    for round in 0..rounds {
        let ranks = comm.size() as u64;
        let mut keys = vec![Vec::new(); ranks as usize];
        let mut places = vec![Vec::new(); ranks as usize];
        let range = start[round as usize] as usize..start[round as usize + 1] as usize;
        for (hash, node) in &of_rounds[range] {
            let rank = (mixed(*hash) / rounds % ranks) as usize;
            let ([x, y, z], edge) = (nodes.points[*node as usize], shortest[*node as usize]);
            keys[rank].extend([*hash, nodes.names[*node as usize]]);
            places[rank].extend([x, y, z, f64::from(edge)]);
        }
        let keys = comm.exchange(&keys).concat();
        let places = comm.exchange(&places).concat();
        let mut all: Vec<(u64, u32, usize)> = keys
            .chunks_exact(2)
            .enumerate()
            .map(|(place, key)| (key[0], key[1] as u32, place))
            .collect();
        all.sort_unstable();
        all.dedup_by_key(|node| (node.0, node.1));
        let at = |node: &(u64, u32, usize)| {
            let [x, y, z, edge] = places.as_chunks().0[node.2];
            ([x, y, z], edge)
        };
        let is_known = |name: &u32| known.binary_search(name).is_ok();
        let mut is_wrong = false;
        for of_box in all.chunk_by(|a, b| a.0 == b.0).filter(|of_box| of_box.len() > 1) {
            pairs_of_box(of_box, at, |a, b| is_wrong |= !(is_known(&a.1) && is_known(&b.1)));
        }
        let wrong = || Error::Input("nodes lie at the places of other nodes".into());
        comm.agree(if is_wrong { Err(wrong()) } else { Ok(()) })?;
    }
    Ok(())
}

/// The first entry of each round, and the end; the entries: hashes of boxes with the nodes in them.
fn by_round(points: &[[f64; 3]], boxes: &Boxes, rounds: u64) -> (Vec<u32>, Vec<(u64, u32)>) {
    let round_of = |hash: u64| (mixed(hash) % rounds) as usize;
    let mut start = vec![0_u32; rounds as usize + 1];
    for point in points {
        boxes.of(*point, |hash| start[round_of(hash) + 1] += 1);
    }
    (0..rounds as usize).for_each(|round| start[round + 1] += start[round]);
    let mut next = start.clone();
    let mut entries = vec![(0, 0); start[rounds as usize] as usize];
    for (node, point) in (0..).zip(points) {
        boxes.of(*point, |hash| {
            let place = &mut next[round_of(hash)];
            entries[*place as usize] = (hash, node);
            *place += 1;
        });
    }
    (start, entries)
}

/// The low bits of a hash are those that are mixed least.
fn mixed(hash: u64) -> u64 {
    hash >> 20
}
