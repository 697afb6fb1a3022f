//! Exact adhesion, exponential softening, secant unloading, contact.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::softening::Envelope;
use crate::error::number_text;

/// Exact adhesion up to the strength, then softening of the traction along the jump as
/// $\sigma_c \exp(-\delta/L)$ with $L = G_c/\sigma_c$, with secant unloading; one strength and one
/// fracture energy for all modes; contact, with friction on what is broken.
///
/// The envelope ends at 36 L, where the traction is as small as the rounding of the strength. The
/// damage is the part of the fracture energy that is dissipated.
///
/// # Source
/// code_aster R7.02.11 (CZM_EXP_REG, without its initial slope); as
/// [`super::LinearSoftening`] written in terms of the largest jump.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExponentialSoftening {
    /// Traction at which the interface starts to open or slide, Pa.
    pub strength: f64,
    /// Energy that full rupture takes, per area, J/m2.
    pub fracture_energy: f64,
    /// Augmentation in units of strength^2 / fracture_energy; more than 1. The converged answer
    /// does not depend on it.
    #[serde(default = "default_augmentation")]
    pub augmentation: f64,
    /// Coefficient of friction on the broken part of closed lips.
    #[serde(default)]
    pub friction: f64,
}

fn default_augmentation() -> f64 {
    20.0
}

/// Where the envelope ends, in units of L: exp(-36) is 2.3e-16.
const END: f64 = 36.0;

impl ExponentialSoftening {
    /// The law with the default augmentation; units as in the fields.
    pub fn new(strength: f64, fracture_energy: f64) -> Self {
        Self { strength, fracture_energy, augmentation: default_augmentation(), friction: 0.0 }
    }

    /// L = G_c / sigma_c, m.
    fn length(&self) -> f64 {
        self.fracture_energy / self.strength
    }
}

impl Envelope for ExponentialSoftening {
    fn strength_and_energy(&self) -> (f64, f64) {
        (self.strength, self.fracture_energy)
    }

    fn stiffness_of_augmentation(&self) -> f64 {
        self.augmentation * self.strength * self.strength / self.fracture_energy
    }

    /// The area under the envelope less the triangle that unloading gives back.
    fn dissipated_part(&self, jump: f64) -> f64 {
        let x = jump / self.length();
        -(-x).exp_m1() - 0.5 * x * (-x).exp()
    }

    /// Newton's method for $x - \ln(1 + x/2) = -\ln(1 - D)$ with x the jump over L, from the right,
    /// where the convex function is positive: it only falls.
    fn jump_of_part(&self, part: f64) -> f64 {
        let wanted = -(-part).ln_1p();
        let mut x = 2.0 * wanted;
        for _ in 0..60 {
            let step = (x - (0.5 * x).ln_1p() - wanted) * (2.0 + x) / (1.0 + x);
            x -= step;
            if step <= f64::EPSILON * x {
                break;
            }
        }
        x * self.length()
    }

    fn coefficient_of_friction(&self) -> f64 {
        self.friction
    }

    fn mistakes(&self) -> Vec<String> {
        let mut problems = Vec::new();
        if !(self.augmentation.is_finite() && self.augmentation > 1.0) {
            let unit = self.strength / self.length();
            problems.push(format!(
                "augmentation must be above 1: r = {} Pa/m has to exceed the steepest slope of the \
                 softening {} Pa/m, got {}",
                number_text(self.augmentation * unit),
                number_text(unit),
                number_text(self.augmentation)
            ));
        }
        problems
    }

    fn unit_jump(&self) -> f64 {
        2.0 * self.length()
    }

    fn elastic_jump(&self) -> f64 {
        0.0
    }

    fn critical_jump(&self) -> f64 {
        END * self.length()
    }

    fn secant(&self, jump: f64) -> f64 {
        self.strength * (-jump / self.length()).exp() / jump
    }

    fn slope(&self, jump: f64) -> f64 {
        -self.strength / self.length() * (-jump / self.length()).exp()
    }

    /// Newton's method from the right, where the convex function is positive: it only falls.
    fn jump_under(&self, q: f64, r: f64) -> f64 {
        let mut jump = q / r;
        for _ in 0..60 {
            let traction = self.strength * (-jump / self.length()).exp();
            let step = (traction + r * jump - q) / (r + self.slope(jump));
            jump -= step;
            if step <= f64::EPSILON * jump {
                break;
            }
        }
        jump.max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testkit::{Samples, respond_to_jump};
    use super::super::{Branch, InterfaceLaw};
    use super::*;

    impl Samples for ExponentialSoftening {
        fn samples() -> Vec<Self> {
            // Not much less: the test kit's own Newton method for a given jump would cycle.
            vec![
                ExponentialSoftening {
                    strength: 1.1e6,
                    fracture_energy: 900.0,
                    augmentation: 20.0,
                    friction: 0.0,
                },
                ExponentialSoftening {
                    strength: 3.0e6,
                    fracture_energy: 100.0,
                    augmentation: 4.0,
                    friction: 0.0,
                },
            ]
        }

        fn branches() -> &'static [Branch] {
            &[
                Branch::Stick,
                Branch::StickClosed,
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
    fn tractions_follow_the_exponential_and_unload_to_the_origin() {
        let law = ExponentialSoftening::samples().swap_remove(0);
        let r = law.stiffness_of_augmentation();
        for size in [1e-5, 3e-4, 2e-3] {
            let jump = [0.6 * size, -0.8 * size, 0.0];
            let full = respond_to_jump(&law, r, jump, 0.0, 3).expect("a jump of the envelope");
            let half = jump.map(|w| 0.5 * w);
            let half = respond_to_jump(&law, r, half, full.history, 3).expect("a smaller jump");
            let exact = 1.1e6 * (-size * 1.1e6 / 900.0_f64).exp();
            for (i, jump) in jump.iter().enumerate() {
                let traction = exact * jump / size;
                assert!((full.traction[i] - traction).abs() < 1e-9 * 1.1e6);
                assert!((half.traction[i] - 0.5 * traction).abs() < 1e-9 * 1.1e6);
            }
            assert_eq!(half.branch, Branch::Unloading);
        }
    }

    #[test]
    fn bad_parameters_are_named() {
        let law = ExponentialSoftening {
            strength: 0.0,
            fracture_energy: -1.0,
            augmentation: 1.0,
            friction: 0.0,
        };
        let problems = law.check();
        assert_eq!(problems.len(), 3);
        for (problem, name) in problems.iter().zip(["strength", "fracture_energy", "augmentation"])
        {
            assert!(problem.starts_with(name));
        }
    }
}
