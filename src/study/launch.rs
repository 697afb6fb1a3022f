//! One launch of the program: its process, its time, how it ended.

use std::fs::{self, File};
use std::io::{Read, Seek, SeekFrom};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, getuid, kill_process_group};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR2};
use signal_hook::flag;

use crate::error::{Error, Result};

/// Time between looks at a process: far below what is measured.
const LOOK: Duration = Duration::from_millis(5);
/// Time a launcher has to end its ranks once it was asked to.
const PATIENCE: Duration = Duration::from_secs(10);
/// Most bytes of a message that are kept.
const KEPT: u64 = 4096;
/// What a run says beside its results.
pub(super) const MESSAGES: &str = "messages.txt";

/// How a launch ended.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum End {
    /// By itself, with this exit status.
    Status(i32),
    /// By a signal that was not ours.
    Signal(i32),
    /// Past its time limit.
    TimeLimit,
    /// Because the study was asked to stop.
    Interrupted,
}

/// What is launched.
pub(super) struct Scene<'a> {
    /// Words of the launcher, `{ranks}` in them.
    pub launcher: &'a [String],
    pub ranks: usize,
    pub case: &'a Path,
    pub overrides: &'a [String],
    /// The directory of its results, which exists.
    pub output: &'a Path,
    pub limit: Duration,
}

/// Whether the study was asked to stop, by INT, TERM, HUP or USR2.
#[derive(Clone, Default)]
pub(super) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens from now on.
    ///
    /// # Errors
    /// `System` when the operating system refuses.
    pub fn listen() -> Result<Self> {
        let asked = Self::default();
        for signal in [SIGINT, SIGTERM, SIGHUP, SIGUSR2] {
            flag::register(signal, asked.0.clone())
                .map_err(|cause| Error::System(format!("cannot catch signals: {cause}")))?;
        }
        Ok(asked)
    }

    /// Whether it was asked.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Launches the program and waits for its end; how it ended, and its wall-clock time in s.
///
/// # Errors
/// `System` when the launcher cannot be started.
pub(super) fn launch(scene: &Scene<'_>, interrupt: &Interrupt) -> Result<(End, f64)> {
    let program = program()?;
    let words: Vec<String> = scene
        .launcher
        .iter()
        .map(|word| word.replace("{ranks}", &scene.ranks.to_string()))
        .collect();
    let messages = scene.output.join(MESSAGES);
    let file =
        File::create(&messages).map_err(|cause| Error::file("cannot write", &messages, cause))?;
    let mut command = Command::new(&words[0]);
    command.args(&words[1..]).arg(program).arg("run").arg(scene.case);
    for assignment in scene.overrides {
        command.args(["--set", assignment]);
    }
    command.arg("--output").arg(scene.output).args(["--overwrite", "--quiet"]);
    // In a group of its own, which can be ended as a whole, and which the terminal does not
    // interrupt.
    command.envs(environment()).process_group(0);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(file);
    let start = Instant::now();
    let mut child = command
        .spawn()
        .map_err(|cause| Error::System(format!("cannot start {}: {cause}", words[0])))?;
    loop {
        let ended = child.try_wait();
        let took = start.elapsed();
        match ended {
            Ok(Some(status)) => return Ok((end_of(status), took.as_secs_f64())),
            Ok(None) => {}
            Err(cause) => {
                end_group(&mut child);
                return Err(Error::System(format!("cannot wait for {}: {cause}", words[0])));
            }
        }
        if interrupt.is_set() || took > scene.limit {
            end_group(&mut child);
            let end = if took > scene.limit { End::TimeLimit } else { End::Interrupted };
            return Ok((end, took.as_secs_f64()));
        }
        sleep(LOOK);
    }
}

fn end_of(status: ExitStatus) -> End {
    match (status.code(), status.signal()) {
        (Some(code), _) => End::Status(code),
        (None, signal) => End::Signal(signal.unwrap_or(0)),
    }
}

/// Asks the launcher to end its ranks, then ends the group. Ranks that have left the group end with
/// their launcher.
fn end_group(child: &mut Child) {
    let Some(group) = i32::try_from(child.id()).ok().and_then(Pid::from_raw) else { return };
    // Gone in the meantime is as good.
    let _ = kill_process_group(group, Signal::TERM);
    let asked = Instant::now();
    while asked.elapsed() < PATIENCE && matches!(child.try_wait(), Ok(None)) {
        sleep(LOOK);
    }
    let _ = kill_process_group(group, Signal::KILL);
    let _ = child.wait();
}

/// This program.
fn program() -> Result<PathBuf> {
    std::env::current_exe()
        .map_err(|cause| Error::System(format!("cannot find the program itself: {cause}")))
}

/// What the run said on standard error, its last part.
pub(super) fn message(output: &Path) -> String {
    let read = || -> std::io::Result<String> {
        let mut file = File::open(output.join(MESSAGES))?;
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(KEPT)))?;
        let mut bytes = Vec::new();
        file.take(KEPT).read_to_end(&mut bytes)?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    };
    read().unwrap_or_default()
}

/// What makes Open MPI work for root and on one node, as `scripts/mpi_env.sh` has it; what the user
/// has set stays.
fn environment() -> Vec<(&'static str, &'static str)> {
    let mut wanted = vec![("OMP_NUM_THREADS", "1"), ("OPENBLAS_NUM_THREADS", "1")];
    if getuid().is_root() {
        wanted.extend([("OMPI_ALLOW_RUN_AS_ROOT", "1"), ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")]);
    }
    if nodes() == 1 {
        wanted.extend([
            ("OMPI_MCA_pml", "ob1"),
            ("OMPI_MCA_btl", "self,vader"),
            ("OMPI_MCA_btl_vader_single_copy_mechanism", "none"),
            ("OMPI_MCA_hwloc_base_binding_policy", "none"),
            ("OMPI_MCA_rmaps_base_oversubscribe", "1"),
            ("OMPI_MCA_mpi_yield_when_idle", "1"),
        ]);
    }
    wanted.retain(|(name, _)| std::env::var_os(name).is_none_or(|value| value.is_empty()));
    wanted
}

/// Nodes of the job that this process is in; 1 outside of one.
fn nodes() -> usize {
    let listed = std::env::var_os("PBS_NODEFILE").and_then(|file| fs::read_to_string(file).ok());
    if let Some(list) = listed {
        return list.lines().collect::<std::collections::BTreeSet<_>>().len();
    }
    std::env::var("SLURM_JOB_NUM_NODES").ok().and_then(|n| n.parse().ok()).unwrap_or(1)
}
