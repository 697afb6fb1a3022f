//! Perfect bond.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Branch, InterfaceLaw, Local, Response};

/// Perfect bond: the jump is zero whatever the traction.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tied {}

impl InterfaceLaw for Tied {
    fn respond(&self, p: Local, _augmentation: f64, history: f64, dim: usize) -> Response {
        let p = std::array::from_fn(|i| if i < dim { p[i] } else { 0.0 });
        Response::held(p, dim, Branch::Tied, history)
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
        true
    }

    fn holds_sliding(&self, _history: f64) -> bool {
        true
    }

    fn check(&self) -> Vec<String> {
        Vec::new()
    }
}

#[cfg(test)]
impl super::testkit::Samples for Tied {
    fn samples() -> Vec<Self> {
        vec![Tied {}]
    }

    fn branches() -> &'static [Branch] {
        &[Branch::Tied]
    }
}
