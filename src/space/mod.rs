//! Who owns which node, the numbering of the unknowns, and the prescribed values.
//!
//! Every node carries as many displacement components as the problem has dimensions, prescribed or
//! not: blocks stay whole. Owned nodes stand first in every local array, ghosts follow.

mod directory;
mod nodes;
mod prescribed;
mod pressure;

pub use directory::Directory;
pub use nodes::Nodes;
pub use prescribed::{AtNode, Prescribed};
pub use pressure::PrescribedPressure;
