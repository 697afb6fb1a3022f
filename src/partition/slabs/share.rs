//! Which rank gets which cells, and in which pieces they are made.

use super::cells::{Cell, Cells};
use super::curve::{Curve, cuts};
use super::exact;
use super::homes::Homes;
use super::labels::AtNodes;
use super::spread::{PieceList, Shared};
use crate::comm::Comm;
use crate::error::Result;
use crate::hash::mix;
use crate::mesh::slabs::Head;
use crate::mesh::whole::Request;
use crate::partition::journey::on_root;
use crate::partition::method::Method;

/// Cells of the coarse graph for each rank, and at most.
const CLUSTERS: u64 = 1024;
const MOST_CLUSTERS: u64 = 1 << 17;
/// A mesh of no more cells is no larger than a coarse graph: it is cut as it is.
const SMALL: u64 = 1 << 15;
/// Pieces of each rank where cells are scattered.
const SCATTERED: u32 = 3;
/// Cells of a piece, which are made at once: of a size that goes with what a rank has in the end,
/// as the cells around pieces are made with each.
const PIECE: f64 = 10_240.0;
/// The same where cells are raised, and have many nodes.
const RAISED_PIECE: f64 = 49_152.0;

/// Shares the cells out. Collective.
///
/// # Arguments
/// * `curve` through the cells, and the positions (m) of the nodes that this rank keeps
/// * `facing`: names of cells that face each other across an interface
///
/// # Errors
/// `System` when METIS fails.
pub fn share(
    comm: &Comm,
    head: &Head,
    homes: &Homes,
    cells: &Cells,
    (curve, points): (Curve, &[[f64; 3]]),
    (request, method, facing): (&Request, Method, &[[u32; 2]]),
) -> Result<Shared> {
    let ranks = comm.size() as u32;
    if method == Method::Scattered {
        let label = |cell: Cell<'_>| {
            let hash = mix(u64::from(cell.name));
            let rank = (hash % u64::from(ranks)) as u32;
            rank * SCATTERED + (mix(hash) % u64::from(SCATTERED)) as u32
        };
        let labels: Vec<u32> = cells.iter().map(label).collect();
        let at_nodes = AtNodes::new(comm, homes, cells, &labels);
        let firsts = (0..=ranks).map(|rank| rank * SCATTERED).collect();
        let list = PieceList { firsts, of_label: (0..ranks * SCATTERED).collect() };
        return Ok(Shared { labels, list, at_nodes });
    }
    if ranks > 1 && head.cells() <= SMALL.min(CLUSTERS * u64::from(ranks)) {
        drop(curve);
        let rank_of = exact::ranks(comm, head, homes, cells, points, request)?;
        let labels: Vec<u32> = cells.iter().map(|cell| rank_of[cell.name as usize]).collect();
        let at_nodes = AtNodes::new(comm, homes, cells, &labels);
        let list = PieceList { firsts: (0..=ranks).collect(), of_label: (0..ranks).collect() };
        return Ok(Shared { labels, list, at_nodes });
    }
    let wanted = (CLUSTERS * u64::from(ranks)).min(MOST_CLUSTERS).min(head.cells());
    let keys = || cells.iter().map(|cell| curve.key(cells, cell.nodes));
    let cuts = cuts(comm, keys().collect(), wanted);
    let label = |key: u64| cuts.partition_point(|cut| *cut <= key) as u32;
    let labels: Vec<u32> = keys().map(label).collect();
    drop(curve);
    let at_nodes = AtNodes::new(comm, homes, cells, &labels);
    let mut sums = vec![0.0; 2 * (cuts.len() + 1)];
    for (cell, label) in cells.iter().zip(&labels) {
        sums[2 * *label as usize] += 1.0;
        sums[2 * *label as usize + 1] += cell.nodes.len() as f64;
    }
    comm.sum(&mut sums);
    let work: Vec<f64> = sums.iter().skip(1).step_by(2).copied().collect();
    let facing = labels_of(comm, cells, &labels, facing)?;
    let rank_of = at_nodes.ranks(comm, &work, &facing)?;
    let counts: Vec<f64> = sums.iter().step_by(2).copied().collect();
    let piece = if request.raise_order == Some(2) { RAISED_PIECE } else { PIECE };
    let list = pieces(&rank_of, &counts, ranks, piece);
    let at_nodes = at_nodes.renamed(&list.of_label);
    Ok(Shared { labels, list, at_nodes })
}

/// The labels in the place of the names of cells, on the root; none on the others. Collective.
fn labels_of(
    comm: &Comm,
    cells: &Cells,
    labels: &[u32],
    pairs: &[[u32; 2]],
) -> Result<Vec<[u32; 2]>> {
    if pairs.is_empty() {
        return Ok(Vec::new());
    }
    let mut names = pairs.as_flattened().to_vec();
    names.sort_unstable();
    names.dedup();
    let all = cells.iter().zip(labels).map(|(cell, label)| (cell.name, *label));
    let own: Vec<(u32, u32)> = all.filter(|(name, _)| names.binary_search(name).is_ok()).collect();
    let Some(mut known) = on_root(comm, &own)? else { return Ok(Vec::new()) };
    known.sort_unstable();
    let label = |name: u32| {
        let place = known.binary_search_by_key(&name, |(name, _)| *name);
        place.map_or(0, |place| known[place].1)
    };
    Ok(pairs.iter().map(|pair| pair.map(label)).collect())
}

/// Pieces of labels that lie beside each other on the curve, of ranks that are told by label.
fn pieces(rank_of: &[u32], counts: &[f64], ranks: u32, most: f64) -> PieceList {
    let mut list = PieceList { firsts: vec![0], of_label: vec![0; counts.len()] };
    for rank in 0..ranks {
        let (mut piece, mut size) = (list.firsts[rank as usize], 0.0);
        for label in (0..counts.len()).filter(|label| rank_of[*label] == rank) {
            if size >= most {
                (piece, size) = (piece + 1, 0.0);
            }
            list.of_label[label] = piece;
            size += counts[label];
        }
        list.firsts.push(piece + 1);
    }
    list
}
