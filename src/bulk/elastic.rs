//! Isotropic linear elasticity on first-order cells, fully integrated or with mean dilatation.
//!
//! Small strain, plane strain in 2D. All cells are boxes; those of one size and material are
//! identical up to translation and share one stiffness.

use super::Modal;
use crate::element::{Shape, gauss, mapping};
use crate::mesh::{Prototype, axes};

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
    dim: usize,
    elastic: Elastic,
    /// K, row by row: (n dim) x (n dim), N/m (2D: per metre of thickness).
    pub matrix: Vec<f64>,
    /// K in sums and differences of nodal values.
    pub modal: Modal,
    /// Gradients of the shape functions at the centre (1/m), one per node.
    centre: Vec<[f64; 3]>,
}

impl Stiffness {
    /// K = integral of B^T D B over the box, by the 2-point Gauss rule per direction, which is
    /// exact for a box. With `b_bar` the volumetric strain is replaced by its mean over the box,
    /// so that nearly incompressible material does not lock (T. Hughes, Int. J. Numer. Methods Engrg.
    /// 15, 1980).
    pub fn new(prototype: &Prototype, elastic: Elastic, dim: usize, b_bar: bool) -> Self {
        // Of sigma = lambda tr(eps) 1 + 2 mu eps the share of the first term that acts on the strain
        // at a point, and that acts on its mean.
        let third = 2.0 / 3.0 * elastic.mu;
        let (at_points, on_mean) =
            if b_bar { (-third, elastic.lambda + third) } else { (elastic.lambda, 0.0) };
        let shape = if dim == 2 { Shape::Quad4 } else { Shape::Hex8 };
        let size: Vec<f64> = axes(dim).iter().map(|a| prototype.size[*a]).collect();
        let corners: Vec<[f64; 3]> = shape
            .vertices()
            .iter()
            .map(|v| std::array::from_fn(|i| if i < dim { 0.5 * size[i] * v[i] } else { 0.0 }))
            .collect();
        let n = corners.len();
        let mut matrix = vec![0.0; (n * dim) * (n * dim)];
        for point in gauss(shape, 2) {
            let (gradients, volume) = physical_gradients(shape, &corners, point.xi, dim);
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
        }
        // The mean gradient of a box is that at its centre.
        let (centre, _) = physical_gradients(shape, &corners, [0.0; 3], dim);
        let volume: f64 = size.iter().product();
        for (row, (a, i)) in (0..n).flat_map(|a| (0..dim).map(move |i| (a, i))).enumerate() {
            for (column, (b, j)) in (0..n).flat_map(|b| (0..dim).map(move |j| (b, j))).enumerate() {
                matrix[row * n * dim + column] += on_mean * volume * centre[a][i] * centre[b][j];
            }
        }
        let modal = Modal::new(&matrix, shape.vertices(), dim)
            .expect("a box of isotropic material is diagonal by modes");
        Self { dim, elastic, matrix, modal, centre }
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
        let mut h = [[0.0; 3]; 3];
        let axes = axes(self.dim);
        for (node, g) in self.centre.iter().enumerate() {
            for (i, ai) in axes.iter().enumerate() {
                for (j, aj) in axes.iter().enumerate() {
                    h[*ai][*aj] += u[node * self.dim + i] * g[j];
                }
            }
        }
        let trace = self.elastic.lambda * (h[0][0] + h[1][1] + h[2][2]);
        let mu = self.elastic.mu;
        let shear = |i: usize, j: usize| mu * (h[i][j] + h[j][i]);
        let normal = |i: usize| trace + 2.0 * mu * h[i][i];
        [normal(0), normal(1), normal(2), shear(0, 1), shear(1, 2), shear(0, 2)]
    }
}

/// Gradients with respect to the position and the determinant of the Jacobian.
fn physical_gradients(
    shape: Shape,
    corners: &[[f64; 3]],
    xi: [f64; 3],
    dim: usize,
) -> (Vec<[f64; 3]>, f64) {
    let mut reference = vec![[0.0; 3]; corners.len()];
    shape.gradients(xi, &mut reference);
    if dim == 2 {
        let plane: Vec<[f64; 2]> = corners.iter().map(|c| [c[0], c[1]]).collect();
        let map = mapping(shape, &plane, xi);
        (reference.iter().map(|g| map.gradient(*g, 2)).collect(), map.determinant)
    } else {
        let map = mapping(shape, corners, xi);
        (reference.iter().map(|g| map.gradient(*g, 3)).collect(), map.determinant)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [f64; 3] = [0.5, 0.25, 2.0];

    fn stiffness(dim: usize, b_bar: bool) -> Stiffness {
        let size = if dim == 2 { [SIZE[0], 1.0, SIZE[2]] } else { SIZE };
        Stiffness::new(&Prototype { size, material: 0 }, Elastic::new(5.8e9, 0.3), dim, b_bar)
    }

    const BOTH: [(usize, bool); 4] = [(2, false), (3, false), (2, true), (3, true)];

    /// Nodal values of the linear field u_i = sum_j h_ij x_j on the box centred at 0.
    fn linear(dim: usize, h: [[f64; 3]; 3]) -> Vec<f64> {
        let shape = if dim == 2 { Shape::Quad4 } else { Shape::Hex8 };
        let axes = axes(dim);
        let mut u = Vec::new();
        for v in shape.vertices() {
            for i in axes {
                let along = |j: usize| h[*i][axes[j]] * 0.5 * SIZE[axes[j]] * v[j];
                u.push((0..dim).map(along).sum());
            }
        }
        u
    }

    #[test]
    fn rigid_motions_need_no_force() {
        for (dim, b_bar) in BOTH {
            let k = stiffness(dim, b_bar);
            let turn = linear(dim, [[0.0, -1.0, 2.0], [1.0, 0.0, 0.5], [-2.0, -0.5, 0.0]]);
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
            let prototype = Prototype { size: [1.0; 3], material: 0 };
            let k = Stiffness::new(&prototype, Elastic::new(1.0, nu), 3, b_bar);
            let corners = Shape::Hex8.vertices();
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
        for (dim, b_bar) in BOTH {
            let k = stiffness(dim, b_bar);
            let y = if dim == 2 { 0.0 } else { 1.0 };
            let h = [[1e-3, 2e-4 * y, -3e-4], [1e-4 * y, 5e-4 * y, 0.0], [2e-4, 7e-4 * y, -4e-4]];
            let u = linear(dim, h);
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
