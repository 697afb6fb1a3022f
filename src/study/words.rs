//! Values and places of a study file in words.

use std::path::Path;

use serde_json::Value as Json;

use crate::error::{Error, number_text};
use crate::input::tree::Origin;

/// `KEY=VALUE` with the value as JSON, which is YAML; nothing for a key that is taken away.
pub(super) fn assignment(key: &str, value: &Json) -> String {
    if value.is_null() { format!("{key}=") } else { format!("{key}={value}") }
}

/// A value as a user would say it: `4x4x20` for a list of counts, the key of a section with one.
pub(super) fn label(value: &Json) -> String {
    match value {
        Json::String(text) => text.clone(),
        Json::Number(number) => number.as_f64().map_or(number.to_string(), number_text),
        Json::Array(items) if !items.is_empty() && items.iter().all(Json::is_u64) => {
            items.iter().map(Json::to_string).collect::<Vec<_>>().join("x")
        }
        Json::Object(keys) if keys.len() == 1 => keys.keys().cloned().collect(),
        other => other.to_string(),
    }
}

/// The number that a value stands for on a chart: of a list the product.
pub(super) fn number_of(value: &Json) -> Option<f64> {
    match value {
        Json::Array(items) => items.iter().map(Json::as_f64).product(),
        Json::String(text) => text.parse().ok(),
        other => other.as_f64(),
    }
}

pub(super) fn size(number: u64) -> usize {
    usize::try_from(number).unwrap_or(usize::MAX)
}

/// The message of a mistake with its place in a file.
pub(super) fn placed(path: &Path, origin: Origin, text: &str) -> String {
    match origin {
        Origin::File(line, column) => format!("{}:{line}:{column}: {text}", path.display()),
        Origin::Override(_) | Origin::Code(_) => format!("{}: {text}", path.display()),
    }
}

/// As one error.
pub(super) fn refuse(lines: &[String]) -> Error {
    Error::Input(lines.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn values_are_labelled_as_they_are_said() {
        for (value, text, number) in [
            (json!([4, 4, 20]), "4x4x20", Some(320.0)),
            (json!(1.0e-9), "1e-9", Some(1e-9)),
            (json!(2), "2", Some(2.0)),
            (json!("mumps"), "mumps", None),
            (json!({"tied": {}}), "tied", None),
            (json!(true), "true", None),
        ] {
            assert_eq!(label(&value), text);
            assert_eq!(number_of(&value), number);
        }
        assert_eq!(assignment("a.b", &Json::Null), "a.b=");
        assert_eq!(assignment("a.b", &json!({"x": [1, 2.5e-9]})), "a.b={\"x\":[1,2.5e-9]}");
    }
}
