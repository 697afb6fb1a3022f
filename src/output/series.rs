//! The field files of a run: a grid over time.
//!
//! Grid and whatever does not change are written once; the file of an instant holds what does, and
//! links to the rest, so that readers find a whole grid in each. The files of a series belong
//! together: they are moved as a folder.

use std::path::PathBuf;

use serde::Serialize;

use super::finite::check_fields;
use super::publisher::Publisher;
use super::vtkhdf::{Data, Grid, write_data, write_grid};
use crate::comm::Comm;
use crate::error::{Error, Result};

/// The files of one grid over time and the index that readers open.
#[derive(Debug)]
pub struct Series {
    directory: PathBuf,
    name: String,
    files: Vec<Instant>,
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

#[derive(Debug, Clone, Serialize)]
struct Instant {
    name: String,
    time: f64,
}

#[derive(Serialize)]
struct Index<'a> {
    #[serde(rename = "file-series-version")]
    version: &'static str,
    files: &'a [Instant],
}

impl Series {
    /// A series without files; `name` is `bulk` or the name of an interface.
    pub fn new(directory: PathBuf, name: &str) -> Self {
        Self { directory, name: name.to_string(), files: Vec::new(), mesh: None }
    }

    /// A series that goes on: `written` are the steps and times of an earlier run, of which those
    /// whose file is there stay in it. The grid is written anew, since other ranks number it
    /// otherwise.
    pub fn resume(directory: PathBuf, name: &str, written: &[(usize, f64)]) -> Self {
        let mut series = Self::new(directory, name);
        let file = |(step, time): &(usize, f64)| Instant { name: series.file(*step), time: *time };
        let there = |i: &Instant| series.directory.join(&i.name).is_file();
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
    /// * `step` number in the file's name
    /// * `time` in s
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
        (step, time): (usize, f64),
        fixed: Fixed,
        data: Data,
    ) -> Result<()> {
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
        write_data(comm, publisher, &path, (&mesh, grid, known), data)?;
        self.files.push(Instant { name: self.file(step), time });
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
