//! Energy: stored, dissipated, and the work of supports and loads.

use super::Prestress;
use crate::solve::Problem;

/// Energies of an accepted state (J; 2D: per metre of thickness).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Energy {
    /// Stored in the bulk, and what the interfaces give back.
    pub elastic: f64,
    /// Dissipated by the interfaces since the start.
    pub dissipated: f64,
    /// Work of supports and loads since the start, trapezoidal between accepted states.
    pub external: f64,
    /// Taken by friction since the start, likewise.
    pub friction: f64,
    /// Likewise of the fluid in the pores and in open interfaces on the skeleton.
    pub fluid: f64,
}

/// Potential energy of the state that `problem` evaluated last: what is stored and dissipated, less
/// the work that the present loads would have done on the way from rest (J; 2D: per metre of
/// thickness). Under the same loads and prescribed displacements, from the same history, stable
/// states are its minima. Collective.
pub(in crate::solve) fn potential(problem: &Problem<'_>) -> f64 {
    let load = problem.applied();
    let owned = problem.all.nodes.owned * problem.all.dim;
    let work: f64 = load[..owned].iter().zip(&problem.displacement).map(|(f, u)| f * u).sum();
    let [stored, dissipated] = held(problem, &load);
    let mut sum = [stored + dissipated - work];
    problem.comm.sum(&mut sum);
    sum[0] - problem.work_on_platens()
}

/// As [`potential`], with all damage as in the accepted state, whatever the laws answer: what the
/// state has to give before anything gives way. None where lips have come into each other.
/// Collective.
pub(super) fn potential_as_accepted(problem: &Problem<'_>) -> Option<f64> {
    let (all, dim, state) = (&problem.all, problem.all.dim, &problem.interfaces);
    let load = problem.applied();
    let forces = problem.bulk_force.iter().zip(&load).zip(&problem.displacement);
    let mut sum: f64 = forces
        .take(all.nodes.owned * dim)
        .map(|((force, load), u)| 0.5 * u * (force + load) - u * load)
        .sum();
    sum += of_prestress(problem);
    let (mut is_pressed_in, moved) = (false, problem.convergence.current().displacement);
    for (index, response) in state.response.iter().enumerate() {
        let rows = &all.secondary[index];
        let jump = crate::solve::model::interfaces::to_local(response.jump, dim);
        is_pressed_in |= jump[0] < -PRESSED_IN * moved;
        let law = state.law_at(index, rows);
        let stored = law.recoverable(jump, state.committed[index]);
        let dissipated = state.dissipated[index] - state.dissipated_before(all, index);
        sum += rows.law_weight(dim) * (stored + dissipated);
    }
    let mut sums = [sum];
    problem.comm.sum(&mut sums);
    let energy = sums[0] - problem.work_on_platens();
    (!problem.comm.any(is_pressed_in)).then_some(energy)
}

/// Part of the displacements by which lips come into each other for rounding.
const PRESSED_IN: f64 = 1e-6;

/// What this rank's part of a state stores and has dissipated (J), with all that acts on the bulk
/// summed at its nodes.
fn held(problem: &Problem<'_>, load: &[f64]) -> [f64; 2] {
    let (all, dim) = (&problem.all, problem.all.dim);
    let forces = problem.bulk_force.iter().zip(load).zip(&problem.displacement);
    let owned = forces.take(all.nodes.owned * dim);
    let mut stored: f64 = owned.map(|((force, load), u)| 0.5 * u * (force + load)).sum();
    stored += of_prestress(problem);
    let mut dissipated = 0.0;
    let state = &problem.interfaces;
    for (index, response) in state.response.iter().enumerate() {
        let rows = &all.secondary[index];
        let law = state.law_at(index, rows);
        let weight = rows.law_weight(dim);
        let jump = crate::solve::model::interfaces::to_local(response.jump, dim);
        let (before, from) = (state.dissipated[index], state.committed[index]);
        let after = law.dissipated_after(before, from, response.history, jump);
        dissipated += weight * (after - state.dissipated_before(all, index));
        stored += weight * law.recoverable(jump, response.history);
    }
    [stored, dissipated]
}

/// What stresses of stages with other stiffnesses add to this rank's part of the energy of the bulk
/// (J).
fn of_prestress(problem: &Problem<'_>) -> f64 {
    let of = |prestress: &Prestress| prestress.energy(&problem.all, &problem.displacement);
    problem.prestress.as_ref().map_or(0.0, of)
}

