//! The JSON Schema of the case file.
//!
//! The schema that editors get is the one that the reader obeys, so the two cannot drift apart.

use std::collections::BTreeSet;
use std::sync::LazyLock;

use super::sections::file::CaseFile;
use crate::input::problems::Problems;
use crate::input::schema::{check_against, schema_of};
use crate::input::tree::Node;

/// The JSON Schema (draft 2020-12) of the case file.
pub fn schema() -> serde_json::Value {
    SCHEMA.clone()
}

static SCHEMA: LazyLock<serde_json::Value> = LazyLock::new(schema_of::<CaseFile>);

/// Checks a tree against the schema, takes unknown and repeated keys out of it, and returns the
/// sections that cannot be read.
pub(super) fn check(tree: &mut Node, problems: &mut Problems) -> BTreeSet<String> {
    check_against(&SCHEMA, "the case", tree, problems)
}
