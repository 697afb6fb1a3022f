//! The nonlinear solution: from one instant to the next.

mod condensed;
mod convergence;
mod eigen;
mod energy;
mod imperfection;
mod interfaces;
mod linear;
pub mod memory;
mod path;
mod problem;
mod recycle;
mod rigid;
mod saddle;
mod setup;
mod stability;
mod state;
mod stepping;

pub use energy::Energy;
pub use imperfection::strength_factors;
pub use interfaces::{InterfaceState, NodeResponse};
pub use linear::{LinearChoice, MULTIGRID};
pub use problem::Problem;
pub use setup::{Model, build};
pub use stability::{Instability, Stability};
pub use state::{MOST_COUNTED, StepState};
pub use stepping::{Accepted, Bifurcation, Stepper};
