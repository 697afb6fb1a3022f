//! The bulk: linear elasticity of the cells, and the loads on them.

mod elastic;
mod loads;
mod modal;

pub use elastic::{Elastic, Stiffness};
pub use loads::Loads;
pub use modal::{MODES, Modal, couples, partner};
