//! Interfaces: which side carries the multipliers, and the jump as rows over nodal values.

mod jump;
pub mod mortar;
mod sides;

pub use jump::{JumpRow, JumpRows, jump_rows};
pub use sides::Sides;
