//! What friction keeps and takes at the nodes of interfaces.

use super::interfaces::{InterfaceState, local_index};
use crate::assembly::Discretization;
use crate::law::Response;

/// Sliding and friction at an accepted state.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sliding {
    /// The sliding that friction holds, by tangential component (m).
    pub at: [f64; 2],
    /// How far the point has slid in contact, there and back (m).
    pub path: f64,
    /// What friction has taken at the node (J; 2D: per metre).
    pub energy: f64,
    /// The traction of friction (Pa).
    pub traction: [f64; 2],
}

impl InterfaceState {
    /// Whether some interface has friction. Local; the same on all ranks.
    pub fn has_friction(&self) -> bool {
        self.laws.iter().any(|law| !law.spec.law().friction().is_none())
    }

    /// Whether a point that slid in the state that was evaluated last slides the other way by this
    /// answer. It is then held: Newton's method would go to and fro between both ways. Local.
    pub(super) fn turns_round(&self, index: usize, answer: &Response) -> bool {
        let before = &self.response[index].state.friction;
        let along: f64 =
            (0..self.dim - 1).map(|c| before[c] * answer.friction[local_index(c, self.dim)]).sum();
        along < 0.0
    }

    /// The traction of friction at the state that was evaluated last, by tangential component (Pa);
    /// the history is the accepted one. Local.
    pub(super) fn friction(&self, all: &Discretization, index: usize) -> [f64; 2] {
        let (law, response) = (self.law_at(index, &all.secondary[index]), &self.response[index]);
        let history = self.committed[index];
        if !law.rubs() || !response.branch.is_closed() || law.broken_part(history) <= 0.0 {
            return [0.0; 2];
        }
        let cohesive = law.cohesive_shear(history, self.sliding_now(all.dim, index));
        std::array::from_fn(|c| {
            if c + 1 < all.dim { response.bulk_traction[c] - cohesive[c] } else { 0.0 }
        })
    }

    /// The sliding that the law answered at the state that was evaluated last (m).
    fn sliding_now(&self, dim: usize, index: usize) -> [f64; 2] {
        let response = &self.response[index];
        std::array::from_fn(
            |c| if c + 1 < dim { response.jump[c] - response.defect[c] } else { 0.0 },
        )
    }

    /// Makes the sliding of the state that was evaluated last the accepted one, with the work of
    /// friction on the way, trapezoidal as that of loads. The history is committed already. Local.
    pub(super) fn slide(&mut self, all: &Discretization, index: usize) {
        let rows = &all.secondary[index];
        if !self.law_at(index, rows).rubs() {
            return;
        }
        let (now, traction) = (self.sliding_now(all.dim, index), self.friction(all, index));
        let before = self.sliding[index];
        let step: [f64; 2] = std::array::from_fn(|c| now[c] - before.at[c]);
        let weight = |c: usize| rows.rows[c].as_ref().map_or(0.0, |row| row.weight);
        let work: f64 = (0..all.dim - 1)
            .map(|c| 0.5 * weight(c) * (before.traction[c] + traction[c]) * step[c])
            .sum();
        let slides = traction != [0.0; 2];
        self.sliding[index] = Sliding {
            at: now,
            path: before.path + if slides { step[0].hypot(step[1]) } else { 0.0 },
            energy: before.energy + work,
            traction,
        };
    }
}
