//! An output directory, as one who reads it sees it.

use std::fs;
use std::path::{Component, Path, PathBuf};

use serde::Deserialize;
use serde_json::Value;

use super::{History, Snapshot};
use crate::case::{BULK, Case};
use crate::error::{Error, Result};
use crate::output::directory::{CASE, FIELDS, HISTORY, REPORT};
use crate::output::history::Table;

/// How the index of a series of field files ends.
const INDEX: &str = ".vtkhdf.series";

/// The results of a run, on disk. Everything here is local: one rank reads, or a program without
/// MPI.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Directory {
    path: PathBuf,
}

impl Directory {
    /// A directory that a run has written into, also one that has not come to its end.
    ///
    /// # Errors
    /// [`Error::Input`] when there are no results in it.
    pub fn open(path: impl Into<PathBuf>) -> Result<Self> {
        let path = path.into();
        if path.join(HISTORY).is_file() {
            return Ok(Self { path });
        }
        let what = if path.is_dir() { "holds no results" } else { "is no directory" };
        Err(Error::Input(format!("{} {what}: there is no {HISTORY} in it", path.display())))
    }

    /// The directory itself.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The rows of `history.csv`.
    ///
    /// # Errors
    /// [`Error::System`] when it cannot be read.
    pub fn history(&self) -> Result<History> {
        Table::read(&self.path.join(HISTORY)).map(History::from)
    }

    /// The content of `report.json`.
    ///
    /// # Errors
    /// [`Error::System`] when it cannot be read: a run writes it at its end.
    pub fn report(&self) -> Result<Value> {
        read_json(&self.path.join(REPORT))
    }

    /// The case that was run, with all defaults.
    ///
    /// # Errors
    /// [`Error::System`] when it cannot be read, [`Error::Input`] when it is no case for this
    /// version of the program.
    pub fn case(&self) -> Result<Case> {
        Case::build(read_json(&self.path.join(CASE))?)
    }

    /// The names of the series of field files: `bulk` first, then the interfaces, in the order of
    /// their names. None where no fields were written.
    ///
    /// # Errors
    /// [`Error::System`] when the directory cannot be read.
    pub fn fields(&self) -> Result<Vec<String>> {
        let folder = self.path.join(FIELDS);
        if !folder.is_dir() {
            return Ok(Vec::new());
        }
        let failed = |cause| Error::file("cannot read", &folder, cause);
        let mut names = Vec::new();
        for entry in fs::read_dir(&folder).map_err(failed)? {
            let name = entry.map_err(failed)?.file_name();
            names.extend(name.to_str().and_then(|n| n.strip_suffix(INDEX)).map(str::to_owned));
        }
        names.sort_by_key(|name| (name != BULK, name.clone()));
        Ok(names)
    }

    /// The fields of the bulk or of an interface, by its name.
    ///
    /// # Errors
    /// [`Error::Input`] when there is no such series, [`Error::System`] when its index cannot be
    /// read.
    pub fn series(&self, name: &str) -> Result<Series> {
        let known = self.fields()?;
        if !known.iter().any(|other| other == name) {
            let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            let place = self.path.display();
            return Err(Error::Input(format!(
                "{place} has no fields of `{name}` (it has: {known})"
            )));
        }
        let folder = self.path.join(FIELDS);
        let path = folder.join(format!("{name}{INDEX}"));
        let Index { files } = read_json(&path)?;
        for file in &files {
            // A file of another folder would not be of this run.
            let mut parts = Path::new(&file.name).components();
            if !matches!((parts.next(), parts.next()), (Some(Component::Normal(_)), None)) {
                return Err(Error::file("cannot read", &path, format!("`{}` in it", file.name)));
            }
        }
        let instants = files.into_iter().map(|file| (file.time, folder.join(file.name)));
        Ok(Series { name: name.to_owned(), instants: instants.collect() })
    }
}

/// The fields of the bulk or of an interface over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    name: String,
    instants: Vec<(f64, PathBuf)>,
}

impl Series {
    /// `bulk`, or the name of the interface.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The instants whose fields were written (s), rising.
    pub fn times(&self) -> Vec<f64> {
        self.instants.iter().map(|(time, _)| *time).collect()
    }

    /// The fields of an instant.
    ///
    /// # Errors
    /// [`Error::Input`] when none were written then; [`Error::System`] when the file cannot be
    /// read.
    pub fn at(&self, time: f64) -> Result<Snapshot> {
        let found = self.instants.iter().find(|(other, _)| *other == time);
        let (_, path) = found.ok_or_else(|| {
            let (name, times) = (&self.name, self.times());
            Error::Input(format!(
                "there are no fields of `{name}` at time {time}, only at {times:?}"
            ))
        })?;
        Snapshot::open(path)
    }
}

#[derive(Deserialize)]
struct Index {
    files: Vec<Instant>,
}

#[derive(Deserialize)]
struct Instant {
    name: String,
    time: f64,
}

fn read_json<T: serde::de::DeserializeOwned>(path: &Path) -> Result<T> {
    let text = fs::read_to_string(path).map_err(|cause| Error::file("cannot read", path, cause))?;
    serde_json::from_str(&text).map_err(|cause| Error::file("cannot read", path, cause))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_directory_of_results_is_refused() {
        let place = std::env::temp_dir().join(format!("column-hpc-open-{}", std::process::id()));
        let told = |path: &Path| Directory::open(path).expect_err("a refusal").to_string();
        assert!(told(&place).contains("is no directory"));
        fs::create_dir_all(&place).expect("a temporary directory");
        assert!(told(&place).contains("holds no results"));
        fs::write(place.join(HISTORY), "time\n1\n").expect("a file of ours");
        let directory = Directory::open(&place).expect("results");
        assert_eq!(directory.history().expect("a table").times(), [1.0]);
        assert_eq!(directory.fields(), Ok(Vec::new()));
        assert_eq!(directory.report().expect_err("none yet").exit_status(), 4);
        let fields = place.join(FIELDS);
        fs::create_dir_all(&fields).expect("a directory of ours");
        let index = |name: &str| format!(r#"{{"files": [{{"name": "{name}", "time": 1}}]}}"#);
        for (name, file) in [("joint", "joint_000001.vtkhdf"), ("bulk", "../other.vtkhdf")] {
            fs::write(fields.join(format!("{name}{INDEX}")), index(file)).expect("a file of ours");
        }
        assert_eq!(directory.fields().expect("two"), ["bulk", "joint"]);
        let joint = directory.series("joint").expect("a series");
        assert_eq!((joint.name(), joint.times()), ("joint", vec![1.0]));
        assert_eq!(joint.at(2.0).expect_err("not written").exit_status(), 2);
        assert_eq!(joint.at(1.0).expect_err("no file").exit_status(), 4);
        assert_eq!(directory.series("bulk").expect_err("elsewhere").exit_status(), 4);
        assert!(directory.series("other").expect_err("none").to_string().contains("bulk, joint"));
        fs::remove_dir_all(place).expect("a directory of ours");
    }
}
