//! Where what is known of a name is kept: each rank has a range of names.

use mpi::traits::Equivalence;

use crate::comm::Comm;
use crate::error::Result;
use crate::partition::journey::everywhere;

/// Names that are told or asked for at once, so that little memory is taken.
const STEP: usize = 1 << 13;

/// Ranges of names, one for each rank.
#[derive(Debug, Clone)]
pub struct Homes {
    /// The first name of each rank, and the end.
    pub firsts: Vec<u64>,
}

impl Homes {
    /// So many names on this rank, after those of the ranks below. Collective.
    ///
    /// # Errors
    /// `Bug` only.
    pub fn new(comm: &Comm, count: u64) -> Result<Self> {
        let mut firsts = vec![0];
        for count in everywhere(comm, &count)? {
            firsts.push(firsts[firsts.len() - 1] + count);
        }
        Ok(Self { firsts })
    }

    /// All names.
    pub fn total(&self) -> u64 {
        self.firsts[self.firsts.len() - 1]
    }

    /// The rank that keeps a name, which there is, and its place there.
    pub fn of(&self, name: u32) -> (usize, u32) {
        let name = u64::from(name);
        let rank = self.firsts.partition_point(|first| *first <= name) - 1;
        (rank, (name - self.firsts[rank]) as u32)
    }

    /// What is told of names, at their homes, with the places there. Collective.
    pub fn send<T: Equivalence + Copy + Default>(
        &self,
        comm: &Comm,
        rows: impl Iterator<Item = (u32, T)>,
    ) -> Vec<(u32, T)> {
        let mut rows = rows.peekable();
        let mut told = Vec::new();
        loop {
            let mut places = vec![Vec::new(); comm.size() as usize];
            let mut values = vec![Vec::new(); comm.size() as usize];
            for (name, value) in rows.by_ref().take(STEP) {
                let (rank, place) = self.of(name);
                places[rank].push(place);
                values[rank].push(value);
            }
            let places = comm.exchange(&places).into_iter().flatten();
            told.extend(places.zip(comm.exchange(&values).into_iter().flatten()));
            if !comm.any(rows.peek().is_some()) {
                return told;
            }
        }
    }

    /// What the homes know of names that rise, in their order. Collective.
    pub fn fetch<T: Equivalence + Copy + Default, const N: usize>(
        &self,
        comm: &Comm,
        names: impl Iterator<Item = u32>,
        value: impl Fn(usize) -> [T; N],
    ) -> Vec<[T; N]> {
        let mut names = names.peekable();
        let mut found = Vec::new();
        loop {
            let mut asked = vec![Vec::new(); comm.size() as usize];
            for name in names.by_ref().take(STEP) {
                let (rank, place) = self.of(name);
                asked[rank].push(place);
            }
            let answer = |places: &Vec<u32>| {
                let mut words = Vec::with_capacity(N * places.len());
                places.iter().for_each(|place| words.extend(value(*place as usize)));
                words
            };
            let answers: Vec<Vec<T>> = comm.exchange(&asked).iter().map(answer).collect();
            let answers = comm.exchange(&answers);
            found.extend(answers.iter().flat_map(|words| words.as_chunks::<N>().0).copied());
            if !comm.any(names.peek().is_some()) {
                found.shrink_to_fit();
                return found;
            }
        }
    }
}
