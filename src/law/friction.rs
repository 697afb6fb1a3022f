//! Coulomb's friction on the broken part of closed lips, for every law.
//!
//! A point whose lips are closed transmits t_t = t_c(w) + m f: the cohesive part t_c, which is that
//! of the law at the augmented traction p_t - m f, and friction of the size m = D (c - mu t_n)
//! against the sliding since the last accepted state, in the direction f; D is the broken part of
//! the area. Without sliding, friction is whatever holds, up to m. See docs/theory.md, section 2.

#![allow(clippy::needless_range_loop)] // index notation, as in the formulas

use super::{Branch, InterfaceLaw, Local, LocalMatrix, Response};
use crate::error::number_text;

/// The friction of a law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction {
    /// Shear per pressure.
    pub coefficient: f64,
    /// Shear that broken closed lips bear without any pressure, Pa.
    pub cohesion: f64,
}

/// What a point keeps from accepted states.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Past {
    /// kappa, m: the largest equivalent jump.
    pub history: f64,
    /// The sliding, m: it stays where friction holds.
    pub sliding: [f64; 2],
}

/// A shear that exceeds the limit by less than this part of what it comes from does not: where a
/// point has slid, friction holds first.
const TIE: f64 = 1e-12;
/// The sliding is found to the last bit in fewer halvings.
const MOST_HALVINGS: usize = 200;

impl Friction {
    /// None.
    pub const NONE: Self = Self { coefficient: 0.0, cohesion: 0.0 };

    /// Whether there is none.
    pub fn is_none(self) -> bool {
        self == Self::NONE
    }

    /// What is wrong, each beginning with the parameter.
    pub(super) fn mistakes(self) -> Vec<String> {
        let of = [("friction", self.coefficient), ("cohesion", self.cohesion)];
        let wrong = of.into_iter().filter(|(_, value)| !(value.is_finite() && *value >= 0.0));
        let words = |(name, value): (&str, f64)| {
            format!("{name} must not be negative, got {}", number_text(value))
        };
        wrong.map(words).collect()
    }

    /// As [`InterfaceLaw::respond`] of `law`, with this friction.
    pub fn respond(
        self,
        law: &dyn InterfaceLaw,
        p: Local,
        r: f64,
        past: Past,
        dim: usize,
    ) -> Response {
        let without = law.respond(p, r, past.history, dim);
        if self.is_none() || !without.branch.is_closed() || law.broken_part(without.history) <= 0.0
        {
            return without;
        }
        let shear = Shear {
            law,
            p: [p[1], if dim == 3 { p[2] } else { 0.0 }],
            r,
            past,
            bearable: self.cohesion - self.coefficient * p[0],
        };
        match shear.slide() {
            None => shear.held(p[0], dim),
            Some(slid) => {
                let at = [p[0], p[1] - slid.size * slid.way[0], p[2] - slid.size * slid.way[1]];
                let cohesive = law.respond(at, r, past.history, dim);
                shear.sliding(self.coefficient, &slid, cohesive, dim)
            }
        }
    }
}

/// The tangential part of a point whose lips are closed.
struct Shear<'l> {
    law: &'l dyn InterfaceLaw,
    /// Tangential part of the augmented traction, Pa.
    p: [f64; 2],
    r: f64,
    past: Past,
    /// What friction bears where all of the area is broken, Pa.
    bearable: f64,
}

/// A point that slides.
struct Slid {
    /// Size of the friction, Pa, and its direction.
    size: f64,
    way: [f64; 2],
    /// How far it has slid since the last accepted state, m.
    distance: f64,
    /// Where the history grows, the derivative of the size by the jump, Pa/m.
    growth: Local,
    /// The broken part.
    broken: f64,
}

