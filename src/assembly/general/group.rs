//! Like cells in batches, and a pass over them.

#![allow(clippy::needless_range_loop)] // index notation, as in the formulas

use super::lanes::{LANES, to_lanes};
use crate::bulk::General;

/// What the forces are those of.
#[derive(Clone, Copy)]
pub struct Field<'a> {
    /// Positions of the local nodes by displacement component (m).
    pub points: &'a [[f64; 3]],
    /// Displacements, `dim` numbers per local node (m).
    pub u: &'a [f64],
}

/// Cells of one prototype that are all straight or all not.
pub struct Group {
    pub prototype: u32,
    pub is_straight: bool,
    pub cells: usize,
    /// Local nodes, by batch, node of the cell and cell; behind the last cell the first one of its
    /// batch stands again.
    pub nodes: Vec<u32>,
    /// Of straight cells: the inverse of the Jacobian (1/m), row by row, and the volume (m^dim), by
    /// batch, number and cell.
    pub geometry: Vec<f64>,
}

/// One pass over the cells of a group.
pub struct Pass<'s> {
    pub group: &'s Group,
    pub general: &'s General,
    pub field: Field<'s>,
    pub force: [&'s mut [f64]; 2],
    pub magnitude: Option<&'s mut [f64]>,
}

impl Group {
    /// `points` where the cells are straight.
    pub fn new(prototype: u32, points: Option<&[[f64; 3]]>, cells: &[&[u32]]) -> Self {
        let (mut nodes, mut geometry) = (Vec::new(), Vec::new());
        for batch in cells.chunks(LANES) {
            to_lanes(batch, |cell, a| cell[a], &mut nodes);
            if let Some(points) = points {
                let of = |cell: &&[u32]| straight_geometry(cell, points);
                let of: Vec<Vec<f64>> = batch.iter().map(of).collect();
                to_lanes(&of, |numbers, i| numbers[i], &mut geometry);
            }
        }
        Self { prototype, is_straight: points.is_some(), cells: cells.len(), nodes, geometry }
    }
}

/// The inverse of the Jacobian (1/m), row by row, and the volume (m^dim) of a simplex.
fn straight_geometry(nodes: &[u32], points: &[[f64; 3]]) -> Vec<f64> {
    let dim = if matches!(nodes.len(), 3 | 6) { 2 } else { 3 };
    let origin = points[nodes[0] as usize];
    let mut j = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    for d in 0..dim {
        let corner = points[nodes[d + 1] as usize];
        (0..dim).for_each(|i| j[i][d] = corner[i] - origin[i]);
    }
    let cofactor = |i: usize, d: usize| {
        let (i1, i2, d1, d2) = ((i + 1) % 3, (i + 2) % 3, (d + 1) % 3, (d + 2) % 3);
        j[i1][d1] * j[i2][d2] - j[i1][d2] * j[i2][d1]
    };
    let determinant: f64 = (0..3).map(|d| j[0][d] * cofactor(0, d)).sum();
    let inverse = (0..dim).flat_map(|d| (0..dim).map(move |i| (i, d)));
    let mut numbers: Vec<f64> = inverse.map(|(i, d)| cofactor(i, d) / determinant).collect();
    numbers.push(determinant / if dim == 2 { 2.0 } else { 6.0 });
    numbers
}
