//! Path following: all loads are scaled by a factor that follows from a quantity of an interface.
//!
//! Each correction solves two systems with the same tangent, one for the out-of-balance forces and
//! one for a change of the loads, and combines them so that the quantity takes its value
//! (bordering: the row of the constraint never enters the matrix).

use super::condensed;
use crate::assembly::Discretization;
use crate::case::{Control, ControlKind};
use crate::comm::Comm;
use crate::interface::JumpRows;
use crate::law::{Branch, InterfaceLaw};
use crate::solve::model::interfaces::{InterfaceState, NodeResponse};

/// In the first evaluation of a step augmented tractions are taken this much larger: a point that
/// stands on its threshold then softens on, instead of unloading.
pub const OVERSTRESS: f64 = 1e-7;

/// So far beyond rupture the last step goes, over the critical jump: on the edge itself Newton's
/// method would cycle.
const BEYOND: f64 = 1e-9;

/// A load factor below this part of that before counts as 0 after rupture.
const NOTHING: f64 = 1e-4;

/// The load factor of a path by dissipation grows or falls by at most this in one correction.
const MOST_GROWTH: f64 = 4.0;

/// The load factor and what it follows from.
pub struct PathControl {
    control: Control,
    /// The quantity in words.
    words: String,
    /// What all loads are scaled by.
    pub factor: f64,
    /// The factor at the last accepted state.
    accepted: f64,
    /// The value that the quantity is to take.
    target: f64,
    /// The loads at factor 1 per local node, not summed (N).
    pub unit_load: Vec<f64>,
    /// Those on platens, by free motion (N, N m).
    pub unit_of_platens: Vec<f64>,
    /// The prescribed displacements at factor 1, owned components (m).
    pub unit_displacement: Vec<f64>,
    /// Whether the factor is held for now.
    held: bool,
    /// Why the factor could not be found in the running step.
    pub failure: Option<String>,
    /// Whether that was a linear solve.
    pub is_unsolved: bool,
}

/// The quantity at a state: its value, and how it answers to a change of the displacement.
#[derive(Default)]
struct Sums {
    /// Area, or energy of full rupture.
    weight: f64,
    value: f64,
    /// Of the corrections given.
    changes: Vec<f64>,
}

/// How the quantity answers to corrections.
pub(super) struct Answers {
    /// What it is beyond its value, times its weight.
    pub missing: f64,
    /// By how much each correction takes it back.
    pub changes: Vec<f64>,
}

impl PathControl {
    /// Without loads yet.
    pub fn new(control: Control, words: String) -> Self {
        Self {
            control,
            words,
            factor: 0.0,
            accepted: 0.0,
            target: 0.0,
            unit_load: Vec::new(),
            unit_of_platens: Vec::new(),
            unit_displacement: Vec::new(),
            held: false,
            failure: None,
            is_unsolved: false,
        }
    }

    /// The time whose loads are scaled at `time`.
    pub fn load_time(&self, time: f64) -> f64 {
        self.control.load_time(time)
    }

    /// Starts a step to `time` from the last accepted state.
    pub fn start(&mut self, time: f64) {
        self.target = self.control.target(time);
        if self.breaks() {
            self.target += BEYOND;
        }
        self.factor = self.accepted;
        self.forget_failure();
    }

    /// Makes another solve possible.
    pub fn forget_failure(&mut self) {
        (self.failure, self.is_unsolved) = (None, false);
    }

    /// Whether the step is to break all that is left of the interface.
    pub fn breaks(&self) -> bool {
        matches!(self.control.kind, ControlKind::Dissipation(_)) && self.target >= 1.0
    }

    /// The dissipated part of the energy, or the mean opening (m). Collective.
    pub fn value(&self, comm: &Comm, all: &Discretization, state: &InterfaceState) -> f64 {
        let sums = self.sums(comm, all, state, &[], false);
        sums.value / sums.weight
    }

    /// The factor of the last accepted state.
    pub fn accepted_factor(&self) -> f64 {
        self.accepted
    }

    /// Goes on from the factor of a state that an earlier run accepted.
    pub fn resume(&mut self, factor: f64) {
        (self.accepted, self.factor) = (factor, factor);
    }

    /// Makes the factor that of an accepted state.
    pub fn accept(&mut self) {
        self.accepted = self.factor;
    }

