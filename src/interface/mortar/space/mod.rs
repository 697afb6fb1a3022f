//! Facets anywhere in space: how those of two sides overlap, and the rows of their jump.
//!
//! Order of use: [`candidates_in_space`] for the pairs, then [`facet_rows_in_space`] per secondary
//! facet; where the two sides have the same facets and it is known which ([`Partners::Twin`]),
//! only the latter. [`nodal_normals`] gives the frames.

mod vector;
mod facet;
mod plane;
mod pieces;
mod overlap;
mod integrate;
mod candidates;
mod normals;

pub use candidates::candidates_in_space;
pub use facet::SpaceFacet;
pub use integrate::{Partners, Share, SpaceRows, facet_rows_in_space};
pub use normals::nodal_normals;

#[cfg(test)]
mod tests;
