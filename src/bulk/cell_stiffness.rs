//! The stiffness of like cells, boxes or not.

use super::{Elastic, General, Stiffness};
use crate::mesh::{Geometry, Prototype};

/// What gives the stiffness of the cells of one prototype.
#[derive(Debug, Clone)]
pub enum CellStiffness {
    /// Of boxes, which share one matrix.
    Box(Stiffness),
    /// Of other cells, from the positions of their nodes.
    General(General),
}

impl CellStiffness {
    /// Of the cells of a prototype, whose displacement components lie along `axes`; with `b_bar` as
    /// [`Stiffness::new`] and [`General::new`].
    pub fn new(
        prototype: &Prototype,
        elastic: Elastic,
        axes: &'static [usize],
        b_bar: bool,
    ) -> Self {
        let shape = prototype.shape;
        match prototype.geometry {
            Geometry::Box(size) => {
                CellStiffness::Box(Stiffness::new(shape, size, elastic, axes, b_bar))
            }
            Geometry::Points => CellStiffness::General(General::new(shape, elastic, axes, b_bar)),
        }
    }
}
