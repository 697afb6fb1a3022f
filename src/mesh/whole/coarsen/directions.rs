//! Directions in which cells follow each other, and along which of them layers are joined.
//!
//! An edge, those beside it in its cells and those that go on from it behind a facet have one
//! direction. A layered block has one along each axis; where blocks meet in irregular nodes,
//! several become one. Smoothing reaches far along short edges only: layers are joined across
//! these, until cells are as long as wide.

use std::collections::BTreeMap;

use super::bits::bits;
use super::kept::Cubes;
use crate::mesh::whole::cells::NONE;
use crate::mesh::whole::facet::WholeFacet;
use crate::mesh::whole::facets::of_slot;

/// Layers are joined along a direction whose edges are at most this many times as long as those of
/// the shortest one.
const ALIKE: f64 = 1.5;
/// An edge is long that is this many times as long as another of its cell.
const LONG: f64 = 3.0;
/// Layers are not joined where more than this part of the cells would be doubled along long edges.
const FEW: f64 = 0.05;

/// The direction of each local axis of each cell.
pub struct Directions {
    parent: Vec<u32>,
}

impl Directions {
    pub fn new(cubes: &Cubes) -> Self {
        let count = cubes.view.shapes.len() * 3;
        let mut all = Self { parent: (0..count as u32).collect() };
        for (place, mate) in cubes.mates.iter().enumerate().filter(|(_, mate)| **mate != NONE) {
            let [one, other] = [place as u32, *mate].map(of_slot);
            if one.cell < other.cell {
                all.follow(cubes, one, other);
            }
        }
        all
    }

    /// Joins the axes of two cells with a common facet.
    fn follow(&mut self, cubes: &Cubes, one: WholeFacet, other: WholeFacet) {
        let [here, there] = [one, other].map(|facet| cubes.sides[facet.facet as usize]);
        self.join(one.cell, here.axis, other.cell, there.axis);
        let local = |node: u32| {
            let nodes = &cubes.view.cell_nodes(other.cell as usize)[..cubes.shape.nodes()];
            nodes.iter().position(|at| *at == node).map(bits)
        };
        let from = here.pull(0);
        for axis in (0..cubes.shape.dim()).filter(|axis| *axis != here.axis) {
            let ends = [from, from | 1 << axis].map(|end| local(cubes.node(one.cell, end)));
            if let [Some(a), Some(b)] = ends {
                self.join(one.cell, axis, other.cell, (a ^ b).trailing_zeros() as usize);
            }
        }
    }

    fn join(&mut self, cell: u32, axis: usize, other: u32, of_other: usize) {
        let [a, b] = [self.find(cell, axis), self.find(other, of_other)];
        let (low, high) = (a.min(b), a.max(b));
        self.parent[high as usize] = low;
    }

    /// The number of the direction of an axis of a cell.
    pub fn find(&mut self, cell: u32, axis: usize) -> u32 {
        let mut at = 3 * cell + axis as u32;
        while self.parent[at as usize] != at {
            let next = self.parent[at as usize];
            self.parent[at as usize] = self.parent[next as usize];
            at = next;
        }
        at
    }

    /// Finds the axes of connected cells, as bits, along which they are not joined. False where
    /// too many cells would become long.
    pub fn find_long(&mut self, cubes: &Cubes, cells: &[u32], found: &mut [u8]) -> bool {
        let dim = cubes.shape.dim();
        // Sum of the logarithms of the lengths of each direction, and how many there are.
        let mut sums = BTreeMap::<u32, [f64; 2]>::new();
        for cell in cells {
            for axis in 0..dim {
                let of = sums.entry(self.find(*cell, axis)).or_default();
                *of = [of[0] + cubes.length(*cell, axis).ln(), of[1] + 1.0];
            }
        }
        let mean = |[sum, number]: &[f64; 2]| (sum / number).exp();
        let shortest = sums.values().map(mean).fold(f64::INFINITY, f64::min);
        let is_joined = |direction: u32| mean(&sums[&direction]) <= ALIKE * shortest;
        let mut long = 0;
        for cell in cells {
            let lengths: [f64; 3] = std::array::from_fn(|axis| {
                if axis < dim { cubes.length(*cell, axis) } else { f64::INFINITY }
            });
            let least = lengths.iter().copied().fold(f64::INFINITY, f64::min);
            let mut becomes_longer = false;
            for (axis, length) in lengths.iter().enumerate().take(dim) {
                if is_joined(self.find(*cell, axis)) {
                    becomes_longer |= *length > LONG * least;
                } else {
                    found[*cell as usize] |= 1 << axis;
                }
            }
            long += usize::from(becomes_longer);
        }
        long as f64 <= FEW * cells.len() as f64
    }
}
