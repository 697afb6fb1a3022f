//! The cells that a rank has read.

use std::ops::Range;

use crate::mesh::import::{Elements, Kind};
use crate::mesh::slabs::{KindRange, Numbers};

/// Cells of one kind with names beside each other.
pub struct Chunk {
    /// The name of the first one.
    pub first: u32,
    /// What they are.
    pub kind: Kind,
    /// Which of the kinds that is.
    pub place: usize,
    /// Names of nodes.
    pub nodes: Vec<u32>,
    /// Sets of groups.
    pub sets: Vec<u32>,
}

/// A cell.
#[derive(Debug, Clone, Copy)]
pub struct Cell<'c> {
    /// Its name.
    pub name: u32,
    /// The names of its nodes.
    pub nodes: &'c [u32],
    /// Its set of groups.
    pub set: u32,
}

/// The cells of a rank in the order of the file.
pub struct Cells {
    /// In pieces.
    pub chunks: Vec<Chunk>,
    /// The names of their nodes.
    pub names: Numbers,
}

impl Chunk {
    /// Its cells.
    pub fn iter(&self) -> impl Iterator<Item = Cell<'_>> {
        self.rows(0..self.sets.len())
    }

    /// Some of its cells.
    pub fn rows(&self, rows: Range<usize>) -> impl Iterator<Item = Cell<'_>> {
        let (width, first) = (self.kind.nodes(), self.first + rows.start as u32);
        let nodes = self.nodes[width * rows.start..width * rows.end].chunks(width);
        let cells = nodes.zip(&self.sets[rows]);
        (first..).zip(cells).map(|(name, (nodes, set))| Cell { name, nodes, set: *set })
    }
}

impl Cells {
    /// Takes the cells out of elements; `next` has the first name of each kind on this rank, and
    /// `nodes` is the number of all nodes.
    pub fn of(
        elements: Vec<Elements>,
        kinds: &[KindRange],
        mut next: Vec<u32>,
        nodes: u64,
    ) -> Self {
        let mut chunks = Vec::new();
        for Elements { kind, nodes, sets } in elements {
            let Some(place) = kinds.iter().position(|range| range.kind == kind) else { continue };
            let first = next[place];
            next[place] += sets.len() as u32;
            chunks.push(Chunk { first, kind, place, nodes, sets });
        }
        let all = chunks.iter().flat_map(|chunk| chunk.nodes.iter().copied());
        let names = Numbers::of(0, nodes, all);
        Self { chunks, names }
    }

    /// All cells.
    pub fn iter(&self) -> impl Iterator<Item = Cell<'_>> {
        self.chunks.iter().flat_map(Chunk::iter)
    }
}
