//! The potential of the law within one step, in polar coordinates (d, theta) of the space of
//! (w_n, beta |w_t|), and the point at which it balances an augmented traction.

use std::f64::consts::FRAC_PI_2;

use crate::law::Branch;

/// Modes and damages at which the steepest descent is evaluated.
const SAMPLES: [u32; 2] = [512, 16];

/// Newton's method takes about five; bisection alone would take 52.
const MAX_CORRECTIONS: usize = 200;

/// What the potential is made of.
pub struct Potential {
    /// Strength N; in this space it is that of every mode, Pa.
    pub strength: f64,
    /// Energies of rupture in pure opening and in pure shear, J/m2.
    pub energies: [f64; 2],
    /// Exponent eta of the share of shear.
    pub exponent: f64,
}

/// A mode theta, with c = N^2 / (4 G) and its derivatives by theta, Pa/m.
#[derive(Clone, Copy)]
pub struct Mode {
    pub sin: f64,
    pub cos: f64,
    c: f64,
    /// c' / (sin cos), which has a limit in the pure modes.
    turn: f64,
    first: f64,
    second: f64,
}

impl Mode {
    /// A symmetric operator (along, mixed, across) of the polar basis as (nn, nt, tt).
    pub fn in_axes(&self, [along, mixed, across]: [f64; 3]) -> [f64; 3] {
        let Mode { sin, cos, .. } = *self;
        [
            cos * cos * along - 2.0 * sin * cos * mixed + sin * sin * across,
            sin * cos * (along - across) + (cos * cos - sin * sin) * mixed,
            sin * sin * along + 2.0 * sin * cos * mixed + cos * cos * across,
        ]
    }
}

/// A point of a mode, with the derivatives of the potential.
pub struct Point {
    /// The regime, as if open.
    pub branch: Branch,
    /// Size of the jump, m.
    pub d: f64,
    /// Traction along the jump, Pa.
    pub along: f64,
    /// Traction across over sin cos, towards larger theta, Pa.
    pub turn: f64,
    /// Second derivatives in the polar basis (along, mixed, across), Pa/m.
    pub second: [f64; 3],
}

/// An augmented traction (p_n+, |p_t| / beta), the augmentation (r, r / beta^2), and the committed
/// history, 0 where nothing has moved.
pub struct Load {
    pub p: [f64; 2],
    pub r: [f64; 2],
    pub kappa: f64,
}

impl Load {
    /// The augmentation in the polar basis (along, mixed, across).
    pub fn augmentation(&self, mode: &Mode) -> [f64; 3] {
        let [normal, shear] = self.r;
        let [opening, sliding] = [mode.cos * mode.cos, mode.sin * mode.sin];
        [
            normal * opening + shear * sliding,
            (shear - normal) * mode.sin * mode.cos,
            normal * sliding + shear * opening,
        ]
    }
}

impl Potential {
    /// The history at which all modes are broken: the critical jump of pure opening, m.
    pub fn critical(&self) -> f64 {
        2.0 * self.energies[0] / self.strength
    }

    pub fn mode(&self, sin: f64, cos: f64) -> Mode {
        let (share, eta) = (sin * sin, self.exponent);
        let more = self.energies[1] - self.energies[0];
        let energy = self.energies[0] + more * share.powf(eta);
        let c = 0.25 * self.strength * self.strength / energy;
        // G' / G over sin cos, and G'' / G.
        let rise = 2.0 * more * eta * share.powf(eta - 1.0) / energy;
        let bend = rise * ((2.0 * eta - 1.0) * cos * cos - share);
        let (turn, first) = (-c * rise, -c * rise * sin * cos);
        Mode { sin, cos, c, turn, first, second: 2.0 * first * first / c - c * bend }
    }

    /// The mode of a vector of this space; opening where it is zero.
    pub fn mode_of(&self, v: [f64; 2]) -> Mode {
        let size = v[0].hypot(v[1]);
        if size > 0.0 { self.mode(v[1] / size, v[0] / size) } else { self.mode(0.0, 1.0) }
    }

    /// k(kappa), Pa/m.
    pub fn secant(&self, kappa: f64) -> f64 {
        self.strength / kappa - self.strength / self.critical()
    }

    /// 1/kappa = 1/d-hat - this, 1/m.
    fn shift(&self, mode: &Mode) -> f64 {
        2.0 * mode.c / self.strength - 1.0 / self.critical()
    }

    /// The jump d-hat of a mode that leaves the secant of the history `kappa`, m.
    pub fn reach(&self, kappa: f64, mode: &Mode) -> f64 {
        kappa / (1.0 + kappa * self.shift(mode))
    }

