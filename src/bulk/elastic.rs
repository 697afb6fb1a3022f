//! Isotropic linear elasticity on boxes of first or second order, fully integrated or B-bar.
//!
//! Small strain, plane strain in 2D. Boxes of one size, material and order are identical up to
//! translation and share one stiffness.

use super::{Modal, Parity};
use crate::element::{Shape, gauss, mapping};

/// Lamé's constants (Pa).
#[derive(Debug, Clone, Copy)]
pub struct Elastic {
    /// First constant, lambda.
    pub lambda: f64,
    /// Shear modulus, mu.
    pub mu: f64,
}

impl Elastic {
    /// From Young's modulus (Pa) and Poisson's ratio.
    pub fn new(young_modulus: f64, poisson_ratio: f64) -> Self {
        let (e, nu) = (young_modulus, poisson_ratio);
        Self { lambda: e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), mu: e / (2.0 * (1.0 + nu)) }
    }
}

/// Stiffness of a box of nodes `n` and `dim` components, and what gives its stress.
#[derive(Debug, Clone)]
pub struct Stiffness {
    axes: &'static [usize],
    elastic: Elastic,
    /// K, row by row: (n dim) x (n dim), N/m (2D: per metre of thickness).
    pub matrix: Vec<f64>,
    /// K in sums and differences of nodal values.
    pub form: SplitForm,
    /// Gradients of the shape functions at the centre (1/m), one per node.
    centre: Vec<[f64; 3]>,
}

/// The stiffness in a basis in which few of its entries are not zero.
#[derive(Debug, Clone)]
pub enum SplitForm {
    /// Of a cell of first order.
    First(Box<Modal>),
    /// Of a cell of second order.
    Second(Box<Parity>),
}

impl Stiffness {
    /// K = integral of B^T D B over the box, by the Gauss rule with one point more per direction
    /// than the order, which is exact for a box. With `b_bar` the volumetric strain is replaced by
    /// its projection on the polynomials of one degree less than the order, so that nearly
    /// incompressible material does not lock (T. Hughes, Int. J. Numer. Methods Engrg. 15, 1980).
    /// The `size` is that along x, y, z (m); the components lie along `axes`.
    pub fn new(
        shape: Shape,
        size: [f64; 3],
        elastic: Elastic,
        axes: &'static [usize],
        b_bar: bool,
    ) -> Self {
        // Of sigma = lambda tr(eps) 1 + 2 mu eps the share of the first term that acts on the
        // strain at a point, and that acts on its projection.
        let third = 2.0 / 3.0 * elastic.mu;
        let (at_points, on_projection) =
            if b_bar { (-third, elastic.lambda + third) } else { (elastic.lambda, 0.0) };
        let dim = axes.len();
        let size: Vec<f64> = axes.iter().map(|a| size[*a]).collect();
        let positions: Vec<[f64; 3]> = shape
            .node_points()
            .iter()
            .map(|v| std::array::from_fn(|i| if i < dim { 0.5 * size[i] * v[i] } else { 0.0 }))
            .collect();
        let n = positions.len();
        let mut matrix = vec![0.0; (n * dim) * (n * dim)];
        // Of 1 and, in cells of second order, each reference coordinate: its integrals against the
        // divergences of the shape functions, and against itself.
        let projected = if shape.order() == 1 { 1 } else { 1 + dim };
        let mut dilatation = vec![(vec![0.0; n * dim], 0.0); projected];
        for point in gauss(shape, shape.order() + 1) {
            let (gradients, volume) = physical_gradients(shape, &positions, point.xi, dim);
            let weight = point.weight * volume;
            for (a, ga) in gradients.iter().enumerate() {
                for (b, gb) in gradients.iter().enumerate() {
                    let dot: f64 = (0..dim).map(|k| ga[k] * gb[k]).sum();
                    for i in 0..dim {
                        for j in 0..dim {
                            let diagonal = if i == j { elastic.mu * dot } else { 0.0 };
                            let k = at_points * ga[i] * gb[j] + elastic.mu * ga[j] * gb[i];
                            matrix[(a * dim + i) * n * dim + b * dim + j] +=
                                weight * (k + diagonal);
                        }
                    }
                }
            }
            for (m, (of_nodes, square)) in dilatation.iter_mut().enumerate() {
                let value = if m == 0 { 1.0 } else { point.xi[m - 1] };
                let divergence = gradients.iter().flat_map(|g| &g[..dim]);
                of_nodes.iter_mut().zip(divergence).for_each(|(d, g)| *d += weight * value * g);
                *square += weight * value * value;
            }
        }
        for (of_nodes, square) in &dilatation {
            for (row, left) in matrix.chunks_exact_mut(n * dim).zip(of_nodes) {
                let factor = on_projection * left / square;
                row.iter_mut().zip(of_nodes).for_each(|(k, right)| *k += factor * right);
            }
        }
        let form = SplitForm::new(&matrix, shape);
        let (centre, _) = physical_gradients(shape, &positions, [0.0; 3], dim);
        Self { axes, elastic, matrix, form, centre }
    }

