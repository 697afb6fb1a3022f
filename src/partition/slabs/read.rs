//! Every rank reads its part of the nodes and the elements.

use std::ops::Range;

use crate::comm::Comm;
use crate::error::Result;
use crate::mesh::import::{Elements, NodeRows, Pieces, SetOfTags};
use crate::partition::journey::joined;

/// What a rank has read.
pub struct Slab {
    /// Elements in the order of the file.
    pub elements: Vec<Elements>,
    /// Nodes in the order of the file.
    pub nodes: NodeRows,
    /// All sets of groups, the same on every rank.
    pub sets: Vec<SetOfTags>,
}

/// Reads the part of this rank. Collective.
///
/// # Errors
/// As the pieces tell, on all ranks.
pub fn read(comm: &Comm, pieces: &dyn Pieces) -> Result<Slab> {
    let (elements, nodes, found) = comm.agree(read_own(comm, pieces))?;
    let mut slab = Slab { elements, nodes, sets: pieces.sets() };
    let known = slab.sets.len();
    for set in joined(comm, &found[known..])? {
        if !slab.sets.contains(&set) {
            slab.sets.push(set);
        }
    }
    let places: Vec<u32> = found
        .iter()
        .map(|set| slab.sets.iter().position(|other| other == set).unwrap_or(0) as u32)
        .collect();
    if found.len() > known {
        let of_elements = slab.elements.iter_mut().flat_map(|elements| &mut elements.sets);
        of_elements.for_each(|set| *set = places[*set as usize]);
    }
    Ok(slab)
}

type Own = (Vec<Elements>, NodeRows, Vec<SetOfTags>);

fn read_own(comm: &Comm, pieces: &dyn Pieces) -> Result<Own> {
    let (of_nodes, of_elements) = (pieces.node_rows(), pieces.element_rows());
    let mut nodes = NodeRows::default();
    let own = share(comm, &of_nodes);
    let rows: u64 = of_nodes[own.clone()].iter().sum();
    nodes.numbers.reserve_exact(rows as usize);
    nodes.points.reserve_exact(rows as usize);
    for piece in own {
        let read = pieces.nodes(piece)?;
        nodes.numbers.extend(read.numbers);
        nodes.points.extend(read.points);
    }
    let (mut elements, mut sets) = (Vec::new(), pieces.sets());
    for piece in share(comm, &of_elements) {
        for mut read in pieces.elements(piece, &mut sets)? {
            read.nodes.shrink_to_fit();
            read.sets.shrink_to_fit();
            elements.push(read);
        }
    }
    Ok((elements, nodes, sets))
}

/// The pieces of this rank, which lie beside each other: about as many rows as of any other.
fn share(comm: &Comm, rows: &[u64]) -> Range<usize> {
    let total = u128::from(rows.iter().sum::<u64>().max(1));
    let (rank, ranks) = (u128::from(comm.rank() as u64), u128::from(comm.size() as u64));
    let mut before = 0;
    let rank_of = rows.iter().map(|rows| {
        before += u128::from(*rows);
        (before - u128::from(*rows)) * ranks / total
    });
    let of: Vec<u128> = rank_of.collect();
    of.partition_point(|other| *other < rank)..of.partition_point(|other| *other <= rank)
}
