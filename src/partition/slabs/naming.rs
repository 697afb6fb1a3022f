//! Names of new nodes: those that the whole mesh gives them.

use super::homes::Homes;
use super::pieces::Work;
use crate::comm::Comm;
use crate::error::Result;
use crate::mesh::slabs::{CENTRE, EDGE, FACE, Head, Key, Numbers};
use crate::partition::journey::joined;

/// How the nodes of all ranks are numbered.
pub struct Naming {
    /// The first name of new nodes in edges, in faces and in cells, and of copies.
    firsts: [u64; 4],
    /// Lowest corners of new nodes of this rank, and how many in edges and faces come before those
    /// of each.
    bases: Numbers,
    below: Vec<[u64; 2]>,
    /// The node that each copy is one of, rising.
    pub origins: Vec<u32>,
    /// For each kind of cell whether its middle is new, and how many of these come before.
    centres: Vec<Option<u64>>,
}

impl Naming {
    /// Collective.
    ///
    /// # Errors
    /// `Bug` only.
    pub fn new(
        comm: &Comm,
        homes: &Homes,
        head: &Head,
        centres: &[bool],
        work: &mut Work,
    ) -> Result<Self> {
        let own = homes.firsts[comm.rank() as usize..][..2].to_vec();
        let mut before = vec![[0_u64; 2]; (own[1] - own[0]) as usize];
        let of = |i: usize| work.counts.iter().map(move |(name, counts)| (*name, counts[i]));
        let told = [homes.send(comm, of(0)), homes.send(comm, of(1))];
        for (i, told) in told.iter().enumerate() {
            // The ranks that tell of a node tell the same.
            for (place, count) in told {
                before[*place as usize][i] = u64::from(*count);
            }
        }
        work.counts = Vec::new();
        let mut sums = [0; 2];
        for counts in &mut before {
            for i in 0..2 {
                (counts[i], sums[i]) = (sums[i], sums[i] + counts[i]);
            }
        }
        let lower = sums.map(|sum| comm.exscan_u64(sum));
        let all = sums.map(|sum| comm.sum_u64(sum));
        let (mut of_kinds, mut middles) = (Vec::new(), 0);
        for (range, is_new) in head.kinds.iter().zip(centres) {
            of_kinds.push(is_new.then_some(middles));
            middles += if *is_new { u64::from(range.count) } else { 0 };
        }
        let edges = homes.total();
        let firsts = [edges, edges + all[0], edges + all[0] + all[1]];
        let firsts = [firsts[0], firsts[1], firsts[2], firsts[2] + middles];
        let keys = work.fresh.keys.iter().copied();
        let keys = keys.chain(work.splits.iter().map(|(key, _)| *key));
        let corners = keys.filter(|key| [EDGE, FACE].contains(&key.kind())).map(Key::base);
        let bases = Numbers::of(0, homes.total(), corners);
        let value = |place: usize| [before[place][0] + lower[0], before[place][1] + lower[1]];
        let below = homes.fetch(comm, bases.iter(), value);
        let centres = of_kinds;
        let mut naming = Self { firsts, bases, below, origins: Vec::new(), centres };
        let splits: Vec<(u32, u32)> =
            work.splits.iter().map(|(key, count)| (naming.origin(head, *key), *count)).collect();
        let mut splits = joined(comm, &splits)?;
        splits.sort_unstable();
        splits.dedup();
        let of_split = |(origin, count): &(u32, u32)| vec![*origin; *count as usize];
        naming.origins = splits.iter().flat_map(of_split).collect();
        Ok(naming)
    }

    /// Drops what is needed only as long as there are nodes without names.
    pub fn forget_keys(&mut self) {
        (self.bases, self.below) = Default::default();
    }

    /// The number of nodes before cutting, which is the first name of copies.
    pub fn uncut(&self) -> u64 {
        self.firsts[3]
    }

    /// The number of all nodes.
    pub fn total(&self) -> u64 {
        self.uncut() + self.origins.len() as u64
    }

    /// The name of a node before cutting.
    fn origin(&self, head: &Head, key: Key) -> u32 {
        let place = u64::from(key.place());
        let before = |i: usize| self.below[self.bases.place(key.base()).unwrap_or_default()][i];
        let name = match key.kind() {
            EDGE => self.firsts[0] + before(0) + place,
            FACE => self.firsts[1] + before(1) + place,
            CENTRE => {
                let of = head.kinds.partition_point(|range| range.first <= key.base()) - 1;
                let before = self.centres[of].unwrap_or_default();
                self.firsts[2] + before + u64::from(key.base() - head.kinds[of].first)
            }
            _ => u64::from(key.base()),
        };
        name as u32
    }

    /// The name that a node or its copy had before cutting.
    pub fn before(&self, name: u32) -> u32 {
        let copy = u64::from(name).checked_sub(self.uncut());
        copy.map_or(name, |copy| self.origins[copy as usize])
    }

    /// The name of a node.
    pub fn name(&self, head: &Head, key: Key) -> u32 {
        let origin = self.origin(head, key);
        match key.sector() {
            0 => origin,
            sector => {
                let first = self.origins.partition_point(|other| *other < origin) as u32;
                self.uncut() as u32 + first + sector - 1
            }
        }
    }
}
