//! What is solved: the discrete problem, the state of its interfaces, and the choice of solvers.

mod boundary_value_problem;
mod imperfection;
pub(in crate::solve) mod interfaces;
pub(in crate::solve) mod linear;
pub mod memory;

pub use boundary_value_problem::BoundaryValueProblem;
pub(in crate::solve) use boundary_value_problem::discretize;
pub use imperfection::strength_factors;
pub use interfaces::{InterfaceState, NodeResponse};
pub use linear::{LinearChoice, MULTIGRID};
