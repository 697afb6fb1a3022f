//! Interfaces: which side carries the multipliers, and the jump as rows over nodal values.

#[cfg(test)]
mod inf_sup_tests;
mod jump;
pub mod mortar;
mod sides;

pub use jump::{JumpRow, JumpRows, jump_rows};
pub use sides::Sides;
