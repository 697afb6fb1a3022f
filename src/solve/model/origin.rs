//! From where the results of interfaces count.

use super::interfaces::InterfaceState;
use crate::assembly::Discretization;

impl InterfaceState {
    /// Energy per area that the damage at the start stands for (J/m2); the run has not dissipated
    /// it. Local.
    pub(in crate::solve) fn dissipated_before(&self, all: &Discretization, index: usize) -> f64 {
        let history = self.initial[index];
        let law = || self.law_at(index, &all.secondary[index]);
        if history > 0.0 { law().dissipated(history) } else { 0.0 }
    }

    /// Lets jumps count from those of the displacements `origin` of all local nodes (m). How far
    /// the lips of a contact or of a crack are apart stays, which is what closes. Local.
    pub(in crate::solve) fn count_from(&mut self, all: &Discretization, origin: &[f64]) {
        let of = |index: usize| -> [f64; 3] {
            let law = self.laws[all.secondary[index].interface].spec.law();
            let is_held = law.strength().is_some() && law.holds_opening(self.initial[index]);
            let counted = if is_held { all.dim } else { all.dim - 1 };
            std::array::from_fn(|c| if c < counted { all.jump(index, c, origin) } else { 0.0 })
        };
        self.origin = (0..self.response.len()).map(of).collect();
    }

    /// Forgets how far lips have slid and what friction has taken. Local.
    pub(in crate::solve) fn forget_slip(&mut self) {
        self.sliding.iter_mut().for_each(|node| (node.path, node.energy) = (0.0, 0.0));
    }

    /// The jump at the owned node of an index since the start, by displacement component; of its
    /// normal part also the gap (m). Local.
    pub fn jump_since_start(&self, index: usize) -> [f64; 3] {
        let (jump, origin) = (self.response[index].jump, self.origin.get(index));
        origin.map_or(jump, |origin| std::array::from_fn(|c| jump[c] - origin[c]))
    }
}
