//! Unilateral contact.

#![allow(clippy::needless_range_loop)] // index notation, as in the formulas

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Branch, Friction, InterfaceLaw, Local, Response};

/// Unilateral contact (Signorini): compression is transmitted, and shear up to the limit of Coulomb
/// and Mohr, $|t_t| \le c - \mu t_n$, where the lips are closed.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Coefficient of friction.
    #[serde(default)]
    pub friction: f64,
    /// Shear that closed lips bear without any pressure, Pa.
    #[serde(default)]
    pub cohesion: f64,
}

impl Contact {
    /// Contact with friction, cohesion in Pa.
    pub fn new(friction: f64, cohesion: f64) -> Self {
        Self { friction, cohesion }
    }
}

impl InterfaceLaw for Contact {
    /// w_n = max(p_n, 0) / r, w_t = p_t / r.
    fn respond(&self, p: Local, augmentation: f64, history: f64, dim: usize) -> Response {
        let closed = p[0] <= 0.0;
        let mut out = Response {
            jump: [0.0; 3],
            traction: [p[0].min(0.0), 0.0, 0.0],
            compliance: [[0.0; 3]; 3],
            stuck: [closed, false, false],
            tangent: [[0.0; 3]; 3],
            friction: [0.0; 3],
            branch: if closed { Branch::Closed } else { Branch::Open },
            history,
        };
        for i in usize::from(closed)..dim {
            out.jump[i] = p[i] / augmentation;
            out.compliance[i][i] = 1.0 / augmentation;
        }
        out
    }

    fn augmentation(&self, stiffness: f64) -> f64 {
        stiffness
    }

    fn jump_scale(&self) -> Option<f64> {
        None
    }

    fn strength(&self) -> Option<f64> {
        None
    }

    fn steepest_softening(&self) -> Option<f64> {
        Some(0.0)
    }

    fn damage(&self, _history: f64) -> f64 {
        0.0
    }

    fn dissipated(&self, _history: f64) -> f64 {
        0.0
    }

    fn recoverable(&self, _jump: Local, _history: f64) -> f64 {
        0.0
    }

    fn holds_opening(&self, _history: f64) -> bool {
        false
    }

    /// As long as the lips are closed.
    fn holds_sliding(&self, _history: f64) -> bool {
        !self.friction().is_none()
    }

    fn friction(&self) -> Friction {
        Friction { coefficient: self.friction, cohesion: self.cohesion }
    }

    fn broken_part(&self, _history: f64) -> f64 {
        1.0
    }

    fn check(&self) -> Vec<String> {
        self.friction().mistakes()
    }
}

#[cfg(test)]
impl super::testkit::Samples for Contact {
    fn samples() -> Vec<Self> {
        vec![Contact::default()]
    }

    fn branches() -> &'static [Branch] {
        &[Branch::Open, Branch::Closed]
    }
}
