//! Gauss-Legendre rules on lines, quadrilaterals and hexahedra.

use crate::element::shape::{Family, Shape};

/// A point of a rule on a reference cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuadraturePoint {
    /// Reference coordinates; zero beyond the dimension of the shape.
    pub xi: [f64; 3],
    /// Weight; the weights of a rule sum to [`Shape::volume`].
    pub weight: f64,
}

/// Tensor product of the Gauss-Legendre rule with `n` points along each axis (1 to 5): exact
/// for polynomials of degree 2n - 1 in each coordinate. The first coordinate runs fastest.
///
/// # Panics
/// If there is no such rule here, or the shape is none of the cubes.
pub fn gauss(shape: Shape, n: usize) -> Vec<QuadraturePoint> {
    assert!(shape.family() == Family::Cube, "a {shape:?} is no product of lines");
    let line = gauss_legendre(n);
    let mut points = vec![QuadraturePoint { xi: [0.0; 3], weight: 1.0 }];
    for axis in 0..shape.dim() {
        points = line
            .iter()
            .flat_map(|&(x, w)| {
                points.iter().map(move |p| {
                    let mut xi = p.xi;
                    xi[axis] = x;
                    QuadraturePoint { xi, weight: p.weight * w }
                })
            })
            .collect();
    }
    points
}

/// Points and weights of the Gauss-Legendre rule on [-1, 1], exact for degree 2n - 1.
///
/// # Panics
/// If there is no such rule here.
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let two = 1.0 / 3.0_f64.sqrt();
    let three = 0.6_f64.sqrt();
    let root = (10.0_f64 / 7.0).sqrt();
    let (inner, outer) = ((5.0 - 2.0 * root).sqrt() / 3.0, (5.0 + 2.0 * root).sqrt() / 3.0);
    let seventy = 13.0 * 70.0_f64.sqrt();
    let (more, less) = ((322.0 + seventy) / 900.0, (322.0 - seventy) / 900.0);
    match n {
        1 => vec![(0.0, 2.0)],
        2 => vec![(-two, 1.0), (two, 1.0)],
        3 => vec![(-three, 5.0 / 9.0), (0.0, 8.0 / 9.0), (three, 5.0 / 9.0)],
        4 => {
            let root = 2.0 / 7.0 * 1.2_f64.sqrt();
            let [inner, outer] = [3.0 / 7.0 - root, 3.0 / 7.0 + root].map(f64::sqrt);
            let [more, less] = [1.0, -1.0].map(|sign| (18.0 + sign * 30.0_f64.sqrt()) / 36.0);
            vec![(-outer, less), (-inner, more), (inner, more), (outer, less)]
        }
        5 => {
            vec![(-outer, less), (-inner, more), (0.0, 128.0 / 225.0), (inner, more), (outer, less)]
        }
        _ => panic!("Gauss rules have 1 to 5 points along each axis, not {n}"),
    }
}
