//! Runs in ranks that stay: the program of `tests/faults` as `serve`.

use std::collections::BTreeMap;
use std::env;
use std::fs::{self, File};
use std::os::unix::process::ExitStatusExt;
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use crate::common::{Cores, environment, stop};

/// Ranks that wait for the next run.
struct Server {
    launcher: Child,
    folder: PathBuf,
    /// Runs so far.
    count: usize,
}

/// Those without work, by their number of ranks and whether these share out cells at random.
static IDLE: Mutex<BTreeMap<(usize, bool), Vec<Server>>> = Mutex::new(BTreeMap::new());

/// Runs `column-hpc` with these words on so many ranks, `scattered` or not, and returns what it
/// said and its status.
///
/// It waits until other tests leave it its [`Cores`].
///
/// # Panics
/// When it takes longer than `limit` from then on.
pub fn run(ranks: usize, scattered: bool, words: &[&str], limit: Duration) -> Output {
    let _cores = Cores::wait(ranks);
    let idle = || IDLE.lock().expect("no panic while it is held");
    let waiting = idle().get_mut(&(ranks, scattered)).and_then(Vec::pop);
    let mut server = waiting.unwrap_or_else(|| Server::start(ranks, scattered));
    let output = server.run(words, limit);
    if output.status.success() {
        idle().entry((ranks, scattered)).or_default().push(server);
    } else {
        // Its ranks end with the run.
        let _ = server.launcher.wait();
        let _ = fs::remove_dir_all(server.folder);
    }
    output
}

impl Server {
    fn start(ranks: usize, scattered: bool) -> Self {
        static NEXT: AtomicUsize = AtomicUsize::new(0);
        let owner = std::process::id().to_string();
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let folder = env::temp_dir().join(format!("column-hpc-served-{owner}-{number}"));
        fs::create_dir_all(&folder).expect("the place is writable");
        let screen = File::create(folder.join("launcher")).expect("the place is writable");
        let partition = if scattered { "scattered" } else { "metis" };
        let launcher = Command::new("mpirun")
            .args(["-n", &ranks.to_string(), "--quiet", env!("CARGO_BIN_EXE_column-hpc-faults")])
            .arg("serve")
            .arg(&folder)
            .arg(owner)
            .envs(environment())
            .env("COLUMN_HPC_PARTITION", partition)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(screen)
            .spawn()
            .expect("mpirun is on the PATH (Debian: openmpi-bin)");
        Self { launcher, folder, count: 0 }
    }

    fn run(&mut self, words: &[&str], limit: Duration) -> Output {
        self.count += 1;
        let of = |what: &str| self.folder.join(format!("{}.{what}", self.count));
        let words: Vec<&str> = ["column-hpc"].iter().chain(words).copied().collect();
        let job = serde_json::to_string(&words).expect("words");
        fs::write(of("written"), job).expect("the place is writable");
        fs::rename(of("written"), of("job")).expect("the place is writable");
        let read = |what: &str| fs::read(of(what)).unwrap_or_default();
        let end = Instant::now() + limit;
        let status = loop {
            if let Ok(status) = fs::read_to_string(of("status")) {
                break ExitStatus::from_raw(status.parse::<i32>().expect("a number") << 8);
            }
            if let Some(status) = self.launcher.try_wait().expect("a child of ours") {
                break status;
            }
            if Instant::now() > end {
                stop(&mut self.launcher);
                let [out, err] = ["out", "err"].map(&read);
                let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
                let (words, seconds) = (words.join(" "), limit.as_secs());
                panic!("{words} was ended after {seconds} s\n{}\n{}", text(&out), text(&err));
            }
            thread::sleep(Duration::from_millis(2));
        };
        let mut stderr = read("err");
        if !status.success() {
            stderr.extend(fs::read(self.folder.join("launcher")).unwrap_or_default());
        }
        let output = Output { status, stdout: read("out"), stderr };
        for what in ["job", "out", "err", "status"] {
            let _ = fs::remove_file(of(what));
        }
        output
    }
}
