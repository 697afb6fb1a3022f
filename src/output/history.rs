//! `history.csv`: one row of quantities per instant.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::atomic;
use crate::error::{Error, Result};

/// Names of columns and rows of values; `None` is an empty field.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Table {
    /// Names, in the order in which they are written.
    pub columns: Vec<String>,
    /// Rows with one entry per column.
    pub rows: Vec<Vec<Option<f64>>>,
}

impl Table {
    /// The index of a column, none if there is no such column.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|c| c == name)
    }

    /// The table as text: 17 significant digits, which parse back to the same number; numbers of
    /// iterations as integers.
    pub fn to_csv(&self) -> Result<String> {
        text(|writer| {
            writer.write_record(&self.columns)?;
            self.rows.iter().try_for_each(|row| self.write_row(writer, row))
        })
    }

    /// One row as text, with the end of its line.
    fn row_to_csv(&self, row: &[Option<f64>]) -> Result<String> {
        text(|writer| self.write_row(writer, row))
    }

    fn write_row(&self, writer: &mut csv::Writer<Vec<u8>>, row: &[Option<f64>]) -> csv::Result<()> {
        writer.write_record(row.iter().zip(&self.columns).map(|(value, column)| match value {
            None => String::new(),
            Some(v) if column.ends_with("_iterations") => format!("{v:.0}"),
            Some(v) => format!("{v:.16e}"),
        }))
    }

    /// Reads a table back from its file. A last line without its end is left out: its run was
    /// killed while it wrote it.
    ///
    /// # Errors
    /// [`Error::System`] if the file cannot be read or a field is not a number.
    ///
    /// # Parallel
    /// Local.
    pub fn read(path: &Path) -> Result<Self> {
        let failed = |cause: &dyn std::fmt::Display| Error::file("cannot read", path, cause);
        let text = std::fs::read_to_string(path).map_err(|e| failed(&e))?;
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let mut reader = csv::Reader::from_reader(&text.as_bytes()[..whole]);
        let columns: Vec<String> =
            reader.headers().map_err(|e| failed(&e))?.iter().map(String::from).collect();
        let mut rows = Vec::new();
        for (index, record) in reader.records().enumerate() {
            let record = record.map_err(|e| failed(&e))?;
            let row = record.iter().zip(&columns).map(|(field, column)| match field {
                "" => Ok(None),
                text => text.parse().map(Some).map_err(|_| {
                    failed(&format!("row {}, {column}: `{text}` is not a number", index + 1))
                }),
            });
            rows.push(row.collect::<Result<_>>()?);
        }
        Ok(Self { columns, rows })
    }
}

