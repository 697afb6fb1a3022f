//! The communicator: reductions, exchanges, and errors that all ranks share.
//!
//! Every method is collective unless it says that it is local: all ranks call it, in the same
//! order. Ranks and counts of messages are `i32`, as in MPI; global numbers are `u64`.

mod agreement;
mod neighbours;
mod slabs;
mod waiting;

pub use agreement::{abort, doubt};
pub use neighbours::Neighbours;
pub use slabs::{Rows, first_of, keeper_of};
pub use waiting::yield_while_waiting;

use crate::error::Result;
use mpi::collective::SystemOperation;
use mpi::datatype::{Partition, PartitionMut};
use mpi::environment::Universe;
use mpi::raw::AsRaw;
use mpi::topology::{Rank, SimpleCommunicator};
use mpi::traits::{Communicator, CommunicatorCollectives, Equivalence, Root};
use std::rc::Rc;

/// The rank that reads, prints and gathers.
const ROOT: Rank = 0;

/// Largest piece of one broadcast: counts of MPI are 32 bits.
const LARGEST_PIECE: usize = 1 << 30;

/// A communicator of our own, apart from everybody else's messages.
///
/// Clones share the communicator. MPI is finalised when the last one is gone, so no handle can
/// outlive it.
#[derive(Clone)]
pub struct Comm {
    shared: Rc<Shared>,
}

/// Declared in drop order: the communicator is freed before MPI is finalised.
struct Shared {
    raw: SimpleCommunicator,
    universe: Rc<Universe>,
}

impl Comm {
    /// A duplicate of the world communicator. Collective.
    pub fn world(universe: Universe) -> Self {
        let raw = universe.world().duplicate();
        Comm { shared: Rc::new(Shared { raw, universe: Rc::new(universe) }) }
    }

    /// The same ranks with messages of their own. Collective.
    pub fn duplicate(&self) -> Self {
        let raw = self.mpi().duplicate();
        Comm { shared: Rc::new(Shared { raw, universe: Rc::clone(&self.shared.universe) }) }
    }

    /// This rank by itself. Local.
    pub fn alone(&self) -> Self {
        let raw = SimpleCommunicator::self_comm().duplicate();
        Comm { shared: Rc::new(Shared { raw, universe: Rc::clone(&self.shared.universe) }) }
    }

    fn mpi(&self) -> &SimpleCommunicator {
        &self.shared.raw
    }

    /// The handle of the C libraries; it lives as long as a clone of this. Local.
    pub(crate) fn raw(&self) -> mpi::ffi::MPI_Comm {
        self.mpi().as_raw()
    }

    /// This process, from 0. Local.
    pub fn rank(&self) -> Rank {
        self.mpi().rank()
    }

    /// The number of processes. Local.
    pub fn size(&self) -> Rank {
        self.mpi().size()
    }

    /// Whether this is the rank that reads and prints. Local.
    pub fn is_root(&self) -> bool {
        self.rank() == ROOT
    }

    /// Waits until every rank is here. Collective.
    pub fn barrier(&self) {
        self.mpi().barrier();
    }

    /// Runs `work` on the root; its bytes, or its error, reach every rank. Collective.
    ///
    /// # Errors
    /// That of `work`.
    pub fn on_root(&self, work: impl FnOnce() -> Result<Vec<u8>>) -> Result<Vec<u8>> {
        let local = if self.is_root() { work() } else { Ok(Vec::new()) };
        Ok(self.broadcast_bytes(self.agree(local)?))
    }

    /// The root's bytes, on every rank; what the others pass is dropped. Collective.
    pub fn broadcast_bytes(&self, bytes: Vec<u8>) -> Vec<u8> {
        self.broadcast_from(ROOT, bytes)
    }

    fn broadcast_from(&self, root: Rank, mut bytes: Vec<u8>) -> Vec<u8> {
        let mut length = bytes.len() as u64;
        let process = self.mpi().process_at_rank(root);
        process.broadcast_into(&mut length);
        bytes.resize(length as usize, 0);
        for piece in bytes.chunks_mut(LARGEST_PIECE) {
            process.broadcast_into(piece);
        }
        bytes
    }

    fn reduce(&self, values: &mut [f64], operation: SystemOperation) {
        let mine = values.to_vec();
        self.mpi().all_reduce_into(&mine[..], values, operation);
    }

    /// Replaces each value by its sum over the ranks. Collective.
    pub fn sum(&self, values: &mut [f64]) {
        self.reduce(values, SystemOperation::sum());
    }

    /// Replaces each value by its maximum over the ranks. Collective.
    ///
    /// The maximum of MPI can lose a NaN: look for NaN with [`Comm::any`].
    pub fn max(&self, values: &mut [f64]) {
        self.reduce(values, SystemOperation::max());
    }

    /// Replaces each value by its minimum over the ranks; see [`Comm::max`] on NaN. Collective.
    pub fn min(&self, values: &mut [f64]) {
        self.reduce(values, SystemOperation::min());
    }

    fn reduce_u64(&self, value: u64, operation: SystemOperation) -> u64 {
        let mut result = 0;
        self.mpi().all_reduce_into(&value, &mut result, operation);
        result
    }

    /// The sum over the ranks. Collective.
    pub fn sum_u64(&self, value: u64) -> u64 {
        self.reduce_u64(value, SystemOperation::sum())
    }

