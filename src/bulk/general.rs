//! Isotropic linear elasticity on cells of every kind and shape, fully integrated or B-bar.
//!
//! Small strain, plane strain in 2D, isoparametric. Nothing is stored per cell: what a cell needs
//! follows from the positions of its nodes.

#![allow(clippy::needless_range_loop)] // index notation, as in the formulas

use super::dilatation::Dilatation;
use super::elastic::{Elastic, stress_of};
use super::rule::RulePoint;
use crate::element::{Family, MAX_NODES, QuadraturePoint, Shape, quadrature, stiffness_rule};

/// Middle nodes that lie beside the middle of their edge by less than this part of the cell's size
/// lie on it.
const STRAIGHT: f64 = 1e-12;

/// The stiffness of cells of one shape and material.
#[derive(Debug, Clone)]
pub struct General {
    shape: Shape,
    axes: &'static [usize],
    elastic: Elastic,
    b_bar: bool,
    rule: Vec<RulePoint>,
    /// Exact for the stiffness where the Jacobian is constant; of simplices only.
    straight: Vec<RulePoint>,
    centre: RulePoint,
}

impl General {
    /// Of cells whose displacement components lie along `axes`. With `b_bar` the volumetric strain
    /// is replaced by its projection on the polynomials in the coordinates of one degree less than
    /// the order. In coordinates of the reference cell these would lose an order on distorted ones
    /// (D. Arnold, D. Boffi, R. Falk, Math. Comput. 71, 2002).
    pub fn new(shape: Shape, elastic: Elastic, axes: &'static [usize], b_bar: bool) -> Self {
        let is_simplex = shape.family() == Family::Simplex;
        let straight = is_simplex.then(|| quadrature(shape, 2 * (shape.order() - 1)));
        Self {
            shape,
            axes,
            elastic,
            b_bar,
            rule: RulePoint::all(shape, rule(shape)),
            straight: RulePoint::all(shape, straight.unwrap_or_default()),
            centre: RulePoint::new(shape, QuadraturePoint { xi: shape.centroid(), weight: 1.0 }),
        }
    }

    /// The shape of the cells.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// The material.
    pub fn elastic(&self) -> Elastic {
        self.elastic
    }

    /// Whether the volumetric strain is projected; on simplices with straight sides it is its own
    /// projection.
    pub fn is_b_bar(&self) -> bool {
        self.b_bar
    }

    /// The rule on cells of any geometry.
    pub fn rule(&self) -> &[RulePoint] {
        &self.rule
    }

    /// Whether the Jacobian of a cell is known to be constant: a simplex with straight sides and
    /// the middle nodes in their middles. `points` are its nodes by displacement component (m).
    pub fn is_straight(&self, points: &[[f64; 3]]) -> bool {
        if self.straight.is_empty() {
            return false;
        }
        let corners = self.shape.corners().nodes();
        let mut allowed = 0.0_f64;
        for point in &points[1..corners] {
            (0..3).for_each(|i| allowed = allowed.max(STRAIGHT * (point[i] - points[0][i]).abs()));
        }
        let places = self.shape.node_points();
        (corners..self.shape.nodes()).all(|a| {
            let mut values = [0.0; 4];
            self.shape.corners().values(places[a], &mut values);
            (0..3).all(|i| {
                let middle: f64 = points.iter().zip(values).map(|(x, n)| n * x[i]).sum();
                (points[a][i] - middle).abs() <= allowed
            })
        })
    }

    /// K of the cell with these nodes (m, by displacement component), row by row: (n dim) x
    /// (n dim), N/m (2D: per metre of thickness).
    pub fn matrix(&self, points: &[[f64; 3]], out: &mut [f64]) {
        match self.axes.len() {
            2 => self.fill::<2>(points, out),
            _ => self.fill::<3>(points, out),
        }
    }

    #[inline(always)]
    fn fill<const DIM: usize>(&self, points: &[[f64; 3]], out: &mut [f64]) {
        let size = self.shape.nodes() * DIM;
        let out = &mut out[..size * size];
        out.fill(0.0);
        let mut flat = [0.0; 3 * MAX_NODES];
        let dilatation = self.for_points::<DIM>(points, |gradients, volume| {
            for (a, g) in gradients.iter().enumerate() {
                flat[a * DIM..][..DIM].copy_from_slice(&g[..DIM]);
            }
            // Of nodes a and b with a <= b: the integral of dN_a/dx_i dN_b/dx_j.
            for (row, target) in out.chunks_exact_mut(size).enumerate() {
                let factor = volume * flat[row];
                let first = row / DIM * DIM;
                let columns = flat[first..size].iter();
                target[first..].iter_mut().zip(columns).for_each(|(w, g)| *w += factor * g);
            }
        });
        let (at_points, on_projection) = self.lame(dilatation.is_some());
        let mu = self.elastic.mu;
        for (a, b) in pairs(self.shape.nodes()) {
            let at = |i: usize, j: usize| (a * DIM + i) * size + b * DIM + j;
            let w: [[f64; DIM]; DIM] =
                std::array::from_fn(|i| std::array::from_fn(|j| out[at(i, j)]));
            let trace = mu * (0..DIM).map(|i| w[i][i]).sum::<f64>();
            for (i, j) in (0..DIM).flat_map(|i| (0..DIM).map(move |j| (i, j))) {
                let k = at_points * w[i][j] + mu * w[j][i];
                out[at(i, j)] = if i == j { k + trace } else { k };
            }
        }
        for vector in dilatation.iter().flat_map(basis::<DIM>) {
            for row in 0..size {
                let factor = on_projection * vector[row];
                let first = row / DIM * DIM;
                let target = &mut out[row * size..][first..size];
                let columns = vector[first..size].iter();
                target.iter_mut().zip(columns).for_each(|(k, d)| *k += factor * d);
            }
        }
        for row in 0..size {
            for column in 0..row / DIM * DIM {
                out[row * size + column] = out[column * size + row];
            }
        }
    }

