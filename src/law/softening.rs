//! The response that all softening laws share, from the envelope of each.
//!
//! The traction follows the direction of the jump; its size is bounded by an envelope of the
//! largest equivalent jump so far, and below that jump it is proportional to the jump. One strength
//! and one fracture energy serve all modes. Friction comes in [`super::friction`].

use super::{Branch, Friction, InterfaceLaw, Local, LocalMatrix, Response};
use crate::error::number_text;

/// Equivalent jumps below this fraction of the critical one count as none: their secant is as good
/// as rigid, and as a number it would only spoil the conditioning.
pub(super) const SMALLEST_JUMP: f64 = 1.0e-12;

/// A state this close to the threshold counts as below it: rounding only.
pub(super) const THRESHOLD_TIE: f64 = 16.0 * f64::EPSILON;

/// How the largest traction falls with the largest equivalent jump.
pub trait Envelope {
    /// The largest traction (Pa) and the energy of full rupture (J/m2).
    fn strength_and_energy(&self) -> (f64, f64);

    /// The augmentation r, Pa/m; more than the steepest fall of the envelope.
    fn stiffness_of_augmentation(&self) -> f64;

    /// The part of the energy of full rupture that is dissipated up to a largest jump below the
    /// critical one.
    fn dissipated_part(&self, jump: f64) -> f64;

    /// The largest jump at which the dissipated part is this much, above 0 and below 1.
    fn jump_of_part(&self, part: f64) -> f64;

    /// Coefficient of friction on the broken part of closed lips.
    fn coefficient_of_friction(&self) -> f64;

    /// What is wrong with the parameters, each positive.
    fn mistakes(&self) -> Vec<String>;

    /// The jump by which errors of jumps are measured, m.
    fn unit_jump(&self) -> f64 {
        self.critical_jump()
    }

    /// The equivalent jump up to which nothing is damaged, m; zero where adhesion is exact.
    fn elastic_jump(&self) -> f64;

    /// The equivalent jump from which nothing is transmitted, m.
    fn critical_jump(&self) -> f64;

    /// Traction over the jump on the envelope, Pa/m.
    fn secant(&self, jump: f64) -> f64;

    /// Derivative of the traction on the envelope by the jump, Pa/m; not positive.
    fn slope(&self, jump: f64) -> f64;

    /// The jump on the envelope at which traction + r jump is `q`, which is beyond the elastic
    /// jump.
    fn jump_under(&self, q: f64, r: f64) -> f64;
}

/// Jump, traction and derivatives at the augmented traction `p`, as
/// [`super::InterfaceLaw::respond`] says.
///
/// On the threshold itself, within a few units in the last place, a damaged point unloads: the
/// first correction after a commit takes the secant, which is exact for a reversal and leaves the
/// softening branch to the next correction of a further loading. For this the first iterate must be
/// evaluated at the very `p` that was committed.
fn respond(law: &impl Envelope, p: Local, r: f64, history: f64, dim: usize) -> Response {
    let critical = law.critical_jump();
    let smallest = SMALLEST_JUMP * critical;
    let closed = p[0] <= 0.0;
    let p: Local = std::array::from_fn(|i| if i < dim { p[i] } else { 0.0 });
    let pulled = [p[0].max(0.0), p[1], p[2]];
    let q = norm(pulled);
    let kappa = history.max(law.elastic_jump()).min(critical);
    let pick = |open, shut| if closed { shut } else { open };
    // traction + r jump at a point of the envelope.
    let threshold = |jump: f64| (law.secant(jump) + r) * jump;

    if kappa < smallest && q <= threshold(smallest) {
        return Response::held(p, dim, pick(Branch::Stick, Branch::StickClosed), kappa);
    }
    // w = ratio p+; C = along e(x)e + across (I - e(x)e), and A = (C + r I)^-1.
    let (branch, ratio, along, across, kappa) = if kappa >= critical || q >= r * critical {
        (pick(Branch::Broken, Branch::BrokenClosed), 1.0 / r, 0.0, 0.0, critical)
    } else if kappa >= smallest && q <= threshold(kappa) * (1.0 + THRESHOLD_TIE) {
        let s = law.secant(kappa);
        (pick(Branch::Unloading, Branch::UnloadingClosed), 1.0 / (r + s), s, s, kappa)
    } else {
        let jump = law.jump_under(q, r);
        let branch = pick(Branch::Softening, Branch::SofteningClosed);
        (branch, jump / q, law.slope(jump), law.secant(jump), kappa.max(jump).min(critical))
    };
    let first = usize::from(closed);
    let mut jump = [0.0; 3];
    for i in first..dim {
        jump[i] = ratio * pulled[i];
    }
    Response {
        jump,
        traction: std::array::from_fn(|i| p[i] - r * jump[i]),
        compliance: transverse_isotropic(1.0 / (r + along), 1.0 / (r + across), pulled, first..dim),
        stuck: [closed, false, false],
        tangent: transverse_isotropic(along, across, pulled, first..dim),
        friction: [0.0; 3],
        branch,
        history: kappa,
    }
}

