//! The nonlinear solution: from one instant to the next.

mod condensed;
mod convergence;
mod coupled;
mod eigen;
mod energy;
mod flow;
mod flow_setup;
mod imperfection;
mod interfaces;
mod known_pressure;
mod linear;
pub mod memory;
mod pace;
mod path;
mod problem;
mod recycle;
mod rigid;
mod saddle;
mod setup;
mod stability;
mod state;
mod stepping;
mod whole;

pub use coupled::Coupling;
pub use energy::Energy;
pub use flow::{Flow, FluidBalance};
pub use imperfection::strength_factors;
pub use interfaces::{InterfaceState, NodeResponse};
pub use known_pressure::KnownPressure;
pub use linear::{LinearChoice, MULTIGRID};
pub use problem::Problem;
pub use setup::{Model, build};
pub use stability::{Instability, Stability};
pub use state::{MOST_COUNTED, State, StepState};
pub use stepping::{Accepted, Bifurcation, Stepper};
