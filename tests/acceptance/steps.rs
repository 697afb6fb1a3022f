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

/// A joint of two modes whose lips turn from opening to sliding, or slide and open a little.
fn turning(x: &str, z: &str) -> Scene {
    let yaml = format!(
        "
mesh: {{column: {{size: [1.0, 2.0], cells: [1, 2]}}}}
materials: {{rock: {{elastic: {{young_modulus: 1.0e10, poisson_ratio: 0}}}}}}
interfaces:
  - {{name: joint, z: 1.0, law: {{benzeggagh_kenane: {{strength: 1.0e6, shear_strength: 1.5e6,
     fracture_energy: 500, shear_fracture_energy: 3000, exponent: 2}}}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, z: 0}}}}
  - {{on: top, displacement: {{x: {{formula: \"{x}\"}}, z: {{formula: \"{z}\"}}}}}}
time: {{instants: [1]}}
solver: {{tolerance: 1.0e-11, stability: \"off\"}}
"
    );
    Scene::new("turning", &yaml).in_any_steps()
}

#[test]
fn steps_of_turning_modes_are_as_long_as_their_error_allows() {
    let scene = turning("1.5e-3*t*sin(1.5*t)", "1.2e-3*t*cos(1.2*t)");
    // In 5120 steps without a tolerance.
    let (external, dissipated) = (1248.5, 366.48);
    for (tolerance, off) in [("0.1", 3e-2), ("0.01", 3e-3)] {
        let run = scene.set(&format!("time.tolerance={tolerance}")).on(1);
        for (name, value) in [("energy.external", external), ("energy.dissipated", dissipated)] {
            let found = run.column(name)[0];
            assert!((found / value - 1.0).abs() < off, "{}: {name} {found}", run.label);
        }
    }
    let coarse = scene.on(1).column("energy.external")[0];
    assert!((coarse / external - 1.0).abs() > 0.1, "one step is no test: {coarse}");
}

#[test]
fn lips_that_are_open_and_pressed_are_not_accepted() {
    let scene = turning("2.5e-3*t", "2e-4*t");
    for instants in ["[1]", "[0.5, 1]", "[0.25, 0.5, 0.75, 1]"] {
        let run = scene.set(&format!("time.instants={instants}")).on(1);
        let (jump, traction) = ("joint.normal_jump.min", "joint.normal_traction.min");
        for (jump, traction) in run.column(jump).into_iter().zip(run.column(traction)) {
            assert!(jump == 0.0 || traction > -1.0, "{}: {jump:e} {traction:e}", run.label);
        }
        assert!(run.column(jump).pop() > Some(1e-4), "{}: not open", run.label);
    }
}

/// On a path as at given loads the balance closes to about the tolerance: errors of steps add up,
/// to 1.57 times it in the column. What steps are cut into changes no state of a law that does not
/// depend on the way.
#[test]
fn steps_of_a_path_are_as_long_as_their_error_allows() {
    for case in ["snap_back/column_20m.yaml", "snap_back/ssnp118t.yaml"] {
        let whole = Scene::shipped(case).on(1);
        for (tolerance, ranks) in [(1e-2, 1), (1e-3, 3)] {
            let scene = Scene::shipped(case).in_any_steps();
            let run = scene.set(&format!("time.tolerance={tolerance}")).on(ranks);
            run.assert_energy_balance(2.0 * tolerance);
            for name in ["load_factor", "energy.elastic", "energy.dissipated"] {
                run.assert_column(name, &whole.column(name), 1e-8, 1e-6);
            }
        }
    }
    // Bending opens and shears; what the way changes is off by the tolerance.
    let bent = |tolerance: f64| {
        let bending = Scene::shipped("notched_beam/mixed_mode_bending.yaml").in_any_steps();
        bending.set("expect=[]").set(&format!("time.tolerance={tolerance}")).on(1)
    };
    let [one, other] = [1e-2, 1e-3].map(|tolerance| {
        let run = bent(tolerance);
        run.assert_energy_balance(2.0 * tolerance);
        run
    });
    let apart = one.difference(&other);
    assert!(apart < 1e-2, "{apart:e}");
}

/// A softening joint sheared far past its strength in saturated rock: iterations that break down
/// shorten the step or end the run in words. No solver of displacements alone takes both fields.
#[test]
fn iterations_that_break_down_are_left_in_words() {
    let yaml = "
mesh: {column: {size: [0.95, 1.15, 1.66], bodies: [{cells: [2, 2, 1]}, {cells: [2, 2, 1]}]}}
materials:
  rock:
    elastic: {young_modulus: 5.0e9, poisson_ratio: 0.3}
    porous:
      {biot: 0.8, porosity: 0.2, permeability: 3.0e-14, viscosity: 1.0e-3,
       fluid_compressibility: 5.0e-10, fluid_density: 1000.0, density: 2900.0}
interfaces:
  - {name: joint, z: 0.65, law: {exponential_softening: {strength: 9.0e5, fracture_energy: 1100}}}
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}
  - on: top
    displacement: {x: {table: [[0, 0], [100, 4.6e-3]]}, y: 0}
    traction: {z: {table: [[0, 0], [100, -2.2e6]]}}
    pressure: 0
time: {instants: [100]}
";
    for linear in ["aggregation", "gamg"] {
        let scene = Scene::new("sheared", yaml).in_any_steps();
        let outcome = scene.set(&format!("solver.linear={linear}")).attempt(1);
        if let Err(failure) = outcome {
            assert_eq!(failure.status, Some(3), "{linear}: {}", failure.complaint);
        }
    }
}
