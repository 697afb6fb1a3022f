//! Boxes of like cells of first order, whose product with a vector is gathered node by node.
//!
//! They are found by the nodes that cells share: lines of like cells along x, lines side by side
//! along y, and layers above one another along z, each of cells of its own. What belongs to no box
//! of some size is left to the sweep over the cells.

mod find;
mod product;
mod stencil;
#[cfg(test)]
mod tests;

use std::cell::RefCell;
use std::rc::Rc;

use crate::bulk::Modal;
use crate::simd::{self, widest};
use crate::sparse::Real;
use find::Found;
use product::{InLanes, Product, Room, Runs};
use stencil::Stencil;

/// Numbers whose products with boxes are compiled.
pub trait Scalar: Real {
    /// Does a product with one box.
    fn multiply(product: Product<'_, Self>);
}

impl Scalar for f64 {
    fn multiply(product: Product<'_, Self>) {
        if simd::is_fused() {
            widest(InLanes::<_, 4, true>(product));
        } else {
            widest(InLanes::<_, 4, false>(product));
        }
    }
}

impl Scalar for f32 {
    fn multiply(product: Product<'_, Self>) {
        if simd::is_fused() {
            widest(InLanes::<_, 8, true>(product));
        } else {
            widest(InLanes::<_, 8, false>(product));
        }
    }
}

/// The boxes of a set of cells in 3D.
#[derive(Default)]
pub struct Boxes<T> {
    boxes: Vec<(Stencil<T>, Rc<Runs>)>,
    room: RefCell<Room<T>>,
}

impl Boxes<f64> {
    /// Finds them among cells with 8 local nodes and the index of their prototype each, whose
    /// modal form `modal` gives; and tells of each cell whether it is in a box.
    pub fn new<'c, 'm>(
        cells: impl Iterator<Item = (&'c [u32], u32)>,
        modal: impl Fn(u32) -> &'m Modal,
    ) -> (Self, Vec<bool>) {
        let (found, is_in_box) = Found::among(cells);
        let of = |found: Found| {
            let Found { across, layers, runs } = found;
            (Stencil::new(across, &layers, &modal), Rc::new(runs))
        };
        let boxes = found.into_iter().map(of).collect();
        (Self { boxes, room: RefCell::default() }, is_in_box)
    }
}

impl Boxes<f64> {
    /// The same in single precision.
    pub fn to_single(&self) -> Boxes<f32> {
        let single =
            |(stencil, runs): &(Stencil<f64>, Rc<Runs>)| (stencil.to_single(), Rc::clone(runs));
        Boxes { boxes: self.boxes.iter().map(single).collect(), room: RefCell::default() }
    }
}

impl<T: Scalar> Boxes<T> {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.boxes.is_empty()
    }

    /// Adds the forces K u to those at the first nodes, then at the others (N); 3 numbers per local
    /// node. Local.
    pub fn add_forces(&self, u: &[T], force: [&mut [T]; 2]) {
        let room = &mut *self.room.borrow_mut();
        let [first, others] = force.map(|part| part.as_chunks_mut::<3>().0);
        for (stencil, runs) in &self.boxes {
            let u = u.as_chunks::<3>().0;
            let force = [&mut *first, &mut *others];
            T::multiply(Product { stencil, runs, u, force, room: &mut *room });
        }
    }
}
