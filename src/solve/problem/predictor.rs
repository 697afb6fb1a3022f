//! The first correction of a step, and what it says of the order in which points give way.
//!
//! When the loads have changed and nothing has answered yet, the forces at the lips are not in
//! balance, and are no tractions to judge the laws by. The first correction is therefore the linear
//! answer of the last accepted state: its branches, its tractions. From there on the laws are
//! evaluated at states that are in equilibrium with the bulk.
//!
//! Between the accepted state and this answer the loads grow in proportion, so that the point which
//! reaches its threshold first on the way does so in truth, and has grown its damage at the end of
//! the step. Where several interfaces give way, open or close, the one that is first does so alone
//! for one correction: the others may find themselves relieved. What opens or closes before it
//! gives way (an intrinsic law from rest) does so in corrections of its own, before anything gives
//! way.

use super::Problem;
use super::energy::potential_as_accepted;
use super::measure::Worst;
use crate::assembly::Discretization;
use crate::comm::Comm;
use crate::petsc::Verdict;
use crate::solve::model::interfaces::{InterfaceState, JointLaw, to_local};

/// Where a step stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(in crate::solve) enum Prediction {
    /// Newton's method goes on from state to state.
    #[default]
    Past,
    /// The next correction is the linear answer of the accepted state.
    Due,
    /// The next correction follows from the laws as they answer, and is a first one all the same.
    Free,
    /// This correction has been made, and its state not been evaluated.
    Made,
}

/// Points that reach their threshold within this part of the first one's way, and this part of the
/// step, after it count as first too.
const TOGETHER: [f64; 2] = [1e-2, 1e-3];
/// Corrections in which points open or close before others give way.
const MOST_TURNS: usize = 4;
/// Growth of the damage that is rounding.
const ROUNDING: f64 = 1e-9;
/// The place on the way is found to 2 to the power of minus this.
const BISECTIONS: u32 = 12;

/// The points that give way first in a step.
#[derive(Debug, Clone, Default)]
pub(in crate::solve) struct Onset {
    /// Owned secondary nodes that reach their threshold as the first ones, with their damage then.
    first: Vec<(usize, f64)>,
}

impl Onset {
    /// Whether points gave way on the way to the predicted state, but none of them has grown its
    /// damage in the state that was evaluated last. Collective.
    pub fn is_missed(&self, comm: &Comm, all: &Discretization, state: &InterfaceState) -> bool {
        let grown = |(index, damage): &(usize, f64)| {
            state.damage_at(all, *index, state.response[*index].history) > *damage
        };
        let is_there = comm.any(!self.first.is_empty());
        is_there && !comm.any(self.first.iter().any(grown))
    }

    /// Name and interface of the lowest of the points of this rank. Local.
    pub fn lowest(&self, all: &Discretization) -> Option<(u64, usize)> {
        self.first.iter().map(|(index, _)| all.name_and_interface(*index)).min()
    }
}

/// Parts of the way from the accepted state to the predicted one after which a node changes.
#[derive(Debug, Clone, Copy, Default)]
struct Changes {
    /// Its damage grows.
    grows: Option<f64>,
    /// Other components are stuck, as where a contact opens or closes.
    turns: Option<f64>,
}

impl Changes {
    /// The first of the two.
    fn first(self) -> Option<f64> {
        self.grows.into_iter().chain(self.turns).reduce(f64::min)
    }
}

/// Whether what changes after `part` of the way does so together with the first, after `first`.
fn is_with(first: f64, part: f64) -> bool {
    part <= first + TOGETHER[0] * first + TOGETHER[1]
}

/// The part of the way after which what holds at its end but not at its beginning does so.
fn part_of_way(holds: impl Fn(f64) -> bool) -> Option<f64> {
    if !holds(1.0) {
        return None;
    }
    let (mut before, mut after) = (0.0, 1.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (before + after);
        *(if holds(middle) { &mut after } else { &mut before }) = middle;
    }
    Some(after)
}

