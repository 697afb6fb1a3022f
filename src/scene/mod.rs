//! The scene as it is seen: the mesh with its supports and loads, deformed shapes, maps of
//! interfaces, of cells of any kinds, as pictures that need nothing else.
//!
//! Everything here is local: one rank draws what is in an output directory.

mod bands;
mod boundary;
mod cover;
mod drawing;
mod features;
mod instants;
mod labels;
mod levels;
mod lines;
mod maps;
mod model;
mod paint;
mod picture;
pub mod plot;
mod quantity;
mod raster;
mod stage;
mod shape;
mod skin;
mod svg;
mod symbols;
mod thin;
mod vector;
mod view;
mod whole;

pub(crate) use picture::Picture;
pub(crate) use svg::dark_rules;
pub(crate) use whole::{Pictures, pictures};

#[cfg(test)]
mod tests;
