//! What the coupling of facets in space must reproduce.

mod curved;
mod invariance;
mod partial;
mod patch;
mod surfaces;
