//! The exchange of the entries of a vector that other ranks' rows need.

use mpi::datatype::traits::Equivalence;

use crate::comm::{Comm, Neighbours};
use crate::error::Result;

/// Entries of a distributed vector: the owned ones, then copies of those of other ranks (ghosts),
/// by rising number. Ranks own consecutive numbers.
pub struct Halo {
    /// Owned entries.
    pub owned: usize,
    /// First number of each rank, and the count of all.
    pub offsets: Vec<u64>,
    /// Numbers of the ghosts, rising.
    pub ghosts: Vec<u64>,
    rank: usize,
    /// Owned entries that neighbours hold as ghosts, by neighbour.
    shared: Vec<u32>,
    /// How many of them each rank wants.
    wanted: Vec<usize>,
    forward: Neighbours,
    backward: Neighbours,
}

impl Halo {
    /// The plan for `owned` entries of this rank and the `ghosts` it needs, numbers that rise.
    /// Collective.
    ///
    /// # Errors
    /// `Bug` when a number is one of no rank.
    pub fn new(comm: &Comm, owned: usize, ghosts: Vec<u64>) -> Result<Self> {
        let (rank, size) = (comm.rank() as usize, comm.size() as usize);
        let mut counts = vec![0.0; size];
        counts[rank] = owned as f64;
        comm.sum(&mut counts);
        let mut offsets = vec![0u64];
        for count in counts {
            offsets.push(offsets[offsets.len() - 1] + count as u64);
        }
        let mut asked = vec![Vec::new(); size];
        for ghost in &ghosts {
            let owner = offsets.partition_point(|first| first <= ghost) - 1;
            asked[owner.min(size - 1)].push(*ghost);
        }
        let wanted = comm.exchange(&asked);
        let segments = |lists: &[Vec<u64>]| -> Vec<(i32, usize)> {
            let segments = (0..).zip(lists).map(|(rank, list)| (rank, list.len()));
            segments.filter(|(_, n)| *n > 0).collect()
        };
        let (send, receive) = (segments(&wanted), segments(&asked));
        let first = offsets[rank];
        Ok(Self {
            owned,
            rank,
            shared: wanted.iter().flatten().map(|number| (number - first) as u32).collect(),
            wanted: wanted.iter().map(Vec::len).collect(),
            forward: Neighbours::new(comm, send.clone(), receive.clone())?,
            backward: Neighbours::new(comm, receive, send)?,
            offsets,
            ghosts,
        })
    }

    /// Owned entries and ghosts. Local.
    pub fn len(&self) -> usize {
        self.owned + self.ghosts.len()
    }

    /// Whether this rank holds no entry. Local.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of the first owned entry. Local.
    pub fn first(&self) -> u64 {
        self.offsets[self.rank]
    }

    /// Entries of all ranks. Local.
    pub fn total(&self) -> u64 {
        self.offsets[self.offsets.len() - 1]
    }

    /// Number of a local entry among all. Local.
    pub fn number(&self, local: usize) -> u64 {
        match local.checked_sub(self.owned) {
            Some(ghost) => self.ghosts[ghost],
            None => self.first() + local as u64,
        }
    }

    /// Local place of a number that this rank holds. Local.
    pub fn local(&self, number: u64) -> Option<u32> {
        if let Some(own) = number.checked_sub(self.first()).filter(|own| *own < self.owned as u64) {
            return Some(own as u32);
        }
        self.ghosts.binary_search(&number).ok().map(|ghost| (self.owned + ghost) as u32)
    }

    /// The rank that owns a number. Local.
    pub fn owner(&self, number: u64) -> usize {
        self.offsets.partition_point(|first| *first <= number) - 1
    }

    /// Owned entries that each rank holds as ghosts, by rank. Local.
    pub fn shared(&self) -> impl Iterator<Item = &[u32]> {
        let mut rest = self.shared.as_slice();
        self.wanted.iter().map(move |count| {
            let (part, tail) = rest.split_at(*count);
            rest = tail;
            part
        })
    }

    /// Copies the owners' values to the ghosts; `values` holds `width` of them per local entry.
    /// Collective.
    pub fn update<T: Equivalence + Copy>(&self, values: &mut [T], width: usize) {
        if self.offsets.len() == 2 {
            return;
        }
        let (owned, ghosts) = values.split_at_mut(self.owned * width);
        let mut outgoing = Vec::with_capacity(self.shared.len() * width);
        for entry in &self.shared {
            outgoing.extend_from_slice(&owned[*entry as usize * width..][..width]);
        }
        self.forward.exchange_wide(width, &outgoing, ghosts);
    }

    /// Adds the ghosts' values to the owners'. Collective.
    pub fn add_to_owners(&self, values: &mut [f32], width: usize) {
        if self.offsets.len() == 2 {
            return;
        }
        let (owned, ghosts) = values.split_at_mut(self.owned * width);
        let mut incoming = vec![0.0; self.shared.len() * width];
        self.backward.exchange_wide(width, ghosts, &mut incoming);
        for (entry, value) in self.shared.iter().zip(incoming.chunks_exact(width)) {
            let target = &mut owned[*entry as usize * width..][..width];
            target.iter_mut().zip(value).for_each(|(t, v)| *t += v);
        }
    }
}
