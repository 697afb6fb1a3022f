//! What is solved: the discrete problem, the state of its interfaces, and the choice of solvers.

mod boundary_value_problem;
mod division;
mod fit;
mod gaps;
pub(crate) mod held_bodies;
mod imperfection;
mod initial;
mod initial_stress;
pub(in crate::solve) mod interfaces;
pub(in crate::solve) mod linear;
pub mod memory;
mod node_law;
mod origin;
mod way;
pub(in crate::solve) mod sliding;
pub(in crate::solve) mod near_null_space;
pub(in crate::solve) mod platens;
mod special;
mod special_by_name;

pub use boundary_value_problem::BoundaryValueProblem;
pub(in crate::solve) use boundary_value_problem::{cells, discretize};
pub use division::{divides, family};
pub use fit::check_whole as check_fit;
pub(in crate::solve) use fit::has_lost_facets;
pub use gaps::NodeData;
pub(in crate::solve) use gaps::{gaps, gaps_in_words};
pub use imperfection::strength_factors;
pub(in crate::solve) use initial::places;
pub use initial::starts;
pub use initial_stress::StressAtStart;
pub use interfaces::{InterfaceState, NodeResponse};
pub use linear::{LinearChoice, MULTIGRID};
pub(in crate::solve) use origin::Left;
pub use platens::{Freedom, Platens};
