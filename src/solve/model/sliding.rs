//! What friction keeps and takes at a node of an interface.

use super::node_law::NodeLaw;
use crate::interface::JumpRows;

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

/// What a state has at a node.
pub(super) struct Reached {
    /// Whether the lips are closed.
    pub is_closed: bool,
    /// History with this state (m).
    pub history: f64,
    /// The sliding that the law answered, by tangential component (m).
    pub sliding: [f64; 2],
    /// The tangential traction, 0 where a component has no multiplier (Pa).
    pub shear: [f64; 2],
}

impl Reached {
    /// The traction of friction: what is not cohesion (Pa).
    pub fn friction(&self, law: NodeLaw<'_>) -> [f64; 2] {
        if !law.rubs() || !self.is_closed || law.broken_part(self.history) <= 0.0 {
            return [0.0; 2];
        }
        let cohesive = law.cohesive_shear(self.history, self.sliding);
        std::array::from_fn(|c| self.shear[c] - cohesive[c])
    }
}

impl Sliding {
    /// Goes on to a state, with the work of friction on the way, trapezoidal as that of loads.
    pub(super) fn go_on(&mut self, law: NodeLaw<'_>, rows: &JumpRows<u32>, to: &Reached) {
        if !law.rubs() {
            return;
        }
        let traction = to.friction(law);
        let step: [f64; 2] = std::array::from_fn(|c| to.sliding[c] - self.at[c]);
        let weight = |c: usize| rows.rows[c].as_ref().map_or(0.0, |row| row.weight);
        let tangents = 0..rows.components - 1;
        let work = |c: usize| 0.5 * weight(c) * (self.traction[c] + traction[c]) * step[c];
        self.energy += tangents.map(work).sum::<f64>();
        if traction != [0.0; 2] {
            self.path += step[0].hypot(step[1]);
        }
        (self.at, self.traction) = (to.sliding, traction);
    }
}
