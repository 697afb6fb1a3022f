//! The mesh of a column: a lattice of boxes per body, and the part of it that a rank holds.
//!
//! Bodies are separate lattices: the two sides of an interface never share a node. Cells and nodes
//! are named by numbers that follow from their place in the lattice, so a name means the same on
//! every rank, on any number of ranks, and a refined mesh needs no numbering of its own.

mod coarsen;
mod column;
mod local;
mod nodes;

pub use column::{CellPlace, Column, Facets, Layer};
pub use local::{LocalMesh, Prototype};
pub use nodes::{NodePlace, Surfaces};

/// The coordinate axes of the displacement components: x, z in 2D and x, y, z in 3D.
pub fn axes(dim: usize) -> &'static [usize] {
    if dim == 2 { &[0, 2] } else { &[0, 1, 2] }
}
