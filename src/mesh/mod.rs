//! Meshes: what is known of the whole one, the nested levels of it, and the part of each that a
//! rank holds, as arrays.
//!
//! The two sides of an interface never share a node. A name of a cell or node means the same on
//! every rank, on any number of ranks. Only this module and `reduce` know that there are lattices.

mod directions;
mod facts;
mod family;
mod first_order;
pub mod import;
mod lattice;
mod local;
mod locate;
mod marks;
mod nested;
mod parts;
mod prototype;
pub mod slabs;
pub mod whole;

pub use crate::case::column_axes as axes;
pub use directions::{Directions, LipNormal, MidNode, SurfaceNormal};
pub use facts::{DualGraph, HingeNode, Hinges, Joint, LipFacts, MeshFacts};
pub use family::{MeshFamily, is_med, request};
pub use lattice::{CellPlace, Column, NodePlace};
pub use local::{Facet, FarFacet, Interpolation, LocalMesh, Places};
pub use marks::{Lip, Marks};
pub use prototype::{Geometry, Prototype};
