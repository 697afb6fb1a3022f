//! The pyramid over the square [-1, 1]^2 with its apex at 1 in the third coordinate.
//!
//! With s = 1 - z the basis is (s + x_a x) (s + y_a y) / (4 s) at the corners of the square and z
//! at the apex. No polynomials do: five functions that are bilinear on the square and linear on
//! the triangles, so that the cell fits beside hexahedra, prisms and tetrahedra, hold the term
//! x y / s. In x/s, y/s and z they are polynomials again, so that a rule in these coordinates
//! integrates an affine cell exactly. They are those of a hexahedron whose top is one node.
//!
//! # Source
//! Bedrosian (1992), Int. J. Numer. Meth. Engng 35, 95-108; for any order Bergot, Cohen and Durufle
//! (2010), J. Sci. Comput. 42, 345-381.

#[rustfmt::skip]
const POINTS: [[f64; 3]; 5] = [
    [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 1.0],
];

/// The nodes.
pub const fn points() -> &'static [[f64; 3]] {
    &POINTS
}

/// Local nodes of each facet: the square, then the triangles in front (second coordinate -1), to
/// the right, at the back, to the left.
pub const fn facets() -> &'static [&'static [usize]] {
    &[&[0, 3, 2, 1], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]]
}

/// The nodal basis.
#[inline]
pub fn values([x, y, z]: [f64; 3], out: &mut [f64]) {
    let (s, [p, _]) = (1.0 - z, across([x, y, z]));
    for (value, node) in out.iter_mut().zip(&POINTS[..4]) {
        *value = 0.25 * (s + node[0] * x + node[1] * y + node[0] * node[1] * p * y);
    }
    out[4] = z;
}

/// Its derivatives; at the apex, where they depend on the direction from which one comes, those on
/// the axis.
#[inline]
pub fn gradients(xi: [f64; 3], out: &mut [[f64; 3]]) {
    let [p, q] = across(xi);
    for (gradient, [x, y, _]) in out.iter_mut().zip(&POINTS[..4]) {
        *gradient =
            [0.25 * x * (1.0 + y * q), 0.25 * y * (1.0 + x * p), 0.25 * (x * y * p * q - 1.0)];
    }
    out[4] = [0.0, 0.0, 1.0];
}

/// x/s and y/s: the place in the square, seen from the apex.
fn across([x, y, z]: [f64; 3]) -> [f64; 2] {
    let s = 1.0 - z;
    if s == 0.0 { [0.0; 2] } else { [x / s, y / s] }
}
