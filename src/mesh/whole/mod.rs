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
mod along_axes;
mod named;
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
mod coarsen;
mod build;
mod across;
mod digest;
mod dual;
mod hinges;
#[cfg(test)]
mod tests;

pub(super) use across::facing_of_lips;
pub(super) use along_axes::lay_along_axes;
pub(super) use cells::{Cells, NONE as NO_MATE, check_copies, corner_count};
pub(super) use cut::{Copies, cut};
pub(super) use doubled::shortest_edges;
pub(super) use facets::{FacetTable, slot};
pub(super) use groups::Groups;
pub(super) use hinges::are_pinched;
pub(super) use jacobian::check_some as check_jacobians;
pub(super) use lips::make as make_interfaces;
pub(super) use materials::of_sets as materials_of_sets;
pub(super) use plan::{Known, Plan, plan};
pub(super) use raise::{Middles, middles, raise, shape_of};
pub(super) use surfaces::{Found as FoundSurface, find as find_surface, finish as finish_surface};
pub(super) use touching::check_bodies;

pub use across::facing;
pub use bodies::bodies;
pub use build::{Keep, build, nested};
pub use build::{is_stiff, locking};
pub use cells::{check_plane, check_size, orphans_of_cells};
pub use digest::{Digest, digest, facet as facet_number, shape_number};
pub use doubled::{Boxes, pairs_of_box};
pub use dual::{FACING, dual_graph};
pub use facet::WholeFacet;
pub use normals::{area, surface_normals};
pub use raise::raised;
pub use refine::{Parent, reference_points};
pub use request::{InterfacePlace, InterfaceRequest, MaterialGroups, Request};
pub use types::{Facing, MAX_FACET_NODES, WholeInterface, WholeMesh, WholeSurface};