    /// Words for loads that have turned round within a step that dissipates. They pass through 0 on
    /// no path: what is damaged springs back there, and dissipates nothing meanwhile. Such a state
    /// is on the path of the opposite loads.
    pub fn turned(&self) -> Option<String> {
        let dissipates = matches!(self.control.kind, ControlKind::Dissipation(_));
        // What is broken carries nothing: forces end at 0, up to what is accepted as such.
        let carries = !self.breaks() || self.factor.abs() > NOTHING * self.accepted.abs();
        (dissipates && carries && self.factor * self.accepted < 0.0).then(|| {
            format!(
                "the load factor jumped from {:e} to {:e}, where the loads are turned round",
                self.accepted, self.factor
            )
        })
    }

    /// Whether the step asks for the state in which something is about to give way.
    pub fn asks_for_onset(&self) -> bool {
        matches!(self.control.kind, ControlKind::Dissipation(_)) && self.target == 0.0
    }

    /// Holds the factor at a value, or lets it follow.
    pub fn hold(&mut self, factor: Option<f64>) {
        self.held = factor.is_some();
        self.factor = factor.unwrap_or(self.factor);
    }

    /// Whether the factor follows from the quantity.
    pub fn follows(&self) -> bool {
        !self.held
    }

    /// How much larger augmented tractions are taken in the first evaluation of a step.
    pub fn overstress(&self) -> f64 {
        if self.held { 1.0 } else { 1.0 + OVERSTRESS }
    }

    /// How far the quantity is from its value, over its scale; 0 while the factor is held.
    /// Collective.
    pub fn error(&self, comm: &Comm, all: &Discretization, state: &InterfaceState) -> f64 {
        if self.held {
            return 0.0;
        }
        let sums = self.sums(comm, all, state, &[], self.breaks());
        let scale = match self.control.kind {
            ControlKind::Dissipation(_) => 1.0,
            ControlKind::Opening(_) => {
                state.laws[self.control.interface].spec.law().typical_jump().unwrap_or(1.0)
            }
        };
        (sums.value / sums.weight - self.target).abs() / scale
    }

    /// The change of the forces on owned components with the factor, where the state is linearised.
    /// Collective.
    pub fn load_forces(
        &self,
        comm: &Comm,
        all: &Discretization,
        state: &InterfaceState,
    ) -> Vec<f64> {
        let minus_load = |_: &[f64], force: &mut [f64]| {
            force.iter_mut().zip(&self.unit_load).for_each(|(force, load)| *force -= load);
        };
        condensed::linear_forces(comm, all, state, self.unit_displacement.clone(), minus_load)
    }

    /// How the quantity answers to corrections of the owned displacements. Collective.
    pub(super) fn answers(
        &self,
        comm: &Comm,
        all: &Discretization,
        state: &InterfaceState,
        corrections: &[&[f64]],
    ) -> Answers {
        let local = |correction: &&[f64]| {
            let mut v = correction.to_vec();
            v.resize(all.nodes.len() * all.dim, 0.0);
            all.nodes.update_ghosts(&mut v, all.dim);
            v
        };
        let local: Vec<Vec<f64>> = corrections.iter().map(local).collect();
        let Sums { weight, value, changes } = self.sums(comm, all, state, &local, self.breaks());
        Answers { missing: value - self.target * weight, changes }
    }

    /// Takes note that the quantity does not follow the loads. Local.
    pub(super) fn does_not_follow(&mut self) {
        self.failure = Some(format!(
            "{} does not follow the loads at the factor {:e}: nothing there softens or opens; \
             see that the loads pull it, or that it is the first to give way",
            self.words, self.factor
        ));
    }

    /// The change of the factor, limited where the first points to soften are to dissipate all of a
    /// step: they would follow it far beyond rupture, or to the other sign.
    pub(super) fn limited(&self, change: f64) -> f64 {
        let dissipates = matches!(self.control.kind, ControlKind::Dissipation(_));
        if !dissipates || self.breaks() || self.factor == 0.0 {
            return change;
        }
        let relative = (change / self.factor).clamp(1.0 / MOST_GROWTH - 1.0, MOST_GROWTH - 1.0);
        relative * self.factor
    }

    /// Value and linear answers of the quantity, over all ranks; with `breaks` the dissipation
    /// gives way to the jumps over the critical one, which grow on beyond rupture. Collective.
    fn sums(
        &self,
        comm: &Comm,
        all: &Discretization,
        state: &InterfaceState,
        corrections: &[Vec<f64>],
        breaks: bool,
    ) -> Sums {
        let dissipation = Dissipation::new(state.laws[self.control.interface].spec.law(), breaks);
        let changes = vec![0.0; corrections.len()];
        let mut sums = Sums { changes, ..Sums::default() };
        for (index, rows) in all.secondary[..all.owned_secondary()].iter().enumerate() {
            if rows.interface != self.control.interface || !rows.has_multiplier() {
                continue;
            }
            let node = Node { all, state, index, corrections };
            match self.control.kind {
                ControlKind::Opening(_) => sums.add_opening(&node),
                ControlKind::Dissipation(_) => sums.add_dissipation(&node, &dissipation),
            }
        }
        sums.over_ranks(comm)
    }
}

