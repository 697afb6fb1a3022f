//! What the answer of a node owes to the length of the step that led to it.

use super::interfaces::{InterfaceState, to_local};
use super::sliding::Reached;
use crate::assembly::Discretization;
use crate::law::{Local, Past};

impl InterfaceState {
    /// How far the traction of a node is from that of a law whose history goes on all the time, as
    /// a part of the strength, or of the traction where that is larger: a law that takes the step
    /// in one has twice the error of one that takes it in two, each with half of the change of the
    /// augmented traction. 0 where only the end of the step counts. Local.
    pub(in crate::solve) fn error_of_traction(&self, all: &Discretization, index: usize) -> f64 {
        let law = self.law_at(index, &all.secondary[index]);
        let (from, to) = (self.accepted[index], self.augmented(all, index));
        let respond =
            |p: [f64; 3], past: Past| law.respond(to_local(p, self.dim), 0.0, past, self.dim);
        let past = self.past(index);
        let half = respond(std::array::from_fn(|c| 0.5 * (from[c] + to[c])), past);
        let [_, first, second] = half.jump;
        let past_half = Past { history: half.history, sliding: [first, second] };
        let (whole, halves) = (respond(to, past), respond(to, past_half));
        let size = |of: Local| of.iter().map(|x| x * x).sum::<f64>().sqrt();
        let apart: Local = std::array::from_fn(|c| whole.traction[c] - halves.traction[c]);
        let scale = law.strength().unwrap_or(0.0).max(size(whole.traction));
        if scale > 0.0 { 2.0 * size(apart) / scale } else { 0.0 }
    }

    /// By how much the trapezoidal work of the traction of a node in the step may be off what its
    /// law stores, dissipates and takes by friction (J; 2D: per metre). Local.
    pub(in crate::solve) fn error_of_work(&self, all: &Discretization, index: usize) -> f64 {
        let (rows, dim) = (&all.secondary[index], self.dim);
        let (law, past, response) =
            (self.law_at(index, rows), self.past(index), &self.response[index]);
        let before = law.respond(to_local(self.accepted[index], dim), 0.0, past, dim);
        let after: [f64; 3] = std::array::from_fn(|c| response.jump[c] - response.defect[c]);
        let (after, traction) = (to_local(after, dim), to_local(response.bulk_traction, dim));
        let work = |c: usize| {
            let local = if c + 1 == dim { 0 } else { c + 1 };
            let weight = rows.rows[c].as_ref().map_or(0.0, |row| row.weight);
            let mean = 0.5 * (before.traction[local] + traction[local]);
            weight * mean * (after[local] - before.jump[local])
        };
        let (old, new) = (self.committed[index], response.history);
        let dissipated = self.dissipated[index];
        let given_back = law.recoverable(after, new) - law.recoverable(before.jump, old);
        let lost = law.dissipated_after(dissipated, old, new, after) - dissipated;
        let mut sliding = self.sliding[index];
        sliding.go_on(law, rows, &self.reached_with(index, new));
        let friction = sliding.energy - self.sliding[index].energy;
        let off =
            (0..dim).map(work).sum::<f64>() - rows.law_weight(dim) * (given_back + lost) - friction;
        off.abs() + self.error_of_friction(all, index, before.traction[0]).abs()
    }

    /// By how much the trapezoidal work of friction at a node is off where sliding begins or turns
    /// in the step: what slides does so against all that friction bears, from the first on, under
    /// the normal traction `normal` of the accepted state (J). Local.
    fn error_of_friction(&self, all: &Discretization, index: usize, normal: f64) -> f64 {
        let (rows, sliding) = (&all.secondary[index], &self.sliding[index]);
        let law = self.law_at(index, rows);
        if !law.rubs() || !self.response[index].branch.is_closed() || normal > 0.0 {
            return 0.0;
        }
        let to = self.reached(index).sliding;
        let step: [f64; 2] = std::array::from_fn(|c| to[c] - sliding.at[c]);
        let bearable = law.bearable(self.committed[index], normal) * step[0].hypot(step[1]);
        let taken = sliding.traction[0] * step[0] + sliding.traction[1] * step[1];
        0.5 * rows.law_weight(self.dim) * (bearable - taken)
    }

    /// What the state that was evaluated last has at a node, with the accepted history. Local.
    pub(super) fn reached(&self, index: usize) -> Reached {
        self.reached_with(index, self.committed[index])
    }

    /// As above with another `history`. Local.
    fn reached_with(&self, index: usize, history: f64) -> Reached {
        let response = &self.response[index];
        let tangent = |c: usize| c + 1 < self.dim;
        let of = |at: &dyn Fn(usize) -> f64| [0, 1].map(|c| if tangent(c) { at(c) } else { 0.0 });
        Reached {
            is_closed: response.branch.is_closed(),
            history,
            sliding: of(&|c| response.jump[c] - response.defect[c]),
            shear: of(&|c| response.bulk_traction[c]),
        }
    }
}
