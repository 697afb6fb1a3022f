//! Triangles and tetrahedra with corners at the origin and at 1 on each axis: polynomials of the
//! barycentric coordinates, complete to the order.

#[rustfmt::skip]
const TRIANGLE: [[f64; 3]; 6] = [
    [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0],
    [0.5, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 0.5, 0.0],
];

#[rustfmt::skip]
const TETRAHEDRON: [[f64; 3]; 10] = [
    [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0],
    [0.5, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 0.5, 0.0],
    [0.0, 0.0, 0.5], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5],
];

/// The ends of the edges in the order of their middle nodes; a triangle has the first three.
const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Nodes of second order; those of first order are the first dim + 1.
pub const fn points(dim: usize) -> &'static [[f64; 3]] {
    if dim == 2 { &TRIANGLE } else { &TETRAHEDRON }
}

/// Local nodes of each facet. Tetrahedra: front (second coordinate 0), slanted, left, bottom.
pub const fn facets(dim: usize, order: usize) -> &'static [&'static [usize]] {
    match (dim, order) {
        (2, 1) => &[&[0, 1], &[1, 2], &[2, 0]],
        (2, _) => &[&[0, 1, 3], &[1, 2, 4], &[2, 0, 5]],
        (_, 1) => &[&[0, 1, 3], &[1, 2, 3], &[2, 0, 3], &[0, 2, 1]],
        _ => &[&[0, 1, 3, 4, 8, 7], &[1, 2, 3, 5, 9, 8], &[2, 0, 3, 6, 7, 9], &[0, 2, 1, 6, 5, 4]],
    }
}

/// The nodal basis, for all of `out`: the barycentric coordinates L_i, or L_i (2 L_i - 1) at the
/// corners and 4 L_i L_j at the middle of each edge.
#[inline]
pub fn values(dim: usize, order: usize, xi: [f64; 3], out: &mut [f64]) {
    let l = barycentric(dim, xi);
    let (corners, edges) = out.split_at_mut(dim + 1);
    for (value, l) in corners.iter_mut().zip(l) {
        *value = if order == 1 { l } else { l * (2.0 * l - 1.0) };
    }
    for (value, [i, j]) in edges.iter_mut().zip(EDGES) {
        *value = 4.0 * l[i] * l[j];
    }
}

/// Its derivatives, for all of `out`.
#[inline]
pub fn gradients(dim: usize, order: usize, xi: [f64; 3], out: &mut [[f64; 3]]) {
    let l = barycentric(dim, xi);
    let (corners, edges) = out.split_at_mut(dim + 1);
    for (i, gradient) in corners.iter_mut().enumerate() {
        let outer = if order == 1 { 1.0 } else { 4.0 * l[i] - 1.0 };
        *gradient = std::array::from_fn(|d| outer * slope(dim, i, d));
    }
    for (gradient, [i, j]) in edges.iter_mut().zip(EDGES) {
        let along = |d| 4.0 * (l[i] * slope(dim, j, d) + l[j] * slope(dim, i, d));
        *gradient = std::array::from_fn(along);
    }
}

/// L_0 of the origin, then those of the corners on the axes; zero beyond dim.
fn barycentric(dim: usize, xi: [f64; 3]) -> [f64; 4] {
    let [x, y, z] = xi;
    if dim == 2 { [1.0 - x - y, x, y, 0.0] } else { [1.0 - x - y - z, x, y, z] }
}

/// dL_i/dxi_d.
fn slope(dim: usize, i: usize, d: usize) -> f64 {
    match i {
        _ if d >= dim => 0.0,
        0 => -1.0,
        _ if i == d + 1 => 1.0,
        _ => 0.0,
    }
}
