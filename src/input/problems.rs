//! The mistakes of a case file, collected and told at once.

use std::collections::BTreeSet;
use std::path::Path;

use super::tree::{Node, Origin};
use crate::error::Error;

/// Most mistakes that are listed.
const LISTED: usize = 20;
/// Most mistakes that are sought.
const SOUGHT: usize = 1000;
/// Most characters of a text of the user that a message repeats.
const SHOWN: usize = 200;

/// Collects mistakes with their places.
pub(crate) struct Problems<'a> {
    path: &'a Path,
    overrides: &'a [String],
    /// What stands in front of each message.
    context: String,
    list: BTreeSet<(Origin, String)>,
}

impl<'a> Problems<'a> {
    pub fn new(path: &'a Path, overrides: &'a [String]) -> Self {
        Problems { path, overrides, context: String::new(), list: BTreeSet::new() }
    }

    /// No mistakes yet, of a part of the same file that messages begin with.
    pub fn within(&self, part: &str) -> Self {
        let context = format!("{part}: ");
        Problems { path: self.path, overrides: self.overrides, context, list: BTreeSet::new() }
    }

    /// No mistakes yet, of the same file.
    pub fn anew(&self) -> Self {
        Problems::new(self.path, self.overrides)
    }

    /// Adds a mistake at a known place.
    pub fn at(&mut self, origin: Origin, text: String) {
        if !self.is_full() {
            self.list.insert((origin, format!("{}{text}", self.context)));
        }
    }

    /// Whether so much is wrong that the rest need not be looked at.
    pub fn is_full(&self) -> bool {
        self.list.len() >= SOUGHT
    }

    /// Adds a mistake at the place of a dotted path; the message is `PATH REASON`.
    pub fn add(&mut self, tree: &Node, path: &str, reason: impl std::fmt::Display) {
        self.at(tree.locate(path), format!("{path} {reason}"));
    }

    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// One line for each mistake, in the order of the file, then of the overrides. What a program
    /// has built has no places, only dotted paths.
    pub fn into_error(self) -> Error {
        let more = self.list.len().saturating_sub(LISTED);
        let mut lines: Vec<String> = self
            .list
            .iter()
            .take(LISTED)
            .map(|(origin, text)| match origin {
                Origin::File(line, column) => {
                    format!("{}:{line}:{column}: {text}", self.path.display())
                }
                Origin::Override(number) => {
                    format!("--set {}: {text}", shortened(&self.overrides[*number]))
                }
                Origin::Code(_) => text.clone(),
            })
            .collect();
        if more > 0 {
            let least = if self.is_full() { "at least " } else { "" };
            lines.push(format!("and {least}{more} more"));
        }
        Error::Input(lines.join("\n"))
    }
}

/// The beginning of what was written, for messages.
pub(crate) fn shortened(text: &str) -> String {
    let shown: String = text.chars().take(SHOWN).collect();
    let more = if shown.len() < text.len() { "..." } else { "" };
    format!("{shown}{more}")
}

/// The known name that a misspelt one most likely means.
pub(crate) fn nearest<'a>(name: &str, known: &'a [String]) -> Option<&'a String> {
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
pub(crate) fn suggestion(name: &str, known: &[String]) -> String {
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
