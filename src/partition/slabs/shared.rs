//! What all ranks know of a file, and the cells that each has read of it.

use std::collections::BTreeMap;

use super::File;
use super::cells::Cells;
use super::homes::Homes;
use super::names::{Named, name_nodes};
use super::read::{Slab, read as read_slab};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::mesh::import::{Block, Elements, Kind};
use crate::mesh::slabs::{Head, KindRange};
use crate::mesh::whole::{Request, check_plane, check_size};
use crate::partition::journey::{everywhere, joined};

/// What a rank has read.
pub struct Read {
    /// What all ranks know.
    pub head: Head,
    /// The cells of this rank.
    pub cells: Cells,
    /// Who keeps what of which node.
    pub homes: Homes,
    /// The positions (m) of the nodes that this rank keeps.
    pub points: Vec<[f64; 3]>,
    /// The least and the largest coordinates (m).
    pub ends: [[f64; 3]; 2],
    /// Nodes of no element, and those of elements that are no cells only.
    pub orphans: [u64; 2],
}

/// Reads a file. Collective.
///
/// # Errors
/// `Input` on all ranks.
pub fn read(comm: &Comm, pieces: File<'_>, request: &Request) -> Result<Read> {
    let mut slab = read_slab(comm, pieces)?;
    let mut own: BTreeMap<Kind, u64> = BTreeMap::new();
    for elements in &slab.elements {
        *own.entry(elements.kind).or_default() += elements.sets.len() as u64;
    }
    own.retain(|_, count| *count > 0);
    let counts = everywhere(comm, &own)?;
    let dim = counts.iter().flat_map(BTreeMap::keys).map(|kind| kind.dim()).max().unwrap_or(0);
    if dim < 2 {
        return Err(Error::Input("there are no cells in it".into()));
    }
    let (kinds, next) = kinds(&counts, pieces, dim, comm.rank() as usize);
    let nodes_of = |range: &KindRange| range.count as usize * range.kind.nodes();
    check_size(kinds.iter().map(nodes_of).sum())?;
    drop_points(&mut slab);
    let Named { homes, mut points, orphans } = name_nodes(comm, &mut slab, dim)?;
    if homes.total() >= 1 << 31 {
        return Err(Error::Input("there are too many nodes".into()));
    }
    let ends = scale(comm, &mut points, request.scale, dim)?;
    let of_cells = |elements: &Elements| elements.kind.dim() == dim;
    let (of_cells, below): (Vec<_>, Vec<_>) = slab.elements.into_iter().partition(of_cells);
    let mut below = gather(comm, &below, pieces)?;
    comm.agree(pieces.join(&mut below, &mut slab.sets))?;
    let (groups, sets) = comm.agree(pieces.groups(slab.sets))?;
    let mut of_sets = vec![0.0; sets.len()];
    let sets_of_cells = of_cells.iter().flat_map(|elements| &elements.sets);
    sets_of_cells.for_each(|set| of_sets[*set as usize] += 1.0);
    comm.sum(&mut of_sets);
    let sets_below = below.iter().flat_map(|block| &block.groups);
    sets_below.for_each(|set| of_sets[*set as usize] += 1.0);
    let mut counts = vec![0; groups.len()];
    for (set, count) in sets.iter().zip(of_sets) {
        set.iter().for_each(|group| counts[*group as usize] += count as usize);
    }
    let cells = Cells::of(of_cells, &kinds, next, homes.total());
    let nodes = homes.total() as u32;
    let head = Head { dim, kinds, sets, groups, counts, below, node_groups: Vec::new(), nodes };
    Ok(Read { head, cells, homes, points, ends, orphans })
}

/// Leaves out points in no group, which are elements of nothing.
fn drop_points(slab: &mut Slab) {
    for points in slab.elements.iter_mut().filter(|elements| elements.kind == Kind::Point1) {
        let mut sets = points.sets.iter();
        points.nodes.retain(|_| sets.next() != Some(&0));
        points.sets.retain(|set| *set != 0);
    }
}

/// The kinds of cells, and the name of the first cell of each on a rank.
fn kinds(
    counts: &[BTreeMap<Kind, u64>],
    pieces: File<'_>,
    dim: usize,
    rank: usize,
) -> (Vec<KindRange>, Vec<u32>) {
    let mut all: Vec<Kind> = counts.iter().flat_map(BTreeMap::keys).copied().collect();
    all.retain(|kind| kind.dim() == dim);
    all.sort_unstable_by_key(|kind| (pieces.order(*kind), *kind));
    all.dedup();
    let (mut kinds, mut next, mut first) = (Vec::new(), Vec::new(), 0);
    for kind in all {
        let of = |counts: &BTreeMap<Kind, u64>| counts.get(&kind).copied().unwrap_or(0);
        let count: u64 = counts.iter().map(of).sum();
        let before: u64 = counts[..rank].iter().map(of).sum();
        kinds.push(KindRange { kind, first: first as u32, count: count as u32 });
        next.push((first + before) as u32);
        first += count;
    }
    (kinds, next)
}

/// Puts points into metres; the least and the largest coordinates. Collective.
fn scale(comm: &Comm, points: &mut [[f64; 3]], scale: f64, dim: usize) -> Result<[[f64; 3]; 2]> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in points.iter_mut() {
        *point = point.map(|x| x * scale);
        for i in 0..3 {
            (low[i], high[i]) = (low[i].min(point[i]), high[i].max(point[i]));
        }
    }
    comm.min(&mut low);
    comm.max(&mut high);
    if dim == 2 {
        check_plane(low, high)?;
        points.iter_mut().for_each(|point| point[2] = 0.0);
        (low[2], high[2]) = (0.0, 0.0);
    }
    Ok([low, high])
}

/// Elements in groups of all ranks by kind, in the order of the file. Collective.
fn gather(comm: &Comm, below: &[Elements], pieces: File<'_>) -> Result<Vec<Block>> {
    let mut own: Vec<(Kind, Vec<u32>, Vec<u32>)> = Vec::new();
    for elements in below {
        if own.last().is_none_or(|(kind, ..)| *kind != elements.kind) {
            own.push((elements.kind, Vec::new(), Vec::new()));
        }
        let Some((kind, nodes, sets)) = own.last_mut() else { continue };
        let rows = elements.nodes.chunks(kind.nodes()).zip(&elements.sets);
        for (row, set) in rows.filter(|(_, set)| **set != 0) {
            nodes.extend_from_slice(row);
            sets.push(*set);
        }
    }
    let mut blocks: BTreeMap<Kind, Block> = BTreeMap::new();
    for (kind, nodes, groups) in joined(comm, &own)? {
        let empty = || Block { kind, nodes: Vec::new(), numbers: Vec::new(), groups: Vec::new() };
        let block = blocks.entry(kind).or_insert_with(empty);
        block.numbers.resize(block.numbers.len() + groups.len(), 0);
        block.nodes.extend(nodes);
        block.groups.extend(groups);
    }
    let mut blocks: Vec<Block> = blocks.into_values().collect();
    blocks.sort_by_key(|block| pieces.order(block.kind));
    Ok(blocks)
}
