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

/// A stiff disk of second order, pulled in three long steps: what breaks at once would take more
/// energy than there is, and the states are those of short steps.
#[test]
fn long_steps_break_no_more_than_the_loads_can() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/meshes/interfaces");
    let yaml = format!(
        "
mesh: {{file: \"{folder}/disk.msh\"}}
materials:
  core: {{on: core, elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.3}}}}
  plate: {{on: plate, elastic: {{young_modulus: 2.0e9, poisson_ratio: 0.45}}}}
interfaces:
  - name: rim
    between: [rimi, rim]
    law: {{linear_softening: {{strength: 1.1e6, fracture_energy: 3000}}}}
boundary:
  - {{on: left, displacement: {{x: 0, y: 0}}}}
  - on: right
    displacement:
      x: {{formula: \"0.5*t*(0.0001*y + 0.002)\"}}
      y: {{formula: \"0.5*t*(0.0001*x + 0.0003)\"}}
time: {{instants: [1, 2, 3]}}
"
    );
    let scene = Scene::new("disk", &yaml).in_any_steps();
    let [long, short] = ["[1, 2, 3]", "[0.5, 1, 1.5, 2, 2.5, 3]"]
        .map(|instants| scene.set(&format!("time.instants={instants}")).on(1));
    for energy in ["energy.elastic", "energy.dissipated"] {
        let [found, exact] = [&long, &short].map(|run| run.column(energy));
        for (found, exact) in found.iter().zip(exact.iter().skip(1).step_by(2)) {
            assert!((found / exact - 1.0).abs() < 1e-8, "{energy}: {found} {exact}");
        }
    }
}
