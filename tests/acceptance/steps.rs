//! Steps pass over no time at which a table bends.

use crate::scene::Scene;

/// Loaded, unloaded and loaded again between two instants: the damage of the first peak stays.
#[test]
fn a_peak_between_instants_is_not_passed_over() {
    let z = "[[0, 0], [1, 1.2e-3], [2, -1.0e-4], [3, 5.0e-4], [4, 6.0e-4]]";
    let scene = Scene::shipped("wtnv146/case.yaml")
        .set("expect=[]")
        .set("boundary.1.displacement.x=0")
        .set(&format!("boundary.1.displacement.z={{table: {z}}}"));
    let every = scene.set("time.instants=[1, 2, 3, 4]").on(1);
    let few = scene.set("time.instants=[1.5, 4]").on(1);
    for name in ["joint.normal_traction.mean", "joint.damage.mean", "energy.dissipated"] {
        let (all, some) = (every.column(name), few.column(name));
        assert!((all[3] - some[1]).abs() <= 1e-9 * all[3].abs(), "{name}: {all:?} {some:?}");
    }
    assert!(every.column("joint.damage.mean")[0] > 0.3);
}
