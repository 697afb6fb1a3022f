//! Dual mortar coupling of the two sides of a planar interface: geometry and coefficients.
//!
//! In: facets of the secondary side (it carries the multipliers) and of the primary side, given by
//! node identities and positions in the plane of the interface, and the multipliers to leave out.
//! Out: for each multiplier node i the integrals of its basis function Phi_i against the traces of
//! both sides, whose difference is the weighted jump
//! $g_i = \sum_k u_k \int\Phi_i N_k - \sum_l u_l \int\Phi_i N_l\circ\chi$.
//! Everything is computed once (small strains), is pure, and is local: no communication.
//!
//! Order of use: [`fn@candidates`] for the pairs, then [`facet_rows`] per secondary facet; sum the
//! [`Contribution`]s of a node over its facets, and divide by the summed diagonal for P = D^-1 M.
//! Invariants: the rows reproduce the polynomials of either side's order for any pair of meshes;
//! sum over primary = sum over secondary = weight; matching facets give a permutation to the last
//! bit.

mod candidates;
mod dual;
mod facet;
mod integrate;
mod segments;

use crate::element::Shape;

pub use candidates::candidates;
pub use dual::DualBasis;
pub use facet::PlaneFacet;
pub use integrate::{Contribution, facet_rows};
pub use segments::{SegmentPoint, matching_nodes, overlap};

/// Nodes of the facet that has most.
const MOST_NODES: usize = Shape::Quad9.nodes();

#[cfg(test)]
mod patch_tests;
