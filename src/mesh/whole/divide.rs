//! Facets of interfaces divided where no node of them could carry a traction.
//!
//! Where a joint between two crossings is one facet long, all its nodes belong to the crossings,
//! and where it is as wide as a strip between rollers, to the rollers. Such a facet gets nodes
//! inside: one for each of its corners, so that the joint also carries moments. The cells beside it
//! become triangles, tetrahedra and pyramids around a node in their middle; all their other sides
//! stay as they are. Groups keep their elements: a divided element becomes its parts.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use super::cells::{Cells, corner_count};
use super::facet::WholeFacet;
use crate::element::Shape;
use crate::mesh::import::{Block, FileMesh, Kind};

/// The corners of an element or a facet, rising, as points of the file.
type Key = Vec<u32>;

/// How far a node inside lies from the middle of its facet, on the way to its corner.
const WAY: [f64; 3] = [1.0 / 3.0, 0.4, 1.0 / 3.0];
/// Squared distances that differ by less than this part of their sum are the same.
const EVEN: f64 = 1e-9;

/// A facet that is divided: each corner, and the point inside that belongs to it.
type Inside = BTreeMap<u32, u32>;

/// The mesh of a file with some `facets` of its `cells` divided; how many were. Those that cannot
/// be stay: of second order, and where pyramids would come of it that are to be raised.
pub fn divide(
    file: &FileMesh,
    cells: &Cells,
    facets: &[WholeFacet],
    is_raised: bool,
) -> (FileMesh, usize) {
    let mut work = Work::new(file);
    let points = points_of_file(cells);
    for facet in facets {
        let (kind, shape) = (cells.kinds[facet.cell as usize], cells.shapes[facet.cell as usize]);
        let is_whole = kind.nodes() == corner_count(kind);
        let makes_pyramids = is_raised && matches!(shape.corners(), Shape::Prism6 | Shape::Hex8);
        if is_whole && !makes_pyramids {
            let corners = cells.view().facet_corners(*facet);
            let corners = &corners[..cells.view().corner_count(*facet)];
            work.divide_facet(
                &corners.iter().map(|node| points[*node as usize]).collect::<Vec<_>>(),
            );
        }
    }
    let count = work.inside.len();
    let dim = cells.dim();
    let blocks = std::mem::take(&mut work.file.blocks);
    let mut made = Blocks::default();
    for block in &blocks {
        for (index, nodes) in block.nodes.chunks(block.kind.nodes()).enumerate() {
            let tags = (block.numbers[index], block.groups[index]);
            if block.kind.dim() == dim {
                work.add_cell(block.kind, nodes, tags, &mut made);
            } else if let Some(inside) = work.inside.get(&key(nodes)).cloned() {
                let parts = parts(nodes, &inside, &work.file.points);
                parts.iter().for_each(|part| made.add_facet(part, tags));
            } else {
                made.add(block.kind, nodes, tags);
            }
        }
    }
    work.file.blocks = made.list;
    (work.file, count)
}

/// The point of the file of each node.
fn points_of_file(cells: &Cells) -> Vec<u32> {
    let mut points = vec![0; cells.points.len()];
    for (point, node) in (0..).zip(&cells.names) {
        if let Some(place) = points.get_mut(*node as usize) {
            *place = point;
        }
    }
    points
}

fn key(nodes: &[u32]) -> Key {
    let mut key = nodes.to_vec();
    key.sort_unstable();
    key
}

/// Number in the file and set of groups of an element.
type Tags = (u64, u32);

/// Elements by kind.
#[derive(Default)]
struct Blocks {
    list: Vec<Block>,
}

impl Blocks {
    fn add(&mut self, kind: Kind, nodes: &[u32], (number, set): Tags) {
        let place = self.list.iter().position(|block| block.kind == kind);
        let place = place.unwrap_or_else(|| {
            let (nodes, numbers, groups) = Default::default();
            self.list.push(Block { kind, nodes, numbers, groups });
            self.list.len() - 1
        });
        let block = &mut self.list[place];
        block.nodes.extend_from_slice(nodes);
        block.numbers.push(number);
        block.groups.push(set);
    }

    fn add_facet(&mut self, nodes: &[u32], tags: Tags) {
        let kind = [Kind::Line2, Kind::Tri3, Kind::Quad4][nodes.len() - 2];
        self.add(kind, nodes, tags);
    }
}

/// The file as it becomes, and its new points.
struct Work {
    file: FileMesh,
    /// Number of the next new point.
    next: u64,
    /// The divided facets.
    inside: BTreeMap<Key, Inside>,
    /// The points in the middle of cells.
    centres: BTreeMap<Key, u32>,
}

impl Work {
    fn new(file: &FileMesh) -> Self {
        let next = file.node_numbers.iter().max().map_or(1, |last| last + 1);
        Self { file: file.clone(), next, inside: BTreeMap::new(), centres: BTreeMap::new() }
    }

