//! Files that people write: read as a tree that knows its lines, checked against a schema, with all
//! mistakes told at once. For cases, and for studies.

pub(crate) mod duration;
mod formula;
mod from_json;
pub(crate) mod problems;
pub(crate) mod schema;
pub(crate) mod text;
pub(crate) mod tree;
mod value;

pub use formula::Formula;
pub use value::Value;
