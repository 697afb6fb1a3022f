//! How a rank waits for others: it gives its core away only while it waits.
//!
//! Open MPI, asked not to spin (`mpi_yield_when_idle`, its own choice with more ranks than cores),
//! calls `sched_yield` whenever it looks for messages and finds none. MUMPS looks between two
//! fronts, also on one rank, with work to go on with: beside three programs that compute on two
//! cores a rank that yields each time takes 62 s for 4 s. A wait is what looks in quick succession.

#![allow(unsafe_code)]

use rustix::thread::sched_yield as give_way;
use std::ffi::c_int;
use std::hint::{black_box, spin_loop};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Who computes for so long between two looks does not wait (ns).
const COMPUTES: u64 = 10_000;
/// A rank that has looked so often in succession waits: after some ten microseconds.
const LOOKS: u64 = 50;

static START: OnceLock<Instant> = OnceLock::new();
/// The end of the last look (ns since the start), and how many came in succession.
static LAST: AtomicU64 = AtomicU64::new(0);
static LOOKED: AtomicU64 = AtomicU64::new(0);

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
    let looked = in_succession(
        now().saturating_sub(LAST.load(Ordering::Relaxed)),
        LOOKED.load(Ordering::Relaxed),
    );
    LOOKED.store(looked, Ordering::Relaxed);
    if looked < LOOKS {
        spin_loop();
    } else {
        give_way();
    }
    LAST.store(now(), Ordering::Relaxed);
    0
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
    }
}
