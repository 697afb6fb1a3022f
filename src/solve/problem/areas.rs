//! The areas of interfaces at their nodes, by which the forces that are out of balance there count:
//! the same force at a node of little area is the more traction.

use crate::assembly::Discretization;
use crate::comm::Comm;
use crate::solve::model::interfaces::InterfaceState;

/// Part of the largest area down to which a force counts as it is: that of the corners of a face of
/// first order beside its inner nodes. Of second order the tolerance is a quarter of it throughout.
const PLAIN: [f64; 2] = [1.0 / 4.0, 1.0 / 16.0];
/// The force scale of an inner node of boxes, over its area and the traction.
const BOTH_SIDES: f64 = 2.0;
/// Where tractions are small beside the forces of the bulk, or beside those of earlier states,
/// linear solves go on to errors that are small beside this part of them.
const LEAST: f64 = 1e-2;
/// Below this part tractions are none, beside which an error would have to be small.
const NONE: f64 = 1e-6;

/// How forces at this rank's nodes count.
pub struct Areas {
    /// Of each owned node, how many times; 1 away from interfaces.
    factors: Vec<f64>,
    /// The largest area of a node of an interface (m2; 2D: m); 0 without one.
    largest: f64,
    /// The largest of all factors.
    most: f64,
}

impl Areas {
    /// Those of the sides of all interfaces, of cells of `order`. Collective.
    pub fn new(comm: &Comm, all: &Discretization, order: usize) -> Self {
        let mut areas = areas(all);
        areas.truncate(all.nodes.owned);
        let mut largest = [areas.iter().copied().fold(0.0, f64::max)];
        comm.max(&mut largest);
        let [largest] = largest;
        let plain = PLAIN[usize::from(order > 1)] * largest;
        let factor = |area: &f64| if *area > 0.0 { (plain / area).max(1.0) } else { 1.0 };
        let factors: Vec<f64> = areas.iter().map(factor).collect();
        let mut most = [factors.iter().copied().fold(1.0, f64::max)];
        comm.max(&mut most);
        Self { factors, largest, most: most[0] }
    }

    /// What a force at a node counts, of which `rounding` may be rounding (N). Local.
    pub fn count(&self, node: usize, force: f64, rounding: f64) -> f64 {
        if force > rounding { self.factors[node] * force } else { force }
    }

    /// Part of the tolerance of forces that a linear solve may use which nobody looks into.
    pub fn strictest(&self) -> f64 {
        self.most.recip().max(LEAST)
    }

    /// What errors of forces have to be small beside (N), where the largest traction at an
    /// interface is `traction` and `force` is the scale of forces.
    pub fn scale(&self, traction: f64, force: f64) -> f64 {
        let of_traction = BOTH_SIDES * self.largest * traction;
        if of_traction > NONE * force { of_traction.clamp(LEAST * force, force) } else { force }
    }
}

/// The areas at all local nodes, complete at owned ones, 0 away from interfaces. Collective.
fn areas(all: &Discretization) -> Vec<f64> {
    let dim = all.dim as u32;
    let mut areas = vec![0.0; all.nodes.len()];
    for rows in &all.secondary[..all.owned_secondary()] {
        areas[rows.node as usize] +=
            if rows.has_multiplier() { rows.law_weight(all.dim) } else { 0.0 };
        let normal = rows.rows[all.dim - 1].as_ref();
        let Some(row) = normal.or_else(|| rows.rows.iter().flatten().next()) else { continue };
        // The normal may have components along several axes.
        let mut squares: Vec<(u32, f64)> = Vec::new();
        for (unknown, a) in &row.others {
            match squares.iter_mut().find(|(node, _)| *node == unknown / dim) {
                Some((_, square)) => *square += a * a,
                None => squares.push((unknown / dim, a * a)),
            }
        }
        for (node, square) in squares {
            areas[node as usize] += row.weight * (square.sqrt() / row.own).abs();
        }
    }
    all.nodes.add_to_owners(&mut areas, 1);
    areas
}

impl InterfaceState {
    /// The largest traction that the bulk transmits in the state that was evaluated last (Pa).
    /// Collective.
    pub(super) fn largest_traction(&self, comm: &Comm) -> f64 {
        let length = |t: [f64; 3]| t.iter().map(|t| t * t).sum::<f64>().sqrt();
        let all = self.response.iter().map(|response| length(response.bulk_traction));
        let mut largest = [all.fold(0.0, f64::max)];
        comm.max(&mut largest);
        largest[0]
    }
}
