//! Elements that a file holds more than once.

use super::super::file_mesh::{Block, Kind};
use super::groups::Sets;
use crate::error::{Error, Result};

/// Joins copies of one element, which MSH 2.2 writes once for each of its groups, to one element of
/// all these groups. Other copies are errors, in MSH 4.1 all but those of points: several entities
/// can be at one node, and a point that is there twice is in all their groups.
pub(super) fn join(block: &mut Block, sets: &mut Sets, are_for_groups: bool) -> Result<()> {
    let count = block.kind.nodes();
    let nodes = |element: usize| &block.nodes[element * count..][..count];
    let sorted = |element: usize| {
        let mut nodes = nodes(element).to_vec();
        nodes.sort_unstable();
        nodes
    };
    // Copies stand beside each other in the order of a hash of the nodes, ties being looked at.
    let hashes = (0..block.numbers.len()).map(|e| (hash(nodes(e)), e));
    let mut order: Vec<(u64, usize)> = hashes.collect();
    order.sort_unstable_by(|a, b| {
        a.0.cmp(&b.0).then_with(|| sorted(a.1).cmp(&sorted(b.1))).then(a.1.cmp(&b.1))
    });
    let is_copy = |a: &(u64, usize), b: &(u64, usize)| a.0 == b.0 && sorted(a.1) == sorted(b.1);
    let mut dropped = vec![false; order.len()];
    let mut joined = Vec::new();
    for copies in order.chunk_by(is_copy).filter(|copies| copies.len() > 1) {
        let (first, second) = (copies[0].1, copies[1].1);
        if let Some(copy) = copies.iter().find(|copy| nodes(copy.1) != nodes(first)) {
            return Err(differing(block, first, copy.1));
        }
        let sets = copies.iter().map(|copy| sets.tags(block.groups[copy.1]));
        let is_grouped = sets.clone().all(|tags| !tags.is_empty());
        let mut tags = sets.flatten().copied().collect::<Vec<_>>();
        tags.sort_unstable();
        let is_distinct = tags.windows(2).all(|pair| pair[0] != pair[1]);
        tags.dedup();
        let is_point = block.kind == Kind::Point1;
        if !(is_point || are_for_groups && is_grouped && is_distinct) {
            return Err(same(block, first, second));
        }
        copies[1..].iter().for_each(|copy| dropped[copy.1] = true);
        joined.push((first, tags));
    }
    for (first, tags) in joined {
        block.groups[first] = sets.place(tags);
    }
    retain(block, &dropped);
    Ok(())
}

/// Of the set of the nodes.
fn hash(nodes: &[u32]) -> u64 {
    // The finaliser of splitmix64 for each, whose sum does not know their order.
    let mixed = nodes.iter().map(|node| {
        let x = (u64::from(*node) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    });
    mixed.fold(0, u64::wrapping_add)
}

/// Takes elements out.
pub(super) fn retain(block: &mut Block, dropped: &[bool]) {
    if !dropped.contains(&true) {
        return;
    }
    let count = block.kind.nodes();
    let kept = |element: usize| !dropped.get(element).copied().unwrap_or(false);
    let mut place = 0;
    block.nodes.retain(|_| {
        place += 1;
        kept((place - 1) / count)
    });
    for list in [0, 1] {
        let mut element = 0;
        let mut is_kept = || {
            element += 1;
            kept(element - 1)
        };
        match list {
            0 => block.numbers.retain(|_| is_kept()),
            _ => block.groups.retain(|_| is_kept()),
        }
    }
}

fn same(block: &Block, one: usize, other: usize) -> Error {
    let (one, other, kind) = (block.numbers[one], block.numbers[other], block.kind.name());
    Error::Input(format!(
        "$Elements: elements {one} and {other} ({kind}) are the same; leave one out, for instance \
         with Mesh.SaveAll = 0 or `Coherence Mesh`"
    ))
}

fn differing(block: &Block, one: usize, other: usize) -> Error {
    let (one, other, kind) = (block.numbers[one], block.numbers[other], block.kind.name());
    Error::Input(format!(
        "$Elements: elements {one} and {other} ({kind}) have the same nodes in different orders, \
         as copies for two groups have of which one has a negative tag; give their physical tags \
         one sign"
    ))
}
