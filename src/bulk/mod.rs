//! The bulk: linear elasticity of the cells, and the loads on them.

mod elastic;
mod loads;
mod modal;
mod parity;

pub use elastic::{Elastic, SplitForm, Stiffness};
pub use loads::Loads;
pub use modal::{MODES, Modal, couples, partner};
pub use parity::{Block, MOST_ROWS, Parity, lattice_places};
