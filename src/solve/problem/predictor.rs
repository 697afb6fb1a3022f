//! The first correction of a step, and what it says of the order in which points give way.
//!
//! When the loads have changed and nothing has answered yet, the forces at the lips are not in
//! balance, and are no tractions to judge the laws by. The first correction is therefore the linear
//! answer of the last accepted state: its branches, its tractions. From there on the laws are
//! evaluated at states that are in equilibrium with the bulk.
//!
//! Between the accepted state and this answer the loads grow in proportion, so that the point which
//! reaches its threshold first on the way does so in truth, and has grown its damage at the end of
//! the step. Where several interfaces pass theirs, the one that is first gives way alone for one
//! correction: the others may find themselves relieved.

use super::{Problem, Worst};
use crate::assembly::Discretization;
use crate::comm::Comm;
use crate::petsc::Verdict;
use crate::solve::interfaces::{InterfaceState, JointLaw, to_local};

/// Where a step stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(in crate::solve) enum Prediction {
    /// Newton's method goes on from state to state.
    #[default]
    Past,
    /// The next correction is the linear answer of the accepted state.
    Due,
    /// This correction has been made, and its state not been evaluated.
    Made,
}

/// Points that reach their threshold within this part of the first one's way, and this part of the
/// step, after it count as first too.
const TOGETHER: [f64; 2] = [1e-2, 1e-3];
/// Growth of the history beyond the threshold that is rounding, over the jump scale of the law.
const ROUNDING: f64 = 1e-9;
/// The place on the way is found to 2 to the power of minus this.
const BISECTIONS: u32 = 12;

/// The points that give way first in a step.
#[derive(Debug, Clone, Default)]
pub(in crate::solve) struct Onset {
    /// Owned secondary nodes that reach their threshold as the first ones, with their history then.
    first: Vec<(usize, f64)>,
}

impl Onset {
    /// Whether points gave way on the way to the predicted state, but none of them has grown its
    /// damage in the state that was evaluated last. Collective.
    pub fn is_missed(&self, comm: &Comm, state: &InterfaceState) -> bool {
        let grown = |(index, history): &(usize, f64)| state.response[*index].history > *history;
        let is_there = comm.any(!self.first.is_empty());
        is_there && !comm.any(self.first.iter().any(grown))
    }

    /// Name and interface of the lowest of the points of this rank. Local.
    pub fn lowest(&self, all: &Discretization) -> Option<(u64, usize)> {
        self.first.iter().map(|(index, _)| all.name_and_interface(*index)).min()
    }
}

impl InterfaceState {
    /// The part of the way from the accepted traction of a node to that of the evaluated state after
    /// which its history grows; none if it does not. Local.
    fn onset_at(&self, all: &Discretization, index: usize) -> Option<f64> {
        let rows = &all.secondary[index];
        let law = self.law_at(index, rows);
        let scale = self.laws[rows.interface].spec.law().typical_jump()?;
        let [from, to] = [self.accepted[index], self.augmented(all, index)];
        let kappa = self.committed[index];
        let grows = |part: f64| {
            let p = std::array::from_fn(|c| from[c] + part * (to[c] - from[c]));
            let history = law.respond(to_local(p, all.dim), 0.0, kappa, all.dim).history;
            history > kappa + ROUNDING * scale
        };
        if !grows(1.0) {
            return None;
        }
        let (mut before, mut after) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (before + after);
            *(if grows(middle) { &mut after } else { &mut before }) = middle;
        }
        Some(after)
    }
}

impl InterfaceState {
    /// Whether other components of a node are stuck after a part of the way from its accepted traction to
    /// that of the evaluated state than at its beginning. Local.
    fn turns_before(&self, all: &Discretization, index: usize, part: f64) -> bool {
        let law = self.law_at(index, &all.secondary[index]);
        let [from, to] = [self.accepted[index], self.augmented(all, index)];
        let stuck = |part: f64| {
            let p = std::array::from_fn(|c| from[c] + part * (to[c] - from[c]));
            law.respond(to_local(p, all.dim), 0.0, self.committed[index], all.dim).stuck
        };
        stuck(0.0) != stuck(part)
    }
}

