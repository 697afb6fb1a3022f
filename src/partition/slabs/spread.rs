//! Cells on their way to the ranks that get them, with those around them.

use super::cells::{Cell, Cells, Chunk};
use super::homes::Homes;
use super::labels::AtNodes;
use super::runs::Runs;
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::mesh::slabs::Head;
use crate::mesh::whole::Request;
use crate::runtime::give_back_memory;

/// Cells that are told at once, so that little memory is taken.
const BATCH: usize = 4096;
/// Of no piece.
const NONE: u32 = u32::MAX;

/// The pieces of all ranks.
pub struct PieceList {
    /// The first piece of each rank, and the end.
    pub firsts: Vec<u32>,
    /// The piece of each label.
    pub of_label: Vec<u32>,
}

/// Which cells go where.
pub struct Shared {
    /// The labels of the cells of this rank.
    pub labels: Vec<u32>,
    /// The pieces of these.
    pub list: PieceList,
    /// The pieces at the nodes that this rank keeps.
    pub at_nodes: AtNodes,
}

/// What a rank has got: its cells with the files' nodes, and those around them.
#[derive(Default)]
pub struct Held {
    /// Names of its cells, rising.
    pub cells: Vec<u32>,
    /// Sets of groups of its cells, until they are replaced by materials.
    pub sets: Vec<u32>,
    /// The piece of each, counted from the first of this rank.
    pub pieces: Vec<u16>,
    /// Where the nodes of each stand.
    pub runs: Runs,
    /// Names of nodes.
    pub nodes: Vec<u32>,
    /// Cells of other ranks: their names, the ends of their nodes, and those.
    pub far: (Vec<u32>, Vec<u32>, Vec<u32>),
    /// For each piece the cells around it, own ones by place, then those of other ranks.
    pub beside: Vec<Vec<u32>>,
}

/// The pieces at nodes where several meet.
struct Meeting {
    /// Where the pieces of each node of this rank stand; 0 where there is one.
    at: Vec<u32>,
    pieces: Vec<u32>,
}

impl Meeting {
    /// Collective.
    fn new(comm: &Comm, homes: &Homes, cells: &Cells, pieces: &AtNodes) -> Self {
        let mut asked = vec![Vec::new(); comm.size() as usize];
        for name in cells.names.iter() {
            let (rank, place) = homes.of(name);
            asked[rank].push(place);
        }
        let sizes: Vec<usize> = asked.iter().map(Vec::len).collect();
        let answer = |places: &Vec<u32>| {
            let mut words = Vec::new();
            for (index, place) in (0..).zip(places) {
                let pieces = pieces.at(*place as usize);
                if pieces.len() > 1 {
                    words.extend([index, pieces.len() as u32]);
                    words.extend_from_slice(pieces);
                }
            }
            words
        };
        let answers: Vec<Vec<u32>> = comm.exchange(&asked).iter().map(answer).collect();
        let mut found = Self { at: vec![0; cells.names.len()], pieces: vec![0] };
        let mut before = 0;
        for (words, size) in comm.exchange(&answers).into_iter().zip(sizes) {
            let mut rest = &words[..];
            while let [index, count, more @ ..] = rest {
                found.at[before + *index as usize] = found.pieces.len() as u32;
                found.pieces.push(*count);
                found.pieces.extend_from_slice(&more[..*count as usize]);
                rest = &more[*count as usize..];
            }
            before += size;
        }
        found
    }

    /// All pieces that need a cell, rising.
    fn of(&self, cells: &Cells, nodes: &[u32], own: u32, found: &mut Vec<u32>) {
        found.clear();
        found.push(own);
        for node in nodes {
            let at = self.at[cells.names.place(*node).unwrap_or_default()] as usize;
            if at > 0 {
                found.extend_from_slice(&self.pieces[at + 1..][..self.pieces[at] as usize]);
            }
        }
        found.sort_unstable();
        found.dedup();
    }
}

/// Sends every cell to the pieces that need it. Collective.
pub fn spread(
    comm: &Comm,
    homes: &Homes,
    head: &Head,
    mut cells: Cells,
    Shared { labels, list, at_nodes }: Shared,
) -> Held {
    let meeting = Meeting::new(comm, homes, &cells, &at_nodes);
    drop(at_nodes);
    let list = &list;
    let mut held = Held::empty(comm, head, &cells, &labels, list);
    let mut labels = by_chunk(&cells, labels).into_iter();
    let batches = |chunk: &Chunk| chunk.sets.len().div_ceil(BATCH) as u64;
    let rounds = comm.max_u64(cells.chunks.iter().map(batches).sum());
    let mut chunks = std::mem::take(&mut cells.chunks).into_iter();
    let mut left: Option<(Chunk, Vec<u32>, usize)> = None;
    for _ in 0..rounds {
        let mut words = vec![Vec::new(); comm.size() as usize];
        if left.is_none() {
            left = chunks.next().zip(labels.next()).map(|(chunk, labels)| (chunk, labels, 0));
        }
        if let Some((chunk, labels, from)) = left.take() {
            let to = chunk.sets.len().min(from + BATCH);
            let rows = chunk.rows(from..to).zip(&labels[from..to]);
            let pieces_of =
                |nodes: &[u32], own: u32, all: &mut Vec<u32>| meeting.of(&cells, nodes, own, all);
            tell(rows, list, pieces_of, &mut words);
            left = (to < chunk.sets.len()).then_some((chunk, labels, to));
        }
        for (source, words) in comm.exchange(&words).iter().enumerate() {
            held.held.take(words, head, &mut held.next, source);
        }
        if left.is_none() {
            // What a chunk has freed lies in many small pieces.
            give_back_memory();
        }
    }
    let mut held = held.held;
    held.beside.iter_mut().for_each(Vec::shrink_to_fit);
    held.far.0.shrink_to_fit();
    held.far.1.shrink_to_fit();
    held.far.2.shrink_to_fit();
    held
}

