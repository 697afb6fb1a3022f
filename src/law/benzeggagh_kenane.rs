//! Exact adhesion, linear softening with a strength and an energy for each mode, contact.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::potential::{Load, Potential};
use super::softening::{SMALLEST_JUMP, THRESHOLD_TIE, not_positive};
use super::{Branch, Friction, InterfaceLaw, Local, LocalMatrix, Response};
use crate::error::number_text;

mod potential;

/// Exact adhesion up to an ellipse of normal and shear strength, then linear softening with the
/// fracture energy of Benzeggagh and Kenane, secant unloading; contact, with friction on what is
/// broken.
///
/// With $N$, $S$ the strengths, $\beta = S/N$, $M = \mathrm{diag}(1, \beta^2, \beta^2)$,
/// $d^2 = w_+ \cdot M w_+$, the share of shear $B = \beta^2 |w_t|^2/d^2 = \sin^2\theta$ and
/// $G = G_I + (G_{II} - G_I) B^\eta$, the traction is $t = k M w$ below
/// $\hat d = N/(k + N^2/2G)$, which is the jump at which the line $N - N^2 d/2G$ has the secant
/// $k$. Beyond, within one step from the committed $k$, it is the gradient of
/// $\psi = N d - \frac{N^2}{4G} d^2 - \frac{N}{2} \hat d$, and of
/// $\psi = G - \frac{N}{2} \hat d$ from $d_c = 2G/N$ on: of the recoverable $\frac{k}{2} d^2$ at
/// the new $k$ and the dissipated $\frac{N}{2} (d - \hat d)$. The history is the jump $\kappa$ of
/// pure opening with the same secant, $k = N/\kappa - N^2/2G_I$.
///
/// # Limits
/// Along a fixed direction of the jump the component of t along it is on the line, and rupture
/// takes $G(B)$, in steps of any length. The gradient also has a part across, against a turn to the
/// mode that takes more, $-(\partial_\theta N^2/4G)(d^2 - \hat d^2)/d$: it makes the tangent
/// symmetric, is of the order of the growth of d within the step, and is gone once the step is
/// accepted. As steps shrink, t tends to $k M w$, and B is the share of shear in the energy. In a
/// step that passes rupture this part remains, though the branch is `Broken`; in mixed modes and
/// long steps it can press open lips together. No potential of the jump avoids it: where no
/// traction is left it is constant, one energy for all modes. What is dissipated depends on the
/// way, not on the history alone.
///
/// # Source
/// Energy: M. Benzeggagh, M. Kenane, Compos. Sci. Technol. 56 (1996) 439-449. Onset and secant:
/// P. Camanho, C. Davila, M. de Moura, J. Compos. Mater. 37 (2003) 1415-1438, there with a penalty
/// stiffness, which is infinite here.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BenzeggaghKenane {
    /// Normal traction at which the interface starts to open where there is no shear, Pa.
    pub strength: f64,
    /// Shear traction at which it starts to slide where there is no tension, Pa.
    pub shear_strength: f64,
    /// Energy that rupture in pure opening takes, per area, J/m2.
    pub fracture_energy: f64,
    /// Energy that rupture in pure shear takes, per area, J/m2.
    pub shear_fracture_energy: f64,
    /// Exponent eta of the share of shear; at least 1.
    pub exponent: f64,
    /// Augmentation in units of twice the steepest descent of the law, which is
    /// strength^2 / fracture_energy if the modes do not differ; at least 1. The converged answer
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

impl BenzeggaghKenane {
    /// The law with the default augmentation, each pair that of opening and of shear; units as in
    /// the fields.
    pub fn new(strengths: [f64; 2], fracture_energies: [f64; 2], exponent: f64) -> Self {
        let [strength, shear_strength] = strengths;
        let [fracture_energy, shear_fracture_energy] = fracture_energies;
        let augmentation = default_augmentation();
        Self {
            strength,
            shear_strength,
            fracture_energy,
            shear_fracture_energy,
            exponent,
            augmentation,
            friction: 0.0,
        }
    }

    fn beta(&self) -> f64 {
        self.shear_strength / self.strength
    }

    fn potential(&self) -> Potential {
        Potential {
            strength: self.strength,
            energies: [self.fracture_energy, self.shear_fracture_energy],
            exponent: self.exponent,
        }
    }

    /// The history at which all modes are broken.
    fn critical(&self) -> f64 {
        self.potential().critical()
    }

    /// (max(w_n, 0), beta |w_t|), m.
    fn scaled(&self, jump: Local) -> [f64; 2] {
        [jump[0].max(0.0), self.beta() * jump[1].hypot(jump[2])]
    }

