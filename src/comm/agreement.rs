//! Errors that all ranks share, and the end of the job where they cannot be shared.
//!
//! Ranks agree on an error between local work and the next collective call. An error in the middle
//! of a collective call of a library may be seen by one rank alone, while the others wait in the
//! library: it is put down as a doubt ([`doubt`]). A rank in doubt waits for the others for a few
//! seconds only; when they do not come, or come without a doubt of their own, the job is ended with
//! one message.

use super::Comm;
use crate::error::{Error, Result};
use mpi::collective::SystemOperation;
use mpi::request;
use mpi::topology::{Rank, SimpleCommunicator};
use mpi::traits::{Communicator, CommunicatorCollectives};
use std::cell::RefCell;
use std::io::Write;
use std::process;
use std::time::{Duration, Instant};

/// Longest error text that is sent to the other ranks, in bytes.
const LONGEST_TEXT: usize = 4096;

/// Exit status of a job that ends by a panic.
const PANIC: u8 = 101;

/// Longest wait of a rank in doubt for the others.
const PATIENCE: Duration = Duration::from_secs(5);
/// Ranks that wait in vain end the job one after the other, so that one message is left.
const STAGGER: Duration = Duration::from_millis(100);
/// Between two looks for the others.
const LOOK: Duration = Duration::from_millis(1);

thread_local! {
    /// The first error that perhaps this rank alone has seen.
    static DOUBT: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Puts down an error of a library in a call that other ranks may still be in. Local.
pub fn doubt(text: &str) {
    DOUBT.with_borrow_mut(|doubt| {
        doubt.get_or_insert_with(|| text.to_owned());
    });
}

/// Ends the whole job from one rank, with one message on standard error. Local.
///
/// For what cannot be agreed on, such as an error in the middle of a collective call of a library.
/// A status of 0 becomes 101, since the job did not succeed.
pub fn abort(status: u8, text: &str) -> ! {
    let status = if status == 0 { PANIC } else { status };
    let up = mpi::environment::is_initialized() && !mpi::environment::is_finalized();
    let rank = if up { SimpleCommunicator::world().rank() } else { 0 };
    // In one write: lines of several ranks do not mix.
    let _ = std::io::stderr().write_all(format!("[rank {rank}] {text}\n").as_bytes());
    if up {
        SimpleCommunicator::world().abort(status.into());
    }
    process::exit(status.into())
}

/// Ends the job for an error that only some ranks have seen.
fn abort_in_doubt(text: &str) -> ! {
    let status = Error::System(String::new()).exit_status();
    abort(
        status,
        &format!(
            "error: {text}\nThe other ranks did not see this error, so that the run cannot go on or be \
             wound up: all ranks are ended. Results and checkpoints of earlier instants stay valid."
        ),
    )
}

impl Comm {
    /// Makes a failure on some ranks a failure on all. Collective.
    ///
    /// To be called between local work that can fail and the next collective call. Where some ranks
    /// alone are in [`doubt`], or the others do not come to one that is, the job ends here.
    ///
    /// # Errors
    /// Kind and text of the lowest rank that failed, on every rank; on more than one rank the text
    /// names that rank, unless the user's input is at fault. Texts end after 4 KiB.
    pub fn agree<T>(&self, local: Result<T>) -> Result<T> {
        self.agree_on(local, self.size() > 1)
    }

    /// As [`Self::agree`], of work that every rank does by itself alike: none is named. Collective.
    ///
    /// # Errors
    /// Kind and text of the lowest rank that failed, on every rank.
    pub fn agree_alike<T>(&self, local: Result<T>) -> Result<T> {
        self.agree_on(local, false)
    }

    /// Collective.
    fn agree_on<T>(&self, local: Result<T>, names_rank: bool) -> Result<T> {
        let none = self.size();
        if none == 1 {
            return local.map_err(|error| decode(&self.encode(&error, names_rank)));
        }
        let of_this_rank = |is: bool| if is { self.rank() } else { none };
        let doubt = DOUBT.with_borrow(Clone::clone);
        // The lowest ranks that failed and that are in doubt, and whether all are.
        let mine =
            [of_this_rank(local.is_err()), of_this_rank(doubt.is_some()), doubt.is_some().into()];
        let [first, doubtful, all_doubt] = self.least_within(mine, doubt.as_deref());
        if doubtful < none {
            if all_doubt == 0 {
                match doubt.filter(|_| self.rank() == doubtful) {
                    Some(text) => abort_in_doubt(&text),
                    // Until the other has ended the job.
                    None => self.barrier(),
                }
            }
            DOUBT.take();
        }
        if first == none {
            return local;
        }
        let message = match (&local, self.rank() == first) {
            (Err(error), true) => self.encode(error, names_rank),
            _ => Vec::new(),
        };
        Err(decode(&self.broadcast_from(first, message)))
    }

    /// The minima over the ranks. A rank in doubt ends the job when the others do not come.
    /// Collective.
    fn least_within(&self, mine: [Rank; 3], doubt: Option<&str>) -> [Rank; 3] {
        let mut least = [0; 3];
        request::scope(|scope| {
            let minimum = SystemOperation::min();
            let mut wait =
                self.mpi().immediate_all_reduce_into(scope, &mine[..], &mut least[..], minimum);
            let Some(text) = doubt else {
                wait.wait_without_status();
                return;
            };
            let end = Instant::now() + PATIENCE + STAGGER * self.rank().min(20).unsigned_abs();
            while let Err(still) = wait.test() {
                wait = still;
                if Instant::now() > end {
                    abort_in_doubt(text);
                }
                std::thread::sleep(LOOK);
            }
        });
        least
    }

    /// The error as bytes: a letter for its kind, then the text.
    fn encode(&self, error: &Error, names_rank: bool) -> Vec<u8> {
        let (kind, text) = match error {
            Error::Input(text) => (b'i', text),
            Error::Numerics(text) => (b'n', text),
            Error::System(text) => (b's', text),
            Error::Stopped(text) => (b't', text),
            Error::Bug(text) => (b'b', text),
        };
        let mut message = vec![kind];
        // An error that was agreed on before names the rank it came from.
        if names_rank && kind != b'i' && !text.starts_with("rank ") {
            message.extend_from_slice(format!("rank {}: ", self.rank()).as_bytes());
        }
        message.extend_from_slice(text.as_bytes());
        if message.len() > LONGEST_TEXT {
            let mut end = LONGEST_TEXT;
            // Not in the middle of a character: its later bytes are 10xx xxxx.
            while message[end] & 0xc0 == 0x80 {
                end -= 1;
            }
            message.truncate(end);
            message.extend_from_slice("…".as_bytes());
        }
        message
    }
}

fn decode(message: &[u8]) -> Error {
    let text = String::from_utf8_lossy(message.get(1..).unwrap_or_default()).into_owned();
    match message.first() {
        Some(b'i') => Error::Input(text),
        Some(b'n') => Error::Numerics(text),
        Some(b's') => Error::System(text),
        Some(b't') => Error::Stopped(text),
        _ => Error::Bug(text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_keeps_its_kind_on_the_way() {
        assert_eq!(decode(b"nno convergence"), Error::Numerics("no convergence".into()));
        assert_eq!(decode(b"iunknown key"), Error::Input("unknown key".into()));
        assert_eq!(decode(b"sdisk full"), Error::System("disk full".into()));
        assert_eq!(decode(b"bnegative count"), Error::Bug("negative count".into()));
    }
}
