//! Which corner of each cell a coarser mesh keeps.
//!
//! Cells that are the parts of one have one corner each that is a corner of theirs, and meet in the
//! opposite one, in the middle. Two cells with a common facet are parts of one cell, where the
//! middle lies on it, or of two that meet there. A wall lies between two cells that are parts of no
//! common one: coarser cells begin anew behind it.

use super::bits::{Side, bits};
use crate::element::Shape;
use crate::mesh::whole::cells::NONE;
use crate::mesh::whole::facet::WholeFacet;
use crate::mesh::whole::facets::{of_slot, slot};
use crate::mesh::whole::view::View;

/// Quadrilaterals or hexahedra, and what lies between them.
pub struct Cubes<'a> {
    pub view: View<'a>,
    /// For each place of a facet that of the facet on its other side, or none.
    pub mates: &'a [u32],
    /// For each place of a facet whether a wall is there.
    pub is_wall: Vec<bool>,
    /// For each cell its local axes, as bits, along which it is not joined to others.
    pub long: Vec<u8>,
    /// The shape of the cells, of first order.
    pub shape: Shape,
    pub sides: Vec<Side>,
}

/// Stands for a cell whose corner is not known yet.
pub const UNKNOWN: u8 = u8::MAX;

impl Cubes<'_> {
    /// All bits of a corner.
    pub fn full(&self) -> usize {
        self.shape.nodes() - 1
    }

    /// The node at a corner of a cell, given by bits.
    pub fn node(&self, cell: u32, of_bits: usize) -> u32 {
        self.view.cell_nodes(cell as usize)[bits(of_bits)]
    }

    /// The mean length of the edges of a cell along a local axis (m).
    pub fn length(&self, cell: u32, axis: usize) -> f64 {
        let starts = (0..=self.full()).filter(|corner| corner >> axis & 1 == 0);
        let length = |corner: usize| {
            let ends = [corner, corner | 1 << axis].map(|end| self.node(cell, end));
            let [p, q] = ends.map(|node| self.view.points[node as usize]);
            (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt()
        };
        starts.map(length).sum::<f64>() / (self.shape.nodes() / 2) as f64
    }

    /// The facet on the other side of one, without a wall between them.
    pub fn beyond(&self, cell: u32, side: Side) -> Option<WholeFacet> {
        let facet = WholeFacet { cell, facet: side.facet(&self.sides) as u8 };
        let mate = self.mates[slot(facet)];
        (mate != NONE && !self.is_wall[slot(facet)]).then(|| of_slot(mate))
    }

    /// The cells that hang together with one by facets, that one first.
    pub fn connected(&self, first: u32, seen: &mut [bool]) -> Vec<u32> {
        let mut found = vec![first];
        seen[first as usize] = true;
        let mut next = 0;
        while let Some(cell) = found.get(next).copied() {
            next += 1;
            for facet in self.view.facets(cell as usize) {
                let mate = self.mates[slot(facet)];
                if mate != NONE && !std::mem::replace(&mut seen[of_slot(mate).cell as usize], true)
                {
                    found.push(of_slot(mate).cell);
                }
            }
        }
        found
    }

    /// Finds the corners that all connected cells keep, as bits, where the first of them keeps this
    /// one. False where they contradict each other.
    pub fn spread(&self, cells: &[u32], of_first: usize, kept: &mut [u8]) -> bool {
        cells.iter().for_each(|cell| kept[*cell as usize] = UNKNOWN);
        kept[cells[0] as usize] = (of_first & !self.long_axes(cells[0])) as u8;
        let mut front = vec![cells[0]];
        while let Some(cell) = front.pop() {
            for facet in self.view.facets(cell as usize) {
                let mate = self.mates[slot(facet)];
                if mate == NONE {
                    continue;
                }
                let other = of_slot(mate);
                let Some(wanted) = self.across(facet, other, usize::from(kept[cell as usize]))
                else {
                    return false;
                };
                let known = kept[other.cell as usize];
                let is_wall = self.is_wall[slot(facet)];
                if known == UNKNOWN {
                    kept[other.cell as usize] = wanted as u8;
                    front.push(other.cell);
                } else {
                    // Along a wall both sides have to agree, across it they need not.
                    let side = self.sides[other.facet as usize];
                    let known = usize::from(known);
                    let agree = if is_wall {
                        side.pull(known) == side.pull(wanted)
                    } else {
                        known == wanted
                    };
                    if !agree {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// The corner that the cell behind a facet keeps, where the one before it keeps `own`.
    fn across(&self, facet: WholeFacet, other: WholeFacet, own: usize) -> Option<usize> {
        let [here, there] = [facet, other].map(|facet| self.sides[facet.facet as usize]);
        let on_facet = self.node(facet.cell, here.pull(own));
        let nodes = &self.view.cell_nodes(other.cell as usize)[..self.shape.nodes()];
        let found = bits(nodes.iter().position(|node| *node == on_facet)?);
        let meets_there = here.has(own) || self.is_wall[slot(facet)];
        let found = if meets_there { found } else { found ^ 1 << there.axis };
        // Along these every corner is kept.
        Some(found & !self.long_axes(other.cell))
    }

    fn long_axes(&self, cell: u32) -> usize {
        usize::from(self.long[cell as usize])
    }
}
