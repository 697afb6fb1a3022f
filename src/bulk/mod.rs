//! The bulk: linear elasticity of the cells, the fluid in their pores, and the loads on them.

mod elastic;
mod loads;
mod modal;
mod parity;
mod porous;

pub use elastic::{Elastic, SplitForm, Stiffness};
pub use loads::Loads;
pub use modal::{MODES, Modal, couples, partner};
pub use parity::{Block, MOST_ROWS, Parity, lattice_places};
pub use porous::{FlowStep, MAX_CORNERS, PorousCell, PorousMedium};