impl<E: Envelope> InterfaceLaw for E {
    fn respond(&self, p: Local, augmentation: f64, history: f64, dim: usize) -> Response {
        respond(self, p, augmentation, history, dim)
    }

    fn augmentation(&self, _stiffness: f64) -> f64 {
        self.stiffness_of_augmentation()
    }

    fn jump_scale(&self) -> Option<f64> {
        Some(self.critical_jump())
    }

    fn typical_jump(&self) -> Option<f64> {
        Some(self.unit_jump())
    }

    fn strength(&self) -> Option<f64> {
        Some(self.strength_and_energy().0)
    }

    /// Envelopes are steepest where they begin.
    fn steepest_softening(&self) -> Option<f64> {
        Some(-self.slope(self.elastic_jump()))
    }

    /// The dissipated part of the energy of full rupture.
    fn damage(&self, history: f64) -> f64 {
        if history >= self.critical_jump() { 1.0 } else { self.dissipated_part(history) }
    }

    fn history_of_damage(&self, damage: f64) -> Option<f64> {
        let critical = self.critical_jump();
        Some(match damage {
            d if d <= 0.0 => 0.0,
            d if d >= 1.0 => critical,
            d => self.jump_of_part(d).min(critical),
        })
    }

    /// None of a point that still holds as if nothing had moved.
    fn broken_part(&self, history: f64) -> f64 {
        let holds = history < SMALLEST_JUMP * self.critical_jump();
        if holds { 0.0 } else { self.damage(history) }
    }

    fn part_of_reach(&self, jump: Local, history: f64) -> Option<f64> {
        let critical = self.critical_jump();
        if history >= critical {
            return Some(0.0);
        }
        let is_damaged = history > self.elastic_jump().max(SMALLEST_JUMP * critical);
        is_damaged.then(|| norm([jump[0].max(0.0), jump[1], jump[2]]) / history)
    }

    fn dissipated(&self, history: f64) -> f64 {
        self.strength_and_energy().1 * self.damage(history)
    }

    fn recoverable(&self, jump: Local, history: f64) -> f64 {
        let critical = self.critical_jump();
        let kappa = history.max(self.elastic_jump());
        if kappa < SMALLEST_JUMP * critical || kappa >= critical {
            return 0.0;
        }
        let opened = norm([jump[0].max(0.0), jump[1], jump[2]]);
        0.5 * self.secant(kappa) * opened * opened
    }

    fn holds_opening(&self, history: f64) -> bool {
        history < self.critical_jump()
    }

    fn holds_sliding(&self, history: f64) -> bool {
        history < self.critical_jump()
    }

    fn friction(&self) -> Friction {
        Friction { coefficient: self.coefficient_of_friction(), cohesion: 0.0 }
    }

    fn shear_secant(&self, history: f64) -> f64 {
        let kappa = history.max(self.elastic_jump());
        if kappa < self.critical_jump() { self.secant(kappa) } else { 0.0 }
    }

    fn sliding_of(&self, history: f64) -> f64 {
        history.max(self.elastic_jump())
    }

    /// From G_c D = (area under the envelope) - (what unloading gives back).
    fn slid_to(&self, sliding: f64) -> (f64, f64) {
        let (secant, slope) = (self.secant(sliding), self.slope(sliding));
        let energy = self.strength_and_energy().1;
        (sliding, 0.5 * (secant - slope) * sliding / energy)
    }

    fn check(&self) -> Vec<String> {
        let (strength, fracture_energy) = self.strength_and_energy();
        let mut problems =
            not_positive(&[("strength", strength), ("fracture_energy", fracture_energy)]);
        problems.extend(self.friction().mistakes());
        problems.extend(self.mistakes());
        problems
    }
}

/// What is wrong with parameters that must be positive, by name.
pub(super) fn not_positive(parameters: &[(&str, f64)]) -> Vec<String> {
    let wrong = parameters.iter().filter(|(_, value)| !(value.is_finite() && *value > 0.0));
    let words = |(name, value): &(&str, f64)| {
        format!("{name} must be positive, got {}", number_text(*value))
    };
    wrong.map(words).collect()
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
