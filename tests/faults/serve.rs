//! Runs one case after the other in the same ranks. To start MPI and its libraries takes a small
//! case ten times as long as to be solved.

use std::fs::{self, File};
use std::path::Path;
use std::time::Duration;

use column_hpc::runtime::Runtime;
use column_hpc::timers::Timers;
use column_hpc::{cli, run};
use rustix::stdio::{dup2_stderr, dup2_stdout};

/// Ranks that wait for work look for it after these times at least and at most.
const LOOK: [Duration; 2] = [Duration::from_millis(1), Duration::from_millis(20)];

/// Carries out the command lines that appear in `folder` as `1.job`, `2.job`, ...: lists of words
/// in JSON. What is said goes to `1.out` and `1.err`, the exit status to `1.status`. It ends with
/// the first run that does not end well, or with the process `owner`, and takes the folder away
/// then. Collective.
pub fn serve(folder: &Path, owner: &str) -> u8 {
    let runtime = Runtime::start(&[]).expect("MPI and PETSc");
    for number in 1_usize.. {
        let of = |what: &str| folder.join(format!("{number}.{what}"));
        if !wait_for(&of("job"), owner) {
            // The ranks go one by one; what is gone is gone.
            let _ = fs::remove_dir_all(folder);
            break;
        }
        if runtime.comm.is_root() {
            let create = |what: &str| File::create(of(what)).expect("the folder is writable");
            dup2_stdout(create("out")).expect("an open file");
            dup2_stderr(create("err")).expect("an open file");
        }
        let status = carry_out(&runtime, &of("job"));
        if runtime.comm.is_root() {
            fs::write(of("written"), status.to_string()).expect("the folder is writable");
            fs::rename(of("written"), of("status")).expect("the folder is writable");
        }
        if status != 0 {
            runtime.exit(status);
        }
    }
    runtime.exit(0)
}

/// False when the owner is gone.
fn wait_for(job: &Path, owner: &str) -> bool {
    let owner = Path::new("/proc").join(owner);
    let mut look = LOOK[0];
    while !job.exists() {
        if !owner.exists() {
            return false;
        }
        std::thread::sleep(look);
        look = LOOK[1].min(look.mul_f64(1.2));
    }
    true
}

/// The exit status of a run. Collective.
fn carry_out(runtime: &Runtime, job: &Path) -> u8 {
    let words = fs::read_to_string(job).expect("a file of the owner");
    let words = serde_json::from_str(&words).expect("a list of words");
    let Ok(cli::Command::Run(options)) = cli::parse(words) else {
        panic!("{} is no run", job.display())
    };
    match run::run_case(runtime, &Timers::new(), &options) {
        Ok(true) => 0,
        Ok(false) => 1,
        Err(error) => {
            if runtime.comm.is_root() {
                run::complain(&error);
            }
            error.exit_status()
        }
    }
}
