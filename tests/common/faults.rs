//! Faults on demand, and a watch over runs that are to fail.

use std::fs;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process, kill_process_group};

/// The program that fails on demand.
pub const PROGRAM: &str = env!("CARGO_BIN_EXE_column-hpc-faults");

/// The environment variable that asks for a fault.
pub const VARIABLE: &str = "COLUMN_HPC_FAULT";

/// A run that has not ended by then hangs.
const HANGS: Duration = Duration::from_secs(60);
/// Every rank is gone so soon after the first sign of a failure.
const SOON: Duration = Duration::from_secs(10);

/// What a run under watch ended with.
#[derive(Debug)]
pub struct Ended {
    /// None where the launcher waited for ranks that were gone, and was ended.
    pub status: Option<i32>,
    pub stdout: String,
    pub stderr: String,
    /// From the start until the last rank was gone.
    pub took: Duration,
}

/// Processes whose command line names `folder` and that run `program`: the ranks of a run.
pub fn ranks_in(folder: &Path, program: &str) -> Vec<i32> {
    let name = folder.to_string_lossy().into_owned();
    let mut found = Vec::new();
    for entry in fs::read_dir("/proc").expect("Linux").flatten() {
        let Some(process) = entry.file_name().to_str().and_then(|n| n.parse().ok()) else {
            continue;
        };
        // Processes come and go meanwhile; one that has ended has no command line.
        let line = fs::read(entry.path().join("cmdline")).unwrap_or_default();
        let line = String::from_utf8_lossy(&line);
        if line.starts_with(program) && line.contains(&name) {
            found.push(process);
        }
    }
    found
}

/// Runs [`PROGRAM`] on `ranks` ranks with a fault, its working directory `folder`, which `args`
/// name too; while it runs `meanwhile` is called.
///
/// # Panics
/// With the scene and the state of its ranks when it hangs, or a rank is left 10 s after the first
/// sign of its failure; everything of it is ended before.
pub fn watch(
    folder: &Path,
    ranks: usize,
    fault: &str,
    args: &[&str],
    meanwhile: impl FnMut(),
) -> Ended {
    watch_within(HANGS, folder, ranks, fault, args, meanwhile)
}

/// As [`watch`], with a time of its own after which the run hangs.
///
/// # Panics
/// As [`watch`].
pub fn watch_within(
    hangs: Duration,
    folder: &Path,
    ranks: usize,
    fault: &str,
    args: &[&str],
    mut meanwhile: impl FnMut(),
) -> Ended {
    let [out, err] = ["stdout", "stderr"].map(|name| folder.join(name));
    let file = |path: &Path| Stdio::from(fs::File::create(path).expect("a folder of ours"));
    let _cores = crate::common::Cores::wait(ranks);
    let start = Instant::now();
    let mut launcher = Command::new("mpirun")
        .args(["-n", &ranks.to_string(), "--quiet", PROGRAM])
        .args(args)
        .envs(crate::common::environment())
        .env(VARIABLE, fault)
        .current_dir(folder)
        .process_group(0)
        .stdin(Stdio::null())
        .stdout(file(&out))
        .stderr(file(&err))
        .spawn()
        .expect("mpirun is on the PATH (Debian: openmpi-bin)");
    let scene = format!("{fault} on {ranks} ranks of {}", args.join(" "));
    let said = || fs::metadata(&err).is_ok_and(|file| file.len() > 0);
    let (mut most, mut failed, mut gone) = (0, None, None);
    let status = loop {
        meanwhile();
        let left = ranks_in(folder, PROGRAM);
        let ended = launcher.try_wait().expect("a child of ours");
        most = most.max(left.len());
        if failed.is_none() && (said() || left.len() < most || ended.is_some()) {
            failed = Some(Instant::now());
        }
        if left.is_empty() && most > 0 && gone.is_none() {
            gone = Some(Instant::now());
        }
        if left.is_empty() && ended.is_some() {
            break ended;
        }
        let late = failed.is_some_and(|at| at.elapsed() > SOON) && !left.is_empty();
        if late || start.elapsed() > hangs && !left.is_empty() {
            let states = states(&left);
            end_all(&mut launcher, &left);
            panic!("{scene} hangs after {:?}; its ranks:\n{states}", start.elapsed());
        }
        // Where a rank is killed while it starts, Open MPI's launcher can wait for ever for one
        // that is gone.
        if left.is_empty() && failed.or(gone).is_some_and(|at| at.elapsed() > SOON)
            || start.elapsed() > 2 * hangs
        {
            end_all(&mut launcher, &left);
            assert!(gone.is_some(), "{scene}: its ranks never started");
            break None;
        }
        sleep(Duration::from_millis(20));
    };
    let read = |path: &Path| fs::read_to_string(path).expect("text");
    Ended {
        status: status.and_then(|status: ExitStatus| status.code()),
        stdout: read(&out),
        stderr: read(&err),
        took: gone.unwrap_or_else(Instant::now).duration_since(start),
    }
}

/// What the system knows of processes: state, place in the kernel, processor time.
fn states(processes: &[i32]) -> String {
    let mut text = String::new();
    for process in processes {
        let place = Path::new("/proc").join(process.to_string());
        let read = |name: &str| fs::read_to_string(place.join(name)).unwrap_or_default();
        let status = read("status");
        let kept = ["State:", "Threads:", "SigPnd:", "VmRSS:"];
        let lines: Vec<&str> =
            status.lines().filter(|line| kept.iter().any(|key| line.starts_with(key))).collect();
        let times: Vec<String> =
            read("stat").split_whitespace().skip(13).take(2).map(str::to_owned).collect();
        text += &format!(
            "process {process}: {}; in {}; ticks {}\n",
            lines.join(", ").replace('\t', " "),
            read("wchan"),
            times.join(" + ")
        );
    }
    text
}

/// Ends a launcher, its process group and the ranks that are left.
fn end_all(launcher: &mut Child, ranks: &[i32]) {
    for rank in ranks.iter().filter_map(|rank| Pid::from_raw(*rank)) {
        // Gone in the meantime is as good.
        let _ = kill_process(rank, Signal::KILL);
    }
    if let Some(group) = Pid::from_raw(launcher.id() as i32) {
        let _ = kill_process_group(group, Signal::KILL);
    }
    let _ = launcher.wait();
}
