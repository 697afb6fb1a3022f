//! Columns in series of any number of layers and interfaces that are pulled or pressed evenly.

use crate::case::Law;

/// A row of springs and interfaces.
#[derive(Clone)]
pub struct Bars {
    /// z of the ends and of the interfaces.
    pub levels: Vec<f64>,
    /// Stress over strain of each body.
    pub moduli: Vec<f64>,
    pub laws: Vec<Law>,
    /// At the start.
    pub damages: Vec<f64>,
    /// Of the fluid in each interface, constant.
    pub pressures: Vec<f64>,
    /// Along z, per volume.
    pub force: f64,
    pub loaded: bool,
    /// Displacement or traction of the top at each instant.
    pub ends: Vec<f64>,
    pub area: f64,
    /// Force on the left over the stress of the column, where the sides are held.
    pub aside: Option<f64>,
}

/// What an instant must give.
pub struct State {
    pub traction: Vec<f64>,
    pub jump: Vec<f64>,
    pub damage: Vec<f64>,
    /// Of the bottom and the top.
    pub reaction: [f64; 2],
    /// Of the left.
    pub aside: Option<f64>,
}

impl Law {
    /// The traction that opens an interface on, opened by `jump` before.
    fn limit(&self, jump: f64) -> f64 {
        match *self {
            Law::Linear { strength, energy }
            | Law::Modes { strength: [strength, _], energy: [energy, _], .. } => {
                (strength * (1.0 - jump * strength / (2.0 * energy))).max(0.0)
            }
            Law::Exponential { strength, energy } => strength * (-jump * strength / energy).exp(),
            Law::Bilinear { strength, energy, stiffness } => {
                let (first, last) = (strength / stiffness, 2.0 * energy / strength);
                (strength * ((last - jump) / (last - first)).min(1.0)).max(0.0)
            }
            Law::Tied => f64::INFINITY,
            Law::Contact => 0.0,
        }
    }

    /// The jump where nothing was dissipated yet.
    fn first(&self) -> f64 {
        if let Law::Bilinear { strength, stiffness, .. } = self {
            strength / stiffness
        } else {
            0.0
        }
    }

    /// The largest jump of a damage; broken, some more.
    fn opened_to(&self, damage: f64) -> f64 {
        let first = self.first();
        let missing = |jump: f64| self.damage(jump) - damage;
        match *self {
            _ if damage == 0.0 => first,
            Law::Linear { strength, energy }
            | Law::Exponential { strength, energy }
            | Law::Bilinear { strength, energy, .. }
            | Law::Modes { strength: [strength, _], energy: [energy, _], .. } => {
                let critical = 2.0 * energy / strength;
                if damage == 1.0 { 1.001 * critical } else { root(missing, first, critical) }
            }
            Law::Tied | Law::Contact => first,
        }
    }

    /// Jump per traction on the way back to the origin.
    fn compliance(&self, jump: f64) -> f64 {
        let limit = self.limit(jump);
        if jump == 0.0 { 0.0 } else { jump / limit }
    }

    fn damage(&self, jump: f64) -> f64 {
        match *self {
            Law::Linear { strength, energy }
            | Law::Modes { strength: [strength, _], energy: [energy, _], .. } => {
                (jump * strength / (2.0 * energy)).min(1.0)
            }
            Law::Exponential { strength, energy } => {
                let x = jump * strength / energy;
                1.0 - (-x).exp() * (1.0 + 0.5 * x)
            }
            Law::Bilinear { strength, energy, stiffness } => {
                let (first, last) = (strength / stiffness, 2.0 * energy / strength);
                ((jump - first) / (last - first)).clamp(0.0, 1.0)
            }
            Law::Tied | Law::Contact => 0.0,
        }
    }
}

impl Bars {
    /// States of all instants up to the first that is not determined by this; and whether it came
    /// to the end.
    pub fn states(&self) -> (Vec<State>, bool) {
        let start = |(law, damage): (&Law, &f64)| law.opened_to(*damage);
        let mut largest: Vec<f64> = self.laws.iter().zip(&self.damages).map(start).collect();
        let mut states = Vec::new();
        for (instant, end) in self.ends.iter().enumerate() {
            match self.state(&mut largest, *end, instant == 0) {
                Some(state) => states.push(state),
                None => return (states, false),
            }
        }
        (states, true)
    }

    fn height(&self) -> f64 {
        self.levels[self.levels.len() - 1]
    }

    /// What the law sees above the traction of the top.
    fn offset(&self, joint: usize) -> f64 {
        self.force * (self.height() - self.levels[joint + 1]) + self.pressures[joint]
    }

    fn elongation(&self, top: f64) -> f64 {
        let bodies = self.levels.windows(2).zip(&self.moduli);
        bodies
            .map(|(z, modulus)| {
                let middle = self.height() - 0.5 * (z[0] + z[1]);
                (z[1] - z[0]) / modulus * (top + self.force * middle)
            })
            .sum()
    }