/// What `write` writes as CSV.
fn text(write: impl FnOnce(&mut csv::Writer<Vec<u8>>) -> csv::Result<()>) -> Result<String> {
    let failed = |cause: &dyn std::fmt::Display| Error::Bug(format!("history table: {cause}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    write(&mut writer).map_err(|e| failed(&e))?;
    let bytes = writer.into_inner().map_err(|e| failed(&e))?;
    String::from_utf8(bytes).map_err(|e| failed(&e))
}

/// The history table and its file, which always holds all rows so far; or the table alone.
#[derive(Debug)]
pub struct History {
    path: Option<PathBuf>,
    table: Table,
    /// Bytes of the file.
    length: u64,
}

impl History {
    /// Starts a table and writes its first line.
    ///
    /// # Errors
    /// [`Error::System`] if the file cannot be written.
    ///
    /// # Parallel
    /// Local; rank 0 keeps the history.
    pub fn create(path: PathBuf, columns: Vec<String>) -> Result<Self> {
        Self::resume(path, Table { columns, rows: Vec::new() })
    }

    /// Goes on with the rows of an earlier run, which take the place of those in the file.
    ///
    /// # Errors
    /// As [`History::create`].
    ///
    /// # Parallel
    /// As [`History::create`].
    pub fn resume(path: PathBuf, table: Table) -> Result<Self> {
        let mut history = Self { path: Some(path), table, length: 0 };
        history.write()?;
        Ok(history)
    }

    /// A table without a file, with the rows so far. Local.
    pub fn in_memory(table: Table) -> Self {
        Self { path: None, table, length: 0 }
    }

    /// Adds a row, shape (number of columns), at the end of the file.
    ///
    /// # Errors
    /// [`Error::Bug`] if the row does not have one entry per column; [`Error::System`] if the file
    /// cannot be written, which then has the rows before.
    ///
    /// # Parallel
    /// Local; rank 0 keeps the history.
    pub fn push(&mut self, row: Vec<Option<f64>>) -> Result<()> {
        if row.len() != self.table.columns.len() {
            return Err(Error::Bug(format!(
                "history row with {} entries for {} columns",
                row.len(),
                self.table.columns.len()
            )));
        }
        let Some(path) = &self.path else {
            self.table.rows.push(row);
            return Ok(());
        };
        let line = self.table.row_to_csv(&row)?;
        self.table.rows.push(row);
        let added = append(path, self.length, line.as_bytes());
        if added.map_err(|cause| Error::file("cannot write", path, cause))? {
            self.length += line.len() as u64;
            return Ok(());
        }
        self.write()
    }

    /// All rows, when nothing is added any more.
    pub fn into_table(self) -> Table {
        self.table
    }

    /// All rows so far.
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// Brings the rows so far to the disk.
    ///
    /// # Errors
    /// [`Error::System`] if that fails.
    ///
    /// # Parallel
    /// As [`History::push`].
    pub fn flush(&self) -> Result<()> {
        let Some(path) = &self.path else { return Ok(()) };
        let flushed = File::open(path).and_then(|file| file.sync_all());
        flushed.map_err(|cause| Error::file("cannot write", path, cause))
    }

    /// Writes the file anew.
    fn write(&mut self) -> Result<()> {
        let Some(path) = &self.path else { return Ok(()) };
        let text = self.table.to_csv()?;
        self.length = text.len() as u64;
        atomic::write_text(path, &text)
    }
}

/// Adds a line to the file if it is the one that was written, of so many bytes; false if somebody
/// has taken it away or changed it. In one write, so that others never read a part of it.
fn append(path: &Path, length: u64, line: &[u8]) -> io::Result<bool> {
    let file = match File::options().append(true).open(path) {
        Err(cause) if cause.kind() == io::ErrorKind::NotFound => return Ok(false),
        other => other?,
    };
    if file.metadata()?.len() != length {
        return Ok(false);
    }
    // A disk without room takes a part.
    let cut = |_: &io::Error| drop(file.set_len(length));
    (&file).write_all(line).inspect_err(cut)?;
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::MetadataExt;

    fn scratch(name: &str) -> PathBuf {
        let process = std::process::id();
        std::env::temp_dir().join(format!("column-hpc-history-{name}-{process}.csv"))
    }

    #[test]
    fn rows_parse_back_to_the_same_numbers() {
        let path = scratch("rows");
        let columns =
            ["time", "newton_iterations", "joint.normal_traction.mean"].map(String::from).to_vec();
        let mut history = History::create(path.clone(), columns).unwrap();
        let rows = [
            vec![Some(0.1), Some(3.0), Some(1_017_312.072_892_938_2)],
            vec![Some(1.0 / 3.0), Some(12.0), None],
            vec![Some(f64::MIN_POSITIVE), Some(0.0), Some(-0.0)],
        ];
        for (i, row) in rows.iter().enumerate() {
            history.push(row.clone()).unwrap();
            let read = Table::read(&path).unwrap();
            assert_eq!(read.rows, rows[..=i]);
            assert_eq!(&read, history.table());
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let second = text.lines().nth(2).unwrap();
        assert_eq!(second, "3.3333333333333331e-1,12,");
        assert_eq!(text, history.table().to_csv().unwrap());
        std::fs::remove_file(path).unwrap();
    }

    #[test]
    fn a_row_is_added_to_the_file_and_the_rest_stays_as_it_is() {
        let path = scratch("added");
        let mut history = History::create(path.clone(), vec!["time".into()]).unwrap();
        history.push(vec![Some(1.0)]).unwrap();
        let before = std::fs::metadata(&path).unwrap().ino();
        history.push(vec![Some(2.0)]).unwrap();
        assert_eq!(std::fs::metadata(&path).unwrap().ino(), before);
        let whole = history.table().to_csv().unwrap();
        // A kill in the middle of a row: it is no row; a restart writes what its checkpoint has.
        std::fs::write(&path, &whole[..whole.len() - 3]).unwrap();
        assert_eq!(Table::read(&path).unwrap().rows, [[Some(1.0)]]);
        // What was changed or taken away meanwhile is written anew.
        history.push(vec![Some(3.0)]).unwrap();
        assert_eq!(Table::read(&path).unwrap().rows.len(), 3);
        std::fs::remove_file(&path).unwrap();
        history.push(vec![Some(4.0)]).unwrap();
        assert_eq!(&Table::read(&path).unwrap(), history.table());
        let first = Table { rows: history.table().rows[..1].to_vec(), ..history.table().clone() };
        let mut resumed = History::resume(path.clone(), first).unwrap();
        resumed.push(vec![Some(5.0)]).unwrap();
        assert_eq!(Table::read(&path).unwrap().rows, [[Some(1.0)], [Some(5.0)]]);
        std::fs::remove_file(path).unwrap();
    }

    #[test]
    fn what_is_not_a_number_shows() {
        let table = Table {
            columns: vec!["time".into(), "damage".into()],
            rows: vec![vec![Some(1.0), Some(f64::NAN)]],
        };
        assert!(table.to_csv().unwrap().ends_with("1.0000000000000000e0,NaN\n"));
    }

    #[test]
    fn a_row_of_another_length_is_a_bug() {
        let path = scratch("short");
        let mut history = History::create(path.clone(), vec!["time".into()]).unwrap();
        assert_eq!(history.push(vec![]).unwrap_err().exit_status(), 101);
        std::fs::remove_file(path).unwrap();
    }
}