    /// The maximum over the ranks. Collective.
    pub fn max_u64(&self, value: u64) -> u64 {
        self.reduce_u64(value, SystemOperation::max())
    }

    /// The sum over the ranks below this one: 0 on the first. Collective.
    pub fn exscan_u64(&self, value: u64) -> u64 {
        let mut below = 0;
        self.mpi().exclusive_scan_into(&value, &mut below, SystemOperation::sum());
        // MPI leaves the first rank's result undefined.
        if self.rank() == 0 { 0 } else { below }
    }

    /// Whether the condition holds on at least one rank. Collective.
    pub fn any(&self, condition: bool) -> bool {
        self.max_u64(u64::from(condition)) > 0
    }

    /// Sends `send[r]` to each rank `r`; returns what each rank sent here, by rank. Collective.
    ///
    /// The counts go from every rank to every rank: for set-up, not for each iteration (see
    /// [`Neighbours`]).
    pub fn exchange<T: Equivalence + Copy + Default>(&self, send: &[Vec<T>]) -> Vec<Vec<T>> {
        assert_eq!(send.len(), self.size() as usize, "one list per rank");
        let send_counts: Vec<Rank> = send.iter().map(|part| count(part.len())).collect();
        let mut receive_counts = vec![0; send.len()];
        self.mpi().all_to_all_into(&send_counts[..], &mut receive_counts[..]);
        let flat = with_an_address(send.concat());
        let total: usize = receive_counts.iter().map(|&n| n as usize).sum();
        let mut received = with_an_address(vec![T::default(); total]);
        {
            let starts = offsets(&send_counts);
            let outgoing = Partition::new(&flat[..], &send_counts[..], &starts[..]);
            let starts = offsets(&receive_counts);
            let mut incoming =
                PartitionMut::new(&mut received[..], &receive_counts[..], &starts[..]);
            self.mpi().all_to_all_varcount_into(&outgoing, &mut incoming);
        }
        split(&received, &receive_counts)
    }

    /// The values of every rank, by rank, on the root; `None` on the others. Collective.
    pub fn gather<T: Equivalence + Copy + Default>(&self, values: &[T]) -> Option<Vec<Vec<T>>> {
        let root = self.mpi().process_at_rank(ROOT);
        let mine = count(values.len());
        let flat = with_an_address(values.to_vec());
        let values = &flat[..values.len()];
        if !self.is_root() {
            root.gather_into(&mine);
            root.gather_varcount_into(values);
            return None;
        }
        let mut counts = vec![0; self.size() as usize];
        root.gather_into_root(&mine, &mut counts[..]);
        let total: usize = counts.iter().map(|&n| n as usize).sum();
        let mut received = with_an_address(vec![T::default(); total]);
        {
            let starts = offsets(&counts);
            let mut incoming = PartitionMut::new(&mut received[..], &counts[..], &starts[..]);
            root.gather_varcount_into_root(values, &mut incoming);
        }
        Some(split(&received, &counts))
    }

    /// Rows of `width` values, each with a number of its own, in ascending order of the numbers on
    /// the root; `None` on the others. Collective.
    ///
    /// `values` has `width * numbers.len()` entries, row after row.
    pub fn to_root_rows(
        &self,
        numbers: &[u64],
        width: usize,
        values: &[f64],
    ) -> Option<(Vec<u64>, Vec<f64>)> {
        assert_eq!(values.len(), width * numbers.len(), "one row per number");
        let numbers = self.gather(numbers);
        let values = self.gather(values);
        let (numbers, values) = (numbers?.concat(), values?.concat());
        let mut order: Vec<usize> = (0..numbers.len()).collect();
        order.sort_by_key(|&row| numbers[row]);
        let sorted = order.iter().flat_map(|&row| &values[row * width..(row + 1) * width]);
        Some((order.iter().map(|&row| numbers[row]).collect(), sorted.copied().collect()))
    }
}

/// A count as MPI wants it.
fn count(n: usize) -> Rank {
    Rank::try_from(n).expect("a rank's part of a 32-bit problem has a 32-bit count")
}

/// The values in memory of their own also where there are none. An empty list of bytes has the
/// address 1, which Open MPI takes for `MPI_IN_PLACE`.
fn with_an_address<T>(mut values: Vec<T>) -> Vec<T> {
    if values.is_empty() {
        values.reserve(1);
    }
    values
}

/// Where each part begins when they lie one after the other.
fn offsets(counts: &[Rank]) -> Vec<Rank> {
    let mut next = 0usize;
    counts
        .iter()
        .map(|&n| {
            let start = count(next);
            next += n as usize;
            start
        })
        .collect()
}

fn split<T: Copy>(flat: &[T], counts: &[Rank]) -> Vec<Vec<T>> {
    let mut rest = flat;
    counts
        .iter()
        .map(|&n| {
            let (part, tail) = rest.split_at(n as usize);
            rest = tail;
            part.to_vec()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_lie_one_after_the_other() {
        assert_eq!(offsets(&[2, 0, 3]), [0, 2, 2]);
        assert_eq!(split(&[1, 2, 3, 4, 5], &[2, 0, 3]), [vec![1, 2], vec![], vec![3, 4, 5]]);
    }
}
