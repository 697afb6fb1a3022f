//! Cracks that run along bonded beams from mesh files: which way the loads act along a path, and
//! what is dissipated.

use crate::scene::{Run, Scene};

/// The beams of the cases (J/m2).
const ENERGY: f64 = 500.0;

/// The loads act as they are meant to, and G_c times the integral of the damage is dissipated:
/// over the broken area G_c, over the zone before it what the law says. Both are sums over nodes.
fn check(run: &Run, interfaces: &[&str], relative: f64) {
    let factor = run.column("load_factor");
    assert!(factor.iter().all(|factor| *factor > 0.0), "{}: {factor:?}", run.label);
    let dissipated = run.column("energy.dissipated");
    let mut of_law = vec![0.0; dissipated.len()];
    for name in interfaces {
        let area = run.column(&format!("{name}.area"));
        let damage = run.column(&format!("{name}.damage.mean"));
        for (sum, (area, damage)) in of_law.iter_mut().zip(area.iter().zip(damage)) {
            *sum += ENERGY * area * damage;
        }
    }
    for (found, exact) in dissipated.iter().zip(&of_law) {
        assert!((found - exact).abs() <= relative * exact, "{}: {found}, {exact}", run.label);
    }
    let broken = run.column(&format!("{}.damage.min", interfaces[0]));
    assert!((broken[broken.len() - 1] - 1.0).abs() < 1e-9, "{}: {broken:?}", run.label);
}

/// A notch that is pressed shut by loads turned round has a path of its own, with as much
/// dissipated: a first step of that size used to end on it.
#[test]
fn loads_stay_the_way_they_are_along_a_path() {
    let path = |case: &str| Scene::shipped(case).in_any_steps();
    let mixed = path("notched_beam/mixed_mode_bending.yaml");
    check(&mixed.on(1), &["joint", "rest"], 1e-9);
    check(&path("notched_beam/end_notched_flexure.yaml").on(2), &["joint", "rest"], 1e-9);
    check(&path("double_cantilever/case_3d.yaml").on(2), &["joint"], 1e-7);
}

/// The nodes of the plane of symmetry have no multiplier across it, so that the weights of the
/// components of their neighbours differ. The first of those to shear off has a secant that is a
/// million times stiffer than what holds it.
#[test]
fn a_path_begins_where_the_weights_of_components_differ() {
    let flexure = Scene::shipped("notched_beam/end_notched_flexure_3d.yaml").in_any_steps();
    check(&flexure.on(1), &["joint", "rest"], 1e-9);
}
