//! Expected values against the history.

use serde::Serialize;

use crate::error::{Error, Result};
use crate::output::history::Table;

/// How one expectation came out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outcome {
    /// A column of the history, or the part of its name before `.min` and `.max`.
    pub quantity: String,
    /// Instant in s.
    pub at: f64,
    /// Expected value.
    pub equals: f64,
    /// The value that came; of min and max the one farther off. None if there is none.
    pub value: Option<f64>,
    /// |value - equals|.
    pub error: Option<f64>,
    /// Largest error allowed: absolute + relative |equals|.
    pub tolerance: f64,
    /// Whether the error is within the tolerance.
    pub met: bool,
    /// Why there is no value to compare.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// The columns that a quantity of an expectation stands for: its own, or its minimum and maximum.
///
/// # Errors
/// [`Error::Input`] with the nearest right name if there is no such column.
pub fn columns_of(columns: &[String], quantity: &str) -> Result<Vec<usize>> {
    let find = |name: &str| columns.iter().position(|c| c == name);
    if let Some(column) = find(quantity) {
        return Ok(vec![column]);
    }
    if let (Some(min), Some(max)) =
        (find(&format!("{quantity}.min")), find(&format!("{quantity}.max")))
    {
        return Ok(vec![min, max]);
    }
    let distance = |name: &str| strsim::damerau_levenshtein(name, quantity);
    let names = columns.iter().flat_map(|c| {
        let base = c.strip_suffix(".min");
        [Some(c.as_str()), base].into_iter().flatten()
    });
    let nearest = names.min_by_key(|name| distance(name));
    Err(Error::Input(format!(
        "expectation: `{quantity}` is not a column of history.csv{}",
        nearest.map(|n| format!("; the nearest is `{n}`")).unwrap_or_default()
    )))
}

/// Compares one expectation with the history.
///
/// It is met when |value - equals| <= absolute + relative |equals|; a quantity that has a minimum
/// and a maximum must meet it with both. No row, an empty field and NaN do not meet it.
///
/// # Errors
/// [`Error::Input`] if the quantity is no column.
///
/// # Parallel
/// Local; rank 0 keeps the history.
pub fn evaluate(
    history: &Table,
    quantity: &str,
    at: f64,
    equals: f64,
    relative: f64,
    absolute: f64,
) -> Result<Outcome> {
    let columns = columns_of(&history.columns, quantity)?;
    let tolerance = absolute + relative * equals.abs();
    let mut outcome = Outcome {
        quantity: quantity.to_string(),
        at,
        equals,
        value: None,
        error: None,
        tolerance,
        met: false,
        note: None,
    };
    let time = history.column("time").ok_or_else(|| Error::Bug("history without time".into()))?;
    // Instants are given as numbers in the case on both sides; sums of steps may differ by
    // rounding.
    let same = |t: f64| (t - at).abs() <= 1e-12 * at.abs().max(t.abs());
    let row = history.rows.iter().rev().find(|row| row[time].is_some_and(same));
    let Some(row) = row else {
        outcome.note = Some(format!("the history has no row at {at}"));
        return Ok(outcome);
    };
    let Some(values) = columns.iter().map(|&c| row[c]).collect::<Option<Vec<f64>>>() else {
        outcome.note = Some("the column is empty: it has no nodes".into());
        return Ok(outcome);
    };
    // The total order places NaN above every number.
    let value = values.into_iter().max_by(|a, b| (a - equals).abs().total_cmp(&(b - equals).abs()));
    let error = value.map(|v| (v - equals).abs());
    if value.is_some_and(f64::is_nan) {
        outcome.note = Some("the value is not a number".into());
    }
    outcome.met = error.is_some_and(|e| e <= tolerance);
    (outcome.value, outcome.error) = (value, error);
    Ok(outcome)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history() -> Table {
        let columns =
            ["time", "energy.elastic", "joint.damage.min", "joint.damage.max", "mid.pressure"];
        Table {
            columns: columns.map(String::from).to_vec(),
            rows: vec![
                vec![Some(1.0), Some(100.0), Some(0.2), Some(0.3), None],
                vec![Some(0.1 + 0.2), Some(f64::NAN), Some(0.5), Some(0.5), None],
            ],
        }
    }

    #[test]
    fn a_value_within_the_sum_of_both_tolerances_meets() {
        let at = |equals, relative, absolute| {
            evaluate(&history(), "energy.elastic", 1.0, equals, relative, absolute).unwrap()
        };
        assert!(at(101.0, 0.0, 1.0).met);
        assert!(!at(101.0, 0.0, 0.999).met);
        assert!(at(-80.0, 2.0, 20.0).met);
        assert_eq!(at(101.0, 0.01, 0.5).tolerance, 1.51);
        assert_eq!(at(101.0, 0.0, 1.0).error, Some(1.0));
    }

    #[test]
    fn minimum_and_maximum_must_both_meet() {
        let at =
            |quantity: &str, time| evaluate(&history(), quantity, time, 0.3, 0.0, 0.05).unwrap();
        let both = at("joint.damage", 1.0);
        assert!(!both.met);
        assert_eq!(both.value, Some(0.2));
        assert!(at("joint.damage.max", 1.0).met);
        let nan = evaluate(
            &Table {
                rows: vec![vec![Some(1.0), None, Some(0.3), Some(f64::NAN), None]],
                ..history()
            },
            "joint.damage",
            1.0,
            0.3,
            0.0,
            1.0,
        );
        assert!(!nan.unwrap().met);
    }

    #[test]
    fn what_has_no_value_is_not_met_and_says_so() {
        let at = |quantity: &str, time| {
            evaluate(&history(), quantity, time, 0.0, 1.0, f64::INFINITY).unwrap()
        };
        for (quantity, time, note) in [
            ("mid.pressure", 1.0, "empty"),
            ("energy.elastic", 0.3, "not a number"),
            ("energy.elastic", 2.0, "no row at 2"),
        ] {
            let outcome = at(quantity, time);
            assert!(!outcome.met, "{outcome:?}");
            assert!(outcome.note.as_ref().is_some_and(|n| n.contains(note)), "{outcome:?}");
        }
    }

    #[test]
    fn a_name_that_is_no_column_gets_the_nearest() {
        let error = columns_of(&history().columns, "joint.damge").unwrap_err();
        assert_eq!(error.exit_status(), 2);
        assert!(error.to_string().contains("nearest is `joint.damage`"), "{error}");
    }
}
