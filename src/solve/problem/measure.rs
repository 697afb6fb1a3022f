//! How large the errors of a state are, and what they are measured by.

use crate::comm::Comm;

/// The largest of some nodal values, and where it is.
#[derive(Debug, Clone, Copy, Default)]
pub struct Worst {
    pub(super) value: f64,
    pub(super) node: u64,
    pub(super) not_a_number: bool,
}

impl Worst {
    /// Takes a value into account.
    pub fn see(&mut self, value: f64, node: u64) {
        if !value.is_finite() && !self.not_a_number {
            *self = Self { value: f64::INFINITY, node, not_a_number: true };
        } else if value > self.value {
            (self.value, self.node) = (value, node);
        }
    }

    /// The largest over all ranks (the lowest rank's if several are equal). Collective.
    pub(super) fn over_ranks(self, comm: &Comm) -> Self {
        let mine = [self.value.to_bits(), self.node, u64::from(self.not_a_number)];
        let all = comm.exchange(&vec![mine.to_vec(); comm.size() as usize]);
        let read = |w: &Vec<u64>| Self {
            value: f64::from_bits(w[0]),
            node: w[1],
            not_a_number: w[2] != 0,
        };
        all.iter().map(read).reduce(|a, b| if b.value > a.value { b } else { a }).unwrap_or(self)
    }
}

/// Forces cancel to this many units in the last place of the largest of them.
const UNITS: f64 = 32.0;
/// Where the largest force is no more than this many times the rounding, none acts.
const MEANINGLESS: f64 = 1e3;

/// What rounding may leave of parts that cancel, of size `cancelling` at most.
pub fn rounding(cancelling: f64) -> f64 {
    UNITS * f64::EPSILON * cancelling
}

/// Whether what is missing in a balance, at most, is no more than what rounding leaves of parts
/// that cancel, of size `cancelling` at most, beside which its largest part `scale` is nothing
/// either.
pub fn is_rounding(missing: f64, scale: f64, cancelling: f64) -> bool {
    let rounding = rounding(cancelling);
    missing <= rounding && scale <= MEANINGLESS * rounding
}

/// How large what makes up a state is at its nodes, at most.
#[derive(Debug, Clone, Copy, Default)]
pub struct Scales {
    /// Sum of the lengths of the forces of cells and loads at a node (N).
    pub force: f64,
    /// Displacement (m).
    pub displacement: f64,
    /// Stiffness times displacement of a node (N): what cancels where bodies move as wholes and no
    /// force acts, but for rounding.
    pub(super) cancelling: f64,
}

impl Scales {
    /// Takes a node into account: its force (N), displacement (m) and stiffness (N/m).
    pub fn see(&mut self, force: f64, u: &[f64], stiffness: f64) {
        let largest = u.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
        self.force = self.force.max(force);
        self.displacement = self.displacement.max(largest);
        self.cancelling = self.cancelling.max(stiffness * largest);
    }
}

/// Errors of a state.
pub(super) struct Measure {
    /// Largest out-of-balance force (N).
    pub worst: Worst,
    /// Largest error of the jump of each interface, over its scale.
    pub defect: Vec<Worst>,
    /// `worst` over the force scale.
    pub out_of_balance: f64,
    /// Largest of `defect`.
    pub largest: f64,
}

impl Measure {
    /// A node at which something is not a number: a jump, else a force.
    pub fn not_a_number(&self) -> Option<u64> {
        let mut all = self.defect.iter().chain([&self.worst]);
        all.find(|worst| worst.not_a_number).map(|worst| worst.node)
    }
}
