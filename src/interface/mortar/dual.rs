//! The biorthogonal (dual) multiplier basis of a facet, some of whose nodes carry no multiplier.

#![allow(clippy::needless_range_loop)] // index notation, as in the formulas

use nalgebra::DMatrix;

use super::MOST_NODES;
use super::edges::EdgeBasis;
use crate::element::{QuadraturePoint, Shape};

/// Multiplier basis Phi_i of a facet, one function per kept node, in the span of the nodal
/// basis: $\int\Phi_i N_k = \delta_{ik}\int N_k$ for kept k, and $\sum_i \Phi_i = 1$.
///
/// For N_k stands the nodal basis, or that of [`EdgeBasis`], which facets of second order need
/// wherever there are triangles among them.
///
/// The function of a dropped node b is handed to its neighbours (constant extension):
/// $\Psi_i = N_i + \sum_b \theta_{ib} N_b$, where the nearest kept nodes of the reference facet
/// share equally. Then $\Phi = A\Psi$ with
/// $A = D M^{-1}$, $M_{jk} = \int\Psi_j N_k$, $D_k = \int N_k$, over kept nodes.
///
/// With the transformed basis of facets of second order the multipliers are handed over instead:
/// $\Phi_i = \Phi^0_i + \sum_b \theta_{ib} \Phi^0_b$ of the basis $\Phi^0$ in which nothing is
/// dropped. So every weight is $D_i + \sum_b \theta_{ib} D_b$ and positive, which the other way
/// does not give there.
///
/// Where nothing is dropped the basis of a first-order facet reproduces constants, that of a
/// second-order one linear functions: enough for the optimal order of the displacement.
///
/// # Source
/// Wohlmuth (2000), SIAM J. Numer. Anal. 38, 989-1012; constant extension as at cross points there.
#[derive(Debug, Clone, PartialEq)]
pub struct DualBasis {
    nodal: EdgeBasis,
    kept: Vec<usize>,
    /// `coefficients[i][b]`: Phi of the local node i = sum over b of it times the function b of
    /// `nodal`; zero if dropped.
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
        Self::to(EdgeBasis::plain(shape), points, dropped)
    }

    /// The basis that is biorthogonal to `nodal`; otherwise as [`DualBasis::new`].
    ///
    /// None also if the points fill so small a part of the facet that the functions of its nodes
    /// cannot be told apart there to eight digits.
    pub fn to(nodal: EdgeBasis, points: &[QuadraturePoint], dropped: u16) -> Option<Self> {
        let n = nodal.shape().nodes();
        let kept: Vec<usize> = (0..n).filter(|b| dropped >> b & 1 == 0).collect();
        if kept.is_empty() {
            return None;
        }
        let (mass, whole) = integrate(nodal, points);
        let extension = extension(nodal.shape(), &kept);
        let coefficients = if nodal.is_transformed() {
            let all: Vec<usize> = (0..n).collect();
            let each = Extended { nodal, kept: &all, extension: &IDENTITY };
            hand_over(&each.coefficients(points, &mass, &whole)?, &kept, &extension)
        } else {
            let extended = Extended { nodal, kept: &kept, extension: &extension };
            extended.coefficients(points, &mass, &whole)?
        };
        let (mut integrals, mut weights) = ([[0.0; MOST_NODES]; MOST_NODES], [0.0; MOST_NODES]);
        for &i in &kept {
            for k in 0..n {
                integrals[i][k] = if k == i {
                    whole[i]
                } else if kept.contains(&k) {
                    0.0
                } else {
                    (0..n).map(|b| coefficients[i][b] * mass[b][k]).sum()
                };
            }
            weights[i] = integrals[i].iter().sum();
            integrals[i] = nodal.of_nodal_values(integrals[i]);
        }
        Some(DualBasis { nodal, kept, coefficients, integrals, weights })
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
    /// exactly zero for the other kept nodes, but for the two corners of the edge of a middle i
    /// that has given them its shares ([`EdgeBasis`]).
    pub fn integrals(&self, i: usize) -> &[f64] {
        &self.integrals[i][..self.nodal.shape().nodes()]
    }

    /// `out[i]` = Phi_i at the reference point `xi`, for each local node; zero for dropped ones.
    /// Also the rule that gives a traction to dropped nodes: sum of Phi_i times its multiplier.
    ///
    /// # Panics
    /// If `out` is shorter than the number of nodes.
    pub fn values(&self, xi: [f64; 3], out: &mut [f64]) {
        let n = self.nodal.shape().nodes();
        let values = self.nodal.values(xi);
        for (value, coefficients) in out[..n].iter_mut().zip(&self.coefficients) {
            *value = coefficients[..n].iter().zip(values).map(|(c, v)| c * v).sum();
        }
    }
}

/// Coefficients of a basis that is far from losing digits: whole facets stay below a tenth of it.
const WELL: f64 = 1e3;

/// Coefficients of this size lose eight digits; parts of a facet where they are larger are small.
const MOST: f64 = 1e8;

type Matrix = [[f64; MOST_NODES]; MOST_NODES];

/// Whether the absolute coefficients of each function add up to no more than `most`.
fn within(coefficients: &Matrix, most: f64) -> bool {
    coefficients.iter().all(|row| row.iter().map(|c| c.abs()).sum::<f64>() <= most)
}

/// The extended functions $\Psi_i = \sum_b$ `extension[i][b]` $N_b$ of the kept nodes.
struct Extended<'a> {
    nodal: EdgeBasis,
    kept: &'a [usize],
    extension: &'a Matrix,
}

