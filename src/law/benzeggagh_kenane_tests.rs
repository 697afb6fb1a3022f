#![allow(clippy::needless_range_loop)] // index notation, as in the formulas

use std::f64::consts::FRAC_PI_2;

use super::super::softening::Envelope;
use super::super::testkit::{Random, Samples, for_each_probe, respond_to_jump};
use super::super::{Branch, InterfaceLaw, LinearSoftening, Local};
use super::*;

impl Samples for BenzeggaghKenane {
    fn samples() -> Vec<Self> {
        vec![
            reference(),
            // Shear is weaker and takes less.
            BenzeggaghKenane {
                strength: 3.0e6,
                shear_strength: 2.0e6,
                fracture_energy: 100.0,
                shear_fracture_energy: 60.0,
                exponent: 1.0,
                augmentation: 4.0,
                friction: 0.0,
            },
            BenzeggaghKenane {
                strength: 1.1,
                shear_strength: 1.1,
                fracture_energy: 0.9,
                shear_fracture_energy: 2.7,
                exponent: 1.5,
                augmentation: 20.0,
                friction: 0.0,
            },
        ]
    }

    fn branches() -> &'static [Branch] {
        LinearSoftening::branches()
    }

    fn rupture(&self, way: Local) -> Option<(f64, f64)> {
        let beta = self.shear_strength / self.strength;
        let shear = beta * beta * (way[1] * way[1] + way[2] * way[2]);
        let square = way[0] * way[0] + shear;
        let more = self.shear_fracture_energy - self.fracture_energy;
        let energy = self.fracture_energy + more * (shear / square).powf(self.exponent);
        Some((2.0 * energy / (self.strength * square.sqrt()), energy))
    }
}

fn reference() -> BenzeggaghKenane {
    BenzeggaghKenane {
        strength: 1.0e6,
        shear_strength: 1.5e6,
        fracture_energy: 500.0,
        shear_fracture_energy: 1500.0,
        exponent: 2.0,
        augmentation: 10.0,
        friction: 0.0,
    }
}

/// Ways of the jump from pure opening to pure shear.
fn ways() -> impl Iterator<Item = Local> {
    (0..=8).map(|i| {
        let (sin, cos) = (FRAC_PI_2 * f64::from(i) / 8.0).sin_cos();
        [if i == 8 { 0.0 } else { cos }, 0.6 * sin, -0.8 * sin]
    })
}

fn dot(a: Local, b: Local) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn size(v: Local) -> f64 {
    dot(v, v).sqrt()
}

fn assert_close(found: f64, exact: f64, scale: f64) {
    assert!((found - exact).abs() <= 1e-12 * scale, "{found} instead of {exact}");
}

#[test]
fn equal_modes_are_linear_softening() {
    let linear = LinearSoftening {
        strength: 1.1e6,
        fracture_energy: 900.0,
        augmentation: 10.0,
        friction: 0.0,
    };
    let law = BenzeggaghKenane {
        strength: 1.1e6,
        shear_strength: 1.1e6,
        fracture_energy: 900.0,
        shear_fracture_energy: 900.0,
        exponent: 1.7,
        augmentation: 10.0,
        friction: 0.0,
    };
    let r = linear.augmentation(0.0);
    assert_close(law.augmentation(0.0), r, r);
    assert!(law.history_is_size_of_jump() && !reference().history_is_size_of_jump());
    for_each_probe::<LinearSoftening>(|other, _, p, history, dim, _| {
        if other != &linear {
            return;
        }
        let (found, exact) = (law.respond(p, r, history, dim), linear.respond(p, r, history, dim));
        assert_eq!((found.branch, found.stuck), (exact.branch, exact.stuck));
        let scale = linear.critical_jump();
        assert_close(found.history, exact.history, scale);
        assert_close(law.damage(found.history), linear.damage(exact.history), 1.0);
        let dissipated = law.dissipated_after(0.0, 0.0, found.history, found.jump);
        assert_close(dissipated, linear.dissipated(exact.history), 900.0);
        let energy = linear.recoverable(exact.jump, exact.history);
        assert_close(law.recoverable(found.jump, found.history), energy, 900.0);
        for i in 0..3 {
            assert_close(found.jump[i], exact.jump[i], scale);
            assert_close(found.traction[i], exact.traction[i], size(p));
            for j in 0..3 {
                let largest = r.max(exact.tangent[i][i].abs());
                assert_close(found.compliance[i][j], exact.compliance[i][j], 1.0 / r);
                assert_close(found.tangent[i][j], exact.tangent[i][j], largest);
            }
        }
    });
}

