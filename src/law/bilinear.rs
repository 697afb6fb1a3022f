//! Initial stiffness, linear softening, secant unloading, contact.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::softening::{Envelope, not_positive};
use crate::error::number_text;

/// Elastic with an initial stiffness K up to the strength at the jump $\delta_0 = \sigma_c/K$, then
/// linear softening to zero at $\delta_c = 2 G_c/\sigma_c$, with secant unloading; one strength and
/// one fracture energy for all modes. Compression is transmitted without penetration.
///
/// This is what most codes have (an intrinsic law): an interface that has not been damaged is
/// compliant too. It is here to be compared with [`super::LinearSoftening`], to which it tends as K
/// grows.
///
/// # Source
/// A. Hillerborg, M. Modeer, P. Petersson, Cem. Concr. Res. 6 (1976), with an initial slope.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bilinear {
    /// Largest traction, Pa.
    pub strength: f64,
    /// Energy that full rupture takes, per area, J/m2.
    pub fracture_energy: f64,
    /// Traction per jump before any damage, Pa/m; more than strength^2 / (2 fracture_energy).
    pub stiffness: f64,
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

impl Bilinear {
    /// The law with the default augmentation; units as in the fields.
    pub fn new(strength: f64, fracture_energy: f64, stiffness: f64) -> Self {
        Self {
            strength,
            fracture_energy,
            stiffness,
            augmentation: default_augmentation(),
            friction: 0.0,
        }
    }

    /// The undamaged part of the critical jump.
    fn elastic_part(&self) -> f64 {
        self.elastic_jump() / self.critical_jump()
    }
}

impl Envelope for Bilinear {
    fn strength_and_energy(&self) -> (f64, f64) {
        (self.strength, self.fracture_energy)
    }

    fn stiffness_of_augmentation(&self) -> f64 {
        let slope = self.strength * self.strength / self.fracture_energy;
        // The slope that the augmentation must exceed grows as the initial stiffness falls.
        self.augmentation * slope / (1.0 - self.elastic_part())
    }

    fn dissipated_part(&self, jump: f64) -> f64 {
        let first = self.elastic_part();
        ((jump / self.critical_jump() - first) / (1.0 - first)).max(0.0)
    }

    fn jump_of_part(&self, part: f64) -> f64 {
        let first = self.elastic_part();
        (first + part * (1.0 - first)) * self.critical_jump()
    }

    fn coefficient_of_friction(&self) -> f64 {
        self.friction
    }

    fn mistakes(&self) -> Vec<String> {
        let mut problems = not_positive(&[("stiffness", self.stiffness)]);
        if problems.is_empty() && self.elastic_part() >= 1.0 {
            problems.push(format!(
                "stiffness must be above {} Pa/m, or the interface takes more than fracture_energy \
                 before it reaches its strength, got {}",
                number_text(0.5 * self.strength * self.strength / self.fracture_energy),
                number_text(self.stiffness)
            ));
        }
        if !(self.augmentation.is_finite() && self.augmentation > 0.5) {
            problems.push(format!(
                "augmentation must be above 0.5, or the response to a traction is not unique, got {}",
                number_text(self.augmentation)
            ));
        }
        problems
    }

    fn elastic_jump(&self) -> f64 {
        self.strength / self.stiffness
    }

    fn critical_jump(&self) -> f64 {
        2.0 * self.fracture_energy / self.strength
    }

    fn secant(&self, jump: f64) -> f64 {
        -self.slope(jump) * (self.critical_jump() / jump - 1.0)
    }

    fn slope(&self, _jump: f64) -> f64 {
        -self.strength / (self.critical_jump() - self.elastic_jump())
    }

    fn jump_under(&self, q: f64, r: f64) -> f64 {
        let h = -self.slope(0.0);
        (q - h * self.critical_jump()) / (r - h)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testkit::{Samples, respond_to_jump};
    use super::super::{Branch, InterfaceLaw};
    use super::*;

    impl Samples for Bilinear {
        fn samples() -> Vec<Self> {
            vec![
                Bilinear {
                    strength: 1.1e6,
                    fracture_energy: 900.0,
                    stiffness: 1.0e11,
                    augmentation: 10.0,
                    friction: 0.0,
                },
                Bilinear {
                    strength: 3.0e6,
                    fracture_energy: 100.0,
                    stiffness: 9.0e10,
                    augmentation: 1.5,
                    friction: 0.0,
                },
            ]
        }

        fn branches() -> &'static [Branch] {
            &[
                Branch::Unloading,
                Branch::UnloadingClosed,
                Branch::Softening,
                Branch::SofteningClosed,
                Branch::Broken,
                Branch::BrokenClosed,
            ]
        }
    }

    #[test]
    fn tractions_rise_with_the_stiffness_and_fall_on_the_line() {
        let law = Bilinear::samples().swap_remove(0);
        let r = law.stiffness_of_augmentation();
        let (first, last) = (1.1e6 / 1.0e11, 2.0 * 900.0 / 1.1e6);
        for (jump, exact) in [
            (0.5 * first, 0.55e6),
            (first, 1.1e6),
            (0.5 * (first + last), 0.55e6),
            (0.25 * first + 0.75 * last, 0.275e6),
        ] {
            let found = respond_to_jump(&law, r, [jump, 0.0, 0.0], 0.0, 2).expect("a jump");
            assert!((found.traction[0] - exact).abs() < 1e-6, "{jump}: {}", found.traction[0]);
            let damage = ((jump - first) / (last - first)).max(0.0);
            assert!((law.damage(found.history) - damage).abs() < 1e-12);
        }
    }

    #[test]
    fn a_stiffness_that_takes_more_than_the_fracture_energy_is_refused() {
        let law = Bilinear { stiffness: 6.0e8, ..Bilinear::samples().swap_remove(0) };
        assert!(law.check()[0].starts_with("stiffness must be above 6.72"), "{:?}", law.check());
    }
}
