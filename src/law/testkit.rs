//! The conformance battery that every law passes.

#![allow(clippy::needless_range_loop)] // index notation, as in the formulas

use super::{Branch, InterfaceLaw, Local, Response};

/// Parameter sets of a law that, with the probes of the battery, reach every branch.
pub trait Samples: InterfaceLaw + Sized {
    fn samples() -> Vec<Self>;
    /// The branches that the battery must have met.
    fn branches() -> &'static [Branch];
    /// Size of the jump at which rupture in the direction `_way` is full (m), and its energy
    /// (J/m2); none if nothing breaks.
    fn rupture(&self, _way: Local) -> Option<(f64, f64)> {
        self.jump_scale().map(|scale| (scale, self.dissipated(scale)))
    }
}

/// A plain generator (xorshift), so that every run probes the same points.
pub struct Random(pub u64);

impl Random {
    /// Uniform in [low, high).
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        low + (high - low) * ((self.0 >> 11) as f64 / (1_u64 << 53) as f64)
    }
}

const STIFFNESS: f64 = 1.0e9;

/// Augmented tractions and histories, from far below to far beyond the strength.
pub fn probes<L: InterfaceLaw>(law: &L, r: f64) -> Vec<(Local, f64, usize)> {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let scale = law.strength().unwrap_or(1.0e6);
    let limit = law.jump_scale().map_or(3.0, |jump| 1.5 * r * jump / scale);
    let mut out = Vec::new();
    for case in 0..3000 {
        let dim = 2 + case % 2;
        let history = match case % 5 {
            0 | 1 => 0.0,
            2 | 3 => random.within(0.0, 1.0) * law.jump_scale().unwrap_or(0.0),
            _ => 1.2 * law.jump_scale().unwrap_or(0.0),
        };
        let size =
            scale * if case % 3 == 0 { random.within(0.0, 2.0) } else { random.within(0.0, limit) };
        let mut p: Local = std::array::from_fn(|_| random.within(-1.0, 1.0));
        match case % 7 {
            0 => p = [1.0, 0.0, 0.0],
            1 => p[0] = 0.0,
            _ => {}
        }
        let norm = p.iter().map(|x| x * x).sum::<f64>().sqrt();
        out.push((p.map(|x| x * size / norm), history, dim));
    }
    out
}

pub fn for_each_probe<L: Samples>(mut test: impl FnMut(&L, f64, Local, f64, usize, &Response)) {
    for law in L::samples() {
        assert_eq!(law.check(), Vec::<String>::new());
        let r = law.augmentation(STIFFNESS);
        for (p, history, dim) in probes(&law, r) {
            test(&law, r, p, history, dim, &law.respond(p, r, history, dim));
        }
    }
}

/// The response of a point whose jump is imposed: solves w(p) = `jump`, if it can be.
pub fn respond_to_jump<L: InterfaceLaw>(
    law: &L,
    r: f64,
    jump: Local,
    history: f64,
    dim: usize,
) -> Option<Response> {
    let largest = |v: Local| v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    // Starts beyond the strength: from below it, a rigid point would creep up in steps of r w. In
    // other modes the strength may be higher.
    let size = largest(jump).max(f64::MIN_POSITIVE);
    let start = |beyond: f64| jump.map(|x| r * x + beyond * x / size);
    let mut p = start(law.strength().unwrap_or(0.0));
    for doubled in 1..5 {
        if law.respond(p, r, history, dim).stuck[dim - 1] {
            p = start(law.strength().unwrap_or(0.0) * f64::from(1 << doubled));
        }
    }
    for _ in 0..100 {
        let response = law.respond(p, r, history, dim);
        let miss: Local = std::array::from_fn(|i| jump[i] - response.jump[i]);
        if largest(miss) <= 8.0 * f64::EPSILON * (largest(jump) + largest(p) / r) {
            return Some(response);
        }
        // Newton: dp = A^-1 miss = (C + r I) miss; r alone frees what is stuck.
        for i in 0..3 {
            p[i] += r * miss[i] + (0..3).map(|j| response.tangent[i][j] * miss[j]).sum::<f64>();
        }
    }
    None
}

