use std::collections::BTreeMap;

use super::super::testkit::{Random, Samples, probes};
use super::super::{
    BenzeggaghKenane, Bilinear, Contact, ExponentialSoftening, InterfaceLaw, LinearSoftening,
};
use super::*;

const FRICTION: Friction = Friction { coefficient: 0.6, cohesion: 0.0 };

/// Calls `test` with points of a law whose lips are closed or open, and that have slid.
fn for_each_probe<L: Samples>(mut test: impl FnMut(&L, f64, Local, Past, usize, &Response)) {
    for law in L::samples() {
        let r = law.augmentation(1.0e9);
        let mut random = Random(0x1234_5678_9abc_def1);
        // An odd step, so that every kind of probe is among them.
        for (mut p, history, dim) in probes(&law, r).into_iter().step_by(11) {
            if random.within(0.0, 1.0) < 0.6 {
                p[0] = -p[0].abs();
            }
            let most = law.jump_scale().map_or(1e-3, |_| law.sliding_of(history));
            let (size, angle) = (random.within(0.0, most), random.within(0.0, 6.3));
            let sliding = if dim == 3 {
                [size * angle.cos(), size * angle.sin()]
            } else {
                [size * angle.cos(), 0.0]
            };
            // What was undamaged has not slid.
            let sliding = if law.broken_part(history) > 0.0 { sliding } else { [0.0; 2] };
            let past = Past { history, sliding };
            test(&law, r, p, past, dim, &FRICTION.respond(&law, p, r, past, dim));
        }
    }
}

fn derivatives<L: Samples>() -> BTreeMap<(Branch, usize), usize> {
    let mut met = BTreeMap::new();
    for_each_probe::<L>(|law, r, p, past, dim, response| {
        let size = p.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
        let step = 1e-7 * size;
        for j in 0..dim {
            let at = |sign: f64| {
                let mut moved = p;
                moved[j] += sign * step;
                FRICTION.respond(law, moved, r, past, dim)
            };
            let (ahead, behind) = (at(1.0), at(-1.0));
            if ahead.branch != response.branch || behind.branch != response.branch {
                continue;
            }
            *met.entry((response.branch, dim)).or_default() += 1;
            for i in 0..dim {
                let difference = r * (ahead.jump[i] - behind.jump[i]) / (2.0 * step);
                let found = r * response.compliance[i][j];
                // Directions turn fast where a point has hardly slid.
                let turns = response.tangent.iter().flatten().fold(1.0_f64, |m, c| m.max(c / r));
                assert!(
                    (found - difference).abs() <= 1e-6 * turns.max(1.0),
                    "{:?} {dim}D {i} {j}: {found} {difference} at {p:?} {past:?}",
                    response.branch
                );
            }
        }
    });
    met
}

/// Every branch of the laws in contact, in 2D and in 3D.
fn meets(met: &BTreeMap<(Branch, usize), usize>, branches: &[Branch]) {
    for branch in branches {
        for dim in [2, 3] {
            assert!(met.get(&(*branch, dim)).is_some_and(|n| *n > 2), "{branch:?} {dim}: {met:?}");
        }
    }
}

#[test]
fn derivatives_are_those_of_the_answer_in_every_branch() {
    use Branch::{Held, Open, Sliding, SofteningClosed, UnloadingClosed};
    meets(&derivatives::<Contact>(), &[Open, Held, Sliding]);
    let cohesive = [Held, UnloadingClosed, SofteningClosed, Sliding];
    meets(&derivatives::<LinearSoftening>(), &cohesive);
    meets(&derivatives::<ExponentialSoftening>(), &cohesive);
    meets(&derivatives::<Bilinear>(), &cohesive);
    meets(&derivatives::<BenzeggaghKenane>(), &cohesive);
}

fn parts_agree<L: Samples>() {
    for_each_probe::<L>(|law, r, p, past, dim, response| {
        let (a, c) = (response.compliance, response.tangent);
        let size = p.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        for i in 0..dim {
            let sum = response.traction[i] + r * response.jump[i];
            assert!((sum - p[i]).abs() <= 1e-9 * size, "{:?}", response.branch);
        }
        let friction: f64 = (1..dim).map(|i| response.friction[i].powi(2)).sum::<f64>().sqrt();
        if friction > 0.0 {
            let broken = law.broken_part(response.history);
            assert!((friction - 0.6 * broken).abs() < 1e-9, "{friction} {broken}");
            for i in 1..dim {
                let normal: f64 = (1..dim).map(|j| a[i][j] * response.friction[j]).sum();
                assert!((a[i][0] + normal).abs() * r < 1e-9);
                for k in 1..dim {
                    let shift = |j: usize| if j == k { r } else { 0.0 };
                    let product: f64 = (1..dim).map(|j| a[i][j] * (c[j][k] + shift(j))).sum();
                    assert!((product - f64::from(u8::from(i == k))).abs() < 1e-9);
                }
            }
        }
        if response.branch == Branch::Held {
            assert_eq!(response.jump, [0.0, past.sliding[0], past.sliding[1]]);
            assert!((0..dim).all(|i| response.stuck[i]));
        }
        if response.branch == Branch::Sliding {
            let shear = response.traction[1].hypot(response.traction[2]);
            assert!((shear + 0.6 * response.traction[0]).abs() <= 1e-9 * size);
        }
    });
}

