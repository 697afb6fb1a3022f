//! Meshes: what is known of the whole one, the nested levels of it, and the part of each that a
//! rank holds, as arrays.
//!
//! The two sides of an interface never share a node. A name of a cell or node means the same on
//! every rank, on any number of ranks. Only this module and `reduce` know that there are lattices.

mod facts;
mod family;
mod lattice;
mod local;
mod marks;

pub use facts::{DualGraph, LipFacts, MeshFacts};
pub use family::MeshFamily;
pub use lattice::{CellPlace, Column, NodePlace};
pub use local::{Facet, FarFacet, Interpolation, LocalMesh, Places, Prototype};
pub use marks::{Lip, Marks};

/// The coordinate axes of the displacement components: x, z in 2D and x, y, z in 3D.
pub fn axes(dim: usize) -> &'static [usize] {
    if dim == 2 { &[0, 2] } else { &[0, 1, 2] }
}