#[test]
fn the_onset_is_an_ellipse_in_the_tractions() {
    for law in BenzeggaghKenane::samples() {
        let r = law.augmentation(0.0);
        for way in ways() {
            let sheared = [way[1], way[2]].map(|w| w * law.shear_strength);
            let edge = [way[0] * law.strength, sheared[0], sheared[1]];
            for (factor, branch) in [(1.0 - 1e-9, Branch::Stick), (1.0 + 1e-9, Branch::Softening)] {
                let p = [0, 1, 2].map(|i| factor * edge[i]);
                let response = law.respond(p, r, 0.0, 3);
                let closed = way[0] == 0.0 && branch == Branch::Softening;
                if way[0] > 0.0 {
                    assert_eq!(response.branch, branch);
                } else {
                    assert_eq!(
                        response.stuck,
                        if closed { [true, false, false] } else { [true; 3] }
                    );
                }
                for i in 0..3 {
                    assert!((response.traction[i] - edge[i]).abs() <= 1e-8 * size(p));
                }
            }
            // Compression adds nothing to shear.
            let p = [-3.0 * law.strength, 0.0, 0.999 * law.shear_strength];
            assert_eq!(law.respond(p, r, 0.0, 3).branch, Branch::StickClosed);
            let p = p.map(|x| x * 1.002);
            assert_eq!(law.respond(p, r, 0.0, 3).branch, Branch::SofteningClosed);
        }
    }
}

/// On the line along the jump, for any steps; what is across does no work and falls with the step.
#[test]
fn proportional_ways_follow_the_line_and_take_their_energy() {
    for law in BenzeggaghKenane::samples() {
        let r = law.augmentation(0.0);
        let beta = law.shear_strength / law.strength;
        for way in ways() {
            let (critical, energy) = law.rupture(way).unwrap();
            let mut across = Vec::new();
            for steps in [1_u32, 7, 200] {
                let (mut history, mut work, mut dissipated, mut largest) = (0.0, 0.0, 0.0, 0.0_f64);
                for step in 1..=steps {
                    let x = f64::from(step) / f64::from(steps);
                    let jump = way.map(|w| x * critical * w);
                    let response = respond_to_jump(&law, r, jump, history, 3).unwrap();
                    // The line is straight: its mean over a step is that of its ends.
                    let along = 2.0 * energy / critical * (1.0 - x);
                    assert!((dot(response.traction, way) - along).abs() < 2e-11 * law.strength);
                    let before = along + 2.0 * energy / critical / f64::from(steps);
                    work += 0.5 * (along + before) * critical / f64::from(steps);
                    let from = history;
                    history = response.history;
                    dissipated = law.dissipated_after(dissipated, from, history, jump);
                    let stored = law.recoverable(jump, history);
                    assert!((work - dissipated - stored).abs() < 1e-10 * energy);
                    let radial = [1.0, beta * beta, beta * beta];
                    let secant = along / (0..3).map(|i| radial[i] * way[i] * way[i]).sum::<f64>();
                    for i in 0..3 {
                        let off = response.traction[i] - secant * radial[i] * way[i];
                        largest = largest.max(off.abs() / law.strength);
                    }
                    // Committed, the traction is on the secant, if the same jump is held.
                    let held = jump.map(|w| w * (1.0 - 1e-12));
                    let again = respond_to_jump(&law, r, held, history, 3).unwrap();
                    assert!(again.history == history && again.branch != Branch::Softening);
                    for i in 0..3 {
                        let off = again.traction[i] - secant * radial[i] * way[i];
                        assert!(off.abs() < 2e-11 * law.strength, "{off}");
                    }
                }
                assert!((dissipated - energy).abs() < 1e-10 * energy, "{dissipated} {energy}");
                across.push(largest);
            }
            if way[0] == 1.0 || way[0] == 0.0 {
                assert!(across.iter().all(|off| *off < 2e-11), "{across:?}");
            } else {
                // First order in the step.
                assert!(across[2] < 0.02 * across[0] && across[0] < 1.0, "{across:?}");
            }
        }
    }
}

