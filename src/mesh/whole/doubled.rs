//! Nodes at one place that are not one node.

use std::collections::HashMap;

use super::buckets::split;
use super::cells::{Cells, NONE};
use super::facet::WholeFacet;
use super::facets::slot;
use super::plan::Plan;
use super::words::{count, place, wrong};
use crate::error::Result;
use crate::mesh::import::FileMesh;

/// Nodes closer than this part of the shortest edge around them are at one place.
const NEAR: f64 = 1e-9;
/// Edge of the boxes into which nodes fall, against the largest distance of a pair.
const BOX: f64 = 16.0;
/// Where the boxes begin: round coordinates do not lie on their walls.
const SHIFT: f64 = 0.371_906_348;
/// Nodes of one box that each is compared with.
const MOST: usize = 8;

/// Refuses pairs of nodes at one place, unless both are on interfaces `between` two groups.
///
/// # Errors
/// `Input` with their number, the first place, and the facets that lie on each other.
pub fn check(cells: &Cells, mates: &[u32], plans: &[Plan], file: &FileMesh) -> Result<()> {
    let mut pairs = pairs(cells);
    let mut is_known = vec![false; cells.points.len()];
    let between = plans.iter().filter(|plan| !plan.is_cut).flat_map(|plan| &plan.lips);
    for facet in between.flatten() {
        cells.view().facet_nodes(*facet).for_each(|node| is_known[node as usize] = true);
    }
    pairs.retain(|pair| !pair.iter().all(|node| is_known[*node as usize]));
    let Some([a, b]) = pairs.first() else { return Ok(()) };
    let at = place(cells.points[*a as usize]);
    let numbers = match [a, b].map(|node| number_of(cells, file, *node)) {
        [Some(a), Some(b)] => format!(" (nodes {a} and {b})"),
        _ => String::new(),
    };
    let what = format!(
        "{} at the place of another node, the first at {at}{numbers}",
        count(pairs.len(), "node") + if pairs.len() == 1 { " lies" } else { " lie" }
    );
    let coincident = coincident(cells, mates, &pairs);
    let Some([one, other]) = coincident.first() else {
        return Err(wrong(format!(
            "{what}; join them (Geometry.Tolerance and `Coherence Mesh` in Gmsh, Merge nodes in \
             SALOME), or name the sides of both bodies in an interface `between`"
        )));
    };
    Err(wrong(format!(
        "{what}; {} on each other and belong to no interface, the first being {} and that of \
         element {}. If the bodies are one there, join their nodes (`Coherence` before meshing, \
         `Coherence Mesh` after it); if there is a joint, name both sides in an interface \
         `between`; if another program split the mesh along a crack, whose crossings it leaves \
         hinged, give the mesh as it was before and the crack with `on: GROUP`",
        count(coincident.len(), "pair")
            + " of facets"
            + if coincident.len() == 1 { " lies" } else { " lie" },
        cells.describe_facet(*one),
        cells.numbers[other.cell as usize]
    )))
}

/// The number in the file of a node that was there.
fn number_of(cells: &Cells, file: &FileMesh, node: u32) -> Option<u64> {
    let point = cells.names.iter().position(|name| *name == node)?;
    file.node_numbers.get(point).copied()
}

/// Pairs of nodes at one place, each higher node once, by rising lower node.
fn pairs(cells: &Cells) -> Vec<[u32; 2]> {
    let edges = shortest_edges(cells);
    let mut low = [f64::INFINITY; 3];
    for point in &cells.points {
        low.iter_mut().zip(point).for_each(|(low, x)| *low = low.min(*x));
    }
    let boxes = Boxes::new(edges.iter().copied().fold(0.0, f64::max), low);
    let mut found = Vec::with_capacity(cells.points.len() + cells.points.len() / 2);
    for (node, point) in (0..).zip(&cells.points) {
        boxes.of(*point, |hash| found.push((hash, node)));
    }
    found.sort_unstable();
    let mut pairs = Vec::new();
    for of_box in found.chunk_by(|a, b| a.0 == b.0).filter(|of_box| of_box.len() > 1) {
        let at = |(_, node): &(u64, u32)| (cells.points[*node as usize], edges[*node as usize]);
        pairs_of_box(of_box, at, |(_, a), (_, b)| {
            if a != b {
                pairs.push([*b.max(a), *a.min(b)]);
            }
        });
    }
    pairs.sort_unstable();
    pairs.dedup_by_key(|pair| pair[0]);
    let mut pairs: Vec<[u32; 2]> = pairs.into_iter().map(|[high, low]| [low, high]).collect();
    pairs.sort_unstable();
    pairs
}

