//! Lattices: bodies stacked along z, each a box of boxes.
//!
//! Cells and nodes are named by numbers that follow from their place in the lattice, so that a
//! refined mesh needs no numbering of its own.

mod coarsen;
mod column;
mod fill;
mod grading;
mod graph;
mod nodes;

pub use column::{CellPlace, Column};
pub use nodes::NodePlace;
