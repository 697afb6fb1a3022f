//! The partition of a mesh that is small enough to be cut as it is.

use super::cells::Cells;
use super::homes::Homes;
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::mesh::import::Block;
use crate::mesh::slabs::Head;
use crate::mesh::whole::{Request, build, dual_graph};
use crate::partition::journey::{on_root, pack, unpack};
use crate::partition::metis;

/// A cell on its way: name, set of groups, names of nodes.
type Sent = (u32, u32, Vec<u32>);

/// The rank of every cell: that which the mesh gives it when one rank reads it whole. Collective.
///
/// # Arguments
/// * `points` (m) that this rank keeps
///
/// # Errors
/// `Input` for what is wrong with the mesh, `System` when METIS fails.
pub fn ranks(
    comm: &Comm,
    head: &Head,
    homes: &Homes,
    cells: &Cells,
    points: &[[f64; 3]],
    request: &Request,
) -> Result<Vec<u32>> {
    let own: Vec<Sent> =
        cells.iter().map(|cell| (cell.name, cell.set, cell.nodes.to_vec())).collect();
    let all = on_root(comm, &own)?;
    drop(own);
    let names = 0..if comm.is_root() { homes.total() as u32 } else { 0 };
    let points = homes.fetch(comm, names, |place| points[place]);
    let cut = |mut all: Vec<Sent>| -> Result<Vec<i32>> {
        all.sort_unstable_by_key(|cell| cell.0);
        let mut file =
            head.file(points, &|name| Some(name as usize).filter(|_| name != NONE), &|_| true);
        let mut rest = &all[..];
        for range in &head.kinds {
            let (of_kind, more) = rest.split_at(range.count as usize);
            file.blocks.push(Block {
                kind: range.kind,
                nodes: of_kind.iter().flat_map(|cell| &cell.2).copied().collect(),
                numbers: of_kind.iter().map(|cell| u64::from(cell.0)).collect(),
                groups: of_kind.iter().map(|cell| cell.1).collect(),
            });
            rest = more;
        }
        let mesh = build(&file, &Request { scale: 1.0, ..request.clone() }, "the mesh")?;
        if mesh.cells() as u64 != head.cells() {
            return Err(Error::Input("cells stand in it once for each of their groups".into()));
        }
        let graph = dual_graph(&mesh);
        let ranks = comm.size() as usize;
        metis::cut(&graph.start, &graph.neighbours, &graph.weights, &graph.work, ranks)
    };
    let cut = all.map_or_else(|| Ok(Vec::new()), cut);
    let bytes = comm.broadcast_bytes(comm.agree(cut.and_then(|cut| pack(&cut)))?);
    let ranks: Vec<i32> = comm.agree(unpack(&bytes))?;
    Ok(ranks.into_iter().map(|rank| rank as u32).collect())
}

/// Of nodes of no cell.
const NONE: u32 = u32::MAX;
