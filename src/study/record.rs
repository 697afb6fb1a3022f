//! What is kept of every finished launch, so that it need not be launched again.

use std::fs;
use std::path::Path;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

use super::launch::{End, message};
use super::plan::Run;
use crate::error::{Error, Result};
use crate::output::directory::{CASE, FIELDS, REPORT};
use crate::output::{atomic, checkpoint};
use crate::report::memory::entry;

/// Name of the record in the directory of a run.
const RECORD: &str = "record.json";

/// How a launch ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Ended {
    Done,
    ExpectationMissed,
    Refused,
    NotConverged,
    MachineFailed,
    Stopped,
    TimeLimit,
    Killed,
    Bug,
}

impl Ended {
    /// All of them, best first.
    pub const ALL: [Ended; 9] = [
        Ended::Done,
        Ended::ExpectationMissed,
        Ended::NotConverged,
        Ended::Stopped,
        Ended::TimeLimit,
        Ended::Refused,
        Ended::MachineFailed,
        Ended::Killed,
        Ended::Bug,
    ];

    /// In words, for charts and the screen.
    pub fn words(self) -> &'static str {
        match self {
            Ended::Done => "done",
            Ended::ExpectationMissed => "expectation missed",
            Ended::Refused => "refused",
            Ended::NotConverged => "not converged",
            Ended::MachineFailed => "machine failed",
            Ended::Stopped => "stopped",
            Ended::TimeLimit => "time limit",
            Ended::Killed => "killed",
            Ended::Bug => "bug",
        }
    }

    /// Its colour in charts: red, green, blue, of light and dark that differ in brightness too.
    pub fn color(self) -> [u8; 3] {
        match self {
            Ended::Done => [198, 232, 212],
            Ended::ExpectationMissed => [252, 232, 178],
            Ended::NotConverged => [240, 170, 140],
            Ended::TimeLimit | Ended::Stopped => [215, 200, 230],
            Ended::Refused => [214, 224, 236],
            Ended::MachineFailed | Ended::Killed | Ended::Bug => [190, 190, 190],
        }
    }

    /// As in study.csv.
    pub fn name(self) -> String {
        self.words().replace(' ', "_")
    }

    /// Whether the run came to its end, so that its numbers can be compared.
    pub fn has_results(self) -> bool {
        matches!(self, Ended::Done | Ended::ExpectationMissed)
    }
}

/// One launch that ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Launch {
    pub status: Ended,
    /// Exit status of the launcher; none where a signal ended it.
    pub exit_status: Option<i32>,
    /// Why it did not end well.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub message: String,
    pub wall_seconds: f64,
    /// The time it was given (s).
    pub limit_seconds: f64,
    /// Cores of the machine it ran on.
    pub cores: usize,
    /// From `report.json`; none where there is none.
    pub solve_seconds: Option<f64>,
    pub memory_bytes: Option<u64>,
    pub cells: Option<u64>,
    pub unknowns: Option<u64>,
    pub corrections: Option<u64>,
    pub iterations: Option<u64>,
    /// The linear solver that was taken.
    pub linear_solver: Option<String>,
}

/// The launches of one run so far.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Record {
    pub name: String,
    pub key: String,
    pub ranks: usize,
    pub overrides: Vec<String>,
    pub version: String,
    pub launches: Vec<Launch>,
}

impl Record {
    /// The record in the directory of a run, or an empty one where there is none of this run.
    pub fn load(directory: &Path, run: &Run, version: &str) -> Self {
        let text = fs::read_to_string(directory.join(RECORD)).ok();
        let found: Option<Record> = text.and_then(|text| serde_json::from_str(&text).ok());
        // Keys are short enough to be alike by chance.
        let ours = |record: &Record| {
            record.key == run.key && record.overrides == run.overrides && record.ranks == run.ranks
        };
        found.filter(ours).unwrap_or_else(|| Record {
            name: run.name.clone(),
            key: run.key.clone(),
            ranks: run.ranks,
            overrides: run.overrides.clone(),
            version: version.to_owned(),
            launches: Vec::new(),
        })
    }

    /// Writes it; complete or absent under its name.
    ///
    /// # Errors
    /// `System` with the path and the reason.
    pub fn store(&self, directory: &Path) -> Result<()> {
        let text = serde_json::to_string_pretty(self)
            .map_err(|cause| Error::Bug(format!("record: {cause}")))?;
        atomic::write_text(&directory.join(RECORD), &(text + "\n"))
    }

    /// Whether nothing is left to launch. A failure is not tried again, but a launch that ran out
    /// of time is where it is given more.
    pub fn is_finished(&self, repeats: usize, limit: Duration) -> bool {
        match self.launches.last() {
            Some(last) if last.status == Ended::TimeLimit => {
                limit.as_secs_f64() <= last.limit_seconds
            }
            Some(last) if !last.status.has_results() => true,
            _ => self.launches.len() >= repeats,
        }
    }

    /// Adds a launch; one with more time takes the place of one that ran out of it.
    pub fn push(&mut self, launch: Launch) {
        self.launches.retain(|earlier| earlier.status != Ended::TimeLimit);
        self.launches.push(launch);
    }
}