fn within(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

pub fn meets_every_branch<L: Samples>() {
    let mut met = std::collections::BTreeSet::new();
    for_each_probe::<L>(|_, _, _, _, _, response| {
        met.insert(response.branch);
    });
    assert_eq!(met, L::branches().iter().copied().collect());
}

pub fn splits_the_augmented_traction<L: Samples>() {
    for_each_probe::<L>(|law, r, p, history, dim, response| {
        for i in 0..dim {
            assert!(within(response.traction[i] + r * response.jump[i], p[i], 1e-9 * p[i].abs()));
            assert!(!response.stuck[i] || response.jump[i] == 0.0);
        }
        let full = law.jump_scale().unwrap_or(f64::INFINITY);
        assert!(response.jump[0] >= 0.0 && response.history >= history.min(full));
        for i in dim..3 {
            assert_eq!((response.jump[i], response.traction[i]), (0.0, 0.0));
            assert!(!response.stuck[i]);
        }
        if response.branch.is_closed() {
            assert!(response.stuck[0] && response.traction[0] <= 0.0);
        }
    });
}

pub fn compliance_is_the_derivative_of_the_jump<L: Samples>() {
    for_each_probe::<L>(|law, r, p, history, dim, response| {
        let step = 1e-6 * p.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
        for j in 0..dim {
            let at = |sign: f64| {
                let mut moved = p;
                moved[j] += sign * step;
                law.respond(moved, r, history, dim)
            };
            let (ahead, behind) = (at(1.0), at(-1.0));
            if ahead.branch != response.branch || behind.branch != response.branch {
                continue;
            }
            for i in 0..dim {
                let difference = (ahead.jump[i] - behind.jump[i]) / (2.0 * step);
                assert!(
                    within(response.compliance[i][j] * r, difference * r, 1e-6),
                    "{:?} {i} {j}: {} {difference}",
                    response.branch,
                    response.compliance[i][j]
                );
            }
        }
    });
}

pub fn tangent_belongs_to_the_compliance<L: Samples>() {
    for_each_probe::<L>(|_, r, _, _, dim, response| {
        let (a, c) = (response.compliance, response.tangent);
        for i in 0..3 {
            for j in 0..3 {
                assert_eq!((a[i][j], c[i][j]), (a[j][i], c[j][i]));
                let free = i < dim && j < dim && !response.stuck[i] && !response.stuck[j];
                if !free {
                    assert_eq!((a[i][j], c[i][j]), (0.0, 0.0));
                    continue;
                }
                let product: f64 =
                    (0..dim).map(|k| a[i][k] * (c[k][j] + if k == j { r } else { 0.0 })).sum();
                assert!(within(product, if i == j { 1.0 } else { 0.0 }, 1e-11));
            }
        }
        // Positive semi-definite, probed by the columns of a fixed basis.
        for v in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.6, -0.8, 0.3], [-0.2, 0.5, 0.9]] {
            let form: f64 = (0..3).flat_map(|i| (0..3).map(move |j| v[i] * a[i][j] * v[j])).sum();
            assert!(form >= -1e-14 / r);
        }
    });
}

pub fn response_is_continuous<L: Samples>() {
    for_each_probe::<L>(|law, r, p, history, dim, _| {
        // Bisect the way from -p/2 to 2p at every change of branch.
        let at = |x: f64| law.respond(p.map(|v| x * v), r, history, dim);
        let size = p.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        for piece in 0..25 {
            let (mut low, mut high) =
                (-0.5 + 0.1 * f64::from(piece), -0.4 + 0.1 * f64::from(piece));
            let (first, last) = (at(low).branch, at(high).branch);
            if first == last {
                continue;
            }
            while high - low > 1e-15 {
                let middle = 0.5 * (low + high);
                if middle == low || middle == high {
                    break;
                }
                if at(middle).branch == first { low = middle } else { high = middle }
            }
            let (below, above) = (at(low), at(high));
            for i in 0..dim {
                let jump = law.jump_scale().unwrap_or(size / r);
                assert!(within(below.traction[i], above.traction[i], 1e-10 * (size + r * jump)));
                assert!(within(below.jump[i], above.jump[i], 2e-12 * jump + 1e-13 * size / r));
            }
        }
    });
}