    /// The answer of an elastic point; normal held if `closed`.
    fn elastic(&self, p: Local, r: f64, secant: f64, closed: bool, dim: usize) -> Response {
        let shear = secant * self.beta() * self.beta();
        let mut response = Response::held(p, dim, Branch::Unloading, 0.0);
        response.stuck = [closed, false, false];
        for (i, stiffness) in [secant, shear, shear].into_iter().enumerate().take(dim) {
            if !response.stuck[i] {
                response.compliance[i][i] = 1.0 / (r + stiffness);
                response.tangent[i][i] = stiffness;
                response.jump[i] = p[i] / (r + stiffness);
                response.traction[i] = p[i] - r * response.jump[i];
            }
        }
        response
    }

    /// The answer beyond the threshold of the history, 0 where nothing has moved; none if rounding
    /// leads back to rest.
    fn loading(&self, p: Local, r: f64, kappa: f64, dim: usize) -> Option<Response> {
        let (potential, beta) = (self.potential(), self.beta());
        let (closed, shear, square) = (p[0] <= 0.0, p[1].hypot(p[2]), beta * beta);
        let load = Load { p: [p[0].max(0.0), shear / beta], r: [r, r / square], kappa };
        let mode = potential.find_mode(&load);
        let at = potential.point(&load, &mode);
        if at.d <= 0.0 {
            return None;
        }
        let e = if shear > 0.0 { [p[1] / shear, p[2] / shear] } else { [1.0, 0.0] };
        let sliding = at.d * mode.sin / beta;
        let jump = [at.d * mode.cos, sliding * e[0], sliding * e[1]];
        // Inverted in the polar basis, where small and large stiffnesses are apart.
        let shift = load.augmentation(&mode);
        let [along, mixed, across]: [f64; 3] = std::array::from_fn(|i| at.second[i] + shift[i]);
        let det = along * across - mixed * mixed;
        let inverse = [across / det, -mixed / det, along / det];
        let aside = square * (at.along + at.turn * mode.cos * mode.cos) / at.d;
        let [c, a] = [at.second, inverse].map(|polar| mode.in_axes(polar));
        let [mut c, mut a] =
            [[c[0], c[1] * beta, c[2] * square], [a[0], a[1] / beta, a[2] / square]];
        if closed {
            c = [0.0, 0.0, square * at.second[0]];
            a = [0.0, 0.0, 1.0 / (r + c[2])];
        }
        let grown = match at.branch {
            Branch::Broken => potential.critical(),
            Branch::Softening => potential.history(at.d, &mode),
            _ => kappa,
        };
        Some(Response {
            jump,
            traction: std::array::from_fn(|i| p[i] - r * jump[i]),
            compliance: in_frame(a, 1.0 / (r + aside), e, dim),
            stuck: [closed, false, false],
            tangent: in_frame(c, aside, e, dim),
            friction: [0.0; 3],
            branch: at.branch,
            history: grown.max(kappa).min(potential.critical()),
        })
    }
}

/// The operator (nn, nt, tt) and `aside` in the tangential direction across `e`.
fn in_frame([nn, nt, tt]: [f64; 3], aside: f64, e: [f64; 2], dim: usize) -> LocalMatrix {
    let mut out = [[0.0; 3]; 3];
    out[0][0] = nn;
    for i in 1..dim {
        out[0][i] = nt * e[i - 1];
        out[i][0] = out[0][i];
        for j in 1..dim {
            out[i][j] = (tt - aside) * (e[i - 1] * e[j - 1]);
        }
        out[i][i] = if dim == 2 { tt } else { out[i][i] + aside };
    }
    out
}

impl InterfaceLaw for BenzeggaghKenane {
    fn respond(&self, p: Local, r: f64, history: f64, dim: usize) -> Response {
        let p: Local = std::array::from_fn(|i| if i < dim { p[i] } else { 0.0 });
        let closed = p[0] <= 0.0;
        let (potential, critical) = (self.potential(), self.critical());
        let kappa = history.min(critical);
        let is_new = kappa < SMALLEST_JUMP * critical;
        let pulled = p[0].max(0.0).hypot(p[1].hypot(p[2]) / self.beta());
        let mut response = if kappa >= critical {
            let response = self.elastic(p, r, 0.0, closed, dim);
            Response { branch: Branch::Broken, ..response }
        } else if is_new && pulled <= self.strength * (1.0 + SMALLEST_JUMP) {
            Response::held(p, dim, Branch::Stick, kappa)
        } else if is_new {
            let answer = self.loading(p, r, 0.0, dim);
            answer.unwrap_or(Response::held(p, dim, Branch::Stick, kappa))
        } else {
            let elastic = self.elastic(p, r, potential.secant(kappa), closed, dim);
            let opened = self.scaled(elastic.jump);
            let reach = potential.reach(kappa, &potential.mode_of(opened));
            // As with the other laws, a tie unloads.
            if opened[0].hypot(opened[1]) <= reach * (1.0 + THRESHOLD_TIE) {
                elastic
            } else {
                self.loading(p, r, kappa, dim).unwrap_or(elastic)
            }
        };
        response.history = response.history.max(kappa);
        if closed {
            response.branch = match response.branch {
                Branch::Stick => Branch::StickClosed,
                Branch::Unloading => Branch::UnloadingClosed,
                Branch::Softening => Branch::SofteningClosed,
                _ => Branch::BrokenClosed,
            };
        }
        response
    }

