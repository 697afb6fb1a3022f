//! Starts linear solves from earlier corrections.
//!
//! The bulk answers linearly, so the solution of a linear system lies close to the span of the
//! corrections that were found before. The start is the element of that span which is closest in
//! the energy norm of the present matrix; it costs one product per kept correction.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::comm::Comm;
use crate::error::Result;
use crate::petsc::{Matrix, Petsc, Vector};

/// Corrections that are kept.
const KEPT: usize = 8;
/// Directions whose energy is smaller than this, relative to the largest, are left out.
const SMALLEST_ENERGY: f64 = 1e-13;

/// The last corrections of one rank.
pub struct Recycle {
    corrections: Vec<Vec<f64>>,
    x: Vector,
    y: Vector,
}

impl Recycle {
    /// Nothing kept yet; for `owned` unknowns in blocks of `dim`. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn new(petsc: &Petsc, owned: usize, dim: usize) -> Result<Self> {
        let x = Vector::new(petsc, owned, dim)?;
        Ok(Self { corrections: Vec::new(), y: x.duplicate()?, x })
    }

    /// Keeps a correction of the displacements (owned components). Local.
    pub fn keep(&mut self, correction: &[f64]) {
        if self.corrections.len() == KEPT {
            self.corrections.remove(0);
        }
        self.corrections.push(correction.to_vec());
    }

    /// Adds the best start to `guess`. `free` marks the components that the matrix couples; the
    /// others stay. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn guess(
        &mut self,
        comm: &Comm,
        matrix: &Matrix,
        free: &[bool],
        rhs: &[f64],
        guess: &mut [f64],
    ) -> Result<()> {
        let n = self.corrections.len();
        let masked = |v: &[f64], i: usize| if free[i] { v[i] } else { 0.0 };
        // Upper triangle of V^T J V, then V^T rhs.
        let mut products = Vec::with_capacity(n * (n + 3) / 2);
        for (j, v) in self.corrections.iter().enumerate() {
            {
                let mut x = self.x.write()?;
                x.iter_mut().enumerate().for_each(|(i, x)| *x = masked(v, i));
            }
            matrix.multiply(&self.x, &mut self.y)?;
            let y = self.y.read()?;
            for u in &self.corrections[..=j] {
                products.push((0..y.len()).map(|i| masked(u, i) * y[i]).sum::<f64>());
            }
            products.push((0..rhs.len()).map(|i| masked(v, i) * rhs[i]).sum::<f64>());
        }
        comm.sum(&mut products);
        let Some(weights) = best_weights(n, &products) else { return Ok(()) };
        for (weight, v) in weights.iter().zip(&self.corrections) {
            guess.iter_mut().enumerate().for_each(|(i, g)| *g += weight * masked(v, i));
        }
        Ok(())
    }
}

/// Minimiser of the energy over the span, from the packed products; none if no direction has
/// positive energy. The vectors are scaled to unit energy first.
fn best_weights(n: usize, products: &[f64]) -> Option<DVector<f64>> {
    if n == 0 {
        return None;
    }
    let (mut energy, mut rhs) = (DMatrix::zeros(n, n), DVector::zeros(n));
    let mut next = products.iter().copied();
    for j in 0..n {
        for i in 0..=j {
            let value = next.next()?;
            (energy[(i, j)], energy[(j, i)]) = (value, value);
        }
        rhs[j] = next.next()?;
    }
    let scale = DVector::from_fn(n, |i, _| {
        let e: f64 = energy[(i, i)];
        if e > 0.0 { 1.0 / e.sqrt() } else { 0.0 }
    });
    let scaled = DMatrix::from_fn(n, n, |i, j| scale[i] * energy[(i, j)] * scale[j]);
    let spectrum = SymmetricEigen::new(scaled);
    let largest = spectrum.eigenvalues.iter().copied().fold(0.0, f64::max);
    if largest <= 0.0 {
        return None;
    }
    let mut weights = DVector::zeros(n);
    for (value, vector) in spectrum.eigenvalues.iter().zip(spectrum.eigenvectors.column_iter()) {
        if *value > SMALLEST_ENERGY * largest {
            let part = vector.dot(&rhs.component_mul(&scale)) / value;
            weights += part * vector;
        }
    }
    Some(weights.component_mul(&scale))
}

#[cfg(test)]
mod tests {
    use super::best_weights;

    #[test]
    fn the_span_of_the_solution_gives_the_solution() {
        // J = diag(1, 2, 4), V = {e1 + e2, e1 - e2, 2 e1}: dependent; rhs = J (3, 5, 0).
        let v = [[1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [2.0, 0.0, 0.0]];
        let diagonal = [1.0, 2.0, 4.0];
        let solution = [3.0, 5.0, 0.0];
        let dot = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|i| a[i] * diagonal[i] * b[i]).sum();
        let mut products = Vec::new();
        for j in 0..3 {
            products.extend((0..=j).map(|i| -> f64 { dot(&v[i], &v[j]) }));
            products.push(dot(&v[j], &solution));
        }
        let weights = best_weights(3, &products).expect("positive energies");
        for (axis, exact) in solution.iter().enumerate() {
            let found: f64 = (0..3).map(|i| weights[i] * v[i][axis]).sum();
            assert!((found - exact).abs() < 1e-12, "{found} {exact}");
        }
    }

    #[test]
    fn directions_without_positive_energy_give_no_start() {
        assert!(best_weights(1, &[-1.0, 5.0]).is_none());
        assert!(best_weights(0, &[]).is_none());
    }
}
