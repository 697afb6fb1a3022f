//! Faults on demand, for tests of what a failure leaves behind.
//!
//! `COLUMN_HPC_FAULT=PHASE:RANK:KIND` or `PHASE:RANK:KIND:COUNT` makes one rank fail where the
//! program calls [`strike`] with that phase for the `COUNT`-th time (1 by default). The kinds:
//! `error`, `panic`, `kill` (as by the system when memory runs out), `wait` (a minute, for a signal
//! from outside), and the signals `usr1`, `usr2`, `term` and `int`, which the rank sends to itself.
//! For tests only; without the variable nothing happens.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use rustix::process::{Signal, getpid, kill_process};

use crate::comm::Comm;
use crate::error::{Error, Result};

/// The environment variable.
const VARIABLE: &str = "COLUMN_HPC_FAULT";

#[derive(Debug, PartialEq, Eq)]
struct Fault {
    phase: String,
    rank: i32,
    kind: String,
    count: u64,
}

impl Fault {
    fn parse(text: &str) -> Option<Self> {
        let mut words = text.split(':');
        let (phase, rank, kind) = (words.next()?, words.next()?.parse().ok()?, words.next()?);
        let count = words.next().map_or(Some(1), |count| count.parse().ok())?;
        Some(Self { phase: phase.into(), rank, kind: kind.into(), count })
    }
}

/// Fails here if the environment asks for it. Collective when it does.
///
/// # Errors
/// `System` on every rank, for the kind `error`.
pub fn strike(comm: &Comm, phase: &str) -> Result<()> {
    static FAULT: OnceLock<Option<Fault>> = OnceLock::new();
    static PASSED: AtomicU64 = AtomicU64::new(0);
    let asked = || std::env::var(VARIABLE).ok().as_deref().and_then(Fault::parse);
    let Some(fault) = FAULT.get_or_init(asked).as_ref().filter(|f| f.phase == phase) else {
        return Ok(());
    };
    let now = PASSED.fetch_add(1, Ordering::Relaxed) + 1 == fault.count;
    comm.agree(if now && comm.rank() == fault.rank { fail(fault) } else { Ok(()) })
}

fn fail(fault: &Fault) -> Result<()> {
    match fault.kind.as_str() {
        "panic" => panic!("a test asked for a panic in phase {}", fault.phase),
        "kill" => signal(Signal::KILL),
        "usr1" => signal(Signal::USR1),
        "usr2" => signal(Signal::USR2),
        "term" => signal(Signal::TERM),
        "int" => signal(Signal::INT),
        "wait" => {
            std::thread::sleep(Duration::from_secs(60));
            Ok(())
        }
        _ => Err(Error::System(format!("a test asked for an error in phase {}", fault.phase))),
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
        let fault = |count| Fault { phase: "output".into(), rank: 1, kind: "panic".into(), count };
        assert_eq!(Fault::parse("output:1:panic"), Some(fault(1)));
        assert_eq!(Fault::parse("output:1:panic:3"), Some(fault(3)));
        for wrong in ["", "output", "output:x:panic", "output:1", "output:1:panic:x"] {
            assert_eq!(Fault::parse(wrong), None, "{wrong}");
        }
    }
}
