//! Where linear solves start: what earlier corrections and rigid motions say of the next one.

pub(in crate::solve) mod energy_projection;
pub(in crate::solve) mod residual_projection;
pub(in crate::solve) mod rigid;
