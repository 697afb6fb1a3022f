//! How a rank waits for others: it gives its core away only while it waits.
//!
//! Open MPI, asked not to spin (`mpi_yield_when_idle`, its own choice with more ranks than cores),
//! calls `sched_yield` whenever it looks for messages and finds none. MUMPS looks between two
//! fronts, also on one rank, with work to go on with: beside three programs that compute on two
//! cores a rank that yields each time takes 62 s for 4 s. A wait is what looks in quick succession.
//! One that lasts, while another rank computes alone or writes to disk, sleeps between two looks.

#![allow(unsafe_code)]

use rustix::thread::sched_yield as give_way;
use std::ffi::c_int;
use std::hint::{black_box, spin_loop};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Who computes for so long between two looks does not wait (ns).
const COMPUTES: u64 = 10_000;
/// A rank that has looked so often in succession waits: after some ten microseconds.
const LOOKS: u64 = 50;
/// A wait that has lasted so long (ns) goes on asleep.
const PATIENCE: u64 = 2_000_000;
/// For so long at a time, a small part of that.
const NAP: Duration = Duration::from_micros(50);

static START: OnceLock<Instant> = OnceLock::new();
/// The end of the last look (ns since the start), and how many came in succession.
static LAST: AtomicU64 = AtomicU64::new(0);
static LOOKED: AtomicU64 = AtomicU64::new(0);
/// The first of these looks (ns since the start).
static FIRST: AtomicU64 = AtomicU64::new(0);

/// Lets ranks wait in this way. Local.
pub fn yield_while_waiting() {
    // The linker keeps what is used.
    black_box(sched_yield as extern "C" fn() -> c_int);
}

/// Takes the place of the function of the C library in this program and its libraries.
#[unsafe(no_mangle)]
extern "C" fn sched_yield() -> c_int {
    let start = *START.get_or_init(Instant::now);
    let now = || start.elapsed().as_nanos() as u64;
    let this = now();
    let looked = in_succession(
        this.saturating_sub(LAST.load(Ordering::Relaxed)),
        LOOKED.load(Ordering::Relaxed),
    );
    LOOKED.store(looked, Ordering::Relaxed);
    if looked == 1 {
        FIRST.store(this, Ordering::Relaxed);
    }
    match between(looked, this.saturating_sub(FIRST.load(Ordering::Relaxed))) {
        Between::Spin => spin_loop(),
        Between::GiveWay => give_way(),
        Between::Sleep => sleep(NAP),
    }
    LAST.store(now(), Ordering::Relaxed);
    0
}

/// What a rank does between two looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Between {
    Spin,
    GiveWay,
    Sleep,
}

/// After so many looks in succession, the first of them so long ago (ns).
fn between(looked: u64, lasted: u64) -> Between {
    match (looked < LOOKS, lasted < PATIENCE) {
        (true, _) => Between::Spin,
        (false, true) => Between::GiveWay,
        (false, false) => Between::Sleep,
    }
}

/// The looks in succession, with one that comes so long (ns) after `looked` others.
fn in_succession(since: u64, looked: u64) -> u64 {
    if since > COMPUTES { 1 } else { looked + 1 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ffi::{c_char, c_void};

    unsafe extern "C" {
        fn dlsym(library: *mut c_void, name: *const c_char) -> *mut c_void;
    }

    /// What libraries call is the function above, and who computes in between starts anew.
    #[test]
    fn looks_in_succession_are_a_wait() {
        yield_while_waiting();
        // SAFETY: the name of a symbol among all that are loaded; the answer is compared only.
        let found = unsafe { dlsym(std::ptr::null_mut(), c"sched_yield".as_ptr()) };
        let ours: extern "C" fn() -> c_int = sched_yield;
        assert_eq!(found as usize, ours as usize);
        assert_eq!(sched_yield(), 0);
        assert_eq!(
            [0, COMPUTES, COMPUTES + 1].map(|since| in_succession(since, LOOKS)),
            [LOOKS + 1, LOOKS + 1, 1]
        );
        let kinds = [(1, PATIENCE), (LOOKS, PATIENCE - 1), (LOOKS, PATIENCE)];
        assert_eq!(
            kinds.map(|(looked, lasted)| between(looked, lasted)),
            [Between::Spin, Between::GiveWay, Between::Sleep]
        );
    }
}
