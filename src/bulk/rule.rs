//! The shape functions of a cell at the points of a rule.

use crate::element::{MAX_NODES, QuadraturePoint, Shape};

/// A point of a rule on a reference cell, with the nodal basis there.
#[derive(Debug, Clone)]
pub struct RulePoint {
    /// Weight on the reference cell.
    pub weight: f64,
    /// Values of the basis, one per node.
    pub values: Vec<f64>,
    /// Derivatives by the reference coordinates, one per node.
    pub gradients: Vec<[f64; 3]>,
}

/// Derivatives by the position at one point of a cell.
pub struct Physical {
    /// Of each function of the basis by each coordinate (1/m); those beyond the nodes and the
    /// dimension mean nothing.
    pub gradients: [[f64; 3]; MAX_NODES],
    /// `inverse[i][d]`: derivative of reference coordinate d by coordinate i (1/m).
    inverse: [[f64; 3]; 3],
    /// Determinant of the Jacobian (m^dim).
    pub determinant: f64,
}

impl RulePoint {
    /// The basis of `shape` at a point.
    pub fn new(shape: Shape, point: QuadraturePoint) -> Self {
        let (mut values, mut gradients) = (vec![0.0; shape.nodes()], vec![[0.0; 3]; shape.nodes()]);
        shape.values(point.xi, &mut values);
        shape.gradients(point.xi, &mut gradients);
        Self { weight: point.weight, values, gradients }
    }

    /// The basis of `shape` at the points of a rule.
    pub fn all(shape: Shape, rule: Vec<QuadraturePoint>) -> Vec<Self> {
        rule.into_iter().map(|point| Self::new(shape, point)).collect()
    }

    /// The point of a cell with these nodes (m).
    #[inline(always)]
    pub fn position(&self, points: &[[f64; 3]]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (value, point) in self.values.iter().zip(points) {
            (0..3).for_each(|i| sum[i] += value * point[i]);
        }
        sum
    }

    /// Derivatives by the first `DIM` coordinates of the nodes (m), which the cell fills.
    #[inline(always)]
    pub fn physical<const DIM: usize>(&self, points: &[[f64; 3]]) -> Physical {
        let mut j = [[0.0; 3]; 3];
        for (gradient, point) in self.gradients.iter().zip(points) {
            for i in 0..DIM {
                for d in 0..DIM {
                    j[i][d] += point[i] * gradient[d];
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
        let cofactors: [[f64; 3]; 3] =
            std::array::from_fn(|i| std::array::from_fn(|d| cofactor(i, d)));
        let determinant = (0..DIM).map(|d| j[0][d] * cofactors[0][d]).sum::<f64>();
        let inverse = cofactors.map(|row| row.map(|c| c / determinant));
        let mut gradients = [[0.0; 3]; MAX_NODES];
        for (out, gradient) in gradients.iter_mut().zip(&self.gradients) {
            for i in 0..DIM {
                out[i] = (0..DIM).map(|d| inverse[i][d] * gradient[d]).sum();
            }
        }
        Physical { gradients, inverse, determinant }
    }
}

impl Physical {
    /// Derivatives by the position (1/m) of a function with these reference derivatives.
    pub fn by_position(&self, reference: [f64; 3], dim: usize) -> [f64; 3] {
        let mut out = [0.0; 3];
        for (out, row) in out.iter_mut().zip(&self.inverse).take(dim) {
            *out = row[..dim].iter().zip(reference).map(|(j, g)| j * g).sum();
        }
        out
    }
}
