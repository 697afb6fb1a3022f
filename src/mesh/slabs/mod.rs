//! Meshes of files that no rank holds whole.
//!
//! Every rank has some cells with those around them (`piece`), and all have the cells behind
//! surfaces and interfaces ([`Skeleton`]). What is decided around a node is decided where all its
//! cells are, and what is told of groups where all their facets are, by the code for whole meshes.
//! Names come out as they do there. Nothing here communicates.

mod head;
mod key;
mod local;
mod numbers;
mod piece;
mod skeleton;
mod skin;

pub use head::{Head, KindRange};
pub use key::{CENTRE, EDGE, FACE, Key};
pub use local::Part;
pub use numbers::Numbers;
pub use piece::{Given, Made, piece};
pub use skeleton::{Behind, Cut, Skeleton, Star, nodes_of};
pub use skin::Skin;
