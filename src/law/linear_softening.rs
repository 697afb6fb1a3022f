//! Exact adhesion, linear softening, secant unloading, contact.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Branch, InterfaceLaw, Local, LocalMatrix, Response};

/// Exact adhesion up to the strength, then linear softening of the traction along the jump to
/// zero, with secant unloading; one strength and one fracture energy for all modes; contact
/// without friction, whatever the damage.
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
}

fn default_augmentation() -> f64 {
    10.0
}

/// Equivalent jumps below this fraction of delta_c count as none: their secant is as good as rigid,
/// and as a number it would only spoil the conditioning.
const SMALLEST_JUMP: f64 = 1.0e-12;

/// A state this close to the threshold counts as below it: rounding only.
const THRESHOLD_TIE: f64 = 16.0 * f64::EPSILON;

impl LinearSoftening {
    /// delta_c = 2 G_c / sigma_c, m.
    pub fn critical_jump(&self) -> f64 {
        2.0 * self.fracture_energy / self.strength
    }

    /// h = sigma_c / delta_c, Pa/m.
    pub fn softening_slope(&self) -> f64 {
        self.strength / self.critical_jump()
    }

    /// s(kappa), Pa/m: the slope of the line from the origin to the envelope.
    fn secant(&self, jump: f64) -> f64 {
        self.strength / jump - self.softening_slope()
    }
}

impl InterfaceLaw for LinearSoftening {
    /// As the trait says. On the threshold itself, within a few units in the last place, a damaged
    /// point unloads: the first correction after a commit takes the secant, which is exact for a
    /// reversal and leaves the softening branch to the next correction of a further loading. For
    /// this the first iterate must be evaluated at the very `p` that was committed.
    fn respond(&self, p: Local, augmentation: f64, history: f64, dim: usize) -> Response {
        let (r, h) = (augmentation, self.softening_slope());
        let critical = self.critical_jump();
        let smallest = SMALLEST_JUMP * critical;
        let closed = p[0] <= 0.0;
        let p: Local = std::array::from_fn(|i| if i < dim { p[i] } else { 0.0 });
        let pulled = [p[0].max(0.0), p[1], p[2]];
        let q = norm(pulled);
        let kappa = history.min(critical);
        let pick = |open, shut| if closed { shut } else { open };

        if kappa < smallest && q <= self.strength + (r - h) * smallest {
            return Response::held(p, dim, pick(Branch::Stick, Branch::StickClosed), kappa);
        }
        // w = ratio p+; C = along e(x)e + across (I - e(x)e), and A = (C + r I)^-1.
        let (branch, ratio, along, across, kappa) = if kappa >= critical || q >= r * critical {
            (pick(Branch::Broken, Branch::BrokenClosed), 1.0 / r, 0.0, 0.0, critical)
        } else if kappa >= smallest
            && q <= (self.strength + (r - h) * kappa) * (1.0 + THRESHOLD_TIE)
        {
            let s = self.secant(kappa);
            (pick(Branch::Unloading, Branch::UnloadingClosed), 1.0 / (r + s), s, s, kappa)
        } else {
            let jump = (q - self.strength) / (r - h);
            let branch = pick(Branch::Softening, Branch::SofteningClosed);
            (branch, jump / q, -h, self.secant(jump), kappa.max(jump).min(critical))
        };
        let first = usize::from(closed);
        let mut jump = [0.0; 3];
        for i in first..dim {
            jump[i] = ratio * pulled[i];
        }
        Response {
            jump,
            traction: std::array::from_fn(|i| p[i] - r * jump[i]),
            compliance: transverse_isotropic(
                1.0 / (r + along),
                1.0 / (r + across),
                pulled,
                first..dim,
            ),
            stuck: [closed, false, false],
            tangent: transverse_isotropic(along, across, pulled, first..dim),
            branch,
            history: kappa,
        }
    }

    fn augmentation(&self, _stiffness: f64) -> f64 {
        self.augmentation * self.strength * self.strength / self.fracture_energy
    }

    fn jump_scale(&self) -> Option<f64> {
        Some(self.critical_jump())
    }

    fn strength(&self) -> Option<f64> {
        Some(self.strength)
    }

    fn damage(&self, history: f64) -> f64 {
        (history / self.critical_jump()).min(1.0)
    }

    fn dissipated(&self, history: f64) -> f64 {
        self.fracture_energy * self.damage(history)
    }

    fn recoverable(&self, jump: Local, history: f64) -> f64 {
        let critical = self.critical_jump();
        if history < SMALLEST_JUMP * critical || history >= critical {
            return 0.0;
        }
        let opened = norm([jump[0].max(0.0), jump[1], jump[2]]);
        0.5 * self.secant(history) * opened * opened
    }

    fn holds_opening(&self, history: f64) -> bool {
        history < self.critical_jump()
    }

    fn holds_sliding(&self, history: f64) -> bool {
        history < self.critical_jump()
    }

    fn check(&self) -> Vec<String> {
        let mut problems = Vec::new();
        for (name, value, unit) in
            [("strength", self.strength, "Pa"), ("fracture_energy", self.fracture_energy, "J/m2")]
        {
            if !(value.is_finite() && value > 0.0) {
                problems.push(format!("{name} is {value} {unit}: it must be positive and finite"));
            }
        }
        if !(self.augmentation.is_finite() && self.augmentation > 0.5) {
            problems.push(format!(
                "augmentation is {}: it must exceed 0.5, or the response to a traction is not \
                 unique (the augmentation times strength^2 / fracture_energy must exceed the \
                 softening slope); 10 is a good value",
                self.augmentation
            ));
        }
        problems
    }
}

fn norm(v: Local) -> f64 {
    v[0].hypot(v[1]).hypot(v[2])
}

/// `along` e(x)e + `across` (I - e(x)e) on the components in `active`, e the direction of `v`.
fn transverse_isotropic(
    along: f64,
    across: f64,
    v: Local,
    active: std::ops::Range<usize>,
) -> LocalMatrix {
    let mut out = [[0.0; 3]; 3];
    let size = norm(v);
    for i in active.clone() {
        out[i][i] = across;
        if along != across {
            for j in active.clone() {
                // This order of the products keeps the operator exactly symmetric.
                out[i][j] += (along - across) * ((v[i] / size) * (v[j] / size));
            }
        }
    }
    out
}

#[cfg(test)]
#[path = "linear_softening_tests.rs"]
mod tests;
