//! How a rank waits for others where more processes want to run than there are cores.
//!
//! Open MPI calls `sched_yield` again and again while it waits. Where another process has the core,
//! a rank that yields stays in the queue of those that want to run, and when its message is there
//! it has to wait for its turn: one that sleeps is woken before them. Runs on crowded machines are
//! several times as fast with ranks that sleep.

#![allow(unsafe_code)]

use rustix::thread::{sched_yield as give_way, set_current_timer_slack};
use std::ffi::c_int;
use std::num::NonZeroU64;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A core that does not come back for so long has been taken by somebody else.
const TAKEN: Duration = Duration::from_millis(2);
/// For how long a machine is then held to be crowded.
const CROWDED: Duration = Duration::from_secs(1);
/// How long a rank sleeps before it looks again.
const NAP: Duration = Duration::from_micros(10);
/// By how much the kernel may prolong that (ns); by default it is 50 microseconds.
const SLACK: NonZeroU64 = NonZeroU64::new(1000).expect("not zero");

/// When waiting began to count, and until when after that the machine is crowded (ns).
static START: OnceLock<Instant> = OnceLock::new();
static CROWDED_UNTIL: AtomicU64 = AtomicU64::new(0);

/// Lets ranks wait in this way. Local.
pub fn wait_by_naps() {
    // Without it naps are longer, no more.
    let _ = set_current_timer_slack(Some(SLACK));
    // The linker keeps what is used.
    std::hint::black_box(sched_yield as extern "C" fn() -> c_int);
}

/// Takes the place of the function of the C library in this program and its libraries.
#[unsafe(no_mangle)]
extern "C" fn sched_yield() -> c_int {
    let start = *START.get_or_init(Instant::now);
    let before = start.elapsed();
    if before < Duration::from_nanos(CROWDED_UNTIL.load(Ordering::Relaxed)) {
        sleep(NAP);
        return 0;
    }
    give_way();
    let after = start.elapsed();
    if after - before > TAKEN {
        CROWDED_UNTIL.store((after + CROWDED).as_nanos() as u64, Ordering::Relaxed);
    }
    0
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ffi::{c_char, c_void};

    unsafe extern "C" {
        fn dlsym(library: *mut c_void, name: *const c_char) -> *mut c_void;
    }

    /// What libraries call is the function above, and it sleeps while the machine is crowded.
    #[test]
    fn a_rank_sleeps_while_the_machine_is_crowded() {
        wait_by_naps();
        // SAFETY: the name of a symbol among all that are loaded; the answer is compared only.
        let found = unsafe { dlsym(std::ptr::null_mut(), c"sched_yield".as_ptr()) };
        let ours: extern "C" fn() -> c_int = sched_yield;
        assert_eq!(found as usize, ours as usize);
        let now = START.get_or_init(Instant::now).elapsed();
        CROWDED_UNTIL.store((now + CROWDED).as_nanos() as u64, Ordering::Relaxed);
        let start = Instant::now();
        (0..100).for_each(|_| assert_eq!(sched_yield(), 0));
        assert!(start.elapsed() >= 100 * NAP);
    }
}
