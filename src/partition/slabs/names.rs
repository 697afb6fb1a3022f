//! Names of nodes: their places in the file among those that cells use.

use super::homes::Homes;
use super::read::Slab;
use crate::comm::{Comm, first_of, keeper_of};
use crate::error::{Error, Result};
use crate::mesh::import::NodeRows;
use crate::mesh::slabs::Numbers;

/// Numbers of nodes with gaps that are wider than this are looked for in another way.
const SPARSE: u64 = 64;
/// Of a number without a node, and of a node that no cell uses.
const NONE: u32 = u32::MAX;

/// The nodes of cells.
pub struct Named {
    /// Who keeps which.
    pub homes: Homes,
    /// Positions of those that this rank keeps, in the unit of the file.
    pub points: Vec<[f64; 3]>,
    /// Nodes of no element, and those of elements that are no cells only.
    pub orphans: [u64; 2],
}

/// Puts names in the place of the numbers of nodes. Collective.
///
/// # Errors
/// `Input` for numbers that come twice, lack a node, or have wide gaps.
pub fn name_nodes(comm: &Comm, slab: &mut Slab, dim: usize) -> Result<Named> {
    let nodes = std::mem::take(&mut slab.nodes);
    let range = range(comm, &nodes)?;
    let asked = comm.agree(asked(slab, dim, &range))?;
    let readers = Homes::new(comm, nodes.numbers.len() as u64)?;
    let mut keeper = Keeper::new(comm, &nodes.numbers, &range, &readers)?;
    let lists = range.split(&asked.all);
    let is_of_cell = |list: &Vec<u32>| -> Vec<u8> {
        list.iter().map(|at| u8::from(asked.of_cells.place(at + range.low).is_some())).collect()
    };
    let flags: Vec<Vec<u8>> = lists.iter().map(is_of_cell).collect();
    let (lists, flags) = (comm.exchange(&lists), comm.exchange(&flags));
    let used = comm.agree(keeper.used(&lists, &flags))?;
    let (homes, points) = keeper.name(comm, &readers, nodes)?;
    let answers: Vec<Vec<u32>> = lists.iter().map(|list| keeper.answer(list)).collect();
    let names = comm.exchange(&answers).concat();
    for node in slab.elements.iter_mut().flat_map(|elements| &mut elements.nodes) {
        *node = asked.all.place(*node).map_or(NONE, |place| names[place]);
    }
    let (all, used) = (readers.total(), comm.sum_u64(used));
    let orphans = [all - used, used - homes.total()];
    Ok(Named { homes, points, orphans })
}

/// The numbers of the nodes of all ranks, and who keeps which of them.
struct Range {
    low: u32,
    count: u64,
    ranks: u64,
}

fn range(comm: &Comm, nodes: &NodeRows) -> Result<Range> {
    let count = comm.sum_u64(nodes.numbers.len() as u64);
    let low = nodes.numbers.iter().min().map_or(0, |low| u64::from(u32::MAX - low));
    let low = u32::MAX - comm.max_u64(low) as u32;
    let high = comm.max_u64(nodes.numbers.iter().max().map_or(0, |high| u64::from(*high)));
    if count == 0 || high - u64::from(low) > SPARSE * count {
        return Err(Error::Input("the numbers of the nodes have wide gaps".into()));
    }
    Ok(Range { low, count: high - u64::from(low) + 1, ranks: comm.size() as u64 })
}

impl Range {
    /// Numbers that rise, counted from the lowest one, by keeper.
    fn split(&self, numbers: &Numbers) -> Vec<Vec<u32>> {
        let mut lists = vec![Vec::new(); self.ranks as usize];
        for at in numbers.iter().map(|number| number - self.low) {
            lists[keeper_of(u64::from(at), self.count, self.ranks) as usize].push(at);
        }
        lists
    }
}

/// The numbers of nodes that the elements of a rank have.
struct Asked {
    all: Numbers,
    of_cells: Numbers,
}

fn asked(slab: &Slab, dim: usize, range: &Range) -> Result<Asked> {
    let end = u64::from(range.low) + range.count;
    let all = || slab.elements.iter().flat_map(|elements| elements.nodes.iter().copied());
    if all().any(|node| node < range.low || u64::from(node) >= end) {
        return Err(Error::Input("an element has a node that is not there".into()));
    }
    let of_cells = slab.elements.iter().filter(|elements| elements.kind.dim() == dim);
    let of_cells = of_cells.flat_map(|elements| elements.nodes.iter().copied());
    Ok(Asked {
        all: Numbers::of(range.low, end, all()),
        of_cells: Numbers::of(range.low, end, of_cells),
    })
}

