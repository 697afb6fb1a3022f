//! Prisms: the triangle of two coordinates along [-1, 1] in the third; products of the polynomials
//! of both.
//!
//! The nodes are right-handed: the normal of the first three points to the other three. So have it
//! files of Gmsh and VTK's interpolation of wedges (their volume is positive since VTK 9.7); what
//! VTK's page says of the linear wedge is the other way round.

use super::{cube, simplex};

#[rustfmt::skip]
const POINTS: [[f64; 3]; 18] = [
    [0.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 1.0, -1.0],
    [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0],
    [0.5, 0.0, -1.0], [0.5, 0.5, -1.0], [0.0, 0.5, -1.0],
    [0.5, 0.0, 1.0], [0.5, 0.5, 1.0], [0.0, 0.5, 1.0],
    [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0],
    [0.5, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 0.5, 0.0],
];

/// The node of the triangle above or below which each node stands.
const OF_TRIANGLE: [usize; 18] = [0, 1, 2, 0, 1, 2, 3, 4, 5, 3, 4, 5, 0, 1, 2, 3, 4, 5];

/// Nodes of second order; those of first order are the first six.
pub const fn points() -> &'static [[f64; 3]] {
    &POINTS
}

/// Local nodes of each facet: the triangles at the bottom and at the top, then the quadrilaterals.
pub const fn facets(order: usize) -> &'static [&'static [usize]] {
    if order == 1 {
        &[&[0, 2, 1], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]]
    } else {
        &[
            &[0, 2, 1, 8, 7, 6],
            &[3, 4, 5, 9, 10, 11],
            &[0, 1, 4, 3, 6, 13, 9, 12, 15],
            &[1, 2, 5, 4, 7, 14, 10, 13, 16],
            &[2, 0, 3, 5, 8, 12, 11, 14, 17],
        ]
    }
}

/// The nodal basis, for all of `out`.
#[inline]
pub fn values(order: usize, xi: [f64; 3], out: &mut [f64]) {
    let mut triangle = [0.0; 6];
    simplex::values(2, order, xi, &mut triangle[..of_triangle(order)]);
    for (value, (node, i)) in out.iter_mut().zip(POINTS.iter().zip(OF_TRIANGLE)) {
        *value = triangle[i] * cube::along(order, node[2], xi[2]);
    }
}

/// Its derivatives, for all of `out`.
#[inline]
pub fn gradients(order: usize, xi: [f64; 3], out: &mut [[f64; 3]]) {
    let (mut triangle, mut slopes) = ([0.0; 6], [[0.0; 3]; 6]);
    simplex::values(2, order, xi, &mut triangle[..of_triangle(order)]);
    simplex::gradients(2, order, xi, &mut slopes[..of_triangle(order)]);
    for (gradient, (node, i)) in out.iter_mut().zip(POINTS.iter().zip(OF_TRIANGLE)) {
        let along = cube::along(order, node[2], xi[2]);
        let [x, y, _] = slopes[i];
        *gradient = [x * along, y * along, triangle[i] * cube::slope(order, node[2], xi[2])];
    }
}

/// Nodes of the triangle.
const fn of_triangle(order: usize) -> usize {
    3 * order
}