/// Finds the nodes at one place among those of a box, each of which has a position (m) and a
/// shortest edge (m).
pub fn pairs_of_box<N>(
    nodes: &[N],
    at: impl Fn(&N) -> ([f64; 3], f64),
    mut found: impl FnMut(&N, &N),
) {
    for (i, a) in nodes.iter().enumerate() {
        for b in nodes[i + 1..].iter().take(MOST) {
            let ((p, of_p), (q, of_q)) = (at(a), at(b));
            if distance(p, q) <= NEAR * of_p.min(of_q) {
                found(a, b);
            }
        }
    }
}

/// The boxes into which nodes fall.
#[derive(Debug, Clone, Copy)]
pub struct Boxes {
    reach: f64,
    size: f64,
    low: [f64; 3],
}

impl Boxes {
    /// Of nodes with edges of at most `longest` (m), of which the least coordinates are `low` (m).
    pub fn new(longest: f64, low: [f64; 3]) -> Self {
        let reach = NEAR * longest;
        Self { reach, size: if reach > 0.0 { BOX * reach } else { 1.0 }, low }
    }

    /// Tells the hash of each box in which a node may meet others.
    pub fn of(&self, point: [f64; 3], mut tell: impl FnMut(u64)) {
        let ends = [0, 1, 2].map(|i| {
            let at = |x: f64| ((x - self.low[i]) / self.size + SHIFT).floor() as i64;
            [at(point[i] - self.reach), at(point[i] + self.reach)]
        });
        for corner in 0..8 {
            let end = |axis: usize| corner >> axis & 1;
            if (0..3).any(|axis| end(axis) == 1 && ends[axis][0] == ends[axis][1]) {
                continue;
            }
            tell(hash([0, 1, 2].map(|axis| ends[axis][end(axis)])));
        }
    }
}

/// Boxes with the same hash only cost a comparison.
fn hash(place: [i64; 3]) -> u64 {
    place.iter().fold(0, |hash: u64, i| {
        let mixed = (hash ^ *i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed ^ (mixed >> 29)
    })
}

/// The shortest edge of the cells around each node.
pub fn shortest_edges(cells: &Cells) -> Vec<f64> {
    let view = cells.view();
    let mut shortest = vec![f64::INFINITY; cells.points.len()];
    for (cell, shape) in cells.shapes.iter().enumerate() {
        let nodes = view.cell_nodes(cell);
        let mut least = f64::INFINITY;
        for (facet, locals) in shape.facets().iter().enumerate() {
            let corners = shape.facet_shape(facet).map_or(2, |shape| shape.corners().nodes());
            for i in 0..corners {
                let ends = [locals[i], locals[(i + 1) % corners]];
                let [p, q] = ends.map(|local| cells.points[nodes[local] as usize]);
                least = least.min(distance(p, q));
            }
        }
        for node in nodes {
            let shortest = &mut shortest[*node as usize];
            *shortest = shortest.min(least);
        }
    }
    shortest
}

fn distance(p: [f64; 3], q: [f64; 3]) -> f64 {
    (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt()
}

/// Facets on the boundary of the mesh that lie on each other.
fn coincident(cells: &Cells, mates: &[u32], pairs: &[[u32; 2]]) -> Vec<[WholeFacet; 2]> {
    let view = cells.view();
    let mut same: HashMap<u32, u32> = HashMap::new();
    for [low, high] in pairs {
        let root = *same.get(low).unwrap_or(low);
        same.extend([(*low, root), (*high, root)]);
    }
    let mut known: HashMap<(u32, [u32; 3]), WholeFacet> = HashMap::new();
    let mut found = Vec::new();
    for facet in (0..cells.shapes.len()).flat_map(|cell| view.facets(cell)) {
        let corners = view.facet_nodes(facet).take(view.corner_count(facet));
        let mut roots = corners.filter_map(|node| same.get(&node).copied());
        if mates[slot(facet)] != NONE || roots.by_ref().count() < view.corner_count(facet) {
            continue;
        }
        let corners = view.facet_nodes(facet).take(view.corner_count(facet));
        let key = split::<3>(corners.filter_map(|node| same.get(&node).copied()));
        match known.get(&key) {
            Some(other) => found.push([*other, facet]),
            None => {
                known.insert(key, facet);
            }
        }
    }
    found
}
