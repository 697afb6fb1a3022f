//! The biorthogonal (dual) multiplier basis of a facet, some of whose nodes carry no multiplier.

#![allow(clippy::needless_range_loop)] // index notation, as in the formulas

use super::MOST_NODES;
use crate::element::{QuadraturePoint, Shape};

/// Multiplier basis Phi_i of a facet, one function per kept node, in the span of the nodal
/// basis: $\int\Phi_i N_k = \delta_{ik}\int N_k$ for kept k, and $\sum_i \Phi_i = 1$.
///
/// The function of a dropped node b is handed to its neighbours (constant extension):
/// $\Psi_i = N_i + \sum_b \theta_{ib} N_b$, where the nearest kept nodes of the reference facet
/// share equally. Then $\Phi = A\Psi$ with
/// $A = D M^{-1}$, $M_{jk} = \int\Psi_j N_k$, $D_k = \int N_k$, over kept nodes.
///
/// Where nothing is dropped the basis of a first-order facet reproduces constants, that of a
/// second-order one linear functions: enough for the optimal order of the displacement.
///
/// # Source
/// Wohlmuth (2000), SIAM J. Numer. Anal. 38, 989-1012; constant extension as at cross points there.
#[derive(Debug, Clone, PartialEq)]
pub struct DualBasis {
    shape: Shape,
    kept: Vec<usize>,
    /// `coefficients[i][b]`: Phi of the local node i = sum over b of it times N_b; zero if dropped.
    coefficients: [[f64; MOST_NODES]; MOST_NODES],
    integrals: [[f64; MOST_NODES]; MOST_NODES],
    weights: [f64; MOST_NODES],
}

impl DualBasis {
    /// The basis with respect to the integration `points` (weights are areas, m2): biorthogonal
    /// for exactly this rule. Bit b of `dropped` says that the local node b carries no multiplier.
    ///
    /// None if every node is dropped (the facet has no multiplier) or the facet has no area.
    pub fn new(shape: Shape, points: &[QuadraturePoint], dropped: u16) -> Option<Self> {
        let n = shape.nodes();
        let kept: Vec<usize> = (0..n).filter(|b| dropped >> b & 1 == 0).collect();
        if kept.is_empty() {
            return None;
        }
        let mut mass = [[0.0; MOST_NODES]; MOST_NODES];
        let mut nodal = [0.0; MOST_NODES];
        let mut values = [0.0; MOST_NODES];
        for point in points {
            shape.values(point.xi, &mut values);
            for b in 0..n {
                nodal[b] += point.weight * values[b];
                for k in 0..n {
                    mass[b][k] += point.weight * values[b] * values[k];
                }
            }
        }
        let extension = extension(shape, &kept);
        let m = nalgebra::DMatrix::from_fn(kept.len(), kept.len(), |j, k| {
            (0..n).map(|b| extension[kept[j]][b] * mass[b][kept[k]]).sum::<f64>()
        });
        let inverse = m.try_inverse()?;
        let (mut coefficients, mut integrals) =
            ([[0.0; MOST_NODES]; MOST_NODES], [[0.0; MOST_NODES]; MOST_NODES]);
        let mut weights = [0.0; MOST_NODES];
        for (row, &i) in kept.iter().enumerate() {
            for b in 0..n {
                coefficients[i][b] = (0..kept.len())
                    .map(|j| nodal[i] * inverse[(row, j)] * extension[kept[j]][b])
                    .sum();
            }
            for k in 0..n {
                integrals[i][k] = if k == i {
                    nodal[i]
                } else if kept.contains(&k) {
                    0.0
                } else {
                    (0..n).map(|b| coefficients[i][b] * mass[b][k]).sum()
                };
            }
            weights[i] = integrals[i].iter().sum();
        }
        Some(DualBasis { shape, kept, coefficients, integrals, weights })
    }

    /// Local nodes that carry a multiplier, ascending.
    pub fn kept(&self) -> &[usize] {
        &self.kept
    }

    /// Integral of Phi_i, m2 (m for lines), i a kept local node.
    pub fn weight(&self, i: usize) -> f64 {
        self.weights[i]
    }

    /// Integrals of Phi_i against the nodal basis N_k of the facet, m2, for all local nodes k:
    /// zero for the other kept nodes.
    pub fn integrals(&self, i: usize) -> &[f64] {
        &self.integrals[i][..self.shape.nodes()]
    }

    /// `out[i]` = Phi_i at the reference point `xi`, for each local node; zero for dropped ones.
    /// Also the rule that gives a traction to dropped nodes: sum of Phi_i times its multiplier.
    ///
    /// # Panics
    /// If `out` is shorter than the number of nodes.
    pub fn values(&self, xi: [f64; 3], out: &mut [f64]) {
        let n = self.shape.nodes();
        let mut values = [0.0; MOST_NODES];
        self.shape.values(xi, &mut values);
        for (value, coefficients) in out[..n].iter_mut().zip(&self.coefficients) {
            *value = coefficients[..n].iter().zip(values).map(|(c, v)| c * v).sum();
        }
    }
}

