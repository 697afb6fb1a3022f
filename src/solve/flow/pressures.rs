//! The nodes of the pore pressure, and those of the displacements that it acts on.

use std::rc::Rc;

use crate::assembly::Discretization;
use crate::case::Case;
use crate::interface::Sides;
use crate::mesh::LocalMesh;
use crate::space::PrescribedPressure;

/// Where pressures stand and which of them are prescribed.
pub(in crate::solve) struct Pressures<'a> {
    /// The mesh with cells of first order.
    pub corners: &'a LocalMesh,
    /// What the case prescribes.
    pub prescribed: &'a PrescribedPressure,
}

/// The discretisation of the displacements.
#[derive(Clone, Copy)]
pub struct Displacements<'a> {
    /// The cells of this rank.
    pub mesh: &'a LocalMesh,
    /// Cells, nodes, rows.
    pub all: &'a Rc<Discretization>,
    /// The sides of the interfaces.
    pub sides: &'a [Sides],
    /// Gaps at the owned secondary nodes before anything moves (m).
    pub gaps: &'a [f64],
}

/// Interfaces along which fluid flows.
pub(super) fn flowing<'a>(
    case: &'a Case,
    sides: &'a [Sides],
) -> impl Iterator<Item = (usize, &'a Sides)> {
    sides.iter().enumerate().filter(|(index, _)| case.interfaces[*index].film.is_some())
}