#[test]
fn damage_unloads_to_the_origin_and_reloads_to_its_threshold_in_every_mode() {
    let mut random = Random(99);
    for law in BenzeggaghKenane::samples() {
        let r = law.augmentation(0.0);
        let beta = law.shear_strength / law.strength;
        for _ in 0..50 {
            let history = random.within(0.01, 0.99) * law.critical();
            let secant = law.strength / history - 0.5 * law.strength.powi(2) / law.fracture_energy;
            for way in ways() {
                let (critical, energy) = law.rupture(way).unwrap();
                let metric = [1.0, beta * beta, beta * beta];
                let square: f64 = (0..3).map(|i| metric[i] * way[i] * way[i]).sum();
                // Where the line has the secant of the history.
                let line = 2.0 * energy / (critical * critical);
                let threshold = critical * line / (line + secant * square);
                for share in [0.0, 0.3, 1.0 - 1e-9] {
                    let jump = way.map(|w| share * threshold * w);
                    let response = respond_to_jump(&law, r, jump, history, 3).unwrap();
                    assert_eq!(response.history, history);
                    for i in 0..3 {
                        let exact = secant * metric[i] * jump[i];
                        let scale = law.strength.max(law.shear_strength);
                        assert!((response.traction[i] - exact).abs() < 2e-11 * scale);
                    }
                }
                let beyond = way.map(|w| (1.0 + 1e-9) * threshold * w);
                let response = respond_to_jump(&law, r, beyond, history, 3).unwrap();
                assert!(response.history > history);
            }
        }
    }
}

/// Single steps from any damage to any jump: the work is what psi says, with the dissipation never
/// negative, and after rupture nothing is left in any mode.
#[test]
fn a_change_of_mode_never_dissipates_less_than_nothing() {
    let mut random = Random(7);
    for law in BenzeggaghKenane::samples() {
        let r = law.augmentation(0.0);
        for case in 0..400 {
            let history = random.within(0.0, 1.0) * law.critical();
            let reach = law.rupture([0.0, 1.0, 0.0]).unwrap().0.max(law.critical());
            let p = [0; 3].map(|_| 1.5 * r * reach * random.within(-0.5, 1.0));
            let response = law.respond(p, r, history, 2 + case % 2);
            let grown = law.dissipated_after(5.0, history, response.history, response.jump) - 5.0;
            assert!(response.history >= history && grown >= 0.0);
            assert_eq!(grown > 1e-12 * law.fracture_energy, response.history > history);
            // Any smaller jump then gives back what is recoverable.
            let half = response.jump.map(|w| 0.5 * w);
            let traction = respond_to_jump(&law, r, half, response.history, 3).unwrap().traction;
            let energy = law.recoverable(half, response.history);
            assert!((0.5 * dot(traction, half) - energy).abs() < 1e-10 * law.fracture_energy);
        }
        for way in ways() {
            let broken = law.respond(way.map(|w| w * law.strength), r, law.critical(), 3);
            assert!(size(broken.traction) <= 1e-15 * law.strength);
            assert!(broken.branch.is_separated());
        }
        let pressed = law.respond([-law.strength, 0.0, law.strength], r, law.critical(), 3);
        assert!(size(pressed.traction) - law.strength <= 1e-15 * law.strength);
        assert_eq!((pressed.traction[0], pressed.jump[0]), (-law.strength, 0.0));
    }
}

