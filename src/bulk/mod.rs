//! The bulk: linear elasticity of the cells, the fluid in their pores, and the loads on them.

mod elastic;
mod rule;
mod dilatation;
mod general;
mod cell_stiffness;
mod initial_stress;
mod load_points;
mod loads;
mod modal;
mod parity;
mod poro_state;
mod porous;
mod porous_cell;

pub use cell_stiffness::CellStiffness;
pub use elastic::{Elastic, SplitForm, Stiffness};
pub use general::General;
pub use initial_stress::InitialStress;
pub use loads::Loads;
pub use modal::{MODES, Modal, couples, partner};
pub use parity::{Block, MOST_ROWS, Parity, lattice_places};
pub use poro_state::{BalanceSums, PoroState};
pub use porous::{PorousMedium, exp_m1_on_its_tangent};
pub use porous_cell::{CANCELLED, FlowStep, MAX_CORNERS, PorousCell};
pub use rule::RulePoint;
