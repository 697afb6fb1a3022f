//! Requests from outside: signals that ask for a checkpoint, or for one and the end.
//!
//! USR1 asks for a checkpoint. USR2, TERM and INT ask for a checkpoint and the end; a second INT
//! ends the process at once. A handler only sets a flag. Signals reach the ranks at different
//! times, so the ranks have to agree before they act on one.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1, SIGUSR2, SIGXFSZ};
use signal_hook::flag;

use crate::comm::Comm;
use crate::error::{Error, Result};

/// What signals have asked for.
#[derive(Default)]
struct Requests {
    checkpoint: Arc<AtomicBool>,
    /// The signal that asked for the end; 0 if none did.
    stop: Arc<AtomicUsize>,
    /// Set by the first INT.
    interrupted: Arc<AtomicBool>,
}

static REQUESTS: OnceLock<Requests> = OnceLock::new();

/// Signals that ask for a checkpoint and the end.
const STOPPING: [(i32, &str); 3] =
    [(SIGUSR2, "the signal USR2"), (SIGTERM, "the signal TERM"), (SIGINT, "the signal INT")];

/// Status of a process that a second INT ends.
const INTERRUPTED: i32 = 130;

/// Listens to the signals from now on; before, they end the process. Local, once in a process.
///
/// # Errors
/// `System` when the operating system refuses.
pub fn listen() -> Result<()> {
    let requests = REQUESTS.get_or_init(Requests::default);
    let refused = |cause: std::io::Error| Error::System(format!("cannot catch signals: {cause}"));
    flag::register(SIGUSR1, requests.checkpoint.clone()).map_err(refused)?;
    flag::register_conditional_shutdown(SIGINT, INTERRUPTED, requests.interrupted.clone())
        .map_err(refused)?;
    flag::register(SIGINT, requests.interrupted.clone()).map_err(refused)?;
    for (signal, _) in STOPPING {
        let number = usize::try_from(signal).unwrap_or(1);
        flag::register_usize(signal, requests.stop.clone(), number).map_err(refused)?;
    }
    // A file that may not grow further (`ulimit -f`) is then an error of the write.
    flag::register(SIGXFSZ, Arc::default()).map_err(refused)?;
    Ok(())
}

/// When the wall-clock time of the run is over.
static DEADLINE: OnceLock<Instant> = OnceLock::new();

/// Number that stands for the wall-clock limit among those of signals.
const WALL: u64 = 1000;

/// Sets the time at which the run must have stopped. Local, once in a process.
pub fn stop_at(deadline: Instant) {
    let _ = DEADLINE.set(deadline);
}

/// What asks for the end before another `ahead` has passed, in words; the same on all ranks.
/// Collective.
pub fn stop(comm: &Comm, ahead: Duration) -> Option<&'static str> {
    let signal = REQUESTS.get().map_or(0, |r| r.stop.load(Ordering::Relaxed)) as u64;
    let late = DEADLINE.get().is_some_and(|deadline| Instant::now() + ahead > *deadline);
    let reason = comm.max_u64(if late { WALL } else { signal });
    if reason == WALL {
        return Some("the wall-clock limit, limits.wall");
    }
    STOPPING.iter().find(|(number, _)| u64::try_from(*number) == Ok(reason)).map(|(_, name)| *name)
}

/// Whether some rank has been asked for a checkpoint since the last call. Collective.
pub fn checkpoint(comm: &Comm) -> bool {
    comm.any(REQUESTS.get().is_some_and(|r| r.checkpoint.swap(false, Ordering::Relaxed)))
}
