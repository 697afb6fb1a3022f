//! The nodes of the pore pressure.

use crate::mesh::LocalMesh;
use crate::space::PrescribedPressure;

/// Where pressures stand and which of them are prescribed.
pub(in crate::solve) struct Pressures<'a> {
    /// The mesh with cells of first order.
    pub corners: &'a LocalMesh,
    /// What the case prescribes.
    pub prescribed: &'a PrescribedPressure,
}
