//! The faults.
//!
//! `COLUMN_HPC_FAULT=PHASE:RANK:KIND` or `PHASE:RANK:KIND:COUNT` makes one rank fail where the
//! program calls `fault::strike` or `fault::strike_values` with that phase for the `COUNT`-th time
//! (1 by default), or each time from the `COUNT`-th on (`COUNT+`). The kinds: `error`, `panic`,
//! `kill` (as by the system when memory runs out), `nan` (one of the values is none), `full` (files
//! of the rank can grow no further), `slow` and `late` (it takes 0.4 s or 4 s longer), `wait`
//! (until there is a file `go` in the working directory, a minute at most), and the signals `usr1`,
//! `usr2`, `term` and `int`, which the rank sends to itself.

use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use rustix::process::{Resource, Signal, getpid, getrlimit, kill_process, setrlimit};

use column_hpc::comm::Comm;
use column_hpc::error::{Error, Result};

/// The environment variable.
const VARIABLE: &str = "COLUMN_HPC_FAULT";
/// The file in the working directory that ends a wait, and the longest wait.
const GO: (&str, Duration) = ("go", Duration::from_secs(60));
/// How long a slow rank takes, and a very slow one.
const SLOW: Duration = Duration::from_millis(400);
/// See [`SLOW`].
const VERY_SLOW: Duration = Duration::from_secs(4);
/// Longest file that a rank without space may write (bytes).
const FULL: u64 = 64;

#[derive(Debug, PartialEq, Eq)]
struct Fault {
    phase: String,
    rank: i32,
    kind: String,
    count: u64,
    /// Also each time after the `count`-th.
    repeats: bool,
}

impl Fault {
    fn parse(text: &str) -> Option<Self> {
        let mut words = text.split(':');
        let (phase, rank, kind) = (words.next()?, words.next()?.parse().ok()?, words.next()?);
        let count = words.next().unwrap_or("1");
        let repeats = count.ends_with('+');
        let count = count.trim_end_matches('+').parse().ok()?;
        Some(Self { phase: phase.into(), rank, kind: kind.into(), count, repeats })
    }

    /// Whether the place that is passed for the `passed`-th time is the one.
    fn is_due(&self, passed: u64) -> bool {
        passed == self.count || self.repeats && passed > self.count
    }
}

/// Fails here if the environment asks for it; of the kind `nan` the last of `values` is no number
/// afterwards. Collective when it does.
///
/// # Errors
/// `System` on every rank, for the kind `error`, and where there is no value to spoil.
pub fn strike(comm: &Comm, phase: &str, values: &mut dyn Iterator<Item = &mut f64>) -> Result<()> {
    static FAULT: OnceLock<Option<Fault>> = OnceLock::new();
    static PASSED: AtomicU64 = AtomicU64::new(0);
    let asked = || std::env::var(VARIABLE).ok().as_deref().and_then(Fault::parse);
    let Some(fault) = FAULT.get_or_init(asked).as_ref().filter(|f| f.phase == phase) else {
        return Ok(());
    };
    let now = fault.is_due(PASSED.fetch_add(1, Ordering::Relaxed) + 1);
    comm.agree(if now && comm.rank() == fault.rank { fail(fault, values) } else { Ok(()) })
}

fn fail(fault: &Fault, values: &mut dyn Iterator<Item = &mut f64>) -> Result<()> {
    let phase = &fault.phase;
    match fault.kind.as_str() {
        "panic" => panic!("a test asked for a panic in phase {phase}"),
        "kill" => signal(Signal::KILL),
        "usr1" => signal(Signal::USR1),
        "usr2" => signal(Signal::USR2),
        "term" => signal(Signal::TERM),
        "int" => signal(Signal::INT),
        "full" => {
            let limit =
                rustix::process::Rlimit { current: Some(FULL), ..getrlimit(Resource::Fsize) };
            let refused = |cause| Error::System(format!("cannot limit the size of files: {cause}"));
            setrlimit(Resource::Fsize, limit).map_err(refused)
        }
        "nan" => match values.last() {
            Some(value) => {
                *value = f64::NAN;
                Ok(())
            }
            None => Err(Error::System(format!("there is no number to spoil in phase {phase}"))),
        },
        "slow" | "late" => {
            std::thread::sleep(if fault.kind == "slow" { SLOW } else { VERY_SLOW });
            Ok(())
        }
        "wait" => {
            let end = Instant::now() + GO.1;
            while Instant::now() < end && !Path::new(GO.0).exists() {
                std::thread::sleep(Duration::from_millis(10));
            }
            Ok(())
        }
        _ => Err(Error::System(format!("a test asked for an error in phase {phase}"))),
    }
}

/// Sends a signal to this process.
fn signal(signal: Signal) -> Result<()> {
    kill_process(getpid(), signal)
        .map_err(|cause| Error::System(format!("cannot signal this process: {cause}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_names_its_phase_rank_kind_and_count() {
        let fault = |count, repeats| Fault {
            phase: "output".into(),
            rank: 1,
            kind: "panic".into(),
            count,
            repeats,
        };
        assert_eq!(Fault::parse("output:1:panic"), Some(fault(1, false)));
        assert_eq!(Fault::parse("output:1:panic:3"), Some(fault(3, false)));
        assert_eq!(Fault::parse("output:1:panic:3+"), Some(fault(3, true)));
        for wrong in ["", "output", "output:x:panic", "output:1", "output:1:panic:x"] {
            assert_eq!(Fault::parse(wrong), None, "{wrong}");
        }
        let due = |fault: &Fault| [2, 3, 4].map(|passed| fault.is_due(passed));
        assert_eq!(due(&fault(3, false)), [false, true, false]);
        assert_eq!(due(&fault(3, true)), [false, true, true]);
    }
}
