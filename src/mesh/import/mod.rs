//! Meshes from files of other programs: read as they are, neither repaired nor cut.

mod file_mesh;
mod order;
mod slab;
pub mod gmsh;
pub mod med;

pub use file_mesh::{Block, FileMesh, Group, Kind};
pub use slab::{Elements, GroupSet, NodeRows, Pieces, SetOfTags};
