//! Meshes made in code, and those of the readers' tests.

mod blocks;
mod checks;
mod coarsening;
mod cutting;
mod dividing;
mod files;
mod graph;
mod looks;
mod orienting;
mod raising;
mod refining;
mod sides;
