//! `history.csv`: one row of quantities per instant.

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
        let mut writer = csv::Writer::from_writer(Vec::new());
        let failed = |cause: csv::Error| Error::Bug(format!("history table: {cause}"));
        writer.write_record(&self.columns).map_err(failed)?;
        let counts: Vec<bool> = self.columns.iter().map(|c| c.ends_with("_iterations")).collect();
        for row in &self.rows {
            let fields = row.iter().zip(&counts).map(|(value, count)| match value {
                None => String::new(),
                Some(v) if *count => format!("{v:.0}"),
                Some(v) => format!("{v:.16e}"),
            });
            writer.write_record(fields).map_err(failed)?;
        }
        let bytes = writer.into_inner().map_err(|e| Error::Bug(format!("history table: {e}")))?;
        String::from_utf8(bytes).map_err(|e| Error::Bug(format!("history table: {e}")))
    }

    /// Reads a table back from its file.
    ///
    /// # Errors
    /// [`Error::System`] if the file cannot be read or a field is not a number.
    ///
    /// # Parallel
    /// Local.
    pub fn read(path: &Path) -> Result<Self> {
        let failed = |cause: &dyn std::fmt::Display| Error::file("cannot read", path, cause);
        let mut reader = csv::Reader::from_path(path).map_err(|e| failed(&e))?;
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

/// The history table and its file, which always holds all rows so far.
#[derive(Debug)]
pub struct History {
    path: PathBuf,
    table: Table,
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
        let history = Self { path, table };
        history.write()?;
        Ok(history)
    }

    /// Adds a row, shape (number of columns), and writes the file anew.
    ///
    /// # Errors
    /// [`Error::Bug`] if the row does not have one entry per column; [`Error::System`] if the file
    /// cannot be written.
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
        self.table.rows.push(row);
        self.write()
    }

    /// All rows so far.
    pub fn table(&self) -> &Table {
        &self.table
    }

    fn write(&self) -> Result<()> {
        atomic::write_text(&self.path, &self.table.to_csv()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_parse_back_to_the_same_numbers() {
        let path =
            std::env::temp_dir().join(format!("column-hpc-history-{}.csv", std::process::id()));
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
        let path =
            std::env::temp_dir().join(format!("column-hpc-short-{}.csv", std::process::id()));
        let mut history = History::create(path.clone(), vec!["time".into()]).unwrap();
        assert_eq!(history.push(vec![]).unwrap_err().exit_status(), 101);
        std::fs::remove_file(path).unwrap();
    }
}
