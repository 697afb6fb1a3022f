//! The map from the reference cell to the real one, where both have the same dimension.

#![allow(clippy::needless_range_loop)] // index notation, as in the formulas

use super::{MAX_NODES, Shape};

/// Jacobian of the map at one reference point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mapping {
    /// `jacobian[i][d]` = dx_i/dxi_d, metres; only the leading `dim` x `dim` block means something.
    pub jacobian: [[f64; 3]; 3],
    /// Its inverse, `inverse[d][i]` = dxi_d/dx_i, 1/m; not finite where the determinant vanishes.
    pub inverse: [[f64; 3]; 3],
    /// Its determinant, m^dim; not positive in a cell that is turned over or degenerate.
    pub determinant: f64,
}

impl Mapping {
    /// Gradient in real coordinates of a function with this reference gradient, 1/m.
    pub fn gradient(&self, reference: [f64; 3], dim: usize) -> [f64; 3] {
        let mut out = [0.0; 3];
        for i in 0..dim {
            out[i] = (0..dim).map(|d| self.inverse[d][i] * reference[d]).sum();
        }
        out
    }
}

/// Jacobian, its inverse and determinant at the reference point `xi`.
///
/// # Arguments
/// * `positions` of the nodes, metres, shape (`shape.nodes()`, `DIM`); in 2D the plane is (x, z)
///
/// `DIM` must be the dimension of the shape.
///
/// # Panics
/// If `DIM` is not the dimension of the shape, or `positions` is too short.
pub fn mapping<const DIM: usize>(shape: Shape, positions: &[[f64; DIM]], xi: [f64; 3]) -> Mapping {
    assert!(DIM == shape.dim() && DIM >= 2, "a {shape:?} does not fill {DIM} dimensions");
    let mut gradients = [[0.0; 3]; MAX_NODES];
    shape.gradients(xi, &mut gradients);
    let mut j = [[0.0; 3]; 3];
    for (x, gradient) in positions[..shape.nodes()].iter().zip(&gradients) {
        for i in 0..DIM {
            for d in 0..DIM {
                j[i][d] += x[i] * gradient[d];
            }
        }
    }
    if DIM == 2 {
        j[2][2] = 1.0;
    }
    let cofactor = |i: usize, d: usize| {
        let (i1, i2, d1, d2) = ((i + 1) % 3, (i + 2) % 3, (d + 1) % 3, (d + 2) % 3);
        j[i1][d1] * j[i2][d2] - j[i1][d2] * j[i2][d1]
    };
    let determinant: f64 = (0..3).map(|d| j[0][d] * cofactor(0, d)).sum();
    let inverse = std::array::from_fn(|d| std::array::from_fn(|i| cofactor(i, d) / determinant));
    Mapping { jacobian: j, inverse, determinant }
}

/// The real point at the reference point `xi`, metres: x = sum N_a(xi) x_a.
pub fn map_point<const DIM: usize>(
    shape: Shape,
    positions: &[[f64; DIM]],
    xi: [f64; 3],
) -> [f64; DIM] {
    let mut values = [0.0; MAX_NODES];
    shape.values(xi, &mut values);
    let mut x = [0.0; DIM];
    for (position, value) in positions[..shape.nodes()].iter().zip(values) {
        for (x, component) in x.iter_mut().zip(position) {
            *x += value * component;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::gauss;

    #[test]
    fn determinants_integrate_to_the_area_and_the_volume() {
        let trapezoid = [[0.0, 0.0], [2.0, 0.0], [1.5, 1.0], [0.5, 1.0]];
        let area: f64 = gauss(Shape::Quad4, 2)
            .iter()
            .map(|p| p.weight * mapping(Shape::Quad4, &trapezoid, p.xi).determinant)
            .sum();
        assert!((area - 1.5).abs() < 1e-14);
        let brick: Vec<[f64; 3]> = Shape::Hex8
            .node_points()
            .iter()
            .map(|v| [v[0] + 0.3 * v[2], 2.0 * v[1], 0.25 * v[2]])
            .collect();
        let volume: f64 = gauss(Shape::Hex8, 2)
            .iter()
            .map(|p| p.weight * mapping(Shape::Hex8, &brick, p.xi).determinant)
            .sum();
        assert!((volume - 4.0).abs() < 1e-14);
    }

    #[test]
    fn the_gradient_of_a_linear_function_is_exact_in_a_distorted_cell() {
        let cell: Vec<[f64; 3]> = Shape::Hex8
            .node_points()
            .iter()
            .map(|v| [v[0] + 0.1 * v[1] * v[2], v[1] - 0.2 * v[0], 2.0 * v[2] + 0.1 * v[0]])
            .collect();
        let xi = [0.2, -0.4, 0.6];
        let map = mapping(Shape::Hex8, &cell, xi);
        let mut gradients = [[0.0; 3]; MAX_NODES];
        Shape::Hex8.gradients(xi, &mut gradients);
        let mut gradient = [0.0; 3];
        for (x, reference) in cell.iter().zip(gradients) {
            let value = 3.0 * x[0] - 5.0 * x[1] + 7.0 * x[2];
            for (sum, part) in gradient.iter_mut().zip(map.gradient(reference, 3)) {
                *sum += value * part;
            }
        }
        for (found, exact) in gradient.iter().zip([3.0, -5.0, 7.0]) {
            assert!((found - exact).abs() < 1e-13);
        }
    }

    #[test]
    fn a_quad_turned_over_has_a_negative_determinant() {
        let clockwise = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
        assert!(mapping(Shape::Quad4, &clockwise, [0.0; 3]).determinant < 0.0);
        assert_eq!(map_point(Shape::Quad4, &clockwise, [0.0; 3]), [0.5, 0.5]);
    }
}
