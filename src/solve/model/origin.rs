//! From where the jumps of interfaces count, for the laws and for the results.

use super::interfaces::{InterfaceState, NodeResponse, to_local};
use crate::assembly::Discretization;

/// What a node of an interface has at the end of a stage, by component.
#[derive(Debug, Clone, Copy)]
pub(in crate::solve) struct Left {
    /// Whether there is a multiplier.
    pub has_multiplier: [bool; 3],
    /// The jump that the law sees (m).
    pub jump: [f64; 3],
    /// The traction (Pa).
    pub traction: [f64; 3],
    /// The jump that results have (m).
    pub shown: [f64; 3],
}

impl InterfaceState {
    /// What is added to the jump of the displacement at a node, by component, that the law answers
    /// to: the gap, less the misfit (m). Local.
    pub(in crate::solve) fn beyond(&self, index: usize) -> [f64; 3] {
        let mut beyond = self.misfit.get(index).map_or([0.0; 3], |misfit| misfit.map(|m| -m));
        beyond[self.dim - 1] += self.gaps[index];
        beyond
    }

    /// Goes on from misfits and jumps at the start, in rows of a later stage from a `place` on.
    /// Local.
    pub(in crate::solve) fn resume_stage(&mut self, rows: &[Vec<f64>], place: usize) {
        if rows.first().is_none_or(|row| row.len() <= place) {
            return;
        }
        let at = |row: &Vec<f64>, place: usize| [row[place], row[place + 1], row[place + 2]];
        self.misfit = rows.iter().map(|row| at(row, place)).collect();
        if !self.origin.is_empty() {
            self.origin = rows.iter().map(|row| at(row, place + 3)).collect();
        }
    }

    /// What the owned node of an index has in the state that was evaluated last. Local.
    pub(in crate::solve) fn left_at(&self, all: &Discretization, index: usize) -> Left {
        let NodeResponse { jump, bulk_traction, .. } = self.response[index];
        let has_multiplier = std::array::from_fn(|c| all.secondary[index].rows[c].is_some());
        let shown = self.jump_since_start(index);
        Left { has_multiplier, jump, traction: bulk_traction, shown }
    }

    /// Lets the laws go on from the jumps and tractions that a stage has `left` at the owned nodes,
    /// whatever the rows of this one make of the displacements; the tractions (Pa). Where there was
    /// no multiplier, what holds does so where the lips are. Local.
    pub(in crate::solve) fn go_on_from(
        &mut self,
        all: &Discretization,
        left: &[Option<Left>],
    ) -> Vec<[f64; 3]> {
        let (mut misfit, mut tractions) = (Vec::new(), Vec::new());
        for (index, left) in left.iter().enumerate() {
            let (jump, traction) = self.first_of_stage(all, index, left.as_ref());
            let here = self.response[index].jump;
            misfit.push(std::array::from_fn(|c| here[c] - jump[c]));
            tractions.push(traction);
            if let Some(origin) = self.origin.get_mut(index) {
                *origin = left
                    .as_ref()
                    .map_or([0.0; 3], |left| std::array::from_fn(|c| left.jump[c] - left.shown[c]));
            }
        }
        self.misfit = misfit;
        tractions
    }

    /// Jump (m) and traction (Pa) from which the law of a node goes on. Local.
    fn first_of_stage(
        &self,
        all: &Discretization,
        index: usize,
        left: Option<&Left>,
    ) -> ([f64; 3], [f64; 3]) {
        let (dim, law) = (self.dim, self.law_at(index, &all.secondary[index]));
        let NodeResponse { jump: here, bulk_traction, .. } = self.response[index];
        let known = |c: usize| left.filter(|left| left.has_multiplier[c]);
        let p: [f64; 3] = std::array::from_fn(|c| match known(c) {
            Some(left) => left.traction[c] + law.augmentation() * left.jump[c],
            None => bulk_traction[c],
        });
        let answer = law.respond(to_local(p, dim), 0.0, self.past(index), dim);
        let holds = answer.stuck;
        let (mut jump, mut traction) = ([0.0; 3], [0.0; 3]);
        for c in (0..dim).filter(|c| all.secondary[index].rows[*c].is_some()) {
            let local = if c + 1 == dim { 0 } else { c + 1 };
            (jump[c], traction[c]) = match known(c) {
                Some(left) => (left.jump[c], left.traction[c]),
                None if holds[local] => (answer.jump[local], bulk_traction[c]),
                None if !answer.branch.is_separated() => (0.0, 0.0),
                // Lips of a contact stay as far apart as they are.
                None if local == 0 => (here[c].max(0.0), 0.0),
                None => (here[c], 0.0),
            };
        }
        (jump, traction)
    }

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
