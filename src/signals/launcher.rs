//! Open MPI's launcher, whose CONT comes before the end.

use std::fs;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use rustix::process::getppid;
use signal_hook::consts::SIGCONT;
use signal_hook::flag;

/// What it is called: on the first node, and on the others, up to version 4 and from 5 on.
const NAMES: [&str; 6] = ["mpirun", "mpiexec", "orterun", "orted", "prterun", "prted"];
/// The variable that it gives its ranks.
const VARIABLE: &str = "OMPI_COMM_WORLD_RANK";
/// Processes between it and a rank: scripts, `time`, `valgrind`.
const MOST_BETWEEN: usize = 8;

/// How often it is looked at.
const TICK: Duration = Duration::from_millis(50);
/// Who sleeps so much longer than he meant to was stopped himself, or the machine is so busy that
/// the TERM which follows has to do.
const MISSED: Duration = Duration::from_millis(400);
/// A CONT so soon after a stop continues from it.
const SOON: Duration = Duration::from_secs(3);

static WATCHED: AtomicBool = AtomicBool::new(false);

/// Whether there is such a launcher. Local.
pub fn is_watched() -> bool {
    WATCHED.load(Ordering::Relaxed)
}

/// Has a CONT of the launcher taken for a request to stop, from now on. Nothing where there is
/// none. Local, once in a process.
///
/// # Errors
/// The operating system's.
pub fn watch(stop: &Arc<AtomicUsize>) -> io::Result<()> {
    let Some(launcher) = std::env::var_os(VARIABLE).and_then(|_| find()) else { return Ok(()) };
    let (continued, stop) = (Arc::new(AtomicBool::new(false)), Arc::clone(stop));
    flag::register(SIGCONT, Arc::clone(&continued))?;
    WATCHED.store(true, Ordering::Relaxed);
    let look = move || {
        let (mut last, mut stood) = (Instant::now(), None::<Instant>);
        loop {
            std::thread::sleep(TICK);
            // Where the launcher was stopped it passes on the CONT that continued it.
            let stands = last.elapsed() > MISSED
                || Process::read(launcher).is_some_and(|process| process.state == 'T');
            last = Instant::now();
            if stands {
                stood = Some(last);
            }
            let asked = continued.swap(false, Ordering::Relaxed);
            if asked && stood.is_none_or(|stood| stood.elapsed() > SOON) {
                stop.store(SIGCONT as usize, Ordering::Relaxed);
            }
        }
    };
    std::thread::Builder::new().name("launcher".into()).spawn(look).map(drop)
}

/// The closest process above this one that is a launcher of Open MPI.
fn find() -> Option<u32> {
    let mut number = getppid()?.as_raw_pid() as u32;
    for _ in 0..MOST_BETWEEN {
        let process = Process::read(number)?;
        if NAMES.contains(&process.name.as_str()) {
            return Some(number);
        }
        number = process.parent;
    }
    None
}

/// What the system tells of a process.
#[derive(Debug, PartialEq, Eq)]
struct Process {
    name: String,
    /// `T` where it is stopped.
    state: char,
    parent: u32,
}

impl Process {
    /// None where there is no such process any more.
    fn read(number: u32) -> Option<Self> {
        Self::parse(&fs::read_to_string(format!("/proc/{number}/stat")).ok()?)
    }

    /// `NUMBER (NAME) STATE PARENT ...`, where the name may hold any character.
    fn parse(text: &str) -> Option<Self> {
        let (before, after) = text.rsplit_once(") ")?;
        let name = before.split_once('(')?.1.to_owned();
        let mut words = after.split(' ');
        let state = words.next()?.chars().next()?;
        Some(Self { name, state, parent: words.next()?.parse().ok()? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_is_read_whatever_its_name() {
        let process = |name: &str, state, parent| Process { name: name.into(), state, parent };
        assert_eq!(Process::parse("7 (mpirun) T 3 7 7"), Some(process("mpirun", 'T', 3)));
        assert_eq!(Process::parse("7 (a) R 1) S 12 7"), Some(process("a) R 1", 'S', 12)));
        assert_eq!(Process::parse("7 (a"), None);
        let own = Process::read(std::process::id()).expect("this process");
        assert_eq!(Some(own.parent), getppid().map(|parent| parent.as_raw_pid() as u32));
    }
}