    fn augmentation(&self, _stiffness: f64) -> f64 {
        2.0 * self.augmentation
            * self.potential().steepest_descent()
            * (self.beta() * self.beta()).max(1.0)
    }

    /// The largest history: the critical jump of pure opening.
    fn jump_scale(&self) -> Option<f64> {
        Some(self.critical())
    }

    /// The smaller critical jump of the two pure modes.
    fn typical_jump(&self) -> Option<f64> {
        Some(self.critical().min(2.0 * self.shear_fracture_energy / self.shear_strength))
    }

    fn strength(&self) -> Option<f64> {
        Some(self.strength)
    }

    /// The part of the fracture energy that pure opening to the same secant dissipates.
    fn damage(&self, history: f64) -> f64 {
        (history / self.critical()).min(1.0)
    }

    fn history_of_damage(&self, damage: f64) -> Option<f64> {
        Some(damage * self.critical())
    }

    /// None of a point that still holds as if nothing had moved.
    fn broken_part(&self, history: f64) -> f64 {
        let holds = history < SMALLEST_JUMP * self.critical();
        if holds { 0.0 } else { self.damage(history) }
    }

    fn part_of_reach(&self, jump: Local, history: f64) -> Option<f64> {
        let (potential, critical) = (self.potential(), self.critical());
        if history >= critical {
            return Some(0.0);
        }
        let opened = self.scaled(jump);
        let reach = || potential.reach(history, &potential.mode_of(opened));
        (history >= SMALLEST_JUMP * critical).then(|| opened[0].hypot(opened[1]) / reach())
    }

    /// What pure opening dissipates; see [`InterfaceLaw::dissipated_after`] for other modes.
    fn dissipated(&self, history: f64) -> f64 {
        self.fracture_energy * self.damage(history)
    }

    fn dissipated_after(&self, before: f64, from: f64, to: f64, jump: Local) -> f64 {
        let potential = self.potential();
        let mode = potential.mode_of(self.scaled(jump));
        let reach = |kappa: f64| potential.reach(kappa.min(potential.critical()), &mode);
        before + 0.5 * self.strength * (reach(to) - reach(from))
    }

    fn history_is_size_of_jump(&self) -> bool {
        self.shear_strength == self.strength && self.shear_fracture_energy == self.fracture_energy
    }

    fn recoverable(&self, jump: Local, history: f64) -> f64 {
        if history < SMALLEST_JUMP * self.critical() || history >= self.critical() {
            return 0.0;
        }
        let opened = self.scaled(jump);
        0.5 * self.potential().secant(history) * (opened[0] * opened[0] + opened[1] * opened[1])
    }

    fn holds_opening(&self, history: f64) -> bool {
        history < self.critical()
    }

    fn holds_sliding(&self, history: f64) -> bool {
        history < self.critical()
    }

    fn friction(&self) -> Friction {
        Friction { coefficient: self.friction, cohesion: 0.0 }
    }

    fn shear_secant(&self, history: f64) -> f64 {
        let open = history < self.critical();
        if open { self.potential().secant(history) * self.beta() * self.beta() } else { 0.0 }
    }

    fn sliding_of(&self, history: f64) -> f64 {
        let potential = self.potential();
        potential.reach(history.min(self.critical()), &potential.mode(1.0, 0.0)) / self.beta()
    }

    fn slid_to(&self, sliding: f64) -> (f64, f64) {
        let (potential, critical) = (self.potential(), self.critical());
        let d = self.beta() * sliding;
        let history = potential.history(d, &potential.mode(1.0, 0.0)).min(critical);
        (history, self.beta() * (history / d).powi(2) / critical)
    }

    fn check(&self) -> Vec<String> {
        let mut problems = not_positive(&[
            ("strength", self.strength),
            ("shear_strength", self.shear_strength),
            ("fracture_energy", self.fracture_energy),
            ("shear_fracture_energy", self.shear_fracture_energy),
        ]);
        problems.extend(self.friction().mistakes());
        if !(self.exponent.is_finite() && self.exponent >= 1.0) {
            problems.push(format!(
                "exponent must be at least 1, or the tangent has no bound at pure opening, got {}",
                number_text(self.exponent)
            ));
        }
        if !(self.augmentation.is_finite() && self.augmentation >= 1.0) {
            problems.push(format!(
                "augmentation must be at least 1, or the response to a traction may not be unique, \
                 got {}",
                number_text(self.augmentation)
            ));
        }
        problems
    }
}

#[cfg(test)]
#[path = "benzeggagh_kenane_tests.rs"]
mod tests;
