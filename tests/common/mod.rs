//! Launches programs under `mpirun`, with a time limit.

mod cores;

pub use cores::Cores;

use std::io::Read;
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// Seconds after which a launch is taken to hang.
pub const TIME_LIMIT: Duration = Duration::from_secs(180);

/// Runs `program` with `args` on `ranks` ranks and returns what it wrote and its status.
///
/// It waits until other tests leave it its [`Cores`]. A launch that takes longer from then on than
/// [`TIME_LIMIT`] is ended, and the panic names it.
pub fn mpirun(ranks: usize, program: &str, args: &[&str]) -> Output {
    mpirun_within(TIME_LIMIT, ranks, program, args)
}

/// As [`mpirun`], with a time limit of its own.
pub fn mpirun_within(limit: Duration, ranks: usize, program: &str, args: &[&str]) -> Output {
    let _cores = Cores::wait(ranks);
    let mut child = Command::new("mpirun")
        .args(["-n", &ranks.to_string(), "--quiet", program])
        .args(args)
        .envs(environment())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("mpirun is on the PATH (Debian: openmpi-bin)");
    let stdout = collect(child.stdout.take());
    let stderr = collect(child.stderr.take());
    let end = Instant::now() + limit;
    let status = loop {
        if let Some(status) = child.try_wait().expect("a child of ours") {
            break Some(status);
        }
        if Instant::now() > end {
            stop(&mut child);
            break None;
        }
        thread::sleep(Duration::from_millis(10));
    };
    let stdout = stdout.join().expect("reading standard output");
    let stderr = stderr.join().expect("reading standard error");
    let Some(status) = status else {
        panic!(
            "{program} {} on {ranks} ranks was ended after {} s\n{}\n{}",
            args.join(" "),
            limit.as_secs(),
            String::from_utf8_lossy(&stdout),
            String::from_utf8_lossy(&stderr)
        )
    };
    Output { status, stdout, stderr }
}

/// What makes Open MPI work in containers, for root, with more ranks than cores, and next to other
/// jobs; each variable counts only where it applies.
pub fn environment() -> Vec<(&'static str, String)> {
    let temporary = std::env::temp_dir().to_string_lossy().into_owned();
    let fixed = [
        ("OMPI_ALLOW_RUN_AS_ROOT", "1"),
        ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"),
        ("OMPI_MCA_pml", "ob1"),
        ("OMPI_MCA_btl", "self,vader"),
        ("OMPI_MCA_hwloc_base_binding_policy", "none"),
        ("OMPI_MCA_rmaps_base_oversubscribe", "1"),
        ("OMPI_MCA_mpi_yield_when_idle", "1"),
        ("OMPI_MCA_btl_vader_single_copy_mechanism", "none"),
        ("OMP_NUM_THREADS", "1"),
        ("OPENBLAS_NUM_THREADS", "1"),
        // A fifth of the time that a launch takes is a look at the cards of the machine.
        ("HWLOC_COMPONENTS", "-pci"),
        ("RUST_BACKTRACE", "0"),
    ];
    let mut variables: Vec<_> =
        fixed.iter().map(|&(name, value)| (name, value.to_string())).collect();
    variables.push(("OMPI_MCA_btl_vader_backing_directory", temporary));
    variables
}

fn collect(pipe: Option<impl Read + Send + 'static>) -> thread::JoinHandle<Vec<u8>> {
    let mut pipe = pipe.expect("standard output and error are piped");
    thread::spawn(move || {
        let mut bytes = Vec::new();
        let _ = pipe.read_to_end(&mut bytes);
        bytes
    })
}

/// Asks mpirun to end its ranks, then insists.
pub fn stop(child: &mut Child) {
    let _ = Command::new("kill").args(["-TERM", &child.id().to_string()]).status();
    let end = Instant::now() + Duration::from_secs(5);
    while Instant::now() < end {
        if matches!(child.try_wait(), Ok(Some(_))) {
            return;
        }
        thread::sleep(Duration::from_millis(50));
    }
    let _ = child.kill();
    let _ = child.wait();
}