    /// Nodal forces f = K u; both of length n dim.
    #[inline]
    pub fn force(&self, u: &[f64], f: &mut [f64]) {
        for (row, value) in self.matrix.chunks_exact(u.len()).zip(f) {
            *value = row.iter().zip(u).map(|(k, u)| k * u).sum();
        }
    }

    /// Stress at the centre (Pa): xx, yy, zz, xy, yz, xz, in 2D too (plane strain).
    pub fn stress(&self, u: &[f64]) -> [f64; 6] {
        let h = match self.axes.len() {
            2 => self.gradient::<2>(u),
            _ => self.gradient::<3>(u),
        };
        stress_of(self.elastic, h)
    }

    /// Derivatives of the displacements along x, y, z by x, y, z at the centre.
    fn gradient<const DIM: usize>(&self, u: &[f64]) -> [[f64; 3]; 3] {
        let mut sum = [[0.0; DIM]; DIM];
        for (u, g) in u.as_chunks::<DIM>().0.iter().zip(&self.centre) {
            for i in 0..DIM {
                for j in 0..DIM {
                    sum[i][j] += u[i] * g[j];
                }
            }
        }
        let mut h = [[0.0; 3]; 3];
        for (i, ai) in self.axes.iter().enumerate() {
            for (j, aj) in self.axes.iter().enumerate() {
                h[*ai][*aj] = sum[i][j];
            }
        }
        h
    }
}

/// Stress (Pa) under the displacement gradient `h`: xx, yy, zz, xy, yz, xz.
pub(super) fn stress_of(elastic: Elastic, h: [[f64; 3]; 3]) -> [f64; 6] {
    let trace = elastic.lambda * (h[0][0] + h[1][1] + h[2][2]);
    let mu = elastic.mu;
    let shear = |i: usize, j: usize| mu * (h[i][j] + h[j][i]);
    let normal = |i: usize| trace + 2.0 * mu * h[i][i];
    [normal(0), normal(1), normal(2), shear(0, 1), shear(1, 2), shear(0, 2)]
}

impl SplitForm {
    fn new(matrix: &[f64], shape: Shape) -> Self {
        const SPLITS: &str = "a box of isotropic material splits by symmetry";
        if shape.order() == 1 {
            let modal = Modal::new(matrix, shape.node_points(), shape.dim());
            return SplitForm::First(Box::new(modal.expect(SPLITS)));
        }
        SplitForm::Second(Box::new(Parity::new(matrix, shape).expect(SPLITS)))
    }
}

