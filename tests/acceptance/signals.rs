//! Signals to the launcher, which passes them on in its own way: Open MPI's gives its ranks two
//! seconds after TERM, INT and HUP.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

use crate::common::environment;
use crate::faults::{self, ranks_in};
use crate::restart::{goes_on, reference, tilting, unbroken};
use crate::scene::{Scene, fresh};

/// A run whose ranks a fault makes slow; it has not come to what is waited for by then.
const LONGEST: Duration = Duration::from_secs(100);

/// A run on two ranks, and where it writes.
struct Running<'a> {
    launcher: Child,
    directory: &'a Path,
}

impl<'a> Running<'a> {
    fn start(scene: &Scene, directory: &'a Path, fault: &str) -> Self {
        let error = fs::File::create(directory.join("stderr")).expect("a directory of ours");
        let launcher = Command::new("mpirun")
            .args(["-n", "2", "--quiet", faults::PROGRAM])
            .args(scene.words(directory))
            .arg("--overwrite")
            .envs(environment())
            .env(faults::VARIABLE, fault)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(error)
            .spawn()
            .expect("mpirun is on the PATH");
        Self { launcher, directory }
    }

    fn wait_until(&mut self, what: &str, is: impl Fn(&Path) -> bool) {
        let end = Instant::now() + LONGEST;
        while !is(self.directory) {
            let ended = self.launcher.try_wait().expect("a child of ours");
            assert!(ended.is_none() && Instant::now() < end, "{what}: {ended:?}, {}", self.told());
            sleep(Duration::from_millis(20));
        }
    }

    fn wait_for_rows(&mut self, rows: usize) {
        let lines = |path: &Path| fs::read_to_string(path).map_or(0, |text| text.lines().count());
        self.wait_until("rows", |directory| lines(&directory.join("history.csv")) > rows);
    }

    fn send(&self, signal: Signal) {
        let launcher = Pid::from_raw(self.launcher.id() as i32).expect("a child of ours");
        kill_process(launcher, signal).expect("a child of ours");
    }

    /// The status, when every rank is gone.
    fn end(&mut self) -> Option<i32> {
        let (start, status) = (Instant::now(), self.launcher.wait().expect("a child of ours"));
        while !ranks_in(self.directory, faults::PROGRAM).is_empty() {
            assert!(start.elapsed() < LONGEST, "a rank is left");
            sleep(Duration::from_millis(20));
        }
        status.code()
    }

    fn told(&self) -> String {
        fs::read_to_string(self.directory.join("stderr")).unwrap_or_default()
    }
}

impl Drop for Running<'_> {
    fn drop(&mut self) {
        let _ = self.launcher.kill();
        let _ = self.launcher.wait();
    }
}

/// Of the checkpoint.
fn accepted(directory: &Path) -> u64 {
    let file = hdf5::File::open(directory.join("checkpoint.h5")).expect("a checkpoint");
    let meta = file.dataset("checkpoint/meta").and_then(|set| set.read_raw::<u8>());
    let meta: serde_json::Value =
        serde_json::from_slice(&meta.expect("a description")).expect("whole JSON");
    meta["accepted"].as_u64().expect("a number")
}

/// Each correction takes longer than the launcher gives, and no rank can ask in the middle of it:
/// the checkpoint is there before.
#[test]
fn a_step_that_nothing_interrupts_costs_no_more_than_itself() {
    let (scene, whole) = unbroken(reference());
    for (signal, ranks) in [(Signal::TERM, 3), (Signal::INT, 1)] {
        let directory = fresh();
        let mut run = Running::start(&scene, &directory, "tangent:1:late:2+");
        run.wait_until("a checkpoint", |directory| directory.join("checkpoint.h5").is_file());
        // In the middle of the next one.
        sleep(Duration::from_millis(500));
        let (before, sent) = (accepted(&directory), Instant::now());
        run.send(signal);
        assert_eq!(run.end(), Some(1), "{signal:?}: {}", run.told());
        assert!(sent.elapsed() < Duration::from_secs(10), "{signal:?}: {:?}", sent.elapsed());
        assert!(before > 0 && accepted(&directory) >= before, "{signal:?}");
        goes_on(&scene, ranks, &directory, &whole, &format!("{signal:?} to mpirun"));
    }
}

/// Steps of more than two seconds in many short corrections end in the middle.
#[test]
fn a_long_step_ends_in_the_middle() {
    // Field files that are on their way to the disk come before a checkpoint.
    let (scene, whole) = unbroken(tilting().set("output.fields=none"));
    for (signal, status, words) in
        [(Signal::HUP, 1, ""), (Signal::USR2, 75, "stopped by the signal USR2 after ")]
    {
        let directory = fresh();
        let mut run = Running::start(&scene, &directory, "residual:0:slow:1+");
        run.wait_for_rows(1);
        sleep(Duration::from_millis(300));
        run.send(signal);
        let label = format!("{signal:?} to mpirun");
        assert_eq!(run.end(), Some(status), "{label}: {}", run.told());
        assert!(run.told().contains(words), "{label}: {}", run.told());
        assert!((1..6).contains(&accepted(&directory)), "{label}: {}", run.told());
        goes_on(&scene, 3, &directory, &whole, &label);
    }
}

/// What a shell does with ctrl-Z and `fg`, and what a batch system does with a job that it
/// suspends.
#[test]
fn a_run_that_was_suspended_goes_on() {
    let scene = reference().set("time.instants=[1, 2, 3]");
    let directory = fresh();
    let mut run = Running::start(&scene, &directory, "residual:0:slow:1+");
    run.wait_for_rows(0);
    for stop in [Signal::TSTP, Signal::STOP] {
        run.send(stop);
        sleep(Duration::from_millis(1500));
        run.send(Signal::CONT);
    }
    assert_eq!(run.end(), Some(0), "{}", run.told());
    assert_eq!(Scene::left_in(&directory, "suspended".into()).table.rows.len(), 3);
}
