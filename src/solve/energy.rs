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

/// Potential energy of the state that `problem` evaluated last: what is stored and dissipated, less the
/// work that the present loads would have done on the way from rest (J; 2D: per metre of thickness).
/// Under the same loads and prescribed displacements, from the same history, stable states are its
/// minima. Collective.
pub(super) fn potential(problem: &Problem<'_>) -> f64 {
    let mut load = problem.load.clone();
    problem.all.nodes.add_to_owners(&mut load, problem.all.dim);
    let owned = problem.all.nodes.owned * problem.all.dim;
    let work: f64 = load[..owned].iter().zip(&problem.displacement).map(|(f, u)| f * u).sum();
    let [stored, dissipated] = held(problem, &load);
    let mut sum = [stored + dissipated - work];
    problem.comm.sum(&mut sum);
    sum[0]
}

/// What this rank's part of a state stores and has dissipated (J), with the loads summed at its nodes.
fn held(problem: &Problem<'_>, load: &[f64]) -> [f64; 2] {
    let (all, dim) = (&problem.all, problem.all.dim);
    let forces = problem.bulk_force.iter().zip(load).zip(&problem.displacement);
    let owned = forces.take(all.nodes.owned * dim);
    let mut stored: f64 = owned.map(|((force, load), u)| 0.5 * u * (force + load)).sum();
    let mut dissipated = 0.0;
    let state = &problem.interfaces;
    for (index, response) in state.response.iter().enumerate() {
        let rows = &all.secondary[index];
        let law = state.law_at(index, rows);
        let weight = rows.law_weight(dim);
        let jump = super::interfaces::to_local(response.jump, dim);
        let before = (state.dissipated[index], state.committed[index]);
        dissipated += weight * law.dissipated_after(before, response.history, jump);
        stored += weight * law.recoverable(jump, response.history);
    }
    [stored, dissipated]
}

/// What does work between two accepted states.
#[derive(Debug, Clone)]
pub(super) struct Work {
    pub(super) displacement: Vec<f64>,
    pub(super) force: Vec<f64>,
    pub(super) total: f64,
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
        let mut work = 0.0;
        for node in 0..all.nodes.owned {
            for c in 0..dim {
                let i = node * dim + c;
                let u = problem.displacement[i];
                let support = if all.prescribed[node][c] { problem.balance[i] } else { 0.0 };
                let force = support + load[i];
                work += 0.5 * (self.force[i] + force) * (u - self.displacement[i]);
                self.displacement[i] = u;
                self.force[i] = force;
            }
        }
        let [stored, dissipated] = held(problem, &load);
        let mut sums = [stored, dissipated, work];
        problem.comm.sum(&mut sums);
        self.total += sums[2];
        Energy { elastic: sums[0], dissipated: sums[1], external: self.total }
    }
}
