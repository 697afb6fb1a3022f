//! Numbers and values of the case as text, and the columns of the history.

use std::fmt::Write;

use serde_json::Value;

use crate::output::history::Table;

/// A unit with the prefix that makes numbers handy.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Unit {
    /// Numbers are multiplied by it.
    pub factor: f64,
    pub name: String,
}

const PREFIXES: [(i32, &str); 8] =
    [(-12, "p"), (-9, "n"), (-6, "µ"), (-3, "m"), (0, ""), (3, "k"), (6, "M"), (9, "G")];

impl Unit {
    /// For numbers in the unit `base`.
    pub fn of(base: &str, numbers: impl Iterator<Item = f64>) -> Self {
        let most = numbers.filter(|v| v.is_finite()).fold(0.0, |most: f64, v| most.max(v.abs()));
        // Nobody speaks of kilometres of a jump, nor of kilokilograms.
        let range = match base {
            "m" => -12..=0,
            "s" | "kg" | "kg/m" | "kg/m²/s" | "J/m²" | "" => 0..=0,
            _ => -12..=9,
        };
        let exponent = if most > 0.0 { (most.log10() + 1e-9).floor() as i32 } else { 0 };
        let wanted = exponent.div_euclid(3) * 3;
        let (exponent, prefix) = PREFIXES
            .into_iter()
            .filter(|(e, _)| range.contains(e))
            .min_by_key(|(e, _)| (e - wanted).abs())
            .unwrap_or((0, ""));
        Self { factor: 10f64.powi(-exponent), name: format!("{prefix}{base}") }
    }

    /// `words [unit]`.
    pub fn label(&self, words: &str) -> String {
        if self.name.is_empty() { words.to_owned() } else { format!("{words} [{}]", self.name) }
    }

    /// A number in this unit.
    pub fn number(&self, value: f64) -> f64 {
        // Division by a power of ten that is exact rounds once.
        if self.factor > 1.0 { value * self.factor } else { value / (1.0 / self.factor).round() }
    }

    /// The number with its unit.
    pub fn text(base: &str, value: f64) -> String {
        let unit = Self::of(base, std::iter::once(value));
        format!("{} {}", number(unit.number(value)), unit.name).trim_end().to_owned()
    }
}

/// Six digits at most.
pub(super) fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let size = value.abs();
    if !(1e-3..1e6).contains(&size) {
        let text = format!("{value:.5e}");
        return match text.split_once('e') {
            Some((digits, power)) => format!("{}e{power}", without_zeros(digits)),
            None => text,
        };
    }
    let digits = (5 - size.log10().floor() as i32).clamp(0, 8) as usize;
    without_zeros(&format!("{value:.digits$}")).to_owned()
}

fn without_zeros(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

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
    fn units_have_the_prefix_of_their_numbers() {
        for (base, most, name, power) in [
            ("Pa", 1.1e6, "MPa", -6),
            ("Pa", 0.0, "Pa", 0),
            ("m", 1.6e-3, "mm", 3),
            ("m", 2e-5, "µm", 6),
            ("m", 5000.0, "m", 0),
            ("N/m", 2.5e7, "MN/m", -6),
            ("s", 1e-4, "s", 0),
            ("Pa", 1e-30, "pPa", 12),
        ] {
            let unit = Unit::of(base, [most, f64::NAN].into_iter());
            assert_eq!(unit, Unit { factor: 10f64.powi(power), name: name.into() });
        }
        assert_eq!(Unit::text("Pa", 5.8e9), "5.8 GPa");
        assert_eq!(Unit::of("m", [1e-3].into_iter()).label("jump"), "jump [mm]");
        assert_eq!(Unit::of("", [3.0].into_iter()).label("damage"), "damage");
    }

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
        assert_eq!(number(1_017_312.072), "1.01731e6");
        assert_eq!(number(-0.001636), "-0.001636");
    }
}