    /// The jump on the way back to the origin; None where broken and pulled, or an open contact.
    fn returning(&self, joint: usize, largest: f64, top: f64) -> f64 {
        let traction = top + self.offset(joint);
        if traction <= 0.0 { 0.0 } else { self.laws[joint].compliance(largest) * traction }
    }

    fn state(&self, largest: &mut [f64], end: f64, first: bool) -> Option<State> {
        let joints = 0..self.laws.len();
        let broken = |i: usize, largest: &[f64]| self.laws[i].limit(largest[i]) == 0.0;
        let mut jump = vec![0.0; self.laws.len()];
        let top;
        if self.loaded {
            top = end;
            for i in joints.clone() {
                let traction = top + self.offset(i);
                if traction > 0.99 * self.laws[i].limit(largest[i]) {
                    return None;
                }
                jump[i] = self.returning(i, largest[i], top);
            }
        } else {
            // Those that are broken carry nothing but pressure.
            let closed = |i: usize| broken(i, largest);
            let total = |top: f64| {
                let jumps = joints.clone().filter(|i| !closed(*i));
                self.elongation(top)
                    + jumps.map(|i| self.returning(i, largest[i], top)).sum::<f64>()
                    - end
            };
            let trial = root(total, 0.0, self.stress());
            let over = |i: &usize, top: f64| {
                let limit = self.laws[*i].limit(largest[*i]);
                top + self.offset(*i) > limit + 1e-12 * self.stress()
            };
            let give: Vec<usize> = joints.clone().filter(|i| over(i, trial)).collect();
            // Close calls are left out.
            let close =
                joints.clone().filter(|i| !give.contains(i) && self.laws[*i] != Law::Contact);
            if close.into_iter().any(|i| {
                let limit = self.laws[i].limit(largest[i]);
                !broken(i, largest)
                    && (trial + self.offset(i) - limit).abs() < 1e-6 * limit
                    && jump[i] == 0.0
                    && largest[i] == self.laws[i].first()
            }) {
                return None;
            }
            let early = |i: &usize| {
                let limit = self.laws[*i].limit(largest[*i]);
                // In the first step everything grows together.
                if first { limit / (trial + self.offset(*i)) } else { limit - self.offset(*i) }
            };
            match give.into_iter().min_by(|a, b| early(a).total_cmp(&early(b))) {
                None => {
                    top = trial;
                    for i in joints.clone() {
                        jump[i] = if broken(i, largest) {
                            0.0
                        } else {
                            self.returning(i, largest[i], top)
                        };
                    }
                }
                Some(one) => {
                    let law = self.laws[one];
                    let before = largest[one];
                    let at = |opened: f64| law.limit(opened.max(before)) - self.offset(one);
                    let excess = |opened: f64| {
                        let top = at(opened);
                        let others = joints.clone().filter(|i| *i != one && !broken(*i, largest));
                        let others: f64 = others.map(|i| self.returning(i, largest[i], top)).sum();
                        opened + others + self.elongation(top) - end
                    };
                    let least = if broken(one, largest) { 0.0 } else { largest[one] };
                    let step = self.elongation(self.stress()).abs();
                    // Softening below the stiffness everywhere: one answer.
                    let samples: Vec<f64> =
                        (0..=200).map(|n| excess(least + 0.1 * step * f64::from(n))).collect();
                    if samples.windows(2).any(|pair| pair[1] <= pair[0]) {
                        return None;
                    }
                    let opened = root(excess, least, step);
                    top = at(opened);
                    for i in joints.clone() {
                        if i == one {
                            jump[i] = opened;
                        } else if over(&i, top)
                            || (broken(i, largest) && top + self.offset(i) > 0.0)
                        {
                            return None;
                        } else {
                            jump[i] = if broken(i, largest) {
                                0.0
                            } else {
                                self.returning(i, largest[i], top)
                            };
                        }
                    }
                    largest[one] = before.max(opened);
                }
            }
        }
        let bottom = top + self.force * self.height();
        Some(State {
            traction: joints.clone().map(|i| top + self.offset(i)).collect(),
            damage: joints.map(|i| self.laws[i].damage(largest[i])).collect(),
            jump,
            aside: self.aside.filter(|_| self.force == 0.0).map(|share| -share * top),
            reaction: [-bottom * self.area, top * self.area],
        })
    }

    fn stress(&self) -> f64 {
        let most = self.laws.iter().map(Law::strength).filter(|s| s.is_finite() && *s > 0.0);
        most.fold(1e-4 * self.moduli.iter().copied().fold(f64::INFINITY, f64::min), f64::max)
    }
}

/// Where a growing function vanishes, to rounding; `step` is about as far as it may be.
fn root(function: impl Fn(f64) -> f64, from: f64, step: f64) -> f64 {
    let (mut low, mut high, mut reach) = (from, from, step);
    while function(high) < 0.0 {
        high += reach;
        reach *= 2.0;
    }
    while function(low) > 0.0 {
        low -= reach;
        reach *= 2.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if function(middle) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
