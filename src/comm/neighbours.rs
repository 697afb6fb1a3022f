//! A sparse exchange that is planned once and run many times.

use super::Comm;
use crate::error::{Error, Result};
use mpi::datatype::traits::Equivalence;
use mpi::request::multiple_scope;
use mpi::topology::Rank;
use mpi::traits::{Communicator, Destination, Source};

/// Which ranks exchange how many values with this one.
///
/// The values lie one neighbour after the other, in ascending order of their ranks. The plan has a
/// communicator of its own, so that no other message can be taken for one of its own.
pub struct Neighbours {
    comm: Comm,
    send: Vec<(Rank, usize)>,
    receive: Vec<(Rank, usize)>,
}

impl Neighbours {
    /// A plan: `send` and `receive` name each neighbour once, with the count of values; empty
    /// segments are left out. Collective.
    ///
    /// # Errors
    /// `Bug` when a list is not in ascending order of ranks or when a rank expects another count
    /// than its neighbour sends.
    pub fn new(
        comm: &Comm,
        mut send: Vec<(Rank, usize)>,
        mut receive: Vec<(Rank, usize)>,
    ) -> Result<Self> {
        send.retain(|&(_, n)| n > 0);
        receive.retain(|&(_, n)| n > 0);
        let ordered = |list: &[(Rank, usize)]| {
            list.windows(2).all(|pair| pair[0].0 < pair[1].0)
                && list.iter().all(|&(rank, _)| (0..comm.size()).contains(&rank))
        };
        comm.agree(if ordered(&send) && ordered(&receive) {
            Ok(())
        } else {
            Err(Error::Bug(format!("neighbours out of order: {send:?} and {receive:?}")))
        })?;
        let mut announced = vec![Vec::new(); comm.size() as usize];
        for &(rank, n) in &send {
            announced[rank as usize].push(n as u64);
        }
        let announced: Vec<(Rank, usize)> = (0..)
            .zip(comm.exchange(&announced))
            .filter_map(|(rank, counts)| counts.first().map(|&n| (rank, n as usize)))
            .collect();
        comm.agree(if announced == receive {
            Ok(())
        } else {
            Err(Error::Bug(format!("expected {receive:?} (rank, values), sent {announced:?}")))
        })?;
        Ok(Neighbours { comm: comm.duplicate(), send, receive })
    }

    /// The ranks that send to this one or receive from it, rising. Local.
    pub fn ranks(&self) -> Vec<Rank> {
        let mut ranks: Vec<Rank> =
            self.send.iter().chain(&self.receive).map(|part| part.0).collect();
        ranks.sort_unstable();
        ranks.dedup();
        ranks
    }

    /// The number of values that [`Neighbours::exchange`] sends. Local.
    pub fn send_len(&self) -> usize {
        self.send.iter().map(|&(_, n)| n).sum()
    }

    /// The number of values that [`Neighbours::exchange`] receives. Local.
    pub fn receive_len(&self) -> usize {
        self.receive.iter().map(|&(_, n)| n).sum()
    }

    /// Exchanges one value per entry of the plan. Collective.
    pub fn exchange<T: Equivalence>(&self, send: &[T], receive: &mut [T]) {
        self.exchange_wide(1, send, receive);
    }

    /// As [`Neighbours::exchange`], with `width` values for each entry of the plan. Collective.
    pub fn exchange_wide<T: Equivalence>(&self, width: usize, send: &[T], receive: &mut [T]) {
        assert_eq!(send.len(), width * self.send_len(), "values to send");
        assert_eq!(receive.len(), width * self.receive_len(), "values to receive");
        let comm = self.comm.mpi();
        let messages = self.send.len() + self.receive.len();
        multiple_scope(messages, |scope, requests| {
            let mut rest = receive;
            for &(rank, n) in &self.receive {
                let (part, tail) = rest.split_at_mut(n * width);
                rest = tail;
                requests.add(comm.process_at_rank(rank).immediate_receive_into(scope, part));
            }
            let mut rest = send;
            for &(rank, n) in &self.send {
                let (part, tail) = rest.split_at(n * width);
                rest = tail;
                requests.add(comm.process_at_rank(rank).immediate_send(scope, part));
            }
            requests.wait_all(&mut Vec::with_capacity(messages));
        });
    }
}
