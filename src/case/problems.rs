//! The mistakes of a case file, collected and told at once.

use std::path::Path;

use super::tree::{Node, Origin};
use crate::error::Error;

/// Most mistakes that are listed.
const LISTED: usize = 20;

/// Collects mistakes with their places.
pub(super) struct Problems<'a> {
    path: &'a Path,
    overrides: &'a [String],
    list: Vec<(Origin, String)>,
}

impl<'a> Problems<'a> {
    pub fn new(path: &'a Path, overrides: &'a [String]) -> Self {
        Problems { path, overrides, list: Vec::new() }
    }

    /// Adds a mistake at a known place.
    pub fn at(&mut self, origin: Origin, text: String) {
        let problem = (origin, text);
        if !self.list.contains(&problem) {
            self.list.push(problem);
        }
    }

    /// Adds a mistake at the place of a dotted path; the message is `PATH REASON`.
    pub fn add(&mut self, tree: &Node, path: &str, reason: impl std::fmt::Display) {
        self.at(tree.locate(path), format!("{path} {reason}"));
    }

    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// One line for each mistake, in the order of the file, then of the overrides.
    pub fn into_error(mut self) -> Error {
        self.list.sort_by_key(|(origin, _)| *origin);
        let more = self.list.len().saturating_sub(LISTED);
        let mut lines: Vec<String> = self
            .list
            .iter()
            .take(LISTED)
            .map(|(origin, text)| match origin {
                Origin::File(line, column) => {
                    format!("{}:{line}:{column}: {text}", self.path.display())
                }
                Origin::Override(number) => format!("--set {}: {text}", self.overrides[*number]),
            })
            .collect();
        if more > 0 {
            lines.push(format!("and {more} more"));
        }
        Error::Input(lines.join("\n"))
    }
}

/// The known name that a misspelt one most likely means.
pub(super) fn nearest<'a>(name: &str, known: &'a [String]) -> Option<&'a String> {
    known
        .iter()
        .map(|candidate| (strsim::jaro_winkler(name, candidate), candidate))
        .filter(|(likeness, candidate)| {
            *likeness > 0.8 || strsim::osa_distance(name, candidate) == 1
        })
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}

/// `; did you mean `x`?` where a known name is near, then all known names; of the statistics of
/// an interface quantity the quantity alone.
pub(super) fn suggestion(name: &str, known: &[String]) -> String {
    let nearest = nearest(name, known)
        .map(|candidate| format!("; did you mean `{candidate}`?"))
        .unwrap_or_default();
    let listed: Vec<&str> = known
        .iter()
        .map(String::as_str)
        .filter(|name| ![".min", ".max", ".mean"].iter().any(|end| name.ends_with(end)))
        .collect();
    format!("{nearest} (known: {})", listed.join(", "))
}
