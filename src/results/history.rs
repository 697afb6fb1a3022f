//! The history of a run: columns by their names.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::input::problems::suggestion;
use crate::output::history::Table;

/// What a quantity of an interface stands for where no statistic is named.
const USUAL: &str = ".mean";

/// The column of the instants.
const TIME: &str = "time";

/// One row for each instant that was reached, one column for each quantity; SI units. The columns
/// are those of `history.csv`.
///
/// ```
/// use column_hpc::output::history::Table;
/// use column_hpc::results::History;
///
/// let columns = ["time", "joint.normal_traction.mean", "top.reaction_z"];
/// let history = History::from(Table {
///     columns: columns.map(str::to_owned).to_vec(),
///     rows: vec![vec![Some(1.0), Some(5.0), Some(10.0)], vec![Some(2.0), Some(7.0), Some(14.0)]],
/// });
/// assert_eq!(history.times(), [1.0, 2.0]);
/// assert_eq!(history.column("top.reaction_z")?, [10.0, 14.0]);
/// // A quantity of an interface without its statistic is the mean over the interface.
/// assert_eq!(history.at(2.0, "joint.normal_traction")?, 7.0);
/// # Ok::<(), column_hpc::error::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct History {
    table: Table,
}

impl From<Table> for History {
    fn from(table: Table) -> Self {
        Self { table }
    }
}

impl History {
    /// The names of all columns.
    pub fn columns(&self) -> &[String] {
        &self.table.columns
    }

    /// Rows with one entry for each column, none where a column has no value: a component of an
    /// interface that has no node of its own.
    pub fn rows(&self) -> &[Vec<Option<f64>>] {
        &self.table.rows
    }

    /// The instants that were reached (s).
    pub fn times(&self) -> Vec<f64> {
        self.column(TIME).unwrap_or_default()
    }

    /// The values of a column at all instants. A quantity of an interface without `.min`, `.max`
    /// or `.mean` is its mean.
    ///
    /// # Errors
    /// [`Error::Input`] when there is no such column, with the nearest name, or when it is empty.
    pub fn column(&self, name: &str) -> Result<Vec<f64>> {
        let column = self.index(name)?;
        self.table.rows.iter().map(|row| value(row, column, name)).collect()
    }

    /// The value of a column at an instant.
    ///
    /// # Errors
    /// As [`History::column`], and when the instant was not reached.
    pub fn at(&self, time: f64, name: &str) -> Result<f64> {
        let (when, column) = (self.index(TIME)?, self.index(name)?);
        let row = self.table.rows.iter().find(|row| row.get(when) == Some(&Some(time)));
        let row = row.ok_or_else(|| {
            let times = self.times();
            Error::Input(format!("the history has no row at time {time}, only at {times:?}"))
        })?;
        value(row, column, name)
    }

    fn index(&self, name: &str) -> Result<usize> {
        let found =
            self.table.column(name).or_else(|| self.table.column(&format!("{name}{USUAL}")));
        found.ok_or_else(|| {
            let hint = suggestion(name, &self.quantities());
            Error::Input(format!("the history has no column `{name}`{hint}"))
        })
    }

    /// The columns, and the quantities whose mean is one.
    fn quantities(&self) -> Vec<String> {
        let with_base = |column: &String| {
            let base = column.strip_suffix(USUAL).map(str::to_owned);
            base.into_iter().chain([column.clone()])
        };
        self.table.columns.iter().flat_map(with_base).collect()
    }
}

fn value(row: &[Option<f64>], column: usize, name: &str) -> Result<f64> {
    let value = row.get(column).copied().flatten();
    value.ok_or_else(|| {
        Error::Input(format!("the column `{name}` of the history is empty: it has no nodes"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history() -> History {
        let names = ["time", "joint.sliding_x.min", "joint.sliding_x.mean", "energy.elastic"];
        let rows =
            vec![vec![Some(0.5), None, None, Some(1.0)], vec![Some(1.0), None, None, Some(4.0)]];
        Table { columns: names.map(str::to_owned).to_vec(), rows }.into()
    }

    #[test]
    fn a_column_has_the_values_of_all_instants() {
        let history = history();
        assert_eq!(history.times(), [0.5, 1.0]);
        assert_eq!(history.column("energy.elastic"), Ok(vec![1.0, 4.0]));
        assert_eq!(history.at(1.0, "energy.elastic"), Ok(4.0));
        let text = serde_json::to_vec(&history).expect("text");
        assert_eq!(serde_json::from_slice::<History>(&text).expect("a history"), history);
    }

    #[test]
    fn what_is_not_there_is_told() {
        let history = history();
        let told = |found: Result<f64>| found.expect_err("a refusal").to_string();
        let unknown = told(history.at(1.0, "energy.elastc"));
        assert!(unknown.contains("did you mean `energy.elastic`?"), "{unknown}");
        assert!(unknown.contains("(known: time, joint.sliding_x, energy.elastic)"), "{unknown}");
        assert!(told(history.at(2.0, "energy.elastic")).contains("only at [0.5, 1.0]"));
        assert!(told(history.at(1.0, "joint.sliding_x")).contains("is empty"));
    }
}