impl InterfaceState {
    /// The damage at a node that a history stands for. Local.
    fn damage_at(&self, all: &Discretization, index: usize, history: f64) -> f64 {
        self.laws[all.secondary[index].interface].spec.law().damage(history)
    }

    /// What changes at a node on the way to the state that was evaluated last. Local.
    fn changes_at(&self, all: &Discretization, index: usize) -> Changes {
        let rows = &all.secondary[index];
        let law = self.law_at(index, rows);
        let [from, to] = [self.base[index], self.augmented(all, index)];
        let past = self.past(index);
        let damage = |history: f64| self.damage_at(all, index, history);
        let answer = |part: f64| {
            let p = std::array::from_fn(|c| from[c] + part * (to[c] - from[c]));
            law.respond(to_local(p, all.dim), 0.0, past, all.dim)
        };
        let stuck = answer(0.0).stuck;
        let least = damage(past.history) + ROUNDING;
        let grows = part_of_way(|part| damage(answer(part).history) > least);
        let turns = part_of_way(|part| answer(part).stuck != stuck);
        // What held and softens is not stuck any more from the same place on.
        let apart = 2.0 * 0.5_f64.powi(BISECTIONS as i32);
        let turns = turns.filter(|turns| grows.is_none_or(|grows| turns + apart < grows));
        Changes { grows, turns }
    }
}