    /// The history that the jump `d` of a mode leaves, m.
    pub fn history(&self, d: f64, mode: &Mode) -> f64 {
        d / (1.0 - d * self.shift(mode))
    }

    /// The point of a mode at which the potential less the work of the load is least.
    pub fn point(&self, load: &Load, mode: &Mode) -> Point {
        let (n, c, r) = (self.strength, mode.c, load.augmentation(mode)[0]);
        let reach = self.reach(load.kappa, mode);
        let q = load.p[0] * mode.cos + load.p[1] * mode.sin;
        let rest = Point { branch: Branch::Stick, d: 0.0, along: 0.0, turn: 0.0, second: [0.0; 3] };
        if load.kappa > 0.0 {
            let secant = self.secant(load.kappa);
            let d = q / (r + secant);
            if d <= reach {
                let second = [secant, 0.0, secant];
                return Point { branch: Branch::Unloading, d, along: secant * d, second, ..rest };
            }
        } else if q <= n {
            return rest;
        }
        // Across, psi_theta = -c' growth.
        let critical = 0.5 * n / c;
        let squared = mode.first * mode.first;
        let softened = (q - n) / (r - 2.0 * c);
        let (branch, d, along, growth) = if softened < critical {
            let growth = softened * softened - reach * reach;
            (Branch::Softening, softened, n - 2.0 * c * softened, growth)
        } else {
            (Branch::Broken, q / r, 0.0, critical * critical - reach * reach)
        };
        let bend = -mode.second * growth - 4.0 * squared * reach.powi(3) / n;
        let across = mode.first * growth / (d * d);
        let second = if branch == Branch::Softening {
            [-2.0 * c, across - 2.0 * mode.first, along / d + bend / (d * d)]
        } else {
            [0.0, across, (bend + 2.0 * squared * critical * critical / c) / (d * d)]
        };
        Point { branch, d, along, turn: -mode.turn * growth / d, second }
    }

    /// The mode in which the potential less the work of the load is least, d being least for each.
    /// It falls up to this mode and rises beyond, as the whole is strictly convex. Newton's method;
    /// bisection where that would leave the bracket or be slow.
    pub fn find_mode(&self, load: &Load) -> Mode {
        if load.p[0] == 0.0 {
            return self.mode(1.0, 0.0);
        }
        if load.p[1] == 0.0 {
            return self.mode(0.0, 1.0);
        }
        let (mut low, mut high) = (0.0, FRAC_PI_2);
        let (mut theta, mut last) = (load.p[1].atan2(load.p[0]), FRAC_PI_2);
        let mut mode = self.mode_of(load.p);
        for _ in 0..MAX_CORRECTIONS {
            let (at, r) = (self.point(load, &mode), load.augmentation(&mode));
            let turned = load.p[0] * mode.sin - load.p[1] * mode.cos;
            let slope = at.turn * mode.sin * mode.cos + r[1] * at.d + turned;
            if slope == 0.0 {
                break;
            }
            if slope > 0.0 {
                high = theta
            } else {
                low = theta
            }
            let mixed = at.second[1] + r[1];
            let curvature = at.second[2] + r[2] - mixed * mixed / (at.second[0] + r[0]);
            let mut step = -slope / (curvature * at.d);
            let inside = theta + step > low && theta + step < high;
            if !(inside && step.abs() <= 0.5 * last) {
                step = 0.5 * (low + high) - theta;
            }
            theta += step;
            last = step.abs();
            mode = self.mode(theta.sin(), theta.cos());
            if last <= f64::EPSILON * theta {
                break;
            }
        }
        mode
    }

    /// Magnitude of the most negative second derivative over all modes and histories, Pa/m. It is
    /// met at the critical jump, on one of its sides: the terms that fall with d only add to it,
    /// and beyond everything falls as 1/d^2.
    pub fn steepest_descent(&self) -> f64 {
        let mut steepest = 0.0_f64;
        for i in 0..=SAMPLES[0] {
            let (sin, cos) = (FRAC_PI_2 * f64::from(i) / f64::from(SAMPLES[0])).sin_cos();
            let Mode { c, first, second, .. } = self.mode(sin, cos);
            let bend = 2.0 * first * first / c;
            for j in 0..=SAMPLES[1] {
                // d-hat / d_c
                let share = f64::from(j) / f64::from(SAMPLES[1]);
                let growth = 1.0 - share * share;
                let across = -second * growth - bend * share.powi(3);
                let before = [-2.0 * c, first * (growth - 2.0), across];
                let beyond = [0.0, first * growth, across + bend];
                for [along, mixed, across] in [before, beyond] {
                    let spread = (0.5 * (along - across)).hypot(mixed);
                    steepest = steepest.max(spread - 0.5 * (along + across));
                }
            }
        }
        steepest
    }
}