pub fn nothing_at_rest<L: Samples>() {
    for law in L::samples() {
        let scale = law.jump_scale().unwrap_or(0.0);
        for history in [0.0, 1e-300, 1e-9 * scale, 0.3 * scale, scale, 2.0 * scale] {
            for dim in [2, 3] {
                let response = law.respond([0.0; 3], law.augmentation(STIFFNESS), history, dim);
                assert_eq!((response.jump, response.traction), ([0.0; 3], [0.0; 3]));
                let numbers = response.compliance.iter().chain(&response.tangent).flatten();
                assert!(numbers.copied().all(f64::is_finite));
            }
        }
    }
}

pub fn tangential_axes_do_not_matter<L: Samples>() {
    for_each_probe::<L>(|law, r, p, history, dim, response| {
        if dim == 2 {
            let mirrored = law.respond([p[0], -p[1], 0.0], r, history, 2);
            assert_eq!(mirrored.traction[1], -response.traction[1]);
            return;
        }
        let (sin, cos) = 0.7_f64.sin_cos();
        let turn = |v: Local| [v[0], cos * v[1] - sin * v[2], sin * v[1] + cos * v[2]];
        let turned = law.respond(turn(p), r, history, 3);
        let size = p.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        for (found, expected) in turned.traction.iter().zip(turn(response.traction)) {
            assert!(within(*found, expected, 1e-11 * size));
        }
        assert!(within(turned.history, response.history, 1e-11 * size / r));
    });
}

pub fn answer_does_not_depend_on_the_augmentation<L: Samples>() {
    for law in L::samples() {
        let r = law.augmentation(STIFFNESS);
        let scale = law.jump_scale().unwrap_or(1e-3);
        let stress = law.strength().unwrap_or(1.0e6);
        let mut random = Random(77);
        for case in 0..200 {
            let history = if case % 2 == 0 { 0.0 } else { random.within(0.01, 1.2) * scale };
            let jump = [
                random.within(0.0, 1.0) * scale,
                random.within(-1.0, 1.0) * scale,
                random.within(-1.0, 1.0) * scale,
            ];
            let Some(one) = respond_to_jump(&law, r, jump, history, 3) else {
                assert!(law.jump_scale().is_none() && law.holds_opening(0.0), "jump not reached");
                return;
            };
            let two = respond_to_jump(&law, 3.7 * r, jump, history, 3).unwrap();
            for i in 0..3 {
                assert!(within(one.traction[i], two.traction[i], 1e-12 * stress));
            }
            assert!(within(one.history, two.history, 1e-13 * scale));
        }
    }
}

/// Work = dissipated + recoverable along random polygons of the jump, and neither dissipation nor
/// history ever decreases.
pub fn energy_balances_along_random_paths<L: Samples>() {
    const STEPS: u32 = 2000;
    for law in L::samples() {
        let r = law.augmentation(STIFFNESS);
        let scale = law.jump_scale().unwrap_or(1e-3);
        let mut random = Random(4242);
        for _ in 0..6 {
            let (mut history, mut work, mut dissipated) = (0.0, 0.0, 0.0);
            let mut from = [1e-9 * scale, 0.0, 0.0];
            for leg in 0..4 {
                let reach = 0.3 * f64::from(leg + 1) * scale;
                let to = [
                    random.within(0.0, reach),
                    random.within(-reach, reach),
                    random.within(-reach, reach),
                ];
                for step in 0..STEPS {
                    let at = |x: f64| -> Local {
                        std::array::from_fn(|i| from[i] + x * (to[i] - from[i]))
                    };
                    let middle = at((f64::from(step) + 0.5) / f64::from(STEPS));
                    let Some(response) = respond_to_jump(&law, r, middle, history, 3) else {
                        assert!(law.jump_scale().is_none() && law.holds_opening(0.0));
                        return;
                    };
                    work += (0..3)
                        .map(|i| response.traction[i] * (to[i] - from[i]) / f64::from(STEPS))
                        .sum::<f64>();
                    assert!(response.history >= history);
                    assert!(law.dissipated(response.history) >= law.dissipated(history));
                    let after =
                        law.dissipated_after(dissipated, history, response.history, response.jump);
                    assert!(after >= dissipated);
                    (history, dissipated) = (response.history, after);
                }
                from = to;
                let stored = dissipated + law.recoverable(to, history);
                let all = law.jump_scale().map_or(0.0, |jump| law.dissipated(jump));
                assert!(within(work, stored, 2e-3 * all), "{work} {stored}");
            }
        }
    }
}