/// What the stresses at the start add to this rank's part of the energy of the bulk (J).
fn of_stress_at_start(problem: &Problem<'_>) -> f64 {
    let force = problem.initial_stress.iter().flat_map(|stress| &stress.force);
    force.zip(&problem.displacement).map(|(force, u)| force * u).sum()
}

/// What does work between two accepted states.
#[derive(Debug, Clone)]
pub(in crate::solve) struct Work {
    pub(in crate::solve) displacement: Vec<f64>,
    pub(in crate::solve) force: Vec<f64>,
    pub(in crate::solve) total: f64,
    /// Forces of the pore pressure (N); empty without one.
    pub(in crate::solve) pore_force: Vec<f64>,
    /// Their work.
    pub(in crate::solve) of_fluid: f64,
    /// Stored, dissipated and taken by friction where earlier stages had multipliers and this one
    /// has none (J).
    pub(in crate::solve) elsewhere: [f64; 3],
    /// Elastic energy of the state from which results count (J).
    pub(in crate::solve) elastic_at_start: f64,
}

impl Work {
    /// At rest, with `size` owned components.
    pub fn new(size: usize) -> Self {
        let (displacement, force) = (vec![0.0; size], vec![0.0; size]);
        let (pore_force, elsewhere) = (Vec::new(), [0.0; 3]);
        let (total, of_fluid, elastic_at_start) = (0.0, 0.0, 0.0);
        Self { displacement, force, total, pore_force, of_fluid, elsewhere, elastic_at_start }
    }

    /// Lets energies count from the state that was accepted last, which stores `elastic`. Local.
    pub fn count_from_here(&mut self, elastic: f64) {
        (self.total, self.of_fluid, self.elastic_at_start) = (0.0, 0.0, elastic);
    }

    /// Energies of the state that `problem` evaluated last and its interfaces have committed; its
    /// work adds to that of the states before. Collective.
    pub fn accept(&mut self, problem: &Problem<'_>) -> Energy {
        let (all, dim) = (&problem.all, problem.all.dim);
        let mut load = problem.load.clone();
        all.nodes.add_to_owners(&mut load, dim);
        // The stresses at the start are no load: their work is stored.
        if let Some(stress) = &problem.initial_stress {
            let mut force = stress.force.clone();
            all.nodes.add_to_owners(&mut force, dim);
            load.iter_mut().zip(&force).for_each(|(load, force)| *load += force);
        }
        let mut pore_force = problem.pore_force.clone();
        if !pore_force.is_empty() {
            all.nodes.add_to_owners(&mut pore_force, dim);
            self.pore_force.resize(self.displacement.len(), 0.0);
        }
        let (mut work, mut of_fluid) = (0.0, 0.0);
        for node in 0..all.nodes.owned {
            for c in 0..dim {
                let i = node * dim + c;
                let u = problem.displacement[i];
                let support = if all.prescribed[node][c] { problem.balance[i] } else { 0.0 };
                let force = support + load[i];
                let step = u - self.displacement[i];
                work += 0.5 * (self.force[i] + force) * step;
                if let Some(before) = self.pore_force.get_mut(i) {
                    of_fluid += 0.5 * (*before + pore_force[i]) * step;
                    *before = pore_force[i];
                }
                self.displacement[i] = u;
                self.force[i] = force;
            }
        }
        let mut sums = [work, of_fluid];
        problem.comm.sum(&mut sums);
        self.total += sums[0];
        self.of_fluid += sums[1];
        let (external, fluid) = (self.total, self.of_fluid);
        let [elastic, dissipated, friction] = self.energies(problem);
        Energy { elastic, dissipated, external, friction, fluid }
    }

    /// What the state that `problem` evaluated last stores, has dissipated and has lost to friction
    /// (J). Collective.
    pub fn energies(&self, problem: &Problem<'_>) -> [f64; 3] {
        let [stored, dissipated] = held(problem, &problem.applied());
        let friction = problem.interfaces.sliding.iter().map(|node| node.energy).sum();
        let mut sums = [stored + of_stress_at_start(problem), dissipated, friction];
        problem.comm.sum(&mut sums);
        sums[0] -= self.elastic_at_start;
        std::array::from_fn(|i| sums[i] + self.elsewhere[i])
    }
}
