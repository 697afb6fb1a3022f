//! The areas of interfaces at their nodes, by which the forces that are out of balance there count:
//! the same force at a node of little area is the more traction (docs/theory.md, section 5).

use crate::assembly::Discretization;
use crate::comm::Comm;
use crate::solve::model::interfaces::InterfaceState;

/// Part of the largest area down to which a force counts as it is: that of the corners of a face of
/// first order beside its inner nodes. Of second order the tolerance is a quarter of it throughout.
const PLAIN: [f64; 2] = [1.0 / 4.0, 1.0 / 16.0];
/// How many times a force counts at most: rounding must not.
const MOST: f64 = 100.0;
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
    /// The largest of all ranks.
    most: f64,
    /// The largest area of a node of an interface (m2; 2D: m); 0 without one.
    largest: f64,
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
        let factor = |area: &f64| if *area > 0.0 { (plain / area).clamp(1.0, MOST) } else { 1.0 };
        let factors: Vec<f64> = areas.iter().map(factor).collect();
        let mut most = [factors.iter().copied().fold(1.0, f64::max)];
        comm.max(&mut most);
        Self { factors, most: most[0], largest }
    }

    /// What a force at a node counts, of which `rounding` may be rounding (N). Local.
    pub fn count(&self, node: usize, force: f64, rounding: f64) -> f64 {
        if force > rounding { self.factors[node] * force } else { force }
    }

    /// The least force that counts as much as one does away from interfaces. Local.
    pub fn least(&self) -> f64 {
        self.most.recip()
    }

    /// What errors of forces have to be small beside (N), where the largest traction at an
    /// interface is `traction` (Pa) and `force` the scale of forces (N). Local.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_force_counts_by_its_area_unless_it_is_rounding() {
        let areas = Areas { factors: vec![1.0, 8.0], most: 8.0, largest: 0.25 };
        assert_eq!([areas.count(0, 3.0, 1.0), areas.count(1, 3.0, 1.0)], [3.0, 24.0]);
        assert_eq!(areas.count(1, 0.5, 1.0), 0.5);
        assert_eq!(areas.least(), 0.125);
    }

    #[test]
    fn errors_are_small_beside_tractions_that_have_fallen_but_for_none() {
        let areas = Areas { factors: Vec::new(), most: 1.0, largest: 0.25 };
        assert_eq!(areas.scale(1e3, 100.0), 100.0);
        assert_eq!(areas.scale(20.0, 100.0), 10.0);
        assert_eq!(areas.scale(0.1, 100.0), 1.0);
        assert_eq!(areas.scale(1e-5, 100.0), 100.0);
        let none = Areas { factors: Vec::new(), most: 1.0, largest: 0.0 };
        assert_eq!(none.scale(0.0, 100.0), 100.0);
    }
}
