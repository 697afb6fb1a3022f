//! Smoothed aggregation: algebraic multigrid that knows the rigid motions.
//!
//! Strongly coupled nodes form aggregates. The motions of an aggregate, smoothed once, are the
//! basis of the next coarser level, whose matrix is that of the finer one between them (Vanek,
//! Mandel and Brezina, Computing 56, 1996). Each level is set up in double precision. The cycles
//! run in single precision with blocks in the place of entries: they are bound by the memory they
//! read.

mod aggregates;
mod by_columns;
mod coarsest;
mod cycle;
mod galerkin;
mod prolongation;
mod setup;
mod smoother;

pub use cycle::Aggregation;
pub use prolongation::Motions;