    /// The diagonal of [`General::matrix`].
    pub fn diagonal(&self, points: &[[f64; 3]], out: &mut [f64]) {
        match self.axes.len() {
            2 => self.fill_diagonal::<2>(points, out),
            _ => self.fill_diagonal::<3>(points, out),
        }
    }

    fn fill_diagonal<const DIM: usize>(&self, points: &[[f64; 3]], out: &mut [f64]) {
        out.fill(0.0);
        let (normal, on_projection) = self.lame(self.projects(points));
        let dilatation = self.for_points::<DIM>(points, |gradients, volume| {
            for (out, g) in out.chunks_exact_mut(DIM).zip(gradients) {
                let square: f64 = (0..DIM).map(|i| g[i] * g[i]).sum();
                for i in 0..DIM {
                    let own = (normal + self.elastic.mu) * g[i] * g[i];
                    out[i] += volume * (own + self.elastic.mu * square);
                }
            }
        });
        for vector in dilatation.iter().flat_map(basis::<DIM>) {
            out.iter_mut().zip(vector).for_each(|(k, d)| *k += on_projection * d * d);
        }
    }

    fn projects(&self, points: &[[f64; 3]]) -> bool {
        self.b_bar && !self.is_straight(points)
    }

    /// Of sigma = lambda tr(eps) 1 + 2 mu eps the share of the first term that acts on the strain
    /// at a point, and that acts on its projection (Pa).
    pub fn lame(&self, projects: bool) -> (f64, f64) {
        let third = 2.0 / 3.0 * self.elastic.mu;
        if projects { (-third, self.elastic.lambda + third) } else { (self.elastic.lambda, 0.0) }
    }

    /// Calls `act` with the gradients of the nodes (1/m) and the volume (m^dim) of every point of
    /// the rule; gives what the projection of the volumetric strain takes, if there is one.
    #[inline(always)]
    fn for_points<const DIM: usize>(
        &self,
        points: &[[f64; 3]],
        mut act: impl FnMut(&[[f64; 3]], f64),
    ) -> Option<Dilatation> {
        let is_straight = self.is_straight(points);
        let rule = if is_straight { &self.straight } else { &self.rule };
        let mut dilatation =
            (self.b_bar && !is_straight).then(|| Dilatation::new(points, self.shape.order() > 1));
        for point in rule {
            let physical = point.physical::<DIM>(points);
            let gradients = &physical.gradients[..self.shape.nodes()];
            let volume = point.weight * physical.determinant;
            if let Some(dilatation) = &mut dilatation {
                dilatation.add::<DIM>(point.position(points), gradients, volume);
            }
            act(gradients, volume);
        }
        dilatation
    }

    /// Stress at the centroid of the reference cell (Pa) under the nodal displacements `u` (m): xx,
    /// yy, zz, xy, yz, xz, in 2D too (plane strain).
    pub fn stress(&self, points: &[[f64; 3]], u: &[f64]) -> [f64; 6] {
        let dim = self.axes.len();
        let physical = match dim {
            2 => self.centre.physical::<2>(points),
            _ => self.centre.physical::<3>(points),
        };
        let mut h = [[0.0; 3]; 3];
        for (u, g) in u.chunks_exact(dim).zip(&physical.gradients) {
            for (i, ai) in self.axes.iter().enumerate() {
                for (j, aj) in self.axes.iter().enumerate() {
                    h[*ai][*aj] += u[i] * g[j];
                }
            }
        }
        stress_of(self.elastic, h)
    }
}

/// The rule on cells of any geometry: it integrates the forces of a constant stress exactly, and
/// the stiffness where the Jacobian is constant. In curved tetrahedra degree 3 does both.
fn rule(shape: Shape) -> Vec<QuadraturePoint> {
    if shape == Shape::Tet10 { quadrature(shape, 3) } else { stiffness_rule(shape) }
}

/// The vectors of a projection that are not zero.
fn basis<const DIM: usize>(dilatation: &Dilatation) -> impl Iterator<Item = [f64; 3 * MAX_NODES]> {
    dilatation.vectors::<DIM>().into_iter().take(dilatation.functions::<DIM>())
}

/// The pairs of nodes with the lower one first, each with itself too.
fn pairs(nodes: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..nodes).flat_map(move |a| (a..nodes).map(move |b| (a, b)))
}

#[cfg(test)]
#[path = "general_tests.rs"]
mod tests;
