//! The cores of the machine, which the launches of all test programs share.
//!
//! Ranks that wait for each other lose a time slice at each message where others compute on their
//! core: two runs one after the other end sooner than beside each other.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};
use std::thread::{available_parallelism, sleep};
use std::time::Duration;

/// Between two looks whether a core is free; far less than a launch takes.
const LOOK: Duration = Duration::from_millis(3);

/// Cores that no other launch uses, until it is dropped: the system frees a lock whose file is
/// closed, also where a test program is ended.
pub struct Cores(#[allow(dead_code)] Vec<File>);

impl Cores {
    /// For scripts that launch runs themselves: the environment variable that names the folder with
    /// the locks, and how many there are.
    #[allow(dead_code)] // one test program calls a script
    pub fn variable() -> (&'static str, String) {
        ("COLUMN_HPC_TEST_CORES", format!("{}:{}", count(), folder().display()))
    }

    /// Waits for as many cores as there are `ranks`, or for all of them.
    ///
    /// # Panics
    /// Where the build directory is not writable.
    pub fn wait(ranks: usize) -> Self {
        let all = count();
        let wanted = ranks.min(all);
        // One at a time gathers several: two that have half of them each would wait for ever.
        let gate = (wanted > 1).then(|| open("gate"));
        if let Some(gate) = &gate {
            gate.lock().expect("a file of ours");
        }
        let mut free: Vec<File> = (0..all).map(|core| open(&core.to_string())).collect();
        let mut taken = Vec::new();
        loop {
            for core in std::mem::take(&mut free) {
                if taken.len() == wanted {
                    break;
                }
                match core.try_lock() {
                    Ok(()) => taken.push(core),
                    Err(TryLockError::WouldBlock) => free.push(core),
                    Err(TryLockError::Error(error)) => panic!("{error}"),
                }
            }
            if taken.len() == wanted {
                return Self(taken);
            }
            sleep(LOOK);
        }
    }
}

/// Ranks that may run on a core: launches wait a third of their time, for the start and the end of
/// their ranks and for each other.
const TIMES: usize = 2;

/// How many ranks may run beside each other.
fn count() -> usize {
    TIMES * available_parallelism().map_or(1, usize::from)
}

/// Where the locks are: one file for each core, by number, and `gate`.
fn folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cores");
    fs::create_dir_all(&folder).expect("the build directory is writable");
    folder
}

fn open(name: &str) -> File {
    let path = folder().join(name);
    File::options().create(true).append(true).open(path).expect("the build directory is writable")
}
