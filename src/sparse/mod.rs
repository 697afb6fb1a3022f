//! Sparse matrices of small dense blocks, shared out over the ranks by block rows.
//!
//! PETSc's AIJ keeps a column number for every entry; these keep one for every block, in either
//! precision, and give algebraic multigrid of our own their rows.

mod halo;
mod matrix;
mod product;
mod real;
mod rows;

pub use halo::Halo;
pub use matrix::BlockMatrix;
pub(crate) use product::with_sizes;
pub use product::{Gathered, times};
pub use real::Real;
pub use rows::{BlockRows, Row};
