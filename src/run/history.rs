//! One row of `history.csv`: what is told of an accepted instant.

use super::probes::Probe;
use crate::case::Case;
use crate::comm::Comm;
use crate::solve::{Accepted, FluidBalance, Model, reactions};

/// The row of the instant that `model` has reached, in the order of `Case::columns`. Collective;
/// complete on every rank.
pub fn row(
    case: &Case,
    model: &Model<'_>,
    probes: &[Probe],
    time: f64,
    accepted: &Accepted,
    comm: &Comm,
) -> Vec<Option<f64>> {
    let problem = &model.stepper.problem;
    let counts = [accepted.newton_iterations, accepted.linear_iterations].map(|n| Some(n as f64));
    let factor = model.stepper.load_factor();
    let mut row = vec![Some(time), Some(factor), counts[0], counts[1]];
    debug_assert_eq!(row.len(), FIRST_OF_INTERFACES);
    row.extend(interface_statistics(case, model, comm));
    let force = |node: usize, c: usize| problem.balance[node * case.dim + c];
    let surfaces = case.supported_surfaces();
    let mut sums = reactions(&problem.all, &surfaces, force);
    comm.sum(sums.as_flattened_mut());
    row.extend(sums.iter().flat_map(|sum| &sum[..case.dim]).map(|v| Some(*v)));
    // Three components, then the pressure and whether there is one.
    let flow = model.stepper.coupling.as_ref().map(|coupling| &coupling.flow);
    let mut at_probes = vec![0.0; 5 * case.probes.len()];
    for probe in probes {
        let own = &mut at_probes[5 * probe.index..][..5];
        own[..3].copy_from_slice(&probe.displacement(problem));
        let pores = model.stepper.pores();
        if let Some(pressure) = pores.and_then(|(space, p)| probe.pressure(space, p)) {
            own[3..].copy_from_slice(&[pressure, 1.0]);
        }
    }
    comm.sum(&mut at_probes);
    for own in at_probes.chunks_exact(5) {
        row.extend(own[..case.dim].iter().map(|v| Some(*v)));
        if case.has_pressure() {
            row.push((own[4] > 0.0).then_some(own[3]));
        }
    }
    let energy = accepted.energy;
    row.extend([energy.elastic, energy.dissipated, energy.external].map(Some));
    if case.has_pressure() {
        row.push(Some(energy.fluid));
    }
    if let Some(flow) = flow {
        let FluidBalance { inflow, outflow, stored } = flow.balance;
        row.extend([inflow, outflow, stored].map(Some));
    }
    row
}

/// Puts 0 for the tractions and jumps of components that a smaller model leaves out and the model
/// asked for has, as `has` tells by interface and component. Local.
pub fn fill(case: &Case, row: &mut [Option<f64>], has: impl Fn(usize, usize) -> bool) {
    let dim = case.dim;
    let mut at = FIRST_OF_INTERFACES;
    for interface in 0..case.interfaces.len() {
        for _ in ["traction", "jump"] {
            for component in order(dim) {
                if has(interface, component) {
                    row[at..at + 3].iter_mut().for_each(|value| *value = value.or(Some(0.0)));
                }
                at += 3;
            }
        }
        // The damage.
        at += 3;
    }
}

/// Puts in the reactions of a model asked for in the place of a smaller one's, whose nodes stand
/// for more of each surface: of each surface, then the total (N). Local.
pub fn put_reactions(case: &Case, row: &mut [Option<f64>], reactions: &[[f64; 3]]) {
    let columns = case.columns();
    let places = row.iter_mut().zip(&columns).filter(|(_, name)| name.contains(".reaction_"));
    let values = reactions.iter().flat_map(|sum| &sum[..case.dim]);
    places.zip(values).for_each(|((place, _), value)| *place = Some(*value));
}

/// Columns before those of the interfaces.
const FIRST_OF_INTERFACES: usize = 4;

/// Order of the columns: the normal component first, then x and y.
fn order(dim: usize) -> impl Iterator<Item = usize> {
    std::iter::once(dim - 1).chain(0..dim - 1)
}

/// Minimum, maximum and weighted mean of a nodal quantity, gathered step by step.
#[derive(Clone, Copy)]
struct Statistic {
    least: f64,
    most: f64,
    weighted: f64,
    weight: f64,
}

impl Statistic {
    const NONE: Self =
        Self { least: f64::INFINITY, most: f64::NEG_INFINITY, weighted: 0.0, weight: 0.0 };

    fn see(&mut self, value: f64, weight: f64) {
        self.least = self.least.min(value);
        self.most = self.most.max(value);
        self.weighted += weight * value;
        self.weight += weight;
    }
}

/// Minimum, maximum and mean of every interface quantity. Collective.
fn interface_statistics(case: &Case, model: &Model<'_>, comm: &Comm) -> Vec<Option<f64>> {
    let problem = &model.stepper.problem;
    let dim = case.dim;
    // The last one is the pressure of a film.
    let per_interface = 2 * dim + 2;
    let is_film = |interface: usize| case.interfaces[interface].film.is_some();
    let mut all = vec![Statistic::NONE; per_interface * case.interfaces.len()];
    let state = &problem.interfaces;
    for (rows, response) in problem.all.secondary.iter().zip(&state.response) {
        let own = &mut all[rows.interface * per_interface..][..per_interface];
        for (place, c) in order(dim).enumerate() {
            if let Some(row) = &rows.rows[c] {
                own[place].see(response.bulk_traction[c], row.weight);
                own[dim + place].see(response.jump[c], row.weight);
            }
        }
        if rows.has_multiplier() {
            let law = state.laws[rows.interface].spec.law();
            own[2 * dim].see(law.damage(response.history), rows.law_weight(dim));
        }
    }
    let flow = model.stepper.coupling.as_ref().map(|coupling| &coupling.flow);
    for (index, pressure) in flow.iter().flat_map(|f| f.space.films.pressures(&f.pressure)) {
        let rows = &problem.all.secondary[index as usize];
        if rows.has_multiplier() {
            let own = &mut all[(rows.interface + 1) * per_interface - 1];
            own.see(pressure, rows.law_weight(dim));
        }
    }
    let mut least: Vec<f64> = all.iter().map(|s| s.least).collect();
    let mut most: Vec<f64> = all.iter().map(|s| s.most).collect();
    let mut sums: Vec<f64> = all.iter().flat_map(|s| [s.weighted, s.weight]).collect();
    comm.min(&mut least);
    comm.max(&mut most);
    comm.sum(&mut sums);
    let mut row = Vec::with_capacity(3 * all.len());
    for (i, sum) in sums.chunks_exact(2).enumerate() {
        let some = sum[1] > 0.0;
        let (interface, place) = (i / per_interface, i % per_interface);
        let is_last = place + 1 == per_interface;
        if !is_last || is_film(interface) {
            row.extend([least[i], most[i], sum[0] / sum[1]].map(|v| some.then_some(v)));
        }
        let flux = is_last && case.has_flux(&case.interfaces[interface]);
        if let Some(flow) = flow.filter(|_| flux) {
            let rates = flow.into_sides[interface];
            row.extend(rates.map(|rate| Some(rate / case.mesh.section())));
        }
    }
    row
}
