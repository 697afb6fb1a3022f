//! Meshes from files made whole: checked, in SI units, raised to full kinds of cells, refined,
//! given their materials, and cut along their interfaces.
//!
//! In: what a reader found in a file ([`FileMesh`](super::import::FileMesh)) and what a case asks
//! of it ([`Request`]). Out: a [`WholeMesh`] on the rank that asked. Nothing here communicates.
//! Every step takes linear time in the number of cells, up to a logarithm.

mod buckets;
mod facet;
mod types;
mod view;
mod words;
mod request;
mod cells;
mod raise;
mod refine;
mod facets;
mod groups;
mod materials;
mod jacobian;
mod orient;
mod plan;
mod doubled;
mod cut;
mod divide;
mod normals;
mod lips;
mod surfaces;
mod bodies;
mod box_tree;
mod touching;
mod build;
mod across;
mod digest;
mod dual;
mod hinges;
#[cfg(test)]
mod tests;

pub use across::facing;
pub use build::{Keep, build, nested};
pub use digest::digest;
pub use dual::dual_graph;
pub use facet::WholeFacet;
pub use normals::{area, surface_normals};
pub use refine::{Parent, reference_points};
pub use request::{InterfacePlace, InterfaceRequest, MaterialGroups, Request};
pub use types::{Facing, MAX_FACET_NODES, WholeInterface, WholeMesh, WholeSurface};
