//! The dual graph of a whole mesh.

use super::across::facing;
use super::facets::{FacetTable, of_slot};
use super::types::WholeMesh;
use crate::mesh::DualGraph;

/// Weight of the edge between two cells that share a facet.
const SHARED: i32 = 1;
/// Weight of the edge between two cells that face each other across an interface.
pub const FACING: i32 = 4;
/// An edge, seen from the first of its cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    from: u32,
    to: u32,
    weight: i32,
}

/// The graph of all cells: those that share a facet (weight 1), and those with facets that face
/// each other across an interface (weight 4 for each pair of facets): of one `on` a group its
/// pairs, of one `between` two groups all that may. The work of a cell is its number of
/// nodes. Every edge is told by both its cells with the same weight; neighbours rise.
///
/// # Parallel
/// Local.
pub fn dual_graph(mesh: &WholeMesh) -> DualGraph {
    let mut edges = Vec::new();
    let mut join = |one: u32, other: u32, weight: i32| {
        if one != other {
            edges.push(Edge { from: one, to: other, weight });
            edges.push(Edge { from: other, to: one, weight });
        }
    };
    for run in FacetTable::new(mesh.view()).runs() {
        if let [one, other] = run {
            join(of_slot(one.id).cell, of_slot(other.id).cell, SHARED);
        }
    }
    for interface in &mesh.interfaces {
        if interface.faces.is_empty() {
            let pairs = facing(mesh, interface);
            pairs.iter().for_each(|[one, other]| join(one.cell, other.cell, FACING));
        } else {
            let [lower, upper] = &interface.lips;
            lower.iter().zip(upper).for_each(|(one, other)| join(one.cell, other.cell, FACING));
        }
    }
    compressed(mesh, edges)
}

/// The edges by their first cells; those between the same cells add up.
fn compressed(mesh: &WholeMesh, mut edges: Vec<Edge>) -> DualGraph {
    edges.sort_unstable();
    let work = mesh.shapes.iter().map(|shape| shape.nodes() as i32).collect();
    let (neighbours, weights) = (Vec::new(), Vec::new());
    let mut graph = DualGraph { start: vec![0], neighbours, weights, work };
    let mut edges = edges.chunk_by(|a, b| (a.from, a.to) == (b.from, b.to)).peekable();
    for cell in 0..mesh.cells() {
        while let Some(same) = edges.next_if(|same| same[0].from as usize == cell) {
            graph.neighbours.push(same[0].to as i32);
            graph.weights.push(same.iter().map(|edge| edge.weight).sum());
        }
        graph.start.push(graph.neighbours.len() as i32);
    }
    graph
}