/// Gradients with respect to the position and the determinant of the Jacobian.
fn physical_gradients(
    shape: Shape,
    positions: &[[f64; 3]],
    xi: [f64; 3],
    dim: usize,
) -> (Vec<[f64; 3]>, f64) {
    let mut reference = vec![[0.0; 3]; positions.len()];
    shape.gradients(xi, &mut reference);
    if dim == 2 {
        let plane: Vec<[f64; 2]> = positions.iter().map(|c| [c[0], c[1]]).collect();
        let map = mapping(shape, &plane, xi);
        (reference.iter().map(|g| map.gradient(*g, 2)).collect(), map.determinant)
    } else {
        let map = mapping(shape, positions, xi);
        (reference.iter().map(|g| map.gradient(*g, 3)).collect(), map.determinant)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::axes;

    const SIZE: [f64; 3] = [0.5, 0.25, 2.0];

    fn stiffness(dim: usize, order: usize, b_bar: bool) -> Stiffness {
        let size = if dim == 2 { [SIZE[0], 1.0, SIZE[2]] } else { SIZE };
        Stiffness::new(Shape::of(dim, order), size, Elastic::new(5.8e9, 0.3), axes(dim), b_bar)
    }

    const ALL: [(usize, usize, bool); 8] = [
        (2, 1, false),
        (3, 1, false),
        (2, 1, true),
        (3, 1, true),
        (2, 2, false),
        (3, 2, false),
        (2, 2, true),
        (3, 2, true),
    ];

    /// Nodal values of the linear field u_i = sum_j h_ij x_j on the box centred at 0.
    fn linear(dim: usize, order: usize, h: [[f64; 3]; 3]) -> Vec<f64> {
        let shape = Shape::of(dim, order);
        let axes = axes(dim);
        let mut u = Vec::new();
        for v in shape.node_points() {
            for i in axes {
                let along = |j: usize| h[*i][axes[j]] * 0.5 * SIZE[axes[j]] * v[j];
                u.push((0..dim).map(along).sum());
            }
        }
        u
    }

    #[test]
    fn rigid_motions_need_no_force() {
        for (dim, order, b_bar) in ALL {
            let k = stiffness(dim, order, b_bar);
            let turn = linear(dim, order, [[0.0, -1.0, 2.0], [1.0, 0.0, 0.5], [-2.0, -0.5, 0.0]]);
            let shift: Vec<f64> =
                turn.iter().enumerate().map(|(i, u)| u + (i % dim) as f64).collect();
            let mut f = vec![0.0; shift.len()];
            k.force(&shift, &mut f);
            let largest = k.matrix.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            assert!(f.iter().all(|v| v.abs() < 1e-14 * largest), "{f:?}");
        }
    }

    /// Bending: the volumetric strain changes its sign across the box, and its mean is zero.
    #[test]
    fn bending_of_nearly_incompressible_material_is_soft() {
        let energy = |nu: f64, b_bar: bool| {
            let elastic = Elastic::new(1.0, nu);
            let k = Stiffness::new(Shape::Hex8, [1.0; 3], elastic, axes(3), b_bar);
            let corners = Shape::Hex8.node_points();
            let u: Vec<f64> = corners.iter().flat_map(|v| [v[0] * v[2], 0.0, 0.0]).collect();
            let mut f = vec![0.0; u.len()];
            k.force(&u, &mut f);
            f.iter().zip(&u).map(|(f, u)| f * u).sum::<f64>()
        };
        assert!(energy(0.4999, false) > 100.0 * energy(0.0, false));
        assert!(energy(0.4999, true) < 2.0 * energy(0.0, true));
    }

    #[test]
    fn energy_of_a_constant_strain_is_exact() {
        for (dim, order, b_bar) in ALL {
            let k = stiffness(dim, order, b_bar);
            let y = if dim == 2 { 0.0 } else { 1.0 };
            let h = [[1e-3, 2e-4 * y, -3e-4], [1e-4 * y, 5e-4 * y, 0.0], [2e-4, 7e-4 * y, -4e-4]];
            let u = linear(dim, order, h);
            let mut f = vec![0.0; u.len()];
            k.force(&u, &mut f);
            let energy: f64 = 0.5 * f.iter().zip(&u).map(|(f, u)| f * u).sum::<f64>();
            let s = k.stress(&u);
            let strain = |i: usize, j: usize| 0.5 * (h[i][j] + h[j][i]);
            let density = 0.5 * (0..3).map(|i| s[i] * strain(i, i)).sum::<f64>()
                + s[3] * strain(0, 1)
                + s[4] * strain(1, 2)
                + s[5] * strain(0, 2);
            let volume = if dim == 2 { SIZE[0] * SIZE[2] } else { SIZE.iter().product() };
            assert!((energy / (density * volume) - 1.0).abs() < 1e-13, "{energy} {density}");
            let trace = h[0][0] + h[1][1] + h[2][2];
            let law = Elastic::new(5.8e9, 0.3);
            assert!((s[2] - law.lambda * trace - 2.0 * law.mu * h[2][2]).abs() < 1e-6);
        }
    }
}
