//! Lines, quadrilaterals and hexahedra on [-1, 1]^dim: products of polynomials of one coordinate
//! each.

#[rustfmt::skip]
const LINE: [[f64; 3]; 3] = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]];

#[rustfmt::skip]
const QUAD: [[f64; 3]; 9] = [
    [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0],
    [0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0],
    [0.0, 0.0, 0.0],
];

#[rustfmt::skip]
const HEX: [[f64; 3]; 27] = [
    [-1.0, -1.0, -1.0], [1.0, -1.0, -1.0], [1.0, 1.0, -1.0], [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0],
    [0.0, -1.0, -1.0], [1.0, 0.0, -1.0], [0.0, 1.0, -1.0], [-1.0, 0.0, -1.0],
    [0.0, -1.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [-1.0, 0.0, 1.0],
    [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0],
    [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0],
    [0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0],
];

/// Nodes of second order; those of first order are the first 2^dim.
pub const fn points(dim: usize) -> &'static [[f64; 3]] {
    match dim {
        1 => &LINE,
        2 => &QUAD,
        _ => &HEX,
    }
}

/// Local nodes of each facet. Hexahedra: bottom, top, front (second coordinate -1), right, back,
/// left.
pub const fn facets(dim: usize, order: usize) -> &'static [&'static [usize]] {
    match (dim, order) {
        (1, _) => &[&[0], &[1]],
        (2, 1) => &[&[0, 1], &[1, 2], &[2, 3], &[3, 0]],
        (2, _) => &[&[0, 1, 4], &[1, 2, 5], &[2, 3, 6], &[3, 0, 7]],
        (_, 1) => &[
            &[0, 3, 2, 1],
            &[4, 5, 6, 7],
            &[0, 1, 5, 4],
            &[1, 2, 6, 5],
            &[2, 3, 7, 6],
            &[3, 0, 4, 7],
        ],
        _ => &[
            &[0, 3, 2, 1, 11, 10, 9, 8, 24],
            &[4, 5, 6, 7, 12, 13, 14, 15, 25],
            &[0, 1, 5, 4, 8, 17, 12, 16, 22],
            &[1, 2, 6, 5, 9, 18, 13, 17, 21],
            &[2, 3, 7, 6, 10, 19, 14, 18, 23],
            &[3, 0, 4, 7, 11, 16, 15, 19, 20],
        ],
    }
}

/// The nodal basis, for all of `out`.
#[inline]
pub fn values(dim: usize, order: usize, xi: [f64; 3], out: &mut [f64]) {
    for (value, node) in out.iter_mut().zip(points(dim)) {
        *value = (0..dim).map(|d| along(order, node[d], xi[d])).product();
    }
}

/// Its derivatives, for all of `out`.
#[inline]
pub fn gradients(dim: usize, order: usize, xi: [f64; 3], out: &mut [[f64; 3]]) {
    for (gradient, node) in out.iter_mut().zip(points(dim)) {
        *gradient = [0.0; 3];
        for (d, component) in gradient.iter_mut().enumerate().take(dim) {
            let factor = |e: usize| {
                if e == d { slope(order, node[e], xi[e]) } else { along(order, node[e], xi[e]) }
            };
            *component = (0..dim).map(factor).product();
        }
    }
}

/// The polynomial of one coordinate that is 1 at `node` (-1, 0 or 1) and 0 at the others.
#[inline]
pub fn along(order: usize, node: f64, x: f64) -> f64 {
    if order == 1 {
        0.5 * (1.0 + node * x)
    } else if node == 0.0 {
        1.0 - x * x
    } else {
        0.5 * x * (x + node)
    }
}

/// The derivative of [`along`].
#[inline]
pub fn slope(order: usize, node: f64, x: f64) -> f64 {
    if order == 1 {
        0.5 * node
    } else if node == 0.0 {
        -2.0 * x
    } else {
        x + 0.5 * node
    }
}
