//! Forces of several like cells of any geometry at once: the sweep over the cells without a matrix.
//!
//! Every array holds a number of each cell of a batch side by side, as wide as the processor's
//! vectors. Simplices with straight sides keep their Jacobian; the others work it out at every
//! point from the positions of their nodes.

mod basis;
mod dense;
mod group;
mod isoparametric;
mod lanes;
mod straight;
#[cfg(test)]
mod speed;
#[cfg(test)]
mod testkit;
#[cfg(test)]
mod tests;

use basis::{Corners, Table};
pub use group::Field;
use group::{Group, Pass};
use isoparametric::Isoparametric;
use straight::Straight;

use crate::bulk::General;
use crate::element::{MAX_NODES, Shape};
use crate::simd::{has_wide_vectors, wide};

/// A set of cells in batches.
#[derive(Default)]
pub struct GeneralSweep {
    groups: Vec<Group>,
}

/// Index of a prototype, and whether the cells are straight.
type Kind = (u32, bool);

impl GeneralSweep {
    /// Puts cells into batches: each has the nodes of its shape and the index of its prototype,
    /// whose stiffness `general` gives. `points` are the positions of the local nodes (m).
    pub fn new<'a, 'g>(
        general: impl Fn(u32) -> &'g General,
        points: &[[f64; 3]],
        cells: impl Iterator<Item = (&'a [u32], u32)>,
    ) -> Self {
        let mut lists: Vec<(Kind, Vec<&[u32]>)> = Vec::new();
        let mut own = [[0.0; 3]; MAX_NODES];
        for (nodes, prototype) in cells {
            own.iter_mut().zip(nodes).for_each(|(x, node)| *x = points[*node as usize]);
            let key = (prototype, general(prototype).is_straight(&own[..nodes.len()]));
            match lists.iter_mut().find(|(of, _)| *of == key) {
                Some((_, list)) => list.push(nodes),
                None => lists.push((key, vec![nodes])),
            }
        }
        let group = |((prototype, is_straight), mut list): (Kind, Vec<&[u32]>)| {
            // Cells with nodes close by in memory follow one another.
            list.sort_by_key(|nodes| nodes.iter().min().copied());
            Group::new(prototype, is_straight.then_some(points), &list)
        };
        Self { groups: lists.into_iter().map(group).collect() }
    }

    /// Adds the forces K u of the cells to `force` (N, `dim` numbers per local node), in two parts:
    /// those of the first nodes, then those of the others. `general` gives the stiffness of a
    /// prototype. `magnitude` gets the sum of the lengths of the cells' nodal forces, one per local
    /// node. Local.
    pub fn add_forces<'g>(
        &self,
        general: impl Fn(u32) -> &'g General,
        field: Field<'_>,
        [first, others]: [&mut [f64]; 2],
        mut magnitude: Option<&mut [f64]>,
    ) {
        for group in &self.groups {
            run(Pass {
                group,
                general: general(group.prototype),
                field,
                force: [&mut *first, &mut *others],
                magnitude: magnitude.as_deref_mut(),
            });
        }
    }
}

/// Runs a pass by the form of its cells.
fn run(pass: Pass<'_>) {
    if !has_wide_vectors() {
        return dense::run(pass);
    }
    let shape = pass.general.shape();
    match (shape, pass.group.is_straight) {
        (Shape::Tri3, _) => wide(Straight::<2, 3, 3>(pass)),
        (Shape::Tri6, true) => wide(Straight::<2, 3, 6>(pass)),
        (Shape::Tet4, _) => wide(Straight::<3, 4, 4>(pass)),
        (Shape::Tet10, true) => wide(Straight::<3, 4, 10>(pass)),
        (Shape::Quad4, _) => wide(Isoparametric::<Corners, 2, 4, 4>::new(pass)),
        (Shape::Hex8, _) => wide(Isoparametric::<Corners, 3, 8, 8>::new(pass)),
        // One code for many shapes: compiled for each, it took minutes and was no faster.
        (Shape::Tri6 | Shape::Quad9, _) => wide(Isoparametric::<Table, 2, 9, 9>::new(pass)),
        (Shape::Tet10 | Shape::Prism6 | Shape::Prism18 | Shape::Pyramid5 | Shape::Hex27, _) => {
            wide(Isoparametric::<Table, 3, 27, 27>::new(pass));
        }
        (Shape::Line2 | Shape::Line3, _) => unreachable!("a line fills no body"),
    }
}