    fn point(&mut self, point: [f64; 3]) -> u32 {
        self.file.points.push(point);
        self.file.node_numbers.push(self.next);
        self.next += 1;
        self.file.points.len() as u32 - 1
    }

    fn middle(&self, nodes: &[u32]) -> [f64; 3] {
        let sum = |i: usize| nodes.iter().map(|n| self.file.points[*n as usize][i]).sum::<f64>();
        [0, 1, 2].map(|i| sum(i) / nodes.len() as f64)
    }

    fn divide_facet(&mut self, corners: &[u32]) {
        let corners = key(corners);
        if self.inside.contains_key(&corners) {
            return;
        }
        let (middle, way) = (self.middle(&corners), WAY[corners.len() - 2]);
        let mut inside = Inside::new();
        for corner in &corners {
            let at = self.file.points[*corner as usize];
            let point = std::array::from_fn(|i| middle[i] + way * (at[i] - middle[i]));
            inside.insert(*corner, self.point(point));
        }
        self.inside.insert(corners, inside);
    }

    /// A cell, or its parts around its middle where facets of it are divided.
    fn add_cell(&mut self, kind: Kind, nodes: &[u32], tags: Tags, made: &mut Blocks) {
        let Some(shape) = first_order(kind) else { return made.add(kind, nodes, tags) };
        let facets: Vec<Vec<u32>> = shape
            .facets()
            .iter()
            .map(|facet| facet.iter().map(|local| nodes[*local]).collect())
            .collect();
        if !facets.iter().any(|facet| self.inside.contains_key(&key(facet))) {
            return made.add(kind, nodes, tags);
        }
        // A cell in several groups can be several elements of the file.
        let all = key(nodes);
        let known = self.centres.get(&all).copied();
        let centre = known.unwrap_or_else(|| {
            let middle = self.middle(nodes);
            self.point(middle)
        });
        self.centres.insert(all, centre);
        for facet in &facets {
            match self.inside.get(&key(facet)) {
                None => add_cone(facet, centre, tags, made),
                Some(inside) => {
                    let parts = parts(facet, inside, &self.file.points);
                    parts.iter().for_each(|part| add_cone(part, centre, tags, made));
                }
            }
        }
    }
}

/// The cell of a facet whose normal points away from its last node.
fn add_cone(facet: &[u32], apex: u32, tags: Tags, made: &mut Blocks) {
    match *facet {
        [a, b] => made.add(Kind::Tri3, &[a, b, apex], tags),
        [a, b, c] => made.add(Kind::Tet4, &[a, c, b, apex], tags),
        [a, b, c, d] => made.add(Kind::Pyramid5, &[a, d, c, b, apex], tags),
        _ => {}
    }
}

/// The parts of a divided facet, each the same way round as its corners.
fn parts(corners: &[u32], inside: &Inside, points: &[[f64; 3]]) -> Vec<Vec<u32>> {
    let inner: Vec<u32> = corners.iter().map(|corner| inside[corner]).collect();
    let ([first, second], count) = ([corners[0], corners[1]], corners.len());
    if count == 2 {
        return vec![vec![first, inner[0]], inner.clone(), vec![inner[1], second]];
    }
    let mut parts = vec![inner.clone()];
    for (i, j) in (0..count).map(|i| (i, (i + 1) % count)) {
        let [a, b, c, d] = [corners[i], corners[j], inner[j], inner[i]];
        if count == 4 {
            parts.push(vec![a, b, c, d]);
            continue;
        }
        let opposite = corners[(j + 1) % count];
        match is_first(a, b, opposite, points) {
            // The same from the other side, where a and b change places.
            true => parts.extend([vec![a, b, c], vec![a, c, d]]),
            false => parts.extend([vec![a, b, d], vec![b, c, d]]),
        }
    }
    parts
}

/// Whether `a` comes before `b`: as the nearer one to `opposite`, else by its place. Numbers of
/// nodes make no other mesh.
fn is_first(a: u32, b: u32, opposite: u32, points: &[[f64; 3]]) -> bool {
    let [p, q, r] = [a, b, opposite].map(|node| points[node as usize]);
    let square = |x: [f64; 3]| (0..3).map(|i| (x[i] - r[i]).powi(2)).sum::<f64>();
    let (one, other) = (square(p), square(q));
    if (one - other).abs() > EVEN * (one + other) {
        return one < other;
    }
    let places = p.iter().zip(&q).map(|(x, y)| x.total_cmp(y));
    places.fold(Ordering::Equal, Ordering::then).then(a.cmp(&b)).is_lt()
}

/// The shape of cells of first order.
fn first_order(kind: Kind) -> Option<Shape> {
    Some(match kind {
        Kind::Tri3 => Shape::Tri3,
        Kind::Quad4 => Shape::Quad4,
        Kind::Tet4 => Shape::Tet4,
        Kind::Prism6 => Shape::Prism6,
        Kind::Pyramid5 => Shape::Pyramid5,
        Kind::Hex8 => Shape::Hex8,
        _ => return None,
    })
}