impl Problem<'_> {
    /// Lets the laws answer to the state that was evaluated last as the next correction needs it:
    /// linearly from the accepted state before the first one of a step, with some interfaces still
    /// held after it. `worst` is the largest out-of-balance force of the state. Whether answers have
    /// changed. Collective.
    pub(in crate::solve) fn answer_in_turn(&mut self, worst: Worst) -> bool {
        self.waits = false;
        let waiting = match self.prediction {
            Prediction::Past => return false,
            Prediction::Due => {
                let (all, state) = (&self.all, &self.interfaces);
                if self.convergence.excess(self.comm, all, state, worst) <= 1.0 {
                    return false;
                }
                None
            }
            Prediction::Made => {
                self.prediction = Prediction::Past;
                // A volume of fluid between lips opens them as little as it is: the first correction,
                // from lips that hold, is no measure of the loads.
                if self.interfaces.is_gradual {
                    return false;
                }
                let Some(waiting) = self.find_onset() else { return false };
                Some(waiting)
            }
        };
        self.waits = true;
        self.interfaces.linearise_at_accepted(&self.all, waiting.as_deref());
        true
    }

    /// Takes note that the state is about to change by a correction. Local.
    pub(in crate::solve) fn correct(&mut self) {
        if self.prediction == Prediction::Due {
            self.prediction = Prediction::Made;
        }
    }

    /// The verdict on a state that some laws may not have been asked about, which is none to stay at.
    pub(in crate::solve) fn unless_waiting(&self, verdict: Verdict) -> Verdict {
        if self.waits && verdict == Verdict::Converged { Verdict::Continue } else { verdict }
    }

    /// Whether the digits of the running correction decide which interface gives way first. Local: the
    /// same on all ranks.
    pub(super) fn decides_order(&self) -> bool {
        let may_break = |law: &&JointLaw| law.spec.law().strength().is_some();
        self.prediction == Prediction::Due
            && self.waits
            && self.interfaces.laws.iter().filter(may_break).count() > 1
    }

    /// Makes the components of a correction that need no solve exact, whatever the linear solver left
    /// there: nothing where displacements are prescribed, the known jump where one is stuck. Local.
    pub(in crate::solve) fn set_known(&self, correction: &mut [f64]) {
        let (all, dim) = (&self.all, self.all.dim);
        for (node, prescribed) in all.prescribed[..all.nodes.owned].iter().enumerate() {
            for c in (0..dim).filter(|c| prescribed[*c]) {
                correction[node * dim + c] = 0.0;
            }
        }
        for (rows, response) in all.secondary.iter().zip(&self.interfaces.response) {
            for c in (0..dim).filter(|c| rows.rows[*c].is_some() && response.state.stuck[*c]) {
                let own = rows.node as usize * dim + c;
                correction[own] = self.known_jumps[own];
            }
        }
    }

    /// Lets Newton's method go on from the state as it is. Local.
    pub(in crate::solve) fn predict_nothing(&mut self) {
        self.prediction = Prediction::Past;
    }

    /// Lets the next correction be the linear answer of the accepted state. Local.
    pub(in crate::solve) fn predict(&mut self) {
        self.prediction = Prediction::Due;
        self.onset = Onset::default();
    }

    /// Finds the points that give way first on the way to the state that was evaluated last, and
    /// marks the nodes of the interfaces whose turn has not come; none if all may give way.
    /// Collective.
    fn find_onset(&mut self) -> Option<Vec<bool>> {
        let (all, state) = (&self.all, &self.interfaces);
        let onsets: Vec<Option<f64>> =
            (0..state.response.len()).map(|index| state.onset_at(all, index)).collect();
        let mut earliest = vec![f64::INFINITY; state.laws.len()];
        for (onset, rows) in onsets.iter().zip(&all.secondary) {
            if let Some(onset) = onset {
                earliest[rows.interface] = earliest[rows.interface].min(*onset);
            }
        }
        self.comm.min(&mut earliest);
        let first = earliest.iter().copied().fold(f64::INFINITY, f64::min);
        if !first.is_finite() {
            return None;
        }
        // Where a contact opens or closes before that, the loads do not grow in proportion up to there.
        let before = (first - 0.5_f64.powi(BISECTIONS as i32)).max(0.0);
        let turns = (0..onsets.len()).any(|index| state.turns_before(all, index, before));
        if self.comm.any(turns) {
            return None;
        }
        let [part, rest] = TOGETHER;
        let last = first + part * first + rest;
        let is_first = |onset: f64| onset <= last;
        let firsts = onsets.iter().enumerate();
        let firsts = firsts.filter(|(_, onset)| onset.is_some_and(is_first));
        self.onset.first = firsts.map(|(index, _)| (index, state.committed[index])).collect();
        let waits: Vec<bool> =
            earliest.iter().map(|onset| onset.is_finite() && !is_first(*onset)).collect();
        let rows = all.secondary.iter().take(onsets.len());
        waits.contains(&true).then(|| rows.map(|rows| waits[rows.interface]).collect())
    }
}
