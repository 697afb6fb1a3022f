//! The nonlinear solution: from one instant to the next.
//!
//! The folders stand in the order in which they are built on each other.

pub mod model;
mod guess;
mod problem;
mod stability;
mod flow;
mod stepping;
mod levels;
mod setup;
mod state;
mod settle;
mod handover;

pub use flow::{Coupling, Flow, FluidBalance};
pub use handover::Handover;
pub use model::{
    BoundaryValueProblem, Freedom, InterfaceState, LinearChoice, MULTIGRID, NodeResponse,
};
pub use model::{check_fit, divides, family, starts, strength_factors};
pub use problem::{Energy, KnownPressure, PlatenSystem, Problem, reactions};
pub use setup::{Model, build};
pub use stability::{Instability, Stability};
pub use state::State;
pub use stepping::{Accepted, Bifurcation, MOST_COUNTED, StepState, Stepper};
