//! Who owns which node, the numbering of the unknowns, and the prescribed values.
//!
//! Every node carries as many displacement components as the problem has dimensions, prescribed or
//! not: blocks stay whole. Owned nodes stand first in every local array, ghosts follow.

/// The share of each end in the displacement of a node in the middle of an edge, where ends have
/// one: see `assembly::Frames`.
pub const SHARE_OF_END: f64 = 0.2;

mod directory;
mod node_frame;
mod node_unknowns;
mod nodes;
mod prescribed;
mod pressure;
mod supports;

pub use directory::Directory;
pub use node_frame::{CARTESIAN, Rotation, tangents};
pub use node_unknowns::{SpecialNode, SupportTerm, check_directions, special_nodes};
pub use nodes::Nodes;
pub use prescribed::{AtNode, Given, Prescribed};
pub use pressure::PrescribedPressure;
pub use supports::{PlatenTerm, Supports};
