//! Numbers and values of the case as text, and the columns of the history.

use std::fmt::Write;

use serde_json::Value;

use crate::output::history::Table;

pub(super) use crate::chart::{Unit, number};

/// A number, or a dash where there is none.
pub(super) fn number_or_dash(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), number)
}

/// A value of the case as one would write it in a case file.
pub(super) fn in_words(value: &Value) -> String {
    match value {
        Value::Null => "none".to_owned(),
        Value::Bool(yes) => if *yes { "yes" } else { "no" }.to_owned(),
        Value::String(text) if text.is_empty() => "none".to_owned(),
        Value::String(text) => text.clone(),
        Value::Number(found) => match (found.as_u64(), found.as_f64()) {
            (Some(whole), _) => whole.to_string(),
            (None, Some(value)) => number(value),
            (None, None) => found.to_string(),
        },
        Value::Array(list) => {
            // A table may have thousands of rows.
            const MOST: usize = 24;
            let mut items: Vec<String> = list.iter().take(MOST).map(in_words).collect();
            if list.len() > MOST {
                items.push(format!("… {} in all", list.len()));
            }
            format!("[{}]", items.join(", "))
        }
        Value::Object(entries) => {
            let pairs = entries.iter().map(|(key, value)| format!("{key}: {}", in_words(value)));
            pairs.collect::<Vec<_>>().join(", ")
        }
    }
}

/// The entries of an object by the path of their keys, for a table of two columns.
pub(super) fn flat(value: &Value) -> Vec<(String, String)> {
    fn walk(value: &Value, path: &str, found: &mut Vec<(String, String)>) {
        match value {
            Value::Object(entries) => {
                for (key, value) in entries {
                    let key = key.replace('_', " ");
                    let path = if path.is_empty() { key } else { format!("{path}, {key}") };
                    walk(value, &path, found);
                }
            }
            Value::Array(list) if list.iter().any(Value::is_object) => {
                for (index, value) in list.iter().enumerate() {
                    walk(value, format!("{path} {}", index + 1).trim(), found);
                }
            }
            other => found.push((path.to_owned(), in_words(other))),
        }
    }
    let mut found = Vec::new();
    walk(value, "", &mut found);
    found
}

/// A column of the history, row by row; none if there is no such column.
pub(super) fn column(history: &Table, name: &str) -> Option<Vec<Option<f64>>> {
    let place = history.column(name)?;
    Some(history.rows.iter().map(|row| row[place].filter(|value| value.is_finite())).collect())
}

/// The rows in which both columns have a number.
pub(super) fn pairs(x: &[Option<f64>], y: &[Option<f64>]) -> Vec<(f64, f64)> {
    x.iter().zip(y).filter_map(|(x, y)| x.zip(*y)).collect()
}

/// A table of HTML; the cells are text.
pub(super) fn table(html: &mut String, head: &[&str], rows: &[Vec<String>]) {
    use crate::html::escaped;
    html.push_str("<div class=\"scroll\"><table>\n");
    if !head.is_empty() {
        let cells = head.iter().map(|cell| format!("<th>{}</th>", escaped(cell)));
        let _ = writeln!(html, "<tr>{}</tr>", cells.collect::<String>());
    }
    for row in rows {
        let cells = row.iter().map(|cell| format!("<td>{}</td>", escaped(cell)));
        let _ = writeln!(html, "<tr>{}</tr>", cells.collect::<String>());
    }
    html.push_str("</table></div>\n");
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn values_are_written_as_in_a_case() {
        for (value, words) in [
            (json!({"table": [[0, 0.5], [1, 1e-7]]}), "table: [[0, 0.5], [1, 1e-7]]"),
            (json!(5.8e9), "5.8e9"),
            (json!(0.25), "0.25"),
            (json!(null), "none"),
            (json!(""), "none"),
        ] {
            assert_eq!(in_words(&value), words);
        }
        assert!(in_words(&json!(vec![1; 100])).ends_with("1, … 100 in all]"));
    }
}
