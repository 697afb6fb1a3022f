//! Energy: stored, dissipated, and the work of supports and loads.

use super::Problem;

/// Energies of an accepted state (J; 2D: per metre of thickness).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Energy {
    /// Stored in the bulk, and what the interfaces give back.
    pub elastic: f64,
    /// Dissipated by the interfaces since the start.
    pub dissipated: f64,
    /// Work of supports and loads since the start, trapezoidal between accepted states.
    pub external: f64,
}

/// What does work between two accepted states.
#[derive(Debug, Clone)]
pub(super) struct Work {
    displacement: Vec<f64>,
    force: Vec<f64>,
    total: f64,
}

impl Work {
    /// At rest, with `size` owned components.
    pub fn new(size: usize) -> Self {
        Self { displacement: vec![0.0; size], force: vec![0.0; size], total: 0.0 }
    }

    /// Energies of the state that `problem` evaluated last and its interfaces have committed; its
    /// work adds to that of the states before. Collective.
    pub fn accept(&mut self, problem: &Problem<'_>) -> Energy {
        let (all, dim) = (&problem.all, problem.all.dim);
        let mut load = problem.load.clone();
        all.nodes.add_to_owners(&mut load, dim);
        let (mut stored, mut work) = (0.0, 0.0);
        for node in 0..all.nodes.owned {
            for c in 0..dim {
                let i = node * dim + c;
                let u = problem.displacement[i];
                stored += 0.5 * u * (problem.bulk_force[i] + load[i]);
                let support = if all.prescribed[node][c] { problem.balance[i] } else { 0.0 };
                let force = support + load[i];
                work += 0.5 * (self.force[i] + force) * (u - self.displacement[i]);
                self.displacement[i] = u;
                self.force[i] = force;
            }
        }
        let mut dissipated = 0.0;
        let state = &problem.interfaces;
        for (index, (rows, response)) in all.secondary.iter().zip(&state.response).enumerate() {
            let law = state.laws[rows.interface].spec.law();
            let weight = rows.law_weight(dim);
            dissipated += weight * state.dissipated[index];
            let jump = super::interfaces::to_local(response.jump, dim);
            stored += weight * law.recoverable(jump, response.history);
        }
        let mut sums = [stored, dissipated, work];
        problem.comm.sum(&mut sums);
        self.total += sums[2];
        Energy { elastic: sums[0], dissipated: sums[1], external: self.total }
    }
}
