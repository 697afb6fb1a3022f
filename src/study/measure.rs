//! What is measured of every run.

use std::collections::BTreeMap;
use std::path::Path;

use super::plan::{Plan, Run};
use super::record::{Ended, Launch, Record};
use super::spec::{Against, At, Measure, Study};
use super::stats::quartiles;
use crate::output::directory::HISTORY;
use crate::output::history::Table;

/// The results of one run.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Row {
    /// Position in the plan.
    pub run: usize,
    /// How it ended; none if it was not run yet.
    pub status: Option<Ended>,
    pub message: String,
    pub launches: usize,
    /// Cores of the machine it ran on.
    pub cores: usize,
    /// Lower quartile, median and upper quartile over the launches, by name.
    pub values: BTreeMap<String, [f64; 3]>,
}

impl Row {
    /// The median of a measure.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.values.get(name).map(|quartiles| quartiles[1])
    }

    /// Whether its numbers can be compared with those of others.
    pub fn has_results(&self) -> bool {
        self.status.is_some_and(Ended::has_results)
    }
}

/// Everything that is measured, one row for each run of the plan; `runs` is the directory of the
/// runs'.
pub(super) fn rows(study: &Study, plan: &Plan, records: &[Record], runs: &Path) -> Vec<Row> {
    let tables: Vec<Option<Table>> = plan
        .runs
        .iter()
        .zip(records)
        .map(|(run, record)| {
            let whole = record.launches.last().is_some_and(|last| last.status.has_results());
            whole.then(|| Table::read(&runs.join(&run.directory).join(HISTORY)).ok()).flatten()
        })
        .collect();
    plan.runs
        .iter()
        .zip(records)
        .enumerate()
        .map(|(index, (run, record))| {
            let mut row = resources(index, run, record);
            for measure in &study.measures {
                let value = tables[index].as_ref().and_then(|own| {
                    let other = |run: Option<usize>| tables[run?].as_ref();
                    value_of(study, plan, run, measure, own, other)
                });
                row.values.extend(value.map(|v| (measure.name.clone(), [v; 3])));
            }
            row
        })
        .collect()
}

/// Times, memory and counters.
fn resources(index: usize, run: &Run, record: &Record) -> Row {
    let last = record.launches.last();
    let mut values = BTreeMap::new();
    let mut add = |name: &str, of: &dyn Fn(&Launch) -> Option<f64>| {
        let numbers: Vec<f64> = record.launches.iter().filter_map(of).collect();
        values.extend(quartiles(&numbers).map(|q| (name.to_owned(), q)));
    };
    let count = |n: Option<u64>| n.map(|n| n as f64);
    add("wall_seconds", &|l| Some(l.wall_seconds));
    add("core_seconds", &|l| Some(l.wall_seconds * run.ranks as f64));
    add("solve_seconds", &|l| l.solve_seconds);
    add("memory_mb", &|l| count(l.memory_bytes).map(|bytes| bytes / 1e6));
    add("cells", &|l| count(l.cells));
    add("unknowns", &|l| count(l.unknowns));
    add("corrections", &|l| count(l.corrections));
    add("iterations", &|l| count(l.iterations));
    add("iterations_per_correction", &|l| {
        let corrections = count(l.corrections).filter(|n| *n > 0.0)?;
        count(l.iterations).map(|n| n / corrections)
    });
    Row {
        run: index,
        status: last.map(|launch| launch.status),
        message: last.map_or_else(String::new, |launch| launch.message.clone()),
        launches: record.launches.len(),
        cores: last.map_or(1, |launch| launch.cores),
        values,
    }
}

fn value_of<'a>(
    study: &Study,
    plan: &Plan,
    run: &Run,
    measure: &Measure,
    own: &Table,
    other: impl Fn(Option<usize>) -> Option<&'a Table>,
) -> Option<f64> {
    let values = column_at(own, &measure.column, &measure.at)?;
    let exact: Vec<f64> = match measure.against.as_ref() {
        None => return values.first().map(|(_, value)| *value),
        Some(Against::Number(number)) => vec![*number; values.len()],
        Some(Against::Formula(formula, axes)) => {
            let number = |axis: Option<usize>| match axis {
                None => Some(0.0),
                Some(axis) => study.axes[axis].choices[*run.choices.get(axis)?].number,
            };
            let point = [number(axes[0])?, number(axes[1])?, 0.0];
            values.iter().map(|(time, _)| formula.at(point, *time)).collect()
        }
        Some(Against::History(table)) => column(table, measure)?,
        Some(Against::Reference(index)) => column(other(Some(*index))?, measure)?,
        Some(Against::Axes(labels)) => column(other(plan.moved(run, labels))?, measure)?,
    };
    let values: Vec<f64> = values.iter().map(|(_, value)| *value).collect();
    error(&values, &exact, measure.relative)
}

fn column(table: &Table, measure: &Measure) -> Option<Vec<f64>> {
    let values = column_at(table, &measure.column, &measure.at)?;
    Some(values.iter().map(|(_, value)| *value).collect())
}

/// Times and values of a column; none unless it has a value at every instant.
fn column_at(table: &Table, name: &str, at: &At) -> Option<Vec<(f64, f64)>> {
    let (time, column) = (table.column("time")?, table.column(name)?);
    let value = |row: &Vec<Option<f64>>| Some((row[time]?, row[column]?));
    match at {
        At::Last => Some(vec![value(table.rows.last()?)?]),
        At::Times(times) => times
            .iter()
            .map(|wanted| {
                let row = table.rows.iter().find(|row| row[time] == Some(*wanted))?;
                value(row)
            })
            .collect(),
    }
}

/// The largest difference, over the largest exact value if it is relative.
fn error(values: &[f64], exact: &[f64], relative: bool) -> Option<f64> {
    let largest = |numbers: &mut dyn Iterator<Item = f64>| {
        numbers.fold(0.0, |a: f64, b| if b.is_nan() || b > a { b } else { a })
    };
    let error = largest(&mut values.iter().zip(exact).map(|(v, e)| (v - e).abs()));
    let scale = if relative { largest(&mut exact.iter().map(|e| e.abs())) } else { 1.0 };
    let error = error / scale;
    error.is_finite().then_some(error)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_over_the_largest_exact_value() {
        let close = |found: Option<f64>, exact: f64| (found.unwrap() - exact).abs() < 1e-15;
        assert!(close(error(&[1.1, 3.9], &[1.0, 4.0], true), 0.1 / 4.0));
        assert!(close(error(&[1.1, 3.7], &[1.0, 4.0], false), 0.3));
        // Nothing is relative to nothing, and what is not a number has no error.
        assert_eq!(error(&[0.1], &[0.0], true), None);
        assert_eq!(error(&[f64::NAN], &[1.0], true), None);
    }

    #[test]
    fn instants_are_found_by_their_time() {
        let table = Table {
            columns: vec!["time".into(), "a".into()],
            rows: vec![
                vec![Some(0.1), Some(5.0)],
                vec![Some(0.2), None],
                vec![Some(0.3), Some(7.0)],
            ],
        };
        assert_eq!(
            column_at(&table, "a", &At::Times(vec![0.3, 0.1])),
            Some(vec![(0.3, 7.0), (0.1, 5.0)])
        );
        assert_eq!(column_at(&table, "a", &At::Last), Some(vec![(0.3, 7.0)]));
        for missing in [0.2, 0.4] {
            assert_eq!(column_at(&table, "a", &At::Times(vec![missing])), None);
        }
        assert_eq!(column_at(&table, "b", &At::Last), None);
    }
}