#[test]
fn traction_jump_and_derivatives_belong_together() {
    parts_agree::<Contact>();
    parts_agree::<LinearSoftening>();
    parts_agree::<ExponentialSoftening>();
    parts_agree::<Bilinear>();
    parts_agree::<BenzeggaghKenane>();
}

fn is_continuous<L: Samples>() {
    for_each_probe::<L>(|law, r, p, past, dim, _| {
        let at = |x: f64| {
            let p = [p[0] * (2.0 - x), p[1] * x, p[2] * x];
            FRICTION.respond(law, p, r, past, dim)
        };
        let size = p.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let size = size + r * law.jump_scale().unwrap_or(size / r);
        for piece in 0..20 {
            let (mut low, mut high) = (0.1 * f64::from(piece), 0.1 * f64::from(piece + 1));
            let first = at(low).branch;
            if first == at(high).branch {
                continue;
            }
            for _ in 0..52 {
                let middle = 0.5 * (low + high);
                if at(middle).branch == first { low = middle } else { high = middle }
            }
            let (below, above) = (at(low), at(high));
            for i in 0..dim {
                let step = (below.traction[i] - above.traction[i]).abs();
                assert!(step <= 1e-10 * size, "{first:?} {:?}: {step} {size}", above.branch);
            }
        }
    });
}

#[test]
fn the_answer_is_continuous_across_branches() {
    is_continuous::<Contact>();
    is_continuous::<LinearSoftening>();
    is_continuous::<ExponentialSoftening>();
    is_continuous::<Bilinear>();
    is_continuous::<BenzeggaghKenane>();
}

/// Slides a point under the pressure `n` to the jump `to`, found by Newton's method in p.
fn slid_to(law: &dyn InterfaceLaw, n: f64, to: f64, past: &mut Past) -> f64 {
    let (r, friction) = (law.augmentation(1e9), law.friction());
    let mut p =
        [-n, r * to + (law.strength().unwrap_or(0.0) + n) * (to - past.sliding[0]).signum(), 0.0];
    for _ in 0..60 {
        let answer = friction.respond(law, p, r, *past, 2);
        let miss = to - answer.jump[1];
        if miss.abs() <= 1e-15 * to.abs() {
            break;
        }
        p[1] += (answer.tangent[1][1] + r) * miss;
    }
    let answer = friction.respond(law, p, r, *past, 2);
    *past = Past { history: answer.history, sliding: [answer.jump[1], 0.0] };
    answer.traction[1]
}

#[test]
fn a_joint_slides_to_residual_friction_and_back_on_the_closed_form() {
    let law = LinearSoftening { friction: 0.6, ..LinearSoftening::new(1.1e6, 900.0) };
    let (n, critical) = (2.0e6, 2.0 * 900.0 / 1.1e6);
    let cohesive = |w: f64, kappa: f64| 1.1e6 * (1.0 / kappa - 1.0 / critical) * w;
    let mut past = Past::default();
    let mut kappa = 0.0_f64;
    for (to, way) in [(0.2, 1.0), (0.5, 1.0), (0.3, -1.0), (-0.1, -1.0), (0.45, 1.0), (0.9, 1.0)] {
        let w = to * critical;
        kappa = kappa.max(w.abs());
        let found = slid_to(&law, n, w, &mut past);
        let exact = cohesive(w, kappa) + way * 0.6 * n * kappa / critical;
        assert!((found - exact).abs() < 1e-9 * exact.abs(), "{to}: {found} {exact}");
    }
    for (to, way) in [(1.5, 1.0), (0.4, -1.0)] {
        let found = slid_to(&law, n, to * critical, &mut past);
        assert!((found - way * 0.6 * n).abs() < 1e-9 * n, "{to}: {found}");
    }
}

#[test]
fn cohesion_of_contact_is_there_as_long_as_the_lips_are_closed() {
    let law = Contact::new(0.5, 1.0e5);
    let answer = |p: Local| law.friction().respond(&law, p, 1e9, Past::default(), 3);
    let sliding = answer([-2.0e5, 3.0e5, -4.0e5]);
    assert_eq!(sliding.branch, Branch::Sliding);
    assert!((sliding.traction[1] - 0.6 * 2.0e5).abs() < 1e-9);
    assert!((sliding.traction[2] + 0.8 * 2.0e5).abs() < 1e-9);
    assert_eq!(answer([-2.0e5, 1.1e5, 1.5e5]).branch, Branch::Held);
    assert_eq!(answer([1.0, 1.1e5, 1.5e5]).traction, [0.0; 3]);
}

#[test]
fn mistakes_are_named() {
    let words = Contact::new(-0.1, f64::NAN).check();
    assert_eq!(words.len(), 2);
    assert!(words[0].starts_with("friction must") && words[1].starts_with("cohesion must"));
}
