//! The field files of a run: a grid over time.
//!
//! Grid and whatever does not change are written once; the file of an instant holds what does, and
//! links to the rest, so that readers find a whole grid in each. The files of a series belong
//! together: they are moved as a folder.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::finite::check_fields;
use super::publisher::Publisher;
use super::vtkhdf::{Data, Grid, StoredGrid, write_data, write_grid};
use crate::comm::Comm;
use crate::error::{Error, Result};

/// The files of one grid over time and the index that readers open.
#[derive(Debug)]
pub struct Series {
    directory: PathBuf,
    name: String,
    files: Vec<Entry>,
    /// The file with the grid, once it is written.
    mesh: Option<String>,
}

/// A grid and the data that never change.
#[derive(Debug, Clone, Copy)]
pub struct Fixed<'a> {
    /// The grid.
    pub grid: &'a Grid<'a>,
    /// The data.
    pub data: Data<'a>,
}

/// An instant of which there are fields.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(from = "(usize, f64)", into = "(usize, f64)")]
pub struct Instant {
    /// The number in the names of its files.
    pub step: usize,
    /// s
    pub time: f64,
}

impl From<(usize, f64)> for Instant {
    fn from((step, time): (usize, f64)) -> Self {
        Self { step, time }
    }
}

impl From<Instant> for (usize, f64) {
    fn from(Instant { step, time }: Instant) -> Self {
        (step, time)
    }
}

/// The file of an instant, as the index names it.
#[derive(Debug, Clone, Serialize)]
struct Entry {
    name: String,
    time: f64,
}

#[derive(Serialize)]
struct Index<'a> {
    #[serde(rename = "file-series-version")]
    version: &'static str,
    files: &'a [Entry],
}

impl Series {
    /// A series without files; `name` is `bulk` or the name of an interface.
    pub fn new(directory: PathBuf, name: &str) -> Self {
        Self { directory, name: name.to_string(), files: Vec::new(), mesh: None }
    }

    /// A series that goes on: `written` are the instants of an earlier run, of which those whose
    /// file is there stay in it. The grid is written anew, since other ranks number it otherwise.
    pub fn resume(directory: PathBuf, name: &str, written: &[Instant]) -> Self {
        let mut series = Self::new(directory, name);
        let file = |of: &Instant| Entry { name: series.file(of.step), time: of.time };
        let there = |entry: &Entry| series.directory.join(&entry.name).is_file();
        let files = written.iter().map(file).filter(there).collect();
        series.files = files;
        series
    }

    fn file(&self, step: usize) -> String {
        format!("{}_{step:06}.vtkhdf", self.name)
    }

    /// Writes one instant, then the index with it; the grid and what never changes once, before.
    ///
    /// # Arguments
    /// * `fixed` the same at every instant
    ///
    /// # Errors
    /// As [`write_grid`], and `Numerics` when a value is not finite.
    ///
    /// # Parallel
    /// Collective.
    pub fn write(
        &mut self,
        comm: &Comm,
        publisher: &mut Publisher,
        instant: Instant,
        fixed: Fixed,
        data: Data,
    ) -> Result<()> {
        let Instant { step, time } = instant;
        let Fixed { grid, data: known } = fixed;
        let path = self.directory.join(self.file(step));
        comm.agree(check_fields(&path, time, grid, known, data))?;
        let mesh = match &self.mesh {
            Some(mesh) => mesh.clone(),
            None => {
                let first = self.files.is_empty();
                // No name of a series holds a dot: this is no file of an instant of NAME_mesh.
                let number = if first { String::new() } else { format!(".{step:06}") };
                let mesh = format!("{}_mesh{number}.vtkhdf", self.name);
                write_grid(comm, publisher, &self.directory.join(&mesh), grid, known)?;
                self.mesh.insert(mesh).clone()
            }
        };
        let grid = StoredGrid { file: &mesh, grid, data: known };
        write_data(comm, publisher, &path, grid, data)?;
        self.files.push(Entry { name: self.file(step), time });
        comm.agree(if comm.is_root() { self.write_index(publisher) } else { Ok(()) })
    }

    fn write_index(&self, publisher: &mut Publisher) -> Result<()> {
        let path = self.directory.join(format!("{}.vtkhdf.series", self.name));
        let index = Index { version: "1.0", files: &self.files };
        let text = serde_json::to_string_pretty(&index)
            .map_err(|cause| Error::Bug(format!("index of {}: {cause}", self.name)))?;
        publisher.write_text(&path, text + "\n")
    }
}
