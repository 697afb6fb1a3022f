//! Exact adhesion, linear softening, secant unloading, contact.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::softening::Envelope;
use crate::error::number_text;

/// Exact adhesion up to the strength, then linear softening of the traction along the jump to
/// zero, with secant unloading; one strength and one fracture energy for all modes; contact,
/// with friction on what is broken.
///
/// With $p_+ = (\max(p_n, 0), p_t)$, $q = |p_+|$, $\delta_c = 2 G_c/\sigma_c$,
/// $h = \sigma_c/\delta_c$ and $s(\kappa) = \sigma_c (1/\kappa - 1/\delta_c)$ the jump is
/// $p_+/(r + s)$ while $q \le \sigma_c + (r - h)\kappa$, then
/// $\frac{q - \sigma_c}{r - h}\,p_+/q$, and $p_+/r$ once broken ($\kappa = \delta_c$).
///
/// # Source
/// code_aster R7.02.11 (CZM_LIN_MIX), written in terms of the largest jump $\kappa$, so that the
/// history does not depend on the augmentation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LinearSoftening {
    /// Traction at which the interface starts to open or slide, Pa.
    pub strength: f64,
    /// Energy that full rupture takes, per area, J/m2.
    pub fracture_energy: f64,
    /// Augmentation in units of strength^2 / fracture_energy; more than 0.5. The converged answer
    /// does not depend on it.
    #[serde(default = "default_augmentation")]
    pub augmentation: f64,
    /// Coefficient of friction on the broken part of closed lips.
    #[serde(default)]
    pub friction: f64,
}

fn default_augmentation() -> f64 {
    10.0
}

impl LinearSoftening {
    /// The law with the default augmentation; units as in the fields.
    pub fn new(strength: f64, fracture_energy: f64) -> Self {
        Self { strength, fracture_energy, augmentation: default_augmentation(), friction: 0.0 }
    }

    /// h = sigma_c / delta_c, Pa/m.
    pub fn softening_slope(&self) -> f64 {
        self.strength / self.critical_jump()
    }
}

impl Envelope for LinearSoftening {
    fn strength_and_energy(&self) -> (f64, f64) {
        (self.strength, self.fracture_energy)
    }

    fn stiffness_of_augmentation(&self) -> f64 {
        self.augmentation * self.strength * self.strength / self.fracture_energy
    }

    fn dissipated_part(&self, jump: f64) -> f64 {
        jump / self.critical_jump()
    }

    fn jump_of_part(&self, part: f64) -> f64 {
        part * self.critical_jump()
    }

    fn coefficient_of_friction(&self) -> f64 {
        self.friction
    }

    fn mistakes(&self) -> Vec<String> {
        let mut problems = Vec::new();
        if !(self.augmentation.is_finite() && self.augmentation > 0.5) {
            // r = augmentation sigma_c^2 / G_c must exceed the slope h = sigma_c^2 / (2 G_c).
            problems.push(format!(
                "augmentation must be above 0.5: r = {} Pa/m has to exceed the softening slope {} \
                 Pa/m, got {}",
                number_text(self.stiffness_of_augmentation()),
                number_text(self.softening_slope()),
                number_text(self.augmentation)
            ));
        }
        problems
    }

    fn elastic_jump(&self) -> f64 {
        0.0
    }

    fn critical_jump(&self) -> f64 {
        2.0 * self.fracture_energy / self.strength
    }

    fn secant(&self, jump: f64) -> f64 {
        self.strength / jump - self.softening_slope()
    }

    fn slope(&self, _jump: f64) -> f64 {
        -self.softening_slope()
    }

    fn jump_under(&self, q: f64, r: f64) -> f64 {
        (q - self.strength) / (r - self.softening_slope())
    }
}

#[cfg(test)]
#[path = "linear_softening_tests.rs"]
mod tests;