impl Problem<'_> {
    /// Lets the laws answer to the state that was evaluated last as the next correction needs it:
    /// linearly from the accepted state before the first one of a step, with some interfaces still
    /// held after it. `worst` is the largest out-of-balance force of the state. Whether answers
    /// have changed. Collective.
    pub(in crate::solve) fn answer_in_turn(&mut self, worst: Worst) -> bool {
        self.waits = false;
        let waiting = match self.prediction {
            Prediction::Past | Prediction::Free => return false,
            Prediction::Due => {
                let (all, state) = (&self.all, &self.interfaces);
                let measured = (worst, self.convergence.force_scale());
                let excess = self.convergence.excess(self.comm, all, state, measured);
                if excess <= 1.0 && self.platen_error() <= self.convergence.tolerance() {
                    return false;
                }
                None
            }
            Prediction::Made => {
                self.prediction = Prediction::Past;
                if self.turns == 0 {
                    self.most_energy = potential_as_accepted(self);
                }
                // A volume of fluid between lips opens them as little as it is: the first
                // correction, from lips that hold, is no measure of the loads.
                if self.interfaces.is_gradual {
                    return false;
                }
                let waiting = self.find_onset();
                if waiting.is_none() {
                    return false;
                }
                waiting
            }
        };
        self.waits = true;
        self.interfaces.linearise_at_base(&self.all, waiting.as_deref());
        true
    }

    /// Takes note that the state is about to change by a correction. Local.
    pub(in crate::solve) fn correct(&mut self) {
        if matches!(self.prediction, Prediction::Due | Prediction::Free) {
            self.prediction = Prediction::Made;
        }
    }

    /// The verdict on a state that some laws may not have been asked about, which is none to stay
    /// at.
    pub(in crate::solve) fn unless_waiting(&self, verdict: Verdict) -> Verdict {
        if self.waits && verdict == Verdict::Converged { Verdict::Continue } else { verdict }
    }

    /// Whether the digits of the running correction decide which interface gives way first. Local:
    /// the same on all ranks.
    pub(super) fn decides_order(&self) -> bool {
        let may_break = |law: &&JointLaw| law.spec.law().strength().is_some();
        self.prediction == Prediction::Due
            && self.waits
            && self.interfaces.laws.iter().filter(may_break).count() > 1
    }

    /// Makes the prescribed components of a correction exact. Local.
    pub(in crate::solve) fn hold_prescribed(&self, correction: &mut [f64]) {
        let (all, dim) = (&self.all, self.all.dim);
        for (node, prescribed) in all.prescribed[..all.nodes.owned].iter().enumerate() {
            for c in (0..dim).filter(|c| prescribed[*c]) {
                correction[node * dim + c] = 0.0;
            }
        }
    }

    /// Makes the components of a correction that need no solve exact, whatever the linear solver
    /// left there: nothing where displacements are prescribed, the known jump where one is stuck.
    /// Local.
    pub(in crate::solve) fn set_known(&self, correction: &mut [f64]) {
        let (all, dim) = (&self.all, self.all.dim);
        self.hold_prescribed(correction);
        for (rows, response) in all.secondary.iter().zip(&self.interfaces.response) {
            for c in (0..dim).filter(|c| rows.rows[*c].is_some() && response.state.stuck[*c]) {
                let own = rows.node as usize * dim + c;
                correction[own] = self.known_jumps[own];
            }
        }
    }

    /// Lets the next correction follow from the laws as they answer, as on a path, where the answer
    /// of the accepted state may not open what is to be opened. Local.
    pub(in crate::solve) fn predict_freely(&mut self) {
        self.predict();
        self.prediction = Prediction::Free;
    }

    /// Lets the next correction be the linear answer of the accepted state. Local.
    pub(in crate::solve) fn predict(&mut self) {
        self.prediction = Prediction::Due;
        self.onset = Onset::default();
        self.turns = 0;
        self.most_energy = None;
        self.interfaces.base.clone_from(&self.interfaces.accepted);
    }

    /// Finds the points that give way first on the way to the state that was evaluated last, and
    /// marks the nodes of the interfaces whose turn has not come; none if all may give way. Nodes
    /// that open or close before any gives way are taken to where they do, and another prediction
    /// is due. Collective.
    fn find_onset(&mut self) -> Option<Vec<bool>> {
        let (all, state) = (&self.all, &self.interfaces);
        let count = state.laws.len();
        let changes: Vec<Changes> =
            (0..state.response.len()).map(|index| state.changes_at(all, index)).collect();
        // By interface, when the first point of it changes, and when one gives way; then any turns.
        let mut earliest = vec![f64::INFINITY; 2 * count + 1];
        for (changes, rows) in changes.iter().zip(&all.secondary) {
            let [any, grows] = [rows.interface, count + rows.interface];
            for (place, part) in
                [(any, changes.first()), (grows, changes.grows), (2 * count, changes.turns)]
            {
                earliest[place] = earliest[place].min(part.unwrap_or(f64::INFINITY));
            }
        }
        self.comm.min(&mut earliest);
        let least = |parts: &[f64]| parts.iter().copied().fold(f64::INFINITY, f64::min);
        let [first, grows] = [least(&earliest[..count]), least(&earliest[count..2 * count])];
        let turns = earliest[2 * count];
        // Where a contact opens or closes before that, the loads do not grow in proportion up to
        // there.
        if grows.is_finite() && turns >= grows {
            let nodes = changes.iter().enumerate();
            let firsts = nodes.filter(|(_, c)| c.grows.is_some_and(|part| is_with(grows, part)));
            self.onset.first = firsts
                .map(|(index, _)| (index, state.damage_at(all, index, state.committed[index])))
                .collect();
        }
        let waits: Vec<bool> = (0..count)
            .map(|i| earliest[count + i].is_finite() && !is_with(first, earliest[i]))
            .collect();
        let rows = all.secondary.iter().take(changes.len());
        let waiting: Option<Vec<bool>> =
            waits.contains(&true).then(|| rows.map(|rows| waits[rows.interface]).collect());
        if waiting.is_some() && self.turns < MOST_TURNS && turns < grows && !is_with(turns, grows) {
            self.turns += 1;
            self.prediction = Prediction::Due;
            for (index, changes) in changes.iter().enumerate() {
                let together = changes.turns.filter(|part| is_with(turns, *part));
                let Some(part) = together else { continue };
                let to = self.interfaces.augmented(&self.all, index);
                let from = self.interfaces.base[index];
                self.interfaces.base[index] =
                    std::array::from_fn(|c| from[c] + part * (to[c] - from[c]));
            }
        }
        waiting
    }
}
