//! Interfaces: which side carries the multipliers, the jump as rows over nodal values, and the film
//! of fluid between the lips.

mod cohesive_zone;
mod facet_terms;
mod film;
mod heirs;
#[cfg(test)]
mod inf_sup_tests;
mod jump;
pub mod mortar;
mod sides;

pub use cohesive_zone::{FEWEST, unresolved_zones, zone_length};
pub use film::{Film, FilmState, Fluid};
pub use heirs::{Heirs, Multipliers, lost_facets};
pub use jump::{JumpRow, JumpRows, jump_rows};
pub use sides::Sides;
