//! Requests from outside: signals that ask for a checkpoint, or for one and the end.
//!
//! USR1 asks for a checkpoint. USR2, TERM and INT ask for a checkpoint and the end; a second INT
//! ends the process at once. A handler only sets a flag. Signals reach the ranks at different
//! times, so the ranks have to agree before they act on one.
//!
//! Open MPI's launcher that gets TERM, INT or HUP gives its ranks two seconds (one half in version
//! 5), and TERM only in the middle of them; what comes at once is CONT. So a CONT from it is a
//! request for the end too, unless there was something to continue.

mod launcher;

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGCONT, SIGINT, SIGTERM, SIGUSR1, SIGUSR2, SIGXFSZ};
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

/// What asks for a checkpoint and the end, by the numbers that ranks agree on.
const STOPPING: [(i32, &str); 5] = [
    (SIGUSR2, "the signal USR2"),
    (SIGTERM, "the signal TERM"),
    (SIGINT, "the signal INT"),
    (SIGCONT, "a signal to the launcher"),
    (WALL, "the wall-clock limit, limits.wall"),
];

/// Number that stands for the wall-clock limit among those of signals.
const WALL: i32 = 1000;

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
    for (signal, _) in STOPPING.into_iter().filter(|(number, _)| ![SIGCONT, WALL].contains(number))
    {
        let number = usize::try_from(signal).unwrap_or(1);
        flag::register_usize(signal, requests.stop.clone(), number).map_err(refused)?;
    }
    // A file that may not grow further (`ulimit -f`) is then an error of the write.
    flag::register(SIGXFSZ, Arc::default()).map_err(refused)?;
    launcher::watch(&requests.stop).map_err(refused)
}

/// Whether the launcher ends its ranks soon after it has asked them to stop. Local.
pub fn is_hurried() -> bool {
    launcher::is_watched()
}

/// When the wall-clock time of the run is over.
static DEADLINE: Mutex<Option<Instant>> = Mutex::new(None);

/// Sets the time at which the run that begins must have stopped; none in the place of that of a run
/// before it. Local.
pub fn stop_at(deadline: Option<Instant>) {
    *DEADLINE.lock().unwrap_or_else(PoisonError::into_inner) = deadline;
}

/// What asks for the end before another `ahead` has passed, in words; the same on all ranks.
/// Collective.
pub fn stop(comm: &Comm, ahead: Duration) -> Option<&'static str> {
    words(comm.max_u64(asked(ahead)))
}

/// The number of what asks this rank for the end; 0 if nothing does. Local.
fn asked(ahead: Duration) -> u64 {
    let deadline = *DEADLINE.lock().unwrap_or_else(PoisonError::into_inner);
    let late = deadline.is_some_and(|deadline| Instant::now() + ahead > deadline);
    let signal = REQUESTS.get().map_or(0, |r| r.stop.load(Ordering::Relaxed)) as u64;
    if late { WALL as u64 } else { signal }
}

fn words(reason: u64) -> Option<&'static str> {
    STOPPING.iter().find(|(number, _)| u64::try_from(*number) == Ok(reason)).map(|(_, name)| *name)
}

/// Whether some rank has been asked for a checkpoint since the last call. Collective.
pub fn checkpoint(comm: &Comm) -> bool {
    comm.any(REQUESTS.get().is_some_and(|r| r.checkpoint.swap(false, Ordering::Relaxed)))
}

/// Where iterations take less, the ranks ask each other so seldom only.
const OFTEN: Duration = Duration::from_millis(50);
/// Who is asked to stop while it cannot ask for longer than this comes too late to write a
/// checkpoint.
const LATE: Duration = Duration::from_millis(200);

/// Asks in the middle of a step whether to stop, and knows how long a step goes without asking.
pub struct Pulse {
    /// When it asked last.
    since: Instant,
    /// Beats since then, and after how many it asks again.
    beats: u32,
    stride: u32,
    /// The longest time without asking since the last accepted state.
    longest: Duration,
    is_slow: bool,
}

impl Default for Pulse {
    fn default() -> Self {
        Self { since: Instant::now(), beats: 0, stride: 1, longest: Duration::ZERO, is_slow: false }
    }
}

impl Pulse {
    /// At each correction: 0 before the first. Collective.
    ///
    /// # Errors
    /// `Stopped` when something asks for the end.
    pub fn correction(&mut self, comm: &Comm, number: usize) -> Result<()> {
        if number == 0 {
            (self.since, self.beats) = (Instant::now(), 0);
        }
        self.ask(comm)
    }

    /// At each iteration within a correction. Collective.
    ///
    /// # Errors
    /// As [`Pulse::correction`].
    pub fn iteration(&mut self, comm: &Comm) -> Result<()> {
        self.beats += 1;
        if self.beats < self.stride { Ok(()) } else { self.ask(comm) }
    }

    fn ask(&mut self, comm: &Comm) -> Result<()> {
        // From numbers that all ranks share, so that all ask again at the same beat.
        let mut most = [asked(Duration::ZERO) as f64, self.since.elapsed().as_secs_f64()];
        comm.max(&mut most);
        self.longest = self.longest.max(Duration::from_secs_f64(most[1]));
        if self.beats > 0 {
            let beats = OFTEN.as_secs_f64() * f64::from(self.beats) / most[1].max(1e-9);
            self.stride = (beats as u32).clamp(1, 2 * self.stride);
        }
        (self.since, self.beats) = (Instant::now(), 0);
        words(most[0] as u64).map_or(Ok(()), |reason| Err(stopped(reason)))
    }

    /// After each accepted state. Local, the same on all ranks.
    pub fn accept(&mut self) {
        self.is_slow = std::mem::take(&mut self.longest) > LATE;
    }

    /// Whether a request in the middle of the next step may come too late to write a checkpoint
    /// then: the last step went for long without asking. Local, the same on all ranks.
    pub fn is_slow(&self) -> bool {
        self.is_slow
    }
}

/// The end of a run that was asked to stop.
pub fn stopped(reason: &str) -> Error {
    Error::Stopped(format!("stopped by {reason}"))
}
