//! Starts linear solves from earlier corrections.
//!
//! The bulk answers linearly, so the solution of a linear system lies close to the span of the
//! corrections that were found before. The start is the element of that span which is closest in
//! the energy norm of the present tangent. The stiffness of the cells never changes: its products
//! with the kept corrections are kept too, and only what the interfaces change is worked out.

#![allow(clippy::needless_range_loop)] // index notation over several arrays at once

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::assembly::{CellSet, Discretization};
use crate::comm::Comm;
use crate::solve::model::interfaces::InterfaceState;

/// Corrections that are kept.
const KEPT: usize = 8;
/// Directions whose energy is smaller than this, relative to the largest, are left out.
const SMALLEST_ENERGY: f64 = 1e-13;

/// A correction of the displacements.
struct Correction {
    /// At all local nodes (m).
    v: Vec<f64>,
    /// Forces K v of the cells at owned nodes (N).
    force: Vec<f64>,
}

/// The last corrections of one rank.
#[derive(Default)]
pub struct EnergyProjection {
    kept: Vec<Correction>,
    /// V^T K V over all ranks, row by row of `kept` (J).
    energy: Vec<Vec<f64>>,
    /// Whether the last one is for one start alone.
    lent: bool,
}

impl EnergyProjection {
    /// Keeps a correction of the displacements (owned components). Collective.
    pub fn keep(&mut self, comm: &Comm, all: &Discretization, correction: &[f64]) {
        if self.kept.len() == KEPT {
            self.kept.remove(0);
            self.energy.remove(0);
            for row in &mut self.energy {
                row.remove(0);
            }
        }
        self.push(comm, all, correction);
    }

    /// Keeps a correction for the next start alone. Collective.
    pub fn lend(&mut self, comm: &Comm, all: &Discretization, correction: &[f64]) {
        self.push(comm, all, correction);
        self.lent = true;
    }

    fn push(&mut self, comm: &Comm, all: &Discretization, correction: &[f64]) {
        let owned = correction.len();
        let mut v = vec![0.0; all.nodes.len() * all.dim];
        v[..owned].copy_from_slice(correction);
        all.nodes.update_ghosts(&mut v, all.dim);
        let mut force = vec![0.0; v.len()];
        all.add_forces(CellSet::All, &v, &mut force, None);
        all.nodes.add_to_owners(&mut force, all.dim);
        force.truncate(owned);
        self.kept.push(Correction { v, force });
        let last = &self.kept[self.kept.len() - 1];
        let mut row: Vec<f64> = self.kept.iter().map(|k| dot(&k.v[..owned], &last.force)).collect();
        comm.sum(&mut row);
        for (other, product) in self.energy.iter_mut().zip(&row) {
            other.push(*product);
        }
        self.energy.push(row);
    }

    /// Adds the best start to `guess`. `free` marks the owned components whose row is not the
    /// identity; the others stay. Collective.
    pub fn guess(
        &mut self,
        comm: &Comm,
        all: &Discretization,
        interfaces: &InterfaceState,
        free: &[bool],
        rhs: &[f64],
        guess: &mut [f64],
    ) {
        self.add_best(comm, all, interfaces, free, rhs, guess);
        if std::mem::take(&mut self.lent) {
            self.kept.pop();
            self.energy.pop();
            self.energy.iter_mut().for_each(|row| row.truncate(self.kept.len()));
        }
    }

    fn add_best(
        &self,
        comm: &Comm,
        all: &Discretization,
        interfaces: &InterfaceState,
        free: &[bool],
        rhs: &[f64],
        guess: &mut [f64],
    ) {
        let n = self.kept.len();
        if n == 0 {
            return;
        }
        let mut starts: Vec<Start> =
            self.kept.iter().map(|k| Start::new(all, interfaces, k)).collect();
        // Rarely: after an interface has closed.
        if comm.any(starts.iter().any(|s| !s.change.is_empty())) {
            starts.iter_mut().for_each(|s| s.move_cells(all));
        }
        let force = |(rhs, free): (&f64, &bool)| if *free { *rhs } else { 0.0 };
        let force: Vec<f64> = rhs.iter().zip(free).map(force).collect();
        let mut products = Vec::with_capacity(n * (n + 3) / 2);
        for (j, b) in starts.iter().enumerate() {
            for a in &starts[..=j] {
                products.push(a.energy_beyond_the_cells(b, all, interfaces));
            }
            products.push(b.work(&force));
        }
        comm.sum(&mut products);
        let mut next = 0;
        for j in 0..n {
            for i in 0..=j {
                products[next] += self.energy[j][i];
                next += 1;
            }
            next += 1;
        }
        let Some(weights) = best_weights(n, &products) else { return };
        add_displacements(&starts, weights.as_slice(), free, guess);
        for (weight, start) in weights.iter().zip(&starts) {
            for (i, w) in &start.unknown {
                guess[*i] += weight * (w - start.kept.v[*i]);
            }
        }
    }
}

/// A kept correction in the unknowns and with the stuck components of the present tangent.
struct Start<'a> {
    kept: &'a Correction,
    /// Jump of each owned secondary component that is not stuck (m).
    jump: Vec<[f64; 3]>,
    /// Unknowns that are not the displacement: places and values.
    unknown: Vec<(usize, f64)>,
    /// What makes the displacement one without jumps where components are stuck: places among the
    /// owned components and values (m), and the forces of that (N).
    change: Vec<(usize, f64)>,
    force: Vec<(usize, f64)>,
}

