//! The mesh cut along facets: one copy of a node for each sector of cells around it.

use std::ops::Range;

use super::cells::{Cells, NONE};
use super::facet::WholeFacet;
use super::facets::{of_slot, slot};

/// The copies of nodes.
#[derive(Debug, Clone)]
pub struct Copies {
    /// Nodes before cutting: copies are numbered from here.
    base: u32,
    /// The node that each copy is one of, rising.
    origins: Vec<u32>,
}

impl Copies {
    /// None of a mesh that is not cut.
    pub fn none(cells: &Cells) -> Self {
        Self { base: cells.points.len() as u32, origins: Vec::new() }
    }

    /// The copies of nodes that rise, numbered from `base` on.
    pub fn of_origins(base: u32, origins: Vec<u32>) -> Self {
        Self { base, origins }
    }

    /// The number of the first copy.
    pub fn base(&self) -> u32 {
        self.base
    }

    /// The node before cutting.
    pub fn origin(&self, node: u32) -> u32 {
        if node < self.base { node } else { self.origins[(node - self.base) as usize] }
    }

    /// All copies of a node that was there before, itself among them, rising.
    pub fn of(&self, origin: u32) -> impl Iterator<Item = u32> {
        let range = self.range(origin);
        std::iter::once(origin).chain(range.map(|copy| self.base + copy as u32))
    }

    /// The number of sectors around a node that was there before.
    pub fn sectors(&self, origin: u32) -> usize {
        1 + self.range(origin).len()
    }

    fn range(&self, origin: u32) -> Range<usize> {
        let from = self.origins.partition_point(|other| *other < origin);
        let count = self.origins[from..].partition_point(|other| *other == origin);
        from..from + count
    }
}

/// Cuts the cells apart along facets, which are given with both sides.
///
/// The cells around each node of a facet fall into sectors, which hang together by facets at the
/// node that are not cut. The first cell's sector keeps the node; the others get copies at the end.
/// `mates` loses the pairs that are cut.
pub fn cut(cells: &mut Cells, mates: &mut [u32], facets: &[WholeFacet]) -> Copies {
    let mut copies = Copies::none(cells);
    for facet in facets {
        mates[slot(*facet)] = NONE;
    }
    let around = Around::new(cells, facets);
    let mut sectors = Vec::new();
    for (index, node) in around.nodes.iter().enumerate() {
        let of_node = around.cells(index);
        let count = find_sectors(cells, mates, *node, of_node, &mut sectors);
        for _ in 1..count {
            copies.origins.push(*node);
            cells.points.push(cells.points[*node as usize]);
        }
        let first = cells.points.len() - count;
        for (cell, sector) in of_node.iter().zip(&sectors).filter(|(_, sector)| **sector > 0) {
            let from = cells.start[*cell as usize] as usize;
            let to = cells.start[*cell as usize + 1] as usize;
            let place = cells.nodes[from..to].iter_mut().find(|other| *other == node);
            if let Some(place) = place {
                *place = (first + sector) as u32;
            }
        }
    }
    copies
}

/// The cells around some nodes.
struct Around {
    nodes: Vec<u32>,
    start: Vec<u32>,
    cells: Vec<u32>,
}

impl Around {
    /// Of the nodes of facets; both rise.
    fn new(cells: &Cells, facets: &[WholeFacet]) -> Self {
        let view = cells.view();
        let mut nodes: Vec<u32> =
            facets.iter().flat_map(|facet| view.facet_nodes(*facet)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mut places = vec![NONE; cells.points.len()];
        (0..).zip(&nodes).for_each(|(place, node)| places[*node as usize] = place);
        let mut start = vec![0_u32; nodes.len() + 1];
        let of_node = |node: &u32| Some(places[*node as usize]).filter(|place| *place != NONE);
        for place in cells.nodes.iter().filter_map(of_node) {
            start[place as usize + 1] += 1;
        }
        for i in 0..nodes.len() {
            start[i + 1] += start[i];
        }
        let mut next = start.clone();
        let mut list = vec![0; start[nodes.len()] as usize];
        for cell in 0..cells.shapes.len() {
            for place in view.cell_nodes(cell).iter().filter_map(of_node) {
                let next = &mut next[place as usize];
                list[*next as usize] = cell as u32;
                *next += 1;
            }
        }
        Self { nodes, start, cells: list }
    }

    fn cells(&self, index: usize) -> &[u32] {
        &self.cells[self.start[index] as usize..self.start[index + 1] as usize]
    }
}

/// The sector of each cell around a node, numbered by their first cells; how many there are.
fn find_sectors(
    cells: &Cells,
    mates: &[u32],
    node: u32,
    around: &[u32],
    sectors: &mut Vec<usize>,
) -> usize {
    let view = cells.view();
    let unknown = usize::MAX;
    sectors.clear();
    sectors.resize(around.len(), unknown);
    let mut count = 0;
    let mut reached = Vec::new();
    for first in 0..around.len() {
        if sectors[first] != unknown {
            continue;
        }
        sectors[first] = count;
        reached.push(first);
        while let Some(place) = reached.pop() {
            for facet in view.facets(around[place] as usize) {
                let mate = mates[slot(facet)];
                if mate == NONE || !view.facet_nodes(facet).any(|other| other == node) {
                    continue;
                }
                let Ok(other) = around.binary_search(&of_slot(mate).cell) else { continue };
                if sectors[other] == unknown {
                    sectors[other] = count;
                    reached.push(other);
                }
            }
        }
        count += 1;
    }
    count
}
