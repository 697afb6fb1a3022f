//! The shipped cases with answers of their own: they meet every expectation.

use crate::scene::{SOLVERS, Scene};

/// The cases and how much each expects at least.
const CASES: [(&str, usize); 11] = [
    ("ssnp121/case_2d.yaml", 6),
    ("ssnp121/case.yaml", 6),
    ("layered/case.yaml", 11),
    ("fluid_pressure/case.yaml", 9),
    ("fluid_pressure/case_cohesive.yaml", 13),
    ("injection/case.yaml", 18),
    ("laws/bilinear.yaml", 20),
    ("laws/exponential_softening.yaml", 15),
    ("two_interfaces/case.yaml", 30),
    ("mixed_mode/case.yaml", 20),
    ("point_law/shear_under_compression.yaml", 3),
];

/// By turns two halves of what there is: either has both orders and every solver.
fn check(case: &str) {
    let place = CASES.iter().position(|(name, _)| *name == case).expect("one of the cases");
    check_in(case, if place % 2 == 0 { &[1, 2, 6, 7] } else { &[0, 3, 4, 5] });
}

/// On 1 to 4 ranks in first order, then in second; `chosen` are the places in this list.
fn check_in(case: &str, chosen: &[usize]) {
    let (_, least_expectations) = CASES.into_iter().find(|(name, _)| *name == case).expect("it");
    for &index in chosen {
        let (order, ranks) = (1 + index / 4, 1 + index % 4);
        let solver = SOLVERS[(index + order - 1) % SOLVERS.len()];
        let run = Scene::shipped(case)
            .set(&format!("mesh.order={order}"))
            .set(&format!("solver.linear={solver}"))
            .on(ranks);
        assert_eq!(run.report["status"], "done", "{}", run.label);
        let expectations = run.report["expectations"].as_array().expect("a list");
        assert!(expectations.len() >= least_expectations, "{}", run.label);
        assert!(expectations.iter().all(|e| e["met"] == true), "{}", run.label);
    }
}

#[test]
fn contact_patch_in_2d() {
    check("ssnp121/case_2d.yaml");
}

#[test]
fn contact_patch_in_3d() {
    check_in("ssnp121/case.yaml", &[0, 3, 5]);
}

#[test]
fn layers() {
    check("layered/case.yaml");
}

#[test]
fn fluid_pressure() {
    check("fluid_pressure/case.yaml");
    check("fluid_pressure/case_cohesive.yaml");
}

#[test]
fn injection() {
    check("injection/case.yaml");
}

#[test]
fn laws() {
    check("laws/bilinear.yaml");
    check("laws/exponential_softening.yaml");
}

#[test]
fn two_interfaces() {
    check("two_interfaces/case.yaml");
}

#[test]
fn mixed_mode() {
    check("mixed_mode/case.yaml");
}

#[test]
fn shear_under_compression() {
    check("point_law/shear_under_compression.yaml");
}

#[test]
#[ignore = "a minute: cargo test --release --test acceptance shipped:: -- --ignored"]
fn every_case_in_both_orders_on_1_to_4_ranks() {
    for (case, _) in CASES {
        check_in(case, &[0, 1, 2, 3, 4, 5, 6, 7]);
    }
}

/// sigma = (U - delta_c/2)/(L/E - delta_c/(2 strength)) in MPa and mm, here in Pa.
#[test]
fn cohesive_bar() {
    let (length, critical, strength, young_modulus) = (99.5, 2.0 * 0.1 / 3.0, 3.0, 3.0e4);
    let traction: Vec<f64> = [0.0124375, 0.014925, 0.0174125, 0.0199]
        .map(|u: f64| {
            (u - 0.5 * critical) / (length / young_modulus - 0.5 * critical / strength) * 1e6
        })
        .to_vec();
    for (ranks, solver, order) in
        [(1, "mumps", 1), (2, "gamg", 1), (3, "hypre", 1), (4, "mumps", 1), (2, "multigrid", 2)]
    {
        let run = Scene::shipped("v101359/case.yaml")
            .set(&format!("mesh.order={order}"))
            .set(&format!("solver.linear={solver}"))
            .on(ranks);
        run.assert_column("joint.normal_traction", &traction, 1e-8, 0.0);
    }
}
