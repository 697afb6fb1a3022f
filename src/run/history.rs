//! One row of `history.csv`: what is told of an accepted instant.

use super::probes::LocatedProbe;
use crate::assembly::Discretization;
use crate::case::{Case, InterfaceQuantity};
use crate::comm::Comm;
use crate::interface::JumpRows;
use crate::solve::{Accepted, FluidBalance, Freedom, Model, reactions};
use crate::space::tangents;

/// The row of the instant that `model` has reached, in the order of `Case::columns`. Collective;
/// complete on every rank.
pub fn row(
    case: &Case,
    model: &Model<'_>,
    probes: &[LocatedProbe],
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
    let force = |node: usize, c: usize| problem.support_force(node, c);
    let surfaces = case.supported_bits();
    let mut sums = reactions(&problem.all, &surfaces, force);
    comm.sum(sums.as_flattened_mut());
    row.extend(sums.iter().flat_map(|sum| &sum[..case.dim]).map(|v| Some(*v)));
    row.extend(of_platens(case, model, comm));
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
    if case.has_friction() {
        row.push(Some(energy.friction));
    }
    if let Some(flow) = flow {
        let FluidBalance { inflow, outflow, stored } = flow.balance;
        row.extend([inflow, outflow, stored].map(Some));
    }
    row
}

/// The motions of the platens, and the moments of them on the body about their centroids; none
/// where a platen binds nothing, or is none in this stage. Collective.
fn of_platens(case: &Case, model: &Model<'_>, comm: &Comm) -> Vec<Option<f64>> {
    let problem = &model.stepper.problem;
    let u = problem.displacement_since_start();
    let known = problem.platens.as_ref().map(|of| {
        let values = of.platens.motions(comm, |unknown| u[unknown]);
        (&of.platens.freedoms, values, of.reactions())
    });
    let mut row = Vec::new();
    for surface in case.rigid_surfaces() {
        let find = |axis: usize, turns: bool| {
            let (freedoms, values, reactions) = known.as_ref()?;
            let is_it =
                |of: &Freedom| of.surface == *surface && of.axis == axis && of.turns == turns;
            let place = freedoms.iter().position(is_it)?;
            Some([values[place], reactions[place]])
        };
        row.extend(case.axes.iter().map(|axis| find(*axis, false).map(|of| of[0])));
        for kind in 0..2 {
            row.extend(case.turning_axes().map(|axis| find(axis, true).map(|of| of[kind])));
        }
    }
    row
}

