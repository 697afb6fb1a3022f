//! What the checks of all sections share.

use std::collections::BTreeSet;

use crate::input::problems::Problems;
use crate::input::tree::Node;

/// A case that is being checked: its tree, and the mistakes so far.
pub(crate) struct Checker<'a> {
    pub tree: &'a Node,
    pub problems: Problems<'a>,
    /// Sections that could not be read and hold placeholders.
    pub broken: BTreeSet<String>,
    /// 2 or 3.
    pub dim: usize,
    pub left_out: Vec<String>,
}

impl Checker<'_> {
    pub fn add(&mut self, path: &str, reason: impl std::fmt::Display) {
        self.problems.add(self.tree, path, reason);
    }

    /// Whether all these sections hold what the file says.
    pub fn sound(&self, sections: &[&str]) -> bool {
        sections.iter().all(|section| !self.broken.contains(*section))
    }
}