/// Sheared half way to rupture, then opened in many steps: the traction stays on the secant.
#[test]
fn small_steps_tend_to_the_secant_law() {
    let law = reference();
    let r = law.augmentation(0.0);
    let slid = 1.0e-3 / 1.5;
    let off = |steps: u32| {
        let mut history = respond_to_jump(&law, r, [0.0, slid, 0.0], 0.0, 2).unwrap().history;
        let mut largest = 0.0_f64;
        for step in 1..=steps {
            let jump = [0.9e-3 * f64::from(step) / f64::from(steps), slid, 0.0];
            let response = respond_to_jump(&law, r, jump, history, 2).unwrap();
            history = response.history;
            let secant = law.potential().secant(history);
            let exact = [secant * jump[0], secant * 2.25 * slid];
            largest =
                (0..2).map(|i| (response.traction[i] - exact[i]).abs()).fold(largest, f64::max);
        }
        largest / law.strength
    };
    let (coarse, fine) = (off(10), off(1000));
    assert!(fine < 0.02 * coarse && fine > 0.0, "{coarse} {fine}");
}

/// No second derivative of the potential falls below what the augmentation is measured by, and
/// somewhere one nearly does.
#[test]
fn the_steepest_descent_is_a_bound_that_is_met() {
    for law in BenzeggaghKenane::samples() {
        let potential = law.potential();
        let bound = potential.steepest_descent();
        let mut random = Random(3);
        let mut steepest = 0.0_f64;
        for _ in 0..200_000 {
            let theta = random.within(0.0, FRAC_PI_2);
            let mode = potential.mode(theta.sin(), theta.cos());
            let p = 40.0 * bound * law.critical() * random.within(0.0, 1.0).powi(3);
            let load = Load {
                p: [p * theta.cos(), p * theta.sin()],
                r: [5.0 * bound, 5.0 * bound],
                kappa: random.within(0.0, 1.0).powi(2) * law.critical(),
            };
            let [along, mixed, across] = potential.point(&load, &mode).second;
            let spread = (0.5 * (along - across)).hypot(mixed);
            steepest = steepest.max(spread - 0.5 * (along + across));
        }
        assert!(steepest <= bound * (1.0 + 1e-4), "{steepest} {bound}");
        assert!(steepest >= 0.9 * bound, "{steepest} {bound}");
    }
}

#[test]
fn nothing_fails_at_the_limits() {
    for law in BenzeggaghKenane::samples() {
        let least = BenzeggaghKenane { augmentation: 1.0, ..law };
        assert!(least.check().is_empty());
        let r = least.augmentation(0.0);
        for exponent in -40..=12 {
            for other in -40..=12 {
                let sizes = [exponent, other].map(|e| 10.0_f64.powi(e));
                for history in [0.0, 1e-11, 0.5, 1.0 - 1e-15, 1.0].map(|x| x * least.critical()) {
                    let p = [sizes[0] * least.strength, -sizes[1] * least.strength, 0.0];
                    let response = least.respond(p, r, history, 3);
                    let numbers = response.compliance.iter().chain(&response.tangent).flatten();
                    assert!(numbers.chain(&response.jump).all(|x| x.is_finite()), "{response:?}");
                    assert!((0.0..=least.critical()).contains(&response.history));
                }
            }
        }
    }
}

#[test]
fn bad_parameters_are_named() {
    let law = BenzeggaghKenane {
        strength: 0.0,
        shear_strength: -1.0,
        fracture_energy: f64::NAN,
        shear_fracture_energy: f64::INFINITY,
        exponent: 0.9,
        augmentation: 0.5,
        friction: 0.0,
    };
    let names = [
        "strength",
        "shear_strength",
        "fracture_energy",
        "shear_fracture_energy",
        "exponent",
        "augmentation",
    ];
    let problems = law.check();
    assert_eq!(problems.len(), names.len());
    for (problem, name) in problems.iter().zip(names) {
        assert!(problem.starts_with(name), "{problem}");
    }
}