/// `[i][b]`: the share of N_b in Psi_i; rows of dropped nodes are zero, columns sum to 1.
fn extension(shape: Shape, kept: &[usize]) -> [[f64; MOST_NODES]; MOST_NODES] {
    let (n, points) = (shape.nodes(), shape.node_points());
    let mut out = [[0.0; MOST_NODES]; MOST_NODES];
    for b in 0..n {
        if kept.contains(&b) {
            out[b][b] = 1.0;
            continue;
        }
        let away =
            |i: usize| -> f64 { (0..2).map(|d| (points[i][d] - points[b][d]).powi(2)).sum() };
        let nearest = kept.iter().map(|&i| away(i)).fold(f64::INFINITY, f64::min);
        let heirs: Vec<usize> = kept.iter().copied().filter(|&i| away(i) == nearest).collect();
        for &i in &heirs {
            out[i][b] = 1.0 / heirs.len() as f64;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interface::mortar::PlaneFacet;

    fn facets() -> [PlaneFacet; 7] {
        let quad9 = |corners: &[[f64; 2]]| {
            PlaneFacet::new(Shape::Quad9, &[0, 1, 2, 3, 4, 5, 6, 7, 8], corners)
        };
        [
            PlaneFacet::line([0, 1], [0.2, 0.7]),
            PlaneFacet::quad([0, 1, 2, 3], [[0.0, 0.0], [2.0, 0.0], [2.0, 0.5], [0.0, 0.5]]),
            PlaneFacet::quad([0, 1, 2, 3], [[0.0, 0.0], [2.0, 0.3], [2.4, 1.5], [0.1, 1.0]]),
            PlaneFacet::quad([0, 1, 2, 3], [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]]),
            PlaneFacet::new(Shape::Line3, &[0, 1, 2], &[[0.2, 0.0], [0.7, 0.0]]),
            quad9(&[[0.0, 0.0], [2.0, 0.0], [2.0, 0.5], [0.0, 0.5]]),
            quad9(&[[0.0, 0.0], [2.0, 0.3], [2.4, 1.5], [0.1, 1.0]]),
        ]
    }

    #[test]
    fn the_basis_is_biorthogonal_and_sums_to_one_whatever_is_dropped() {
        for facet in facets() {
            let n = facet.shape().nodes();
            // Of 511 choices of 9 nodes every seventh.
            for dropped in (0..(1_u16 << n) - 1).step_by(if n > 4 { 7 } else { 1 }) {
                let basis = DualBasis::new(facet.shape(), &facet.points(), dropped).unwrap();
                let mut found = [[0.0; MOST_NODES]; MOST_NODES];
                let mut nodal = [0.0; MOST_NODES];
                for p in facet.points() {
                    let (mut phi, mut values) = ([0.0; MOST_NODES], [0.0; MOST_NODES]);
                    basis.values(p.xi, &mut phi);
                    facet.shape().values(p.xi, &mut values);
                    assert!((phi.iter().sum::<f64>() - 1.0).abs() < 1e-13, "{dropped:b}");
                    for k in 0..n {
                        nodal[k] += p.weight * values[k];
                        for i in 0..n {
                            found[i][k] += p.weight * phi[i] * values[k];
                        }
                    }
                }
                let area = facet.area();
                for &i in basis.kept() {
                    for k in 0..n {
                        assert!((found[i][k] - basis.integrals(i)[k]).abs() < 1e-13 * area);
                        if basis.kept().contains(&k) {
                            let exact = if i == k { nodal[k] } else { 0.0 };
                            assert!((basis.integrals(i)[k] - exact).abs() < 1e-15 * area);
                        }
                    }
                }
                let weights: f64 = basis.kept().iter().map(|&i| basis.weight(i)).sum();
                assert!((weights - area).abs() < 1e-13 * area);
            }
        }
    }

    #[test]
    fn the_plain_basis_of_a_segment_is_the_known_one() {
        let facet = PlaneFacet::line([0, 1], [0.0, 1.0]);
        let basis = DualBasis::new(Shape::Line2, &facet.points(), 0).unwrap();
        let mut phi = [0.0; MOST_NODES];
        basis.values([-1.0, 0.0, 0.0], &mut phi);
        assert!((phi[0] - 2.0).abs() < 1e-14 && (phi[1] + 1.0).abs() < 1e-14);
    }

    #[test]
    fn the_basis_of_second_order_reproduces_linear_functions_with_positive_weights() {
        for facet in &facets()[4..6] {
            let shape = facet.shape();
            let basis = DualBasis::new(shape, &facet.points(), 0).unwrap();
            let mut phi = [0.0; MOST_NODES];
            for xi in [[0.3, -0.7, 0.0], [-1.0, 1.0, 0.0]] {
                basis.values(xi, &mut phi);
                for d in 0..shape.dim() {
                    let linear: f64 =
                        phi.iter().zip(shape.node_points()).map(|(phi, x)| phi * x[d]).sum();
                    assert!((linear - xi[d]).abs() < 1e-13, "{shape:?}: {linear} {}", xi[d]);
                }
            }
            assert!((0..shape.nodes()).all(|i| basis.weight(i) > 0.02 * facet.area()));
        }
    }

    #[test]
    fn a_dropped_edge_leaves_a_constant_across() {
        let facet = facets()[1];
        // Nodes 0 and 3 (the left edge) are dropped: constant along the first axis.
        let basis = DualBasis::new(Shape::Quad4, &facet.points(), 0b1001).unwrap();
        let (mut left, mut right) = ([0.0; MOST_NODES], [0.0; MOST_NODES]);
        basis.values([-1.0, 0.3, 0.0], &mut left);
        basis.values([1.0, 0.3, 0.0], &mut right);
        for i in 0..4 {
            assert!((left[i] - right[i]).abs() < 1e-14);
        }
        assert!((basis.weight(1) - 0.5).abs() < 1e-14);
        assert!(DualBasis::new(Shape::Quad4, &facet.points(), 0b1111).is_none());
    }
}
