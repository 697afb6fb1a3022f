//! Dual mortar coupling of the two sides of an interface: geometry and coefficients.
//!
//! In: facets of the secondary side (it carries the multipliers) and of the primary side, given by
//! node identities and positions, and the multipliers to leave out.
//! Out: for each multiplier node i the integrals of its basis function Phi_i against the traces of
//! both sides, whose difference is the weighted jump
//! $g_i = \sum_k u_k \int\Phi_i N_k - \sum_l u_l \int\Phi_i N_l\circ\chi$.
//! Everything is computed once (small strains), is pure, and is local: no communication.
//!
//! There are two ways to it. Interfaces of boxes are planes that both sides fill: [`PlaneFacet`]s,
//! lines and quadrilaterals in the plane. All others have [`SpaceFacet`]s: lines, triangles and
//! quadrilaterals in space, plane or curved, on sides that need not cover each other.
//!
//! Order of use: [`fn@candidates`] or [`candidates_in_space`] for the pairs, then [`facet_rows`] or
//! [`facet_rows_in_space`] per secondary facet; sum the [`Contribution`]s of a node over its
//! facets, and divide by the summed diagonal for P = D^-1 M.
//! Invariants: across planes the rows reproduce the polynomials of either side's order for any pair
//! of meshes with straight edges, linear ones for any; sum over primary = sum over secondary =
//! weight; matching facets give a permutation to the last bit.

mod candidates;
mod dual;
mod edges;
mod facet;
mod integrate;
mod polygon;
mod rows;
mod segments;
mod space;

use crate::element::Shape;

pub use candidates::candidates;
pub use dual::DualBasis;
pub use edges::EdgeBasis;
pub use facet::PlaneFacet;
pub use integrate::facet_rows;
pub use rows::Contribution;
pub use segments::{SegmentPoint, matching_nodes, overlap};
pub use space::{
    Partners, Share, SpaceFacet, SpaceRows, candidates_in_space, facet_rows_in_space, nodal_normals,
};

/// Nodes of the facet that has most.
const MOST_NODES: usize = Shape::Quad9.nodes();

#[cfg(test)]
mod dual_tests;
#[cfg(test)]
mod patch_tests;
