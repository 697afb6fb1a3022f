//! The bulk: linear elasticity of the cells, and the loads on them.

mod elastic;
mod loads;

pub use elastic::{Elastic, Stiffness};
pub use loads::Loads;
