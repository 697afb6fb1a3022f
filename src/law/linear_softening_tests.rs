#![allow(clippy::needless_range_loop)] // index notation, as in the formulas

use super::super::testkit::{Samples, respond_to_jump};
use super::super::{Branch, InterfaceLaw, Local};
use super::*;

impl Samples for LinearSoftening {
    fn samples() -> Vec<Self> {
        vec![
            LinearSoftening {
                strength: 1.1e6,
                fracture_energy: 900.0,
                augmentation: 10.0,
                friction: 0.0,
            },
            LinearSoftening {
                strength: 3.0e6,
                fracture_energy: 100.0,
                augmentation: 1.5,
                friction: 0.0,
            },
            LinearSoftening {
                strength: 1.1,
                fracture_energy: 0.9,
                augmentation: 100.0,
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

fn reference() -> LinearSoftening {
    LinearSoftening::samples().swap_remove(0)
}

fn assert_close(found: f64, exact: f64) {
    let size = exact.abs().max(1.0);
    assert!((found - exact).abs() <= 1e-12 * size, "{found} instead of {exact}");
}

#[test]
fn imposed_jumps_give_the_tractions_of_the_closed_form() {
    let law = reference();
    let r = law.augmentation(0.0);
    let (sigma, h) = (law.strength, law.softening_slope());
    for (jump, size) in [([3e-4, 4e-4], 5e-4), ([6e-4, 8e-4], 1e-3), ([0.0, 5e-4], 5e-4)] {
        for dim in [2, 3] {
            let wanted = [jump[0], jump[1], 0.0];
            let response = respond_to_jump(&law, r, wanted, 0.0, dim).unwrap();
            let half =
                respond_to_jump(&law, r, wanted.map(|w| 0.5 * w), response.history, dim).unwrap();
            for i in 0..2 {
                let exact = (sigma - h * size) * jump[i] / size;
                assert_close(response.traction[i], exact);
                assert_close(half.traction[i], 0.5 * exact);
            }
            assert_close(response.history / size, 1.0);
            assert!(matches!(half.branch, Branch::Unloading | Branch::UnloadingClosed));
        }
    }
    // As printed in the verification list.
    let printed = respond_to_jump(&law, r, [3e-4, 4e-4, 0.0], 0.0, 3).unwrap().traction;
    assert!((printed[0] - 458333.33).abs() < 0.01 && (printed[1] - 611111.11).abs() < 0.01);
}

#[test]
fn compression_does_not_change_the_shear() {
    let law = reference();
    let r = law.augmentation(0.0);
    let sheared = respond_to_jump(&law, r, [0.0, 5e-4, 0.0], 0.0, 3).unwrap();
    let p = [-2.0e6, sheared.traction[1] + r * 5e-4, 0.0];
    let pressed = law.respond(p, r, 0.0, 3);
    assert_eq!(pressed.jump[0], 0.0);
    assert_eq!(pressed.traction[0], -2.0e6);
    assert_close(pressed.traction[1], 763_888.888_888_888_9);
    assert_eq!(pressed.branch, Branch::SofteningClosed);
}

/// A bar of stiffness K pulled by U: t = K (U - w). The first correction of an instant starts from
/// the committed state and its tangent.
#[test]
fn the_reference_column_follows_its_path_in_few_corrections() {
    const K: f64 = 5.8e9 / 5.0;
    // (u_x, u_z, traction, kappa / delta_c, branch, corrections)
    let path = [
        (0.0, -1.0e-4, -116_000.0, 0.0, Branch::StickClosed, 1),
        (0.0, 1.0e-4, 116_000.0, 0.0, Branch::Stick, 1),
        (0.0, 1.0e-3, 1_017_312.072_892_938_2, 0.075_170_842_8, Branch::Softening, 2),
        (0.0, 5.0e-4, 508_656.036_446_469_1, 0.075_170_842_8, Branch::Unloading, 1),
        (0.0, 1.2e-3, 697_585.421_412_300_9, 0.365_831_435_1, Branch::Softening, 2),
        (0.0, 1.7e-3, 0.0, 1.0, Branch::Broken, 3),
        (1.0e-3, 1.7e-3, 0.0, 1.0, Branch::Broken, 1),
        (0.0, -1.0e-4, -116_000.0, 1.0, Branch::BrokenClosed, 2),
    ];
    let law = reference();
    let r = law.augmentation(0.0);
    let (mut kappa, mut jump, mut pulled) = (0.0, [0.0; 3], [0.0; 3]);
    for (instant, (x, z, traction, damage, branch, corrections)) in path.into_iter().enumerate() {
        let target = [z, x, 0.0];
        let mut count = 0;
        let state = loop {
            let p: Local = std::array::from_fn(|i| K * (pulled[i] - jump[i]) + r * jump[i]);
            let state = law.respond(p, r, kappa, 2);
            let miss: Local = std::array::from_fn(|i| jump[i] - state.jump[i]);
            if count > 0 && miss.iter().all(|m| m.abs() <= 1e-14 * law.critical_jump()) {
                break state;
            }
            // dw = A dp + (w(p) - w), dp = K dU + (r - K) dw.
            let a = nalgebra::Matrix3::from_fn(|i, j| state.compliance[i][j]);
            let load = nalgebra::Vector3::from_fn(|i, _| K * (target[i] - pulled[i]));
            let miss = nalgebra::Vector3::from(miss);
            let correction = (nalgebra::Matrix3::identity() - a * (r - K))
                .lu()
                .solve(&(a * load - miss))
                .unwrap();
            (0..3).for_each(|i| jump[i] += correction[i]);
            pulled = target;
            count += 1;
            assert!(count < 10, "instant {}", instant + 1);
        };
        kappa = state.history;
        assert_close(state.traction[0], traction);
        assert_close(state.traction[1], 0.0);
        assert!((law.damage(kappa) - damage).abs() < 1e-8);
        assert_eq!((state.branch, count), (branch, corrections), "instant {}", instant + 1);
    }
    assert_eq!(law.dissipated(kappa), law.fracture_energy);
}

#[test]
fn a_committed_softening_state_is_taken_as_unloading() {
    let law = reference();
    let r = law.augmentation(0.0);
    for step in 1..2000 {
        let q = law.strength * (1.0 + f64::from(step) * 0.0095);
        let p = [0.6 * q, 0.8 * q, 0.0];
        let first = law.respond(p, r, 0.0, 2);
        assert_eq!(first.branch, Branch::Softening);
        let again = law.respond(p, r, first.history, 2);
        assert_eq!(again.branch, Branch::Unloading);
        assert_eq!(again.history, first.history);
        let further = law.respond(p.map(|x| x * (1.0 + 1e-13)), r, first.history, 2);
        assert_eq!(further.branch, Branch::Softening);
    }
}

#[test]
fn bad_parameters_are_named() {
    let law = LinearSoftening {
        strength: -1.0,
        fracture_energy: f64::NAN,
        augmentation: 0.5,
        friction: 0.0,
    };
    let problems = law.check();
    for (problem, name) in problems.iter().zip(["strength", "fracture_energy", "augmentation"]) {
        assert!(problem.starts_with(name));
    }
    assert_eq!(problems.len(), 3);
}
