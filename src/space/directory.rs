//! A distributed directory of the nodes: owner and number of every name.
//!
//! Each rank keeps the entries of one range of names, so that no rank holds them all.

use crate::comm::{Comm, first_of, keeper_of};
use crate::hash::mix;

/// Owner and block number of a node.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Entry {
    /// The rank that owns the node.
    pub owner: i32,
    /// The node's number among all nodes; the owner's are contiguous.
    pub number: i32,
}

/// The directory; needed while the mesh is set up, then dropped.
pub struct Directory<'a> {
    comm: &'a Comm,
    total: u64,
    first: u64,
    entries: Vec<Entry>,
    /// Names of the nodes this rank owns, rising.
    pub owned: Vec<u64>,
    /// Number of the first owned node.
    pub first_owned: i32,
}

impl<'a> Directory<'a> {
    /// Decides the owner of every node among the ranks whose cells touch it, and numbers the
    /// nodes. `touched` are the names of this rank's nodes, rising; `total` bounds all names.
    ///
    /// Collective. The owner is drawn by a hash of the name, so that no rank is favoured.
    pub fn new(comm: &'a Comm, total: u64, touched: &[u64]) -> Self {
        let ranks = comm.size() as u64;
        let first = first_of(comm.rank() as u64, total, ranks);
        let last = first_of(comm.rank() as u64 + 1, total, ranks);
        let entries = vec![Entry { owner: -1, number: -1 }; (last - first) as usize];
        let mut directory = Self { comm, total, first, entries, owned: Vec::new(), first_owned: 0 };
        directory.elect_owners(touched);
        directory.number_owned();
        directory
    }

    /// Owner and number of each name. Collective.
    pub fn look_up(&self, names: &[u64]) -> Vec<Entry> {
        let asked = self.comm.exchange(&self.split(names));
        let answers = |of: fn(&Entry) -> i32| {
            let replies: Vec<Vec<i32>> = asked
                .iter()
                .map(|list| list.iter().map(|n| of(self.entry(*n))).collect())
                .collect();
            self.join(names, &self.comm.exchange(&replies))
        };
        let (owners, numbers) = (answers(|e| e.owner), answers(|e| e.number));
        owners.into_iter().zip(numbers).map(|(owner, number)| Entry { owner, number }).collect()
    }

    fn elect_owners(&mut self, touched: &[u64]) {
        let asked = self.comm.exchange(&self.split(touched));
        let mut claims: Vec<(u64, i32)> = asked
            .iter()
            .enumerate()
            .flat_map(|(rank, list)| list.iter().map(move |n| (*n, rank as i32)))
            .collect();
        claims.sort_unstable();
        for same in claims.chunk_by(|a, b| a.0 == b.0) {
            let name = same[0].0;
            let chosen = (mix(name) % same.len() as u64) as usize;
            self.entries[(name - self.first) as usize].owner = same[chosen].1;
        }
        let replies: Vec<Vec<i32>> =
            asked.iter().map(|list| list.iter().map(|n| self.entry(*n).owner).collect()).collect();
        let owners = self.join(touched, &self.comm.exchange(&replies));
        let me = self.comm.rank();
        self.owned =
            touched.iter().zip(owners).filter(|(_, o)| *o == me).map(|(name, _)| *name).collect();
    }

    fn number_owned(&mut self) {
        self.first_owned = self.comm.exscan_u64(self.owned.len() as u64) as i32;
        let names = self.split(&self.owned);
        let mut numbers: Vec<Vec<i32>> =
            names.iter().map(|l| Vec::with_capacity(l.len())).collect();
        for (i, name) in self.owned.iter().enumerate() {
            let keeper = self.keeper(*name);
            numbers[keeper].push(self.first_owned + i as i32);
        }
        let (names, numbers) = (self.comm.exchange(&names), self.comm.exchange(&numbers));
        for (name, number) in names.iter().flatten().zip(numbers.iter().flatten()) {
            self.entries[(name - self.first) as usize].number = *number;
        }
    }

    fn entry(&self, name: u64) -> &Entry {
        &self.entries[(name - self.first) as usize]
    }

    /// The rank that keeps the entry of a name.
    fn keeper(&self, name: u64) -> usize {
        keeper_of(name, self.total, self.comm.size() as u64) as usize
    }

    /// Names by keeper, in the order of `names`.
    fn split(&self, names: &[u64]) -> Vec<Vec<u64>> {
        let mut lists = vec![Vec::new(); self.comm.size() as usize];
        for name in names {
            lists[self.keeper(*name)].push(*name);
        }
        lists
    }

    /// The answers of the keepers, put back into the order of `names`.
    fn join<T: Copy>(&self, names: &[u64], answers: &[Vec<T>]) -> Vec<T> {
        let mut next = vec![0usize; answers.len()];
        names
            .iter()
            .map(|name| {
                let keeper = self.keeper(*name);
                next[keeper] += 1;
                answers[keeper][next[keeper] - 1]
            })
            .collect()
    }
}