/// Puts 0 for the tractions and jumps of components that a smaller model leaves out and the model
/// asked for has, as `has` tells by interface and component, and the `totals` of its interfaces in
/// the place of the smaller model's. Local.
pub fn fill(
    case: &Case,
    row: &mut [Option<f64>],
    has: impl Fn(usize, usize) -> bool,
    totals: &[[f64; 4]],
) {
    let mut at = FIRST_OF_INTERFACES;
    for (number, interface) in case.interfaces.iter().enumerate() {
        for quantity in case.interface_quantities(interface) {
            if let InterfaceQuantity::Traction(c) | InterfaceQuantity::Jump(c) = quantity
                && has(number, c)
            {
                row[at..at + 3].iter_mut().for_each(|value| *value = value.or(Some(0.0)));
            }
            at += 3;
        }
        for total in &totals[number][..=case.dim] {
            row[at] = Some(*total);
            at += 1;
        }
        // Flow into the rock on both sides.
        at += if case.has_flux(interface) { 2 } else { 0 };
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

    /// Minimum, maximum and mean; none where nothing was seen.
    fn columns(&self) -> [Option<f64>; 3] {
        let some = self.weight > 0.0;
        [self.least, self.most, self.weighted / self.weight].map(|v| some.then_some(v))
    }
}

/// Minimum, maximum and mean of every interface quantity, and the flow into the rock. Collective.
fn interface_statistics(case: &Case, model: &Model<'_>, comm: &Comm) -> Vec<Option<f64>> {
    let mut all = nodal_statistics(case, model);
    let mut least: Vec<f64> = all.iter().flatten().map(|s| s.least).collect();
    let mut most: Vec<f64> = all.iter().flatten().map(|s| s.most).collect();
    let mut sums: Vec<f64> = all.iter().flatten().flat_map(|s| [s.weighted, s.weight]).collect();
    comm.min(&mut least);
    comm.max(&mut most);
    comm.sum(&mut sums);
    for (i, statistic) in all.iter_mut().flatten().enumerate() {
        let [weighted, weight] = [sums[2 * i], sums[2 * i + 1]];
        *statistic = Statistic { least: least[i], most: most[i], weighted, weight };
    }
    let problem = &model.stepper.problem;
    let mut totals =
        totals(case, &problem.all, |index| problem.interfaces.response[index].bulk_traction);
    comm.sum(totals.as_flattened_mut());
    let flow = model.stepper.coupling.as_ref().map(|coupling| &coupling.flow);
    let mut row = Vec::with_capacity(3 * least.len());
    for (number, own) in all.iter().enumerate() {
        row.extend(own.iter().flat_map(Statistic::columns));
        row.extend(totals[number][..=case.dim].iter().map(|v| Some(*v)));
        if let Some(flow) = flow.filter(|_| case.has_flux(&case.interfaces[number])) {
            let lips = &model.mesh.facts.interfaces[number];
            let sides = flow.into_sides[number].iter().zip(lips);
            row.extend(sides.map(|(rate, lip)| Some(rate / lip.area)));
        }
    }
    row
}

/// The component of a vector of the frame of a node that a column is made of, with its weight: the
/// tangents of the surface, then the normal; none where a part of it has no multiplier. Local.
fn along_surface(
    all: &Discretization,
    rows: &JumpRows<u32>,
    values: [f64; 3],
    c: usize,
) -> Option<(f64, f64)> {
    let (dim, rotation) = (all.dim, all.frames.rotation(rows.node));
    if c + 1 == dim {
        return rows.rows[c].as_ref().map(|row| (values[c], row.weight));
    }
    let tangent = tangents(dim, rotation[dim - 1])[c];
    let (mut sum, mut weight, mut largest) = (0.0, 0.0, 0.0_f64);
    for k in 0..dim - 1 {
        let cosine: f64 = (0..dim).map(|i| rotation[k][i] * tangent[i]).sum();
        if cosine.abs() < 1e-9 {
            continue;
        }
        let row = rows.rows[k].as_ref()?;
        sum += cosine * values[k];
        if cosine.abs() > largest {
            (weight, largest) = (row.weight, cosine.abs());
        }
    }
    Some((sum, weight))
}

/// The force of the upper side of each interface on the lower one by component (N), then its area
/// (m2), of the multiplier nodes that this rank owns; `traction` is that of each of them in the
/// frame of its node (Pa). Local.
pub fn totals(
    case: &Case,
    all: &Discretization,
    traction: impl Fn(usize) -> [f64; 3],
) -> Vec<[f64; 4]> {
    let dim = case.dim;
    let mut sums = vec![[0.0; 4]; case.interfaces.len()];
    for (index, rows) in all.secondary[..all.owned_secondary()].iter().enumerate() {
        let of = |c: usize| rows.rows[c].as_ref().map_or(0.0, |row| row.weight);
        let traction = traction(index);
        let force = std::array::from_fn(|c| of(c) * traction[c]);
        let force = all.frames.turned_back(&all.frames.rotation(rows.node), force);
        let sum = &mut sums[rows.interface];
        sum.iter_mut().zip(&force[..dim]).for_each(|(sum, force)| *sum += force);
        sum[dim] += if rows.has_multiplier() { rows.law_weight(dim) } else { 0.0 };
    }
    sums
}

/// The quantities of each interface over the nodes of this rank. Local.
fn nodal_statistics(case: &Case, model: &Model<'_>) -> Vec<Vec<Statistic>> {
    let problem = &model.stepper.problem;
    let quantities: Vec<_> = case.interfaces.iter().map(|i| case.interface_quantities(i)).collect();
    let mut all: Vec<Vec<Statistic>> =
        quantities.iter().map(|own| vec![Statistic::NONE; own.len()]).collect();
    let state = &problem.interfaces;
    for (index, response) in state.response.iter().enumerate() {
        let rows = &problem.all.secondary[index];
        let is_of_file = case.mesh.file().is_some();
        let of_component = |values: [f64; 3], c: usize| {
            if is_of_file {
                return along_surface(&problem.all, rows, values, c);
            }
            rows.rows[c].as_ref().map(|row| (values[c], row.weight))
        };
        let own = all[rows.interface].iter_mut().zip(&quantities[rows.interface]);
        for (statistic, quantity) in own {
            let seen = match *quantity {
                InterfaceQuantity::Traction(c) => of_component(response.bulk_traction, c),
                InterfaceQuantity::Jump(c) => of_component(state.jump_since_start(index), c),
                InterfaceQuantity::Damage => rows.has_multiplier().then(|| {
                    let law = state.laws[rows.interface].spec.law();
                    (law.damage(response.history), rows.law_weight(case.dim))
                }),
                InterfaceQuantity::Slip => rows
                    .has_multiplier()
                    .then(|| (state.sliding[index].path, rows.law_weight(case.dim))),
                // Films have lists of their own.
                InterfaceQuantity::Pressure => None,
            };
            if let Some((value, weight)) = seen {
                statistic.see(value, weight);
            }
        }
    }
    let flow = model.stepper.coupling.as_ref().map(|coupling| &coupling.flow);
    for (index, pressure) in flow.iter().flat_map(|f| f.space.films.pressures(&f.pressure)) {
        let rows = &problem.all.secondary[index as usize];
        let own = all[rows.interface].iter_mut().zip(&quantities[rows.interface]);
        for (statistic, _) in own.filter(|(_, q)| **q == InterfaceQuantity::Pressure) {
            if rows.has_multiplier() {
                statistic.see(pressure, rows.law_weight(case.dim));
            }
        }
    }
    all
}