impl<'a> Start<'a> {
    fn new(all: &Discretization, interfaces: &InterfaceState, kept: &'a Correction) -> Self {
        let dim = all.dim;
        let (mut jump, mut unknown) = (Vec::new(), Vec::new());
        let mut change = Vec::new();
        for (rows, response) in all.secondary.iter().zip(&interfaces.response) {
            let mut jumps = [0.0; 3];
            for c in 0..dim {
                let Some(row) = &rows.rows[c] else { continue };
                let own = rows.own(c) as usize;
                let w = row.trace(rows.own(c), |unknown| kept.v[unknown as usize]);
                if response.state.stuck[c] {
                    if w != 0.0 {
                        change.push((own, -w / row.own));
                    }
                    continue;
                }
                jumps[c] = w;
                if response.state.jump[c] {
                    unknown.push((own, w / row.own));
                }
            }
            jump.push(jumps);
        }
        Self { kept, jump, unknown, change, force: Vec::new() }
    }

    /// Finds the forces of the change. Collective.
    fn move_cells(&mut self, all: &Discretization) {
        let mut change = vec![0.0; self.kept.v.len()];
        self.change.iter().for_each(|(i, value)| change[*i] = *value);
        all.nodes.update_ghosts(&mut change, all.dim);
        let mut force = vec![0.0; change.len()];
        all.add_forces(CellSet::Layer, &change, &mut force, None);
        all.nodes.add_to_owners(&mut force, all.dim);
        let owned = force[..self.kept.force.len()].iter().copied().enumerate();
        self.force = owned.filter(|(_, force)| *force != 0.0).collect();
    }

    /// This rank's part of the energy product without that of the kept displacements in the cells.
    fn energy_beyond_the_cells(
        &self,
        other: &Self,
        all: &Discretization,
        interfaces: &InterfaceState,
    ) -> f64 {
        let mut sum = 0.0;
        for (i, change) in &self.change {
            sum += change * other.kept.force[*i];
        }
        for (i, force) in &other.force {
            sum += self.kept.v[*i] * force;
        }
        // Both lists rise.
        let mut forces = other.force.iter().peekable();
        for (i, change) in &self.change {
            while forces.next_if(|(j, _)| j < i).is_some() {}
            sum += forces.peek().filter(|(j, _)| j == i).map_or(0.0, |(_, force)| change * force);
        }
        let pairs = self.jump.iter().zip(&other.jump);
        for ((rows, response), (a, b)) in all.secondary.iter().zip(&interfaces.response).zip(pairs)
        {
            let weight = |c: usize| rows.rows[c].as_ref().map_or(0.0, |r| r.weight.sqrt());
            for (c, d) in (0..all.dim).flat_map(|c| (0..all.dim).map(move |d| (c, d))) {
                let tangent = weight(c) * weight(d) * response.state.tangent[c][d];
                sum += a[c] * tangent * b[d];
            }
        }
        sum
    }

    /// This rank's part of the work of a force on the unknowns, zero where they are not free.
    fn work(&self, force: &[f64]) -> f64 {
        let own = dot(&self.kept.v[..force.len()], force);
        let differing = self.unknown.iter().map(|(i, w)| (w - self.kept.v[*i]) * force[*i]);
        own + differing.sum::<f64>()
    }
}

/// Numbers that are worked on at once, which the innermost cache holds.
const TOGETHER: usize = 1024;

/// Adds the weighted sum of kept displacements at free components.
fn add_displacements(starts: &[Start<'_>], weights: &[f64], free: &[bool], guess: &mut [f64]) {
    let mut sums = [0.0; TOGETHER];
    let parts = guess.chunks_mut(TOGETHER).zip(free.chunks(TOGETHER)).enumerate();
    for (part, (guess, free)) in parts {
        let sums = &mut sums[..guess.len()];
        sums.fill(0.0);
        for (weight, start) in weights.iter().zip(starts) {
            let v = &start.kept.v[part * TOGETHER..][..guess.len()];
            sums.iter_mut().zip(v).for_each(|(sum, v)| *sum += weight * v);
        }
        for ((guess, sum), free) in guess.iter_mut().zip(sums).zip(free) {
            *guess += if *free { *sum } else { 0.0 };
        }
    }
}

/// The scalar product, in several sums that the processor works on at once.
pub(in crate::solve) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.0.iter().zip(b.0) {
        for i in 0..8 {
            sums[i] += a[i] * b[i];
        }
    }
    let rest: f64 = a.1.iter().zip(b.1).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

/// Minimiser of the energy over the span, from the packed products; none if no direction has
/// positive energy.
pub(in crate::solve) fn best_weights(n: usize, products: &[f64]) -> Option<DVector<f64>> {
    let (mut energy, mut rhs) = (DMatrix::zeros(n, n), DVector::zeros(n));
    let mut next = products.iter().copied();
    for j in 0..n {
        for i in 0..=j {
            let value = next.next()?;
            (energy[(i, j)], energy[(j, i)]) = (value, value);
        }
        rhs[j] = next.next()?;
    }
    least_energy(&energy, &rhs)
}

/// The weights for which the energy less the work of `rhs` is least, in the directions of positive
/// energy; none if there are none. The vectors are scaled to unit energy first.
pub(in crate::solve) fn least_energy(
    energy: &DMatrix<f64>,
    rhs: &DVector<f64>,
) -> Option<DVector<f64>> {
    let n = rhs.len();
    if n == 0 {
        return None;
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