impl Launch {
    /// What there is to say of a launch that ended, from its exit status and what it wrote.
    pub fn of(end: &End, wall_seconds: f64, limit: Duration, output: &Path) -> Self {
        let text = fs::read_to_string(output.join(REPORT)).ok();
        let report: Option<Json> = text.and_then(|text| serde_json::from_str(&text).ok());
        let said = message(output);
        let told = report.as_ref().and_then(|r| r["message"].as_str()).map(str::to_owned);
        let status = status_of(end, report.is_some());
        let message = match (status, end) {
            (Ended::Done, _) => String::new(),
            (Ended::TimeLimit, _) => format!("ended after {} s", limit.as_secs_f64()),
            (_, End::Signal(signal)) => format!("ended by signal {signal}"),
            _ => told.unwrap_or_else(|| plain(&said)),
        };
        let number = |name: &str| report.as_ref().and_then(|r| r[name].as_u64());
        Launch {
            status,
            exit_status: if let End::Status(status) = end { Some(*status) } else { None },
            message,
            wall_seconds,
            limit_seconds: limit.as_secs_f64(),
            cores: cores(),
            solve_seconds: report.as_ref().and_then(|r| r["timings"]["solve"].as_f64()),
            memory_bytes: number("peak_memory_bytes"),
            cells: number("cells"),
            unknowns: number("unknowns"),
            corrections: number("newton_iterations"),
            iterations: number("linear_iterations"),
            linear_solver: report
                .as_ref()
                .and_then(|r| r["linear_solver"]["choice"].as_str())
                .map(str::to_owned),
        }
    }
}

fn status_of(end: &End, reported: bool) -> Ended {
    match end {
        End::TimeLimit => Ended::TimeLimit,
        End::Signal(_) | End::Interrupted => Ended::Killed,
        End::Status(0) => Ended::Done,
        // Launchers end with 1 too.
        End::Status(1) if reported => Ended::ExpectationMissed,
        End::Status(2) => Ended::Refused,
        End::Status(3) => Ended::NotConverged,
        End::Status(75) => Ended::Stopped,
        End::Status(101) => Ended::Bug,
        End::Status(status) if *status > 128 => Ended::Killed,
        End::Status(_) => Ended::MachineFailed,
    }
}

/// The messages of the program without the word before them; all that was said where there are
/// none.
fn plain(said: &str) -> String {
    let own: Vec<&str> = said.lines().filter_map(|line| line.strip_prefix("error: ")).collect();
    if own.is_empty() { said.trim().to_owned() } else { own.join("\n") }
}

/// Cores of this machine.
pub(super) fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Memory of this machine in bytes.
pub(super) fn machine_memory() -> Option<u64> {
    entry("/proc/meminfo", "MemTotal:")
}

/// Removes what a run needs only while it goes on.
pub(super) fn tidy(directory: &Path) {
    // What cannot be removed does no harm.
    let _ = fs::remove_dir_all(directory.join(FIELDS));
    for name in [checkpoint::NEWEST, checkpoint::PREVIOUS, CASE] {
        let _ = fs::remove_file(directory.join(name));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exit_status_says_how_a_run_ended() {
        for (end, reported, status) in [
            (End::Status(0), true, Ended::Done),
            (End::Status(1), true, Ended::ExpectationMissed),
            (End::Status(1), false, Ended::MachineFailed),
            (End::Status(2), false, Ended::Refused),
            (End::Status(3), true, Ended::NotConverged),
            (End::Status(4), false, Ended::MachineFailed),
            (End::Status(75), true, Ended::Stopped),
            (End::Status(101), false, Ended::Bug),
            (End::Status(137), false, Ended::Killed),
            (End::Signal(9), false, Ended::Killed),
            (End::TimeLimit, true, Ended::TimeLimit),
        ] {
            assert_eq!(status_of(&end, reported), status, "{end:?}");
        }
    }

    #[test]
    fn what_ran_out_of_time_is_tried_again_only_with_more() {
        let launch = |status, limit| Launch {
            status,
            exit_status: None,
            message: String::new(),
            wall_seconds: 1.0,
            limit_seconds: limit,
            cores: 1,
            solve_seconds: None,
            memory_bytes: None,
            cells: None,
            unknowns: None,
            corrections: None,
            iterations: None,
            linear_solver: None,
        };
        let mut record = Record {
            name: String::new(),
            key: String::new(),
            ranks: 1,
            overrides: Vec::new(),
            version: String::new(),
            launches: Vec::new(),
        };
        let limit = Duration::from_secs(10);
        assert!(!record.is_finished(1, limit));
        record.push(launch(Ended::TimeLimit, 10.0));
        assert!(record.is_finished(3, limit) && !record.is_finished(3, 2 * limit));
        record.push(launch(Ended::Done, 20.0));
        assert_eq!(record.launches.len(), 1);
        assert!(record.is_finished(1, limit) && !record.is_finished(2, limit));
        record.push(launch(Ended::NotConverged, 20.0));
        assert!(record.is_finished(5, limit));
    }

    #[test]
    fn messages_lose_the_word_in_front() {
        assert_eq!(
            plain("noise\nerror: no step\nerror: results are valid\n"),
            "no step\nresults are valid"
        );
        assert_eq!(plain(" There are not enough slots\n"), "There are not enough slots");
    }
}