/// Opening, sliding and mixed rupture take the full energy of the law in their direction.
pub fn rupture_takes_the_fracture_energy<L: Samples>() {
    for law in L::samples() {
        let r = law.augmentation(STIFFNESS);
        for way in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.6, 0.0, -0.8], [0.48, 0.6, 0.64]] {
            let Some((scale, energy)) = law.rupture(way) else { continue };
            let (mut work, mut history, mut dissipated) = (0.0, 0.0, 0.0);
            let steps = 4000;
            for step in 0..steps {
                let middle = 1.1 * scale * (f64::from(step) + 0.5) / f64::from(steps);
                let response =
                    respond_to_jump(&law, r, way.map(|x| x * middle), history, 3).unwrap();
                let traction: f64 = (0..3).map(|i| response.traction[i] * way[i]).sum();
                work += traction * 1.1 * scale / f64::from(steps);
                dissipated =
                    law.dissipated_after(dissipated, history, response.history, response.jump);
                history = response.history;
            }
            assert!(within(work, energy, 1e-5 * work));
            assert!(within(dissipated, energy, 1e-10 * energy));
            assert_eq!(law.damage(history), 1.0);
            assert!(!law.holds_opening(history) && !law.holds_sliding(history));
        }
    }
}

/// A point that starts with some damage answers as one that has been loaded to it and unloaded.
pub fn damage_at_the_start_is_that_of_loading<L: Samples>() {
    for law in L::samples() {
        let Some(broken) = law.history_of_damage(1.0) else {
            assert_eq!(law.damage(f64::MAX), 0.0);
            continue;
        };
        assert_eq!((law.history_of_damage(0.0), law.damage(broken)), (Some(0.0), 1.0));
        assert!(!law.holds_opening(broken) && law.part_of_reach([1.0; 3], broken) == Some(0.0));
        let r = law.augmentation(STIFFNESS);
        for (way, part) in [[1.0, 0.0, 0.0], [0.6, 0.0, -0.8], [0.0, 1.0, 0.0]]
            .into_iter()
            .flat_map(|way| [1e-6, 0.02, 0.1, 0.5, 0.9].map(|part| (way, part)))
        {
            let size = part * law.rupture(way).map_or(0.0, |(scale, _)| scale);
            let [full, half] = [1.0, 0.5].map(|part| way.map(|x| part * size * x));
            let loaded = respond_to_jump(&law, r, full, 0.0, 3).unwrap().history;
            let given = law.history_of_damage(law.damage(loaded)).unwrap();
            let [one, two] =
                [loaded, given].map(|h| respond_to_jump(&law, r, half, h, 3).unwrap().traction);
            let strength = law.strength().unwrap_or(0.0);
            (0..3).for_each(|i| assert!(within(one[i], two[i], 1e-9 * strength)));
            let reached = law.part_of_reach(half, loaded);
            assert!(reached.map_or(law.damage(loaded) == 0.0, |part| within(part, 0.5, 1e-9)));
        }
    }
}

/// One test per property, for the law given.
macro_rules! conformance {
    ($law:ty; $($property:ident)+) => {
        $(
            #[test]
            fn $property() {
                crate::law::testkit::$property::<$law>();
            }
        )+
    };
    ($law:ty) => {
        conformance! { $law;
            meets_every_branch
            splits_the_augmented_traction
            compliance_is_the_derivative_of_the_jump
            tangent_belongs_to_the_compliance
            response_is_continuous
            nothing_at_rest
            tangential_axes_do_not_matter
            answer_does_not_depend_on_the_augmentation
            energy_balances_along_random_paths
            rupture_takes_the_fracture_energy
            damage_at_the_start_is_that_of_loading
        }
    };
}
pub(crate) use conformance;
