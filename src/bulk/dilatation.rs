//! The projection of the volumetric strain of a cell on polynomials of low degree (B-bar).
//!
//! T. Hughes, Int. J. Numer. Methods Engrg. 15, 1980.

#![allow(clippy::needless_range_loop)] // index notation, as in the formulas

use crate::element::MAX_NODES;

/// Integrals over a cell of 1 and the coordinates against the divergences of the basis and against
/// each other.
pub struct Dilatation {
    /// The coordinates are counted from here (m), so that nothing cancels.
    origin: [f64; 3],
    /// Whether the polynomials are linear, not constant.
    linear: bool,
    volume: f64,
    first: [f64; 3],
    second: [[f64; 3]; 3],
    /// Against the divergences: of 1, then of each coordinate.
    of_nodes: [[f64; 3 * MAX_NODES]; 4],
}

impl Dilatation {
    /// Of a cell with these nodes (m).
    pub fn new(points: &[[f64; 3]], linear: bool) -> Self {
        let mut origin = [0.0; 3];
        for point in points {
            (0..3).for_each(|i| origin[i] += point[i] / points.len() as f64);
        }
        Self {
            origin,
            linear,
            volume: 0.0,
            first: [0.0; 3],
            second: [[0.0; 3]; 3],
            of_nodes: [[0.0; 3 * MAX_NODES]; 4],
        }
    }

    /// Adds a point of the rule, with the gradients of the nodes there (1/m) and its volume.
    #[inline(always)]
    pub fn add<const DIM: usize>(&mut self, at: [f64; 3], gradients: &[[f64; 3]], volume: f64) {
        let x: [f64; 3] = std::array::from_fn(|i| at[i] - self.origin[i]);
        self.volume += volume;
        if self.linear {
            for i in 0..DIM {
                self.first[i] += volume * x[i];
                (0..DIM).for_each(|j| self.second[i][j] += volume * x[i] * x[j]);
            }
        }
        let functions = self.functions::<DIM>();
        for (m, of_nodes) in self.of_nodes.iter_mut().enumerate().take(functions) {
            let factor = if m == 0 { volume } else { volume * x[m - 1] };
            for (out, g) in of_nodes.chunks_exact_mut(DIM).zip(gradients) {
                (0..DIM).for_each(|i| out[i] += factor * g[i]);
            }
        }
    }

    /// The integrals of an orthonormal basis of the polynomials against the divergences, by node
    /// and component (m^(dim/2 - 1)): the squares of their products with nodal displacements sum to
    /// that of the projected strain. Those beyond the basis are zero.
    #[inline(always)]
    pub fn vectors<const DIM: usize>(&self) -> [[f64; 3 * MAX_NODES]; 4] {
        let mut vectors = [[0.0; 3 * MAX_NODES]; 4];
        vectors[0] = self.of_nodes[0];
        if self.linear {
            let mean = self.first.map(|s| s / self.volume);
            // Gram's matrix of the coordinates less their mean, by Cholesky.
            let mut l = [[0.0; 3]; 3];
            for i in 0..DIM {
                let mut vector = self.of_nodes[1 + i];
                let constant = self.of_nodes[0];
                vector.iter_mut().zip(constant).for_each(|(v, c)| *v -= mean[i] * c);
                for j in 0..=i {
                    let mut entry = self.second[i][j] - mean[i] * self.first[j];
                    (0..j).for_each(|k| entry -= l[i][k] * l[j][k]);
                    l[i][j] = if i == j { entry.sqrt() } else { entry / l[j][j] };
                }
                for j in 0..i {
                    let known = vectors[1 + j];
                    vector.iter_mut().zip(known).for_each(|(v, k)| *v -= l[i][j] * k);
                }
                vector.iter_mut().for_each(|v| *v /= l[i][i]);
                vectors[1 + i] = vector;
            }
        }
        let length = self.volume.sqrt();
        vectors[0].iter_mut().for_each(|v| *v /= length);
        vectors
    }

    /// Functions of the basis of the polynomials.
    pub fn functions<const DIM: usize>(&self) -> usize {
        if self.linear { 1 + DIM } else { 1 }
    }
}