/// What a rank knows of a range of numbers.
struct Keeper {
    /// The first number, counted from the lowest one.
    first: u32,
    /// The place in the file of the node of each number, later its name.
    nodes: Vec<u32>,
    is_of_cell: Vec<bool>,
}

impl Keeper {
    /// Collective.
    fn new(comm: &Comm, numbers: &[u32], range: &Range, readers: &Homes) -> Result<Self> {
        let rank = comm.rank() as u64;
        let ends = [rank, rank + 1].map(|rank| first_of(rank, range.count, range.ranks));
        let mut lists = vec![Vec::new(); range.ranks as usize];
        let first = readers.firsts[rank as usize] as u32;
        for (place, number) in (first..).zip(numbers) {
            let at = number - range.low;
            let keeper = keeper_of(u64::from(at), range.count, range.ranks) as usize;
            lists[keeper].extend([at, place]);
        }
        let size = (ends[1] - ends[0]) as usize;
        let mut keeper =
            Self { first: ends[0] as u32, nodes: vec![NONE; size], is_of_cell: vec![false; size] };
        let is_short = readers.total() < u64::from(NONE);
        let mut is_twice = false;
        for pair in comm.exchange(&lists).iter().flat_map(|list| list.chunks_exact(2)) {
            let place = &mut keeper.nodes[(pair[0] - keeper.first) as usize];
            is_twice |= *place != NONE;
            *place = pair[1];
        }
        let wrong = || Error::Input("two nodes have one number, or there are too many".into());
        comm.agree(if is_twice || !is_short { Err(wrong()) } else { Ok(keeper) })
    }

    /// Marks the nodes that cells use; how many elements use.
    fn used(&mut self, lists: &[Vec<u32>], flags: &[Vec<u8>]) -> Result<u64> {
        let mut is_used = vec![false; self.nodes.len()];
        for (at, flag) in lists.iter().flatten().zip(flags.iter().flatten()) {
            let place = (at - self.first) as usize;
            if self.nodes[place] == NONE {
                return Err(Error::Input("an element has a node that is not there".into()));
            }
            is_used[place] = true;
            self.is_of_cell[place] |= *flag == 1;
        }
        Ok(is_used.iter().filter(|is_used| **is_used).count() as u64)
    }

    /// Names the nodes that cells use; who keeps them, and their positions. Collective.
    fn name(
        &mut self,
        comm: &Comm,
        readers: &Homes,
        nodes: NodeRows,
    ) -> Result<(Homes, Vec<[f64; 3]>)> {
        let mut lists = vec![Vec::new(); comm.size() as usize];
        for place in self.of_cells() {
            let (rank, at) = readers.of(self.nodes[place]);
            lists[rank].push(at);
        }
        let used = comm.exchange(&lists);
        let all = used.iter().flatten().copied();
        let kept = Numbers::of(0, nodes.numbers.len() as u64, all);
        let homes = Homes::new(comm, kept.len() as u64)?;
        let first = homes.firsts[comm.rank() as usize] as u32;
        let name = |at: &u32| first + kept.place(*at).unwrap_or_default() as u32;
        let names: Vec<Vec<u32>> =
            used.iter().map(|list| list.iter().map(name).collect()).collect();
        let mut names: Vec<_> = comm.exchange(&names).into_iter().map(Vec::into_iter).collect();
        for place in 0..self.nodes.len() {
            let node = self.nodes[place];
            self.nodes[place] = NONE;
            if self.is_of_cell[place] {
                self.nodes[place] = names[readers.of(node).0].next().unwrap_or(NONE);
            }
        }
        let mut points = nodes.points;
        let mut at = 0;
        points.retain(|_| {
            at += 1;
            kept.place(at - 1).is_some()
        });
        points.shrink_to_fit();
        Ok((homes, points))
    }

    fn of_cells(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.nodes.len()).filter(|place| self.is_of_cell[*place])
    }

    fn answer(&self, list: &[u32]) -> Vec<u32> {
        list.iter().map(|at| self.nodes[(at - self.first) as usize]).collect()
    }
}
