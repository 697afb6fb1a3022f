//! Coarser elements of groups that are no cells.

use std::collections::{BTreeMap, HashMap};

use super::families::{Child, Family};
use crate::element::Shape;
use crate::mesh::import::{Block, Kind};
use crate::mesh::whole::cells::{Cells, NONE, corner_count};
use crate::mesh::whole::facets::FacetTable;
use crate::mesh::whole::refine::reference_points;

/// Cells with the coarser ones that they are parts of.
pub struct Parts<'a> {
    pub cells: &'a Cells,
    pub table: &'a FacetTable,
    pub families: &'a [Family],
    /// The family of each cell and which child it is.
    pub place: &'a [(u32, u8)],
    pub shape: Shape,
}

/// A coarser element, of which some parts were found.
struct Element {
    kind: Kind,
    corners: Vec<u32>,
    number: u64,
    set: u32,
    found: usize,
    wanted: usize,
}

/// Joins elements of groups to coarser ones, all of whose parts are in the same groups. Their nodes
/// are those of the finer mesh; points stay.
pub fn coarsen(blocks: &[Block], parts: &Parts) -> Vec<Block> {
    let edges = parts.edges_of(blocks);
    let mut known: HashMap<(Vec<u32>, u32), usize> = HashMap::new();
    let mut elements: Vec<Element> = Vec::new();
    for block in blocks {
        let corners = corner_count(block.kind);
        for (index, nodes) in block.nodes.chunks(block.kind.nodes()).enumerate() {
            let set = block.groups[index];
            if parts.cells.group_sets[set as usize].is_empty() {
                continue;
            }
            let Some((kind, corners, wanted)) = parts.coarser(&nodes[..corners], &edges) else {
                continue;
            };
            let mut key = corners.clone();
            key.sort_unstable();
            let place = *known.entry((key, set)).or_insert(elements.len());
            if place == elements.len() {
                let number = block.numbers[index];
                elements.push(Element { kind, corners, number, set, found: 0, wanted });
            }
            elements[place].found += 1;
        }
    }
    let mut blocks: BTreeMap<Kind, Block> = BTreeMap::new();
    for element in elements.iter().filter(|element| element.found == element.wanted) {
        let kind = element.kind;
        let empty = || Block { kind, nodes: Vec::new(), numbers: Vec::new(), groups: Vec::new() };
        let block = blocks.entry(kind).or_insert_with(empty);
        block.nodes.extend(&element.corners);
        block.numbers.push(element.number);
        block.groups.push(element.set);
    }
    blocks.into_values().collect()
}

/// Edges of elements by their ends, rising, with a cell that has them.
type Edges = HashMap<[u32; 2], u32>;

impl Parts<'_> {
    /// The edges among elements of a mesh in space.
    fn edges_of(&self, blocks: &[Block]) -> Edges {
        let lines = blocks.iter().filter(|block| block.kind.dim() == 1 && self.shape.dim() == 3);
        let ends = lines.flat_map(|block| block.nodes.chunks(block.kind.nodes()));
        let mut edges: Edges = ends.map(|line| (rising(line[0], line[1]), NONE)).collect();
        if edges.is_empty() {
            return edges;
        }
        for cell in 0..self.place.len() {
            let nodes = &self.cells.view().cell_nodes(cell)[..self.shape.nodes()];
            for facet in self.shape.facets() {
                for (i, corner) in facet.iter().enumerate() {
                    let next = facet[(i + 1) % facet.len()];
                    if let Some(of) = edges.get_mut(&rising(nodes[*corner], nodes[next])) {
                        *of = cell as u32;
                    }
                }
            }
        }
        edges
    }

    /// The coarser element of one given by its corners: kind, corners among the nodes of the mesh,
    /// the number of its parts. None where it does not lie on the boundary of a coarser cell.
    fn coarser(&self, corners: &[u32], edges: &Edges) -> Option<(Kind, Vec<u32>, usize)> {
        let cell = match *corners {
            [point] => return Some((Kind::Point1, vec![point], 1)),
            [a, b] if self.shape.dim() == 3 => *edges.get(&rising(a, b)).filter(|c| **c != NONE)?,
            _ => self.table.find(corners.iter().copied()).next()?.cell,
        };
        let (family, child) = self.place[cell as usize];
        let family = &self.families[family as usize];
        let child: &Child = &family.children[usize::from(child)];
        let nodes = self.cells.view().cell_nodes(cell as usize);
        let local = |node: &u32| nodes.iter().position(|other| other == node);
        let locals = corners.iter().map(local).collect::<Option<Vec<usize>>>()?;
        let points = reference_points(self.shape);
        let points: Vec<[f64; 3]> =
            locals.iter().map(|local| points[usize::from(child.places[*local])]).collect();
        let mut wanted = 1;
        for (axis, first) in points[0].iter().enumerate().take(self.shape.dim()) {
            let along = || points.iter().map(|point| point[axis]);
            if along().all(|x| x == *first) {
                if *first == 0.0 {
                    return None;
                }
            } else if along().any(|x| x == 0.0) {
                wanted *= 2;
            }
        }
        let to = |local: &usize| family.corners[usize::from(child.towards[*local])];
        let kind = if corners.len() == 2 { Kind::Line2 } else { Kind::Quad4 };
        Some((kind, locals.iter().map(to).collect(), wanted))
    }
}

fn rising(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}