impl Shear<'_> {
    /// p - (secant + r) of the accepted sliding: beyond the friction it makes the point slide.
    fn beyond(&self, secant: f64) -> [f64; 2] {
        std::array::from_fn(|i| self.p[i] - (secant + self.r) * self.past.sliding[i])
    }

    /// The sliding with a given history, where friction of its `size` does not hold it: direction,
    /// distance, and the size of the jump.
    fn with(&self, history: f64) -> Option<(Slid, f64)> {
        let broken = self.law.broken_part(history);
        let (size, secant) = (broken * self.bearable, self.law.shear_secant(history));
        let z = self.beyond(secant);
        let length = z[0].hypot(z[1]);
        let distance = (length - size) / (secant + self.r);
        if distance <= 0.0 {
            return None;
        }
        let way = z.map(|z| z / length);
        let jump: [f64; 2] = std::array::from_fn(|i| self.past.sliding[i] + distance * way[i]);
        let slid = Slid { size, way, distance, growth: [0.0; 3], broken };
        Some((slid, jump[0].hypot(jump[1])))
    }

    /// How the point slides; none where friction holds it.
    fn slide(&self) -> Option<Slid> {
        let Past { history, sliding } = self.past;
        let broken = self.law.broken_part(history);
        let secant = self.law.shear_secant(history);
        if broken > 0.0 {
            let z = self.beyond(secant);
            let parts =
                self.p[0].hypot(self.p[1]) + (secant + self.r) * sliding[0].hypot(sliding[1]);
            if z[0].hypot(z[1]) <= broken * self.bearable + TIE * parts {
                return None;
            }
        }
        let before = self.law.sliding_of(history);
        // An undamaged point that adheres has no secant.
        if before > 0.0 || broken >= 1.0 {
            let (slid, jump) = self.with(history)?;
            if broken >= 1.0 || jump <= before * (1.0 + TIE) {
                return Some(slid);
            }
        }
        self.break_further(before)
    }

    /// How the point slides where that breaks more of it than before, when it had slid `before`.
    fn break_further(&self, before: f64) -> Option<Slid> {
        let end = self.law.jump_scale().map_or(f64::INFINITY, |scale| self.law.sliding_of(scale));
        let excess = |d: f64| {
            let history = if d >= end { self.law.jump_scale()? } else { self.law.slid_to(d).0 };
            self.with(history).map(|(slid, jump)| (slid, jump - d))
        };
        if let Some((broken, excess)) = excess(end)
            && excess >= 0.0
        {
            return Some(broken);
        }
        let (mut low, mut high) = (before, end);
        for _ in 0..MOST_HALVINGS {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            *(if excess(middle).is_some_and(|e| e.1 > 0.0) { &mut low } else { &mut high }) =
                middle;
        }
        let (mut slid, _) = excess(low).filter(|_| low > 0.0).or_else(|| excess(high))?;
        let rate = self.bearable * self.law.slid_to(high).1;
        let jump: [f64; 2] =
            std::array::from_fn(|i| self.past.sliding[i] + slid.distance * slid.way[i]);
        let length = jump[0].hypot(jump[1]);
        slid.growth = [0.0, rate * jump[0] / length, rate * jump[1] / length];
        Some(slid)
    }

    /// The answer of a point that friction holds, with the normal traction `normal`.
    fn held(&self, normal: f64, dim: usize) -> Response {
        let [a, b] = self.past.sliding;
        let r = self.r;
        Response {
            jump: [0.0, a, b],
            traction: [normal, self.p[0] - r * a, self.p[1] - r * b],
            compliance: [[0.0; 3]; 3],
            stuck: std::array::from_fn(|i| i < dim),
            tangent: [[0.0; 3]; 3],
            friction: [0.0; 3],
            branch: Branch::Held,
            history: self.past.history,
        }
    }

    /// The answer of a point that slides, with that of the cohesive part.
    fn sliding(&self, coefficient: f64, slid: &Slid, cohesive: Response, dim: usize) -> Response {
        let way = [0.0, slid.way[0], slid.way[1]];
        let across = slid.size / slid.distance;
        let mut out = cohesive;
        for i in 1..dim {
            out.traction[i] += slid.size * way[i];
            for j in 1..dim {
                let same = f64::from(u8::from(i == j));
                // On a line there is no across.
                let turn = if dim == 3 { across * (same - way[i] * way[j]) } else { 0.0 };
                out.tangent[i][j] += turn + way[i] * slid.growth[j];
            }
            out.friction[i] = -slid.broken * coefficient * way[i];
        }
        out.compliance = compliance(&out.tangent, self.r, dim);
        for i in 1..dim {
            out.compliance[i][0] =
                -(1..dim).map(|j| out.compliance[i][j] * out.friction[j]).sum::<f64>();
        }
        if matches!(out.branch, Branch::Closed | Branch::BrokenClosed) {
            out.branch = Branch::Sliding;
        }
        out
    }
}

/// (C + r I)^-1 on the tangential components.
fn compliance(tangent: &LocalMatrix, r: f64, dim: usize) -> LocalMatrix {
    let mut out = [[0.0; 3]; 3];
    let [a, d] = [tangent[1][1] + r, tangent[2][2] + r];
    if dim == 2 {
        out[1][1] = 1.0 / a;
        return out;
    }
    let [b, c] = [tangent[1][2], tangent[2][1]];
    let det = a * d - b * c;
    out[1] = [0.0, d / det, -b / det];
    out[2] = [0.0, -c / det, a / det];
    out
}

#[cfg(test)]
#[path = "friction_tests.rs"]
mod tests;
