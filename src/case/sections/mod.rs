//! The sections of a case: as they are written, and the types that come of them.

mod boundary;
pub(super) mod file;
mod interface;
mod material;
mod mesh;
mod output;
pub(super) mod quantity;
mod solver;

pub use boundary::{BoundarySpec, Surface};
pub use interface::{FilmSpec, InterfaceSpec, Side};
pub use material::{Material, Porous};
pub use mesh::{Cells, Formulation, MeshSpec};
pub use output::{Expectation, Fields, OutputSpec, Probe};
pub use solver::{Form, Linear, Reduce, SolverSpec, Stability};
