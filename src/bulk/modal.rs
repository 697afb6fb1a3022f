//! The stiffness of a box in sums and differences of its nodal values.
//!
//! In the basis of the products of 1 and xi, eta, zeta over the corners (a Walsh transform), the
//! one-dimensional mass and stiffness matrices of first-order elements are diagonal and the mixed
//! matrix exchanges sum and difference. So a component's force needs one number of each component's
//! displacement: 3 entries per row in place of 24 (2D: 2 in place of 8).

/// Modes of a box with 8 corners.
pub const MODES: usize = 8;

/// Modes that differ by less than this part of the largest entry are taken for zero.
const ZERO: f64 = 1e-12;

/// K in modal form: the force of component c in mode m is the sum over d of
/// `entry[c][d][m]` (N/m) times the displacement of component d in mode m with the bits of c and d
/// exchanged (if c and d differ). Bit i of a mode marks the difference along axis i.
#[derive(Debug, Clone, PartialEq)]
pub struct Modal {
    /// N/m; only the leading `dim` components and 2^dim modes mean something.
    pub entry: [[[f64; MODES]; 3]; 3],
}

impl Modal {
    /// From the dense matrix of a box (rows over nodes, then components) whose corners have the
    /// reference coordinates `corners`; none if it has other entries: not a box, or not an
    /// isotropic material.
    pub fn new(matrix: &[f64], corners: &[[f64; 3]], dim: usize) -> Option<Self> {
        let (n, size) = (corners.len(), corners.len() * dim);
        let sign = |corner: usize, mode: usize| -> f64 {
            (0..dim).filter(|i| mode >> i & 1 == 1).map(|i| corners[corner][i]).product()
        };
        let mut modal = Self { entry: [[[0.0; MODES]; 3]; 3] };
        let (mut largest, mut other) = (0.0_f64, 0.0_f64);
        for (c, d) in (0..dim).flat_map(|c| (0..dim).map(move |d| (c, d))) {
            for (m, k) in (0..n).flat_map(|m| (0..n).map(move |k| (m, k))) {
                let mut value = 0.0;
                for (a, b) in (0..n).flat_map(|a| (0..n).map(move |b| (a, b))) {
                    value += sign(a, m) * matrix[(a * dim + c) * size + b * dim + d] * sign(b, k);
                }
                value /= (n * n) as f64;
                if k == partner(c, d, m) && couples(c, d, m) {
                    modal.entry[c][d][m] = value;
                    largest = largest.max(value.abs());
                } else {
                    other = other.max(value.abs());
                }
            }
        }
        (other <= ZERO * largest).then_some(modal)
    }
}

/// Whether components c and d act on each other in mode `m` of c: only where it is a difference
/// along the axis of one of them and a sum along that of the other.
pub const fn couples(c: usize, d: usize, m: usize) -> bool {
    c == d || (m >> c ^ m >> d) & 1 == 1
}

/// The mode of component d that acts on mode `m` of component c.
pub const fn partner(c: usize, d: usize, m: usize) -> usize {
    if c == d { m } else { m ^ (1 << c) ^ (1 << d) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bulk::{Elastic, SplitForm, Stiffness};
    use crate::element::Shape;
    use crate::mesh::axes;

    #[test]
    fn the_modal_form_gives_the_forces_of_the_matrix() {
        let shapes = [(2, Shape::Quad4), (3, Shape::Hex8)];
        for ((dim, shape), b_bar) in shapes.into_iter().flat_map(|s| [(s, false), (s, true)]) {
            let size = [0.5, if dim == 2 { 1.0 } else { 0.3 }, 0.2];
            let elastic = Elastic::new(5.8e9, 0.3);
            let stiffness = Stiffness::new(shape, size, elastic, axes(dim), b_bar);
            let corners = shape.node_points();
            let SplitForm::First(modal) = &stiffness.form else { panic!("of second order") };
            let n = corners.len();
            let u: Vec<f64> = (0..n * dim).map(|i| ((i * 7 + 3) % 11) as f64 - 5.0).collect();
            let mut exact = vec![0.0; n * dim];
            stiffness.force(&u, &mut exact);
            let sign = |a: usize, m: usize| -> f64 {
                (0..dim).filter(|i| m >> i & 1 == 1).map(|i| corners[a][i]).product()
            };
            let largest = exact.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            for a in 0..n {
                for c in 0..dim {
                    let mut found = 0.0;
                    for m in 0..n {
                        for d in 0..dim {
                            let k = partner(c, d, m);
                            let w: f64 = (0..n).map(|b| sign(b, k) * u[b * dim + d]).sum();
                            found += sign(a, m) * modal.entry[c][d][m] * w;
                        }
                    }
                    assert!((found - exact[a * dim + c]).abs() < 1e-13 * largest);
                }
            }
        }
    }

    #[test]
    fn other_matrices_have_no_modal_form() {
        let mut matrix = vec![0.0; 64];
        matrix[1] = 1.0;
        assert!(Modal::new(&matrix, Shape::Quad4.node_points(), 2).is_none());
    }
}
