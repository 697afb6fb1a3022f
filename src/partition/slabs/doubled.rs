//! Nodes of any ranks at one place that are not one node.

use super::pieces::Work;
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::mesh::whole::{Boxes, pairs_of_box};

/// The nodes are looked at in rounds of about so many, and not more rounds than these, so that no
/// rank has many of others at once.
const OF_ROUND: u64 = 100_000;
const MOST_ROUNDS: u64 = 8;

/// A node: its name, position (m) and shortest edge (m).
type Node = (u32, [f64; 3], f64);

/// Refuses pairs of nodes at one place, unless both are `known`: names of nodes on interfaces
/// between two groups, rising. Collective.
///
/// # Arguments
/// * `names` of the new nodes before cutting
/// * `low`: the least coordinates (m)
///
/// # Errors
/// `Input` on all ranks.
pub fn check(
    comm: &Comm,
    work: &Work,
    names: &[Option<u32>],
    low: [f64; 3],
    known: &[u32],
) -> Result<()> {
    let plain = || work.names.iter().zip(work.points.iter().zip(&work.shortest));
    let plain = || plain().map(|(name, (point, edge))| (name, *point, *edge));
    let fresh = || work.fresh.iter().zip(names);
    let fresh = || fresh().filter_map(|(f, name)| Some(((*name)?, f.point, f.shortest)));
    let nodes = || plain().chain(fresh()).filter(|node: &Node| node.2.is_finite());
    let mut longest = [nodes().map(|node| node.2).fold(0.0, f64::max)];
    comm.max(&mut longest);
    let boxes = Boxes::new(longest[0], low);
    let rounds = (comm.sum_u64(nodes().count() as u64) / OF_ROUND).clamp(1, MOST_ROUNDS);
    for round in 0..rounds {
        let ranks = comm.size() as u64;
        let mut keys = vec![Vec::new(); ranks as usize];
        let mut places = vec![Vec::new(); ranks as usize];
        for (name, point, edge) in nodes() {
            boxes.of(point, |hash| {
                // The low bits of the hash are those that are mixed least.
                let mixed = hash >> 20;
                if mixed % rounds == round {
                    let rank = (mixed / rounds % ranks) as usize;
                    keys[rank].extend([hash, u64::from(name)]);
                    places[rank].extend([point[0], point[1], point[2], edge]);
                }
            });
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