impl Extended<'_> {
    /// Coefficients of $\Phi = D M^{-1} \Psi$; none if they lose too many digits.
    fn coefficients(
        &self,
        points: &[QuadraturePoint],
        mass: &Matrix,
        whole: &[f64; MOST_NODES],
    ) -> Option<Matrix> {
        let (n, kept) = (self.nodal.shape().nodes(), self.kept);
        let m = DMatrix::from_fn(kept.len(), kept.len(), |j, k| {
            (0..n).map(|b| self.extension[kept[j]][b] * mass[b][kept[k]]).sum::<f64>()
        });
        let from = |inverse: DMatrix<f64>| {
            let mut out = [[0.0; MOST_NODES]; MOST_NODES];
            for (row, &i) in kept.iter().enumerate() {
                for b in 0..n {
                    out[i][b] = (0..kept.len())
                        .map(|j| whole[i] * inverse[(row, j)] * self.extension[kept[j]][b])
                        .sum();
                }
            }
            out
        };
        let inverse = m.clone().try_inverse().filter(|inverse| belong(&m, inverse, 1e-10));
        let quick = inverse.map(from).filter(|c| within(c, WELL));
        let careful = || self.inverse(points).filter(|inverse| belong(&m, inverse, 1e-2)).map(from);
        quick.or_else(careful).filter(|c| within(c, MOST))
    }

    /// The inverse of M that loses half as many digits as that of the mass matrix: with the
    /// functions orthogonalized over the points, V = Q R, it is $M = E R^T R S$ (E the extension, S
    /// the choice of the kept nodes), and R S = Q' R' once more.
    fn inverse(&self, points: &[QuadraturePoint]) -> Option<DMatrix<f64>> {
        let (n, kept) = (self.nodal.shape().nodes(), self.kept);
        if points.len() < n {
            return None;
        }
        let mut v = DMatrix::zeros(points.len(), n);
        for (p, point) in points.iter().enumerate() {
            let values = self.nodal.values(point.xi);
            (0..n).for_each(|b| v[(p, b)] = point.weight.sqrt() * values[b]);
        }
        let r = v.qr().r();
        let chosen = DMatrix::from_fn(n, kept.len(), |a, k| r[(a, kept[k])]).qr();
        let extension = DMatrix::from_fn(kept.len(), n, |j, b| self.extension[kept[j]][b]);
        let left = extension * r.transpose() * chosen.q();
        let right = chosen.r();
        let inverse = right.solve_upper_triangular(&DMatrix::identity(kept.len(), kept.len()))?;
        Some(inverse * left.lu().try_inverse()?)
    }
}

/// Whether the product of both is the identity but for errors of this size: the formulas of small
/// inverses give anything for matrices that are singular to rounding.
fn belong(m: &DMatrix<f64>, inverse: &DMatrix<f64>, most: f64) -> bool {
    let identity = DMatrix::identity(m.nrows(), m.nrows());
    (m * inverse - identity).iter().all(|error| error.abs() <= most)
}

/// The functions of the dropped nodes handed to the kept ones.
fn hand_over(each: &Matrix, kept: &[usize], extension: &Matrix) -> Matrix {
    let mut out = [[0.0; MOST_NODES]; MOST_NODES];
    for &i in kept {
        for b in (0..MOST_NODES).filter(|b| extension[i][*b] != 0.0) {
            for k in 0..MOST_NODES {
                out[i][k] += extension[i][b] * each[b][k];
            }
        }
    }
    out
}

const IDENTITY: Matrix = {
    let mut out = [[0.0; MOST_NODES]; MOST_NODES];
    let mut i = 0;
    while i < MOST_NODES {
        out[i][i] = 1.0;
        i += 1;
    }
    out
};

/// The mass matrix of a basis, and the integrals of its functions.
fn integrate(nodal: EdgeBasis, points: &[QuadraturePoint]) -> (Matrix, [f64; MOST_NODES]) {
    let n = nodal.shape().nodes();
    let (mut mass, mut whole) = ([[0.0; MOST_NODES]; MOST_NODES], [0.0; MOST_NODES]);
    for point in points {
        let values = nodal.values(point.xi);
        for b in 0..n {
            whole[b] += point.weight * values[b];
            for k in 0..n {
                mass[b][k] += point.weight * values[b] * values[k];
            }
        }
    }
    (mass, whole)
}

/// `[i][b]`: the share of N_b in Psi_i; rows of dropped nodes are zero, columns sum to 1.
fn extension(shape: Shape, kept: &[usize]) -> Matrix {
    let (n, points) = (shape.nodes(), shape.node_points());
    let mut out = [[0.0; MOST_NODES]; MOST_NODES];
    for b in 0..n {
        if kept.contains(&b) {
            out[b][b] = 1.0;
            continue;
        }
        let away = |i: usize| distance(shape, points[i], points[b]);
        let nearest = kept.iter().map(|&i| away(i)).fold(f64::INFINITY, f64::min);
        let heirs: Vec<usize> = kept.iter().copied().filter(|&i| away(i) == nearest).collect();
        for &i in &heirs {
            out[i][b] = 1.0 / heirs.len() as f64;
        }
    }
    out
}

/// The square of the distance of two points of the reference facet; triangles count as equilateral,
/// so that no corner is preferred.
fn distance(shape: Shape, a: [f64; 3], b: [f64; 3]) -> f64 {
    let [x, y] = [a[0] - b[0], a[1] - b[1]];
    let squares = x.powi(2) + y.powi(2);
    if shape.corners() == Shape::Tri3 { squares + x * y } else { squares }
}