/// The labels of each chunk, which go with it.
fn by_chunk(cells: &Cells, labels: Vec<u32>) -> Vec<Vec<u32>> {
    let mut rest = labels.into_iter();
    cells.chunks.iter().map(|chunk| rest.by_ref().take(chunk.sets.len()).collect()).collect()
}

/// Puts cells into the words for all ranks that need them.
fn tell<'c>(
    cells: impl Iterator<Item = (Cell<'c>, &'c u32)>,
    list: &PieceList,
    pieces_of: impl Fn(&[u32], u32, &mut Vec<u32>),
    words: &mut [Vec<u32>],
) {
    let mut pieces = Vec::new();
    for (Cell { name, nodes, set }, label) in cells {
        let own = list.of_label[*label as usize];
        pieces_of(nodes, own, &mut pieces);
        let rank_of = |piece: u32| list.firsts.partition_point(|first| *first <= piece) - 1;
        for of_rank in pieces.chunk_by(|a, b| rank_of(*a) == rank_of(*b)) {
            let rank = rank_of(of_rank[0]);
            let local = |piece: &u32| piece - list.firsts[rank];
            let is_own = rank_of(own) == rank;
            let others = of_rank.iter().filter(|piece| **piece != own);
            let words = &mut words[rank];
            let count = of_rank.len() - usize::from(is_own);
            words.extend([name, set, if is_own { local(&own) } else { NONE }, count as u32]);
            words.extend(others.map(local));
            words.extend_from_slice(nodes);
        }
    }
}

/// What a rank gets, and where the next cell of each kind from each rank stands.
struct Filling {
    held: Held,
    next: Vec<Vec<u32>>,
}

impl Held {
    /// Room for the cells that come. Collective.
    fn empty(comm: &Comm, head: &Head, cells: &Cells, labels: &[u32], list: &PieceList) -> Filling {
        let ranks = comm.size() as usize;
        let mut counts = vec![vec![0_u64; head.kinds.len()]; ranks];
        let mut labels = labels.iter();
        for chunk in &cells.chunks {
            for label in labels.by_ref().take(chunk.sets.len()) {
                let piece = list.of_label[*label as usize];
                let rank = list.firsts.partition_point(|first| *first <= piece) - 1;
                counts[rank][chunk.place] += 1;
            }
        }
        let counts = comm.exchange(&counts);
        let mut next = vec![vec![0; head.kinds.len()]; ranks];
        let mut total = 0;
        for place in 0..head.kinds.len() {
            for (source, counts) in counts.iter().enumerate() {
                next[source][place] = total;
                total += counts[place] as u32;
            }
        }
        let of_kind = |place: usize| counts.iter().map(|counts| counts[place] as usize).sum();
        let widths = head.kinds.iter().map(|range| range.kind.nodes());
        let runs = Runs::new((0..).map(of_kind).zip(widths));
        let own = list.firsts[comm.rank() as usize..][..2].to_vec();
        let total = total as usize;
        let held = Held {
            cells: vec![0; total],
            sets: vec![0; total],
            pieces: vec![0; total],
            nodes: vec![0; runs.nodes()],
            runs,
            far: (Vec::new(), vec![0], Vec::new()),
            beside: vec![Vec::new(); (own[1] - own[0]) as usize],
        };
        Filling { held, next }
    }

    /// Takes what a rank has sent.
    fn take(&mut self, words: &[u32], head: &Head, next: &mut [Vec<u32>], source: usize) {
        let mut rest = words;
        while let [name, set, piece, count, more @ ..] = rest {
            let (others, more) = more.split_at(*count as usize);
            let of = head.kinds.partition_point(|range| range.first <= *name) - 1;
            let (nodes, more) = more.split_at(head.kinds[of].kind.nodes());
            let place = if *piece == NONE {
                self.far.0.push(*name);
                self.far.2.extend_from_slice(nodes);
                self.far.1.push(self.far.2.len() as u32);
                self.cells.len() + self.far.0.len() - 1
            } else {
                let place = next[source][of] as usize;
                next[source][of] += 1;
                self.cells[place] = *name;
                self.sets[place] = *set;
                self.pieces[place] = *piece as u16;
                self.nodes[self.runs.of(place)].copy_from_slice(nodes);
                place
            };
            others.iter().for_each(|piece| self.beside[*piece as usize].push(place as u32));
            rest = more;
        }
    }

    /// Puts materials in the place of sets of groups.
    ///
    /// # Errors
    /// `Input` for cells in no material, or in several.
    pub fn choose_materials(&mut self, head: &Head, request: &Request) -> Result<()> {
        let of_sets = head.materials(request)?;
        let wrong = || Error::Input("cells are in no material, or in several".into());
        for set in &mut self.sets {
            *set = of_sets[*set as usize].ok_or_else(wrong)?;
        }
        Ok(())
    }

    /// Name and nodes of a cell by place, own ones first.
    pub fn cell(&self, place: usize) -> (u32, &[u32]) {
        let Some(far) = place.checked_sub(self.cells.len()) else {
            return (self.cells[place], &self.nodes[self.runs.of(place)]);
        };
        let range = self.far.1[far] as usize..self.far.1[far + 1] as usize;
        (self.far.0[far], &self.far.2[range])
    }
}