/// An owned secondary node of the interface, at a state from which corrections lead on.
struct Node<'s> {
    all: &'s Discretization,
    state: &'s InterfaceState,
    /// Into `Discretization::secondary`.
    index: usize,
    corrections: &'s [Vec<f64>],
}

impl Node<'_> {
    fn rows(&self) -> &JumpRows<u32> {
        &self.all.secondary[self.index]
    }

    fn response(&self) -> &NodeResponse {
        &self.state.response[self.index]
    }
}

/// How the law of the interface dissipates energy.
struct Dissipation<'l> {
    law: &'l dyn InterfaceLaw,
    /// Critical jump (m).
    critical: f64,
    /// Energy per area of full rupture (J/m2).
    full: f64,
    /// Whether jumps over the critical one, which grow on beyond rupture, take its place.
    breaks: bool,
}

impl<'l> Dissipation<'l> {
    fn new(law: &'l dyn InterfaceLaw, breaks: bool) -> Self {
        let critical = law.jump_scale().unwrap_or(f64::MAX);
        Self { law, critical, full: law.dissipated(critical), breaks }
    }

    /// Energy per area (J/m2) at a history, and its growth with the history (Pa); `grown` is the
    /// size of the jump where that is what grows.
    fn value_and_rate(&self, history: f64, grown: Option<f64>) -> (f64, f64) {
        if self.breaks {
            let grown = grown.unwrap_or(history);
            return (self.full * grown / self.critical, self.full / self.critical);
        }
        let step = 1e-4 * history;
        let [low, high] = [history - step, history + step];
        let rate = (self.law.dissipated(high) - self.law.dissipated(low)) / (2.0 * step);
        (self.law.dissipated(history), rate)
    }
}

impl Sums {
    /// Adds the opening of a node.
    fn add_opening(&mut self, node: &Node<'_>) {
        let normal = node.all.dim - 1;
        let Some(row) = &node.rows().rows[normal] else { return };
        self.weight += row.weight;
        self.value += row.weight * node.response().jump[normal];
        self.add_changes(row.weight, node, normal);
    }

    /// Adds what is dissipated at a node.
    fn add_dissipation(&mut self, node: &Node<'_>, of: &Dissipation<'_>) {
        let response = node.response();
        // What the law dissipates has the factor of the node.
        let weight = node.rows().law_weight(node.all.dim) * node.state.factors[node.index];
        // What the damage at the start stands for is not to be dissipated any more.
        let before = of.law.dissipated(node.state.initial[node.index]);
        self.weight += weight * (of.full - before);
        // The law's jump; the history is its size, and follows the displacement's.
        let own: [f64; 3] = std::array::from_fn(|c| response.jump[c] - response.defect[c]);
        let size = own.iter().map(|w| w * w).sum::<f64>().sqrt();
        let grows = matches!(response.branch, Branch::Softening | Branch::SofteningClosed);
        let breaks_now =
            response.branch.is_separated() && node.state.committed[node.index] < of.critical;
        let (value, rate) = of.value_and_rate(response.history, breaks_now.then_some(size));
        self.value += weight * (value - before);
        if !(grows || of.breaks && breaks_now) {
            return;
        }
        for c in (0..node.all.dim).filter(|_| size > 0.0) {
            let direction = weight * rate * own[c] / size;
            self.value += direction * response.defect[c];
            self.add_changes(direction, node, c);
        }
    }

    /// Adds the jumps of the corrections in a component, times a factor.
    fn add_changes(&mut self, factor: f64, node: &Node<'_>, component: usize) {
        for (change, v) in self.changes.iter_mut().zip(node.corrections) {
            *change += factor * node.all.jump(node.index, component, v);
        }
    }

    /// Collective.
    fn over_ranks(self, comm: &Comm) -> Self {
        let mut sums = vec![self.weight, self.value];
        sums.extend(self.changes);
        comm.sum(&mut sums);
        let changes = sums.split_off(2);
        Self { weight: sums[0], value: sums[1], changes }
    }
}
