//! Pore pressure and displacement together.

#![allow(clippy::print_stdout)] // the figures, with --nocapture

use crate::scene::{Run, Scene};

pub fn last(run: &Run, name: &str) -> f64 {
    *run.column(name).last().expect("an instant")
}

/// Every column but iterations, relative to its largest value or to the size that such a quantity
/// has.
pub fn assert_close(one: &Run, run: &Run, tolerance: f64) {
    for name in one.table.columns.iter().filter(|name| !name.contains("iterations")) {
        let scale = one.column(name).iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let scale = match name.split('.').next_back() {
            Some("min" | "max" | "mean") if name.contains("traction") => 1e6,
            Some(of) if of.starts_with("reaction") || of.starts_with("force_") => 1e6,
            Some(of) if of.starts_with("displacement") => 1e-4,
            Some("min" | "max" | "mean") if name.contains("jump") => 1e-4,
            Some("min" | "max" | "mean") if name.contains("sliding") => 1e-4,
            _ => scale,
        };
        for (a, b) in one.column(name).iter().zip(run.column(name)) {
            assert!((a - b).abs() <= tolerance * scale, "{}: {name}: {a} and {b}", run.label);
        }
    }
}

/// Displacements that are large beside the volumes that flow: the balance of the fluid is known to
/// fewer digits than a hundredth of the tolerance.
#[test]
fn a_small_tolerance_is_met_as_far_as_rounding_allows() {
    let yaml = "
mesh:
  column:
    size: [1, 1.5, 11]
    bodies: [{cells: [2, 1, 2]}, {cells: [3, 2, 3]}, {cells: [2, 1, 3]}, {cells: [2, 1, 3]}]
  order: 2
materials:
  m0: {z: [0, 2], elastic: {young_modulus: 5.0e+10, poisson_ratio: 0}, porous: &pores {biot: 0.8, porosity: 0.2,
    permeability: 1.0e-4, viscosity: 1.0e+7, fluid_compressibility: 5.0e-11, fluid_density: 1000, density: 2500}}
  m1: {z: [2, 5], elastic: {young_modulus: 2.0e+10, poisson_ratio: 0}, porous: *pores}
  m2: {z: [5, 8], elastic: {young_modulus: 1.0e+11, poisson_ratio: 0}, porous: *pores}
  m3: {z: [8, 11], elastic: {young_modulus: 1.0e+10, poisson_ratio: 0}, porous: *pores}
interfaces:
  - {name: lower, z: 2, law: {linear_softening: {strength: 1.4e+6, fracture_energy: 1.1e+6}}}
  - {name: middle, z: 5, law: {linear_softening: {strength: 1.1e+6, fracture_energy: 1.8e+6}},
     fluid: {pressure: {table: [[0, 0], [1, 2.5e+5]]}}}
  - {name: upper, z: 8, law: {tied: {}}}
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}
  - {on: top, traction: {z: {formula: \"7.5e5*t*(1 - 0.75*(x - 0.5) - (y - 0.75)/6)\"}}, pressure: 0}
  - {on: right, traction: {z: {table: [[0, 0], [1, -4.0e+5]]}}}
initial: {pressure: 5.0e+5}
time: {instants: [1]}
";
    let scene = Scene::new("small", yaml).in_any_steps();
    let reference = scene.set("solver.tolerance=1e-9").set("solver.linear=mumps").on(1);
    for (linear, ranks) in [("mumps", 1), ("mumps", 2), ("multigrid", 1)] {
        let run = scene.set("solver.tolerance=1e-11").set(&format!("solver.linear={linear}"));
        assert_close(&reference, &run.on(ranks), 1e-6);
    }
}

/// With a pressure that is 0 everywhere the coupled model is the mechanical one.
#[test]
fn without_a_pressure_it_is_the_reference_problem() {
    for (index, case) in ["wtnv146/case.yaml", "wtnv146/case_2d.yaml"].iter().enumerate() {
        for (order, ranks) in [(1, 1), (2, 2), (1, 3)] {
            let solver = ["mumps", "multigrid"][(index + ranks) % 2];
            let scene = Scene::shipped(case)
                .set(&format!("mesh.order={order}"))
                .set(&format!("solver.linear={solver}"));
            let alone = scene.on(1);
            let coupled = scene.set("physics=hydro_mechanics").on(ranks);
            assert_eq!(coupled.report["model"]["physics"], "hydro_mechanics");
            assert_eq!(alone.report["model"]["physics"], "mechanics");
            let expectations = coupled.report["expectations"].as_array().expect("a list");
            assert!(expectations.len() >= 30);
            assert!(expectations.iter().all(|e| e["met"] == true), "{}", coupled.label);
            let corrections = |run: &Run| run.column("newton_iterations");
            for (one, other) in corrections(&alone).iter().zip(corrections(&coupled)) {
                assert!(other <= one + 1.0, "{}: {other} corrections, not {one}", coupled.label);
            }
            for name in ["normal_traction.mean", "shear_traction_x.mean", "normal_jump.mean"] {
                let name = format!("joint.{name}");
                let scale = if name.contains("traction") { 1e5 } else { 1e-4 };
                for (a, b) in alone.column(&name).iter().zip(coupled.column(&name)) {
                    assert!((a - b).abs() <= 1e-10 * scale, "{}: {name} {a} {b}", coupled.label);
                }
            }
        }
    }
}

#[test]
fn terzaghi() {
    let scene = Scene::shipped("terzaghi/case.yaml").in_any_steps();
    for ranks in 1..=3 {
        let run = scene.on(ranks);
        assert_eq!(run.report["expectations"].as_array().expect("a list").len(), 5);
        // The first step neither over- nor undershoots.
        for probe in ["base", "middle", "below_top"] {
            let first = run.column(&format!("{probe}.pressure"))[0];
            assert!((0.999..=1.001).contains(&first), "{}: {first}", run.label);
        }
        assert!(run.screen.contains("cells of first order are held back"), "{}", run.screen);
        let balance = last(&run, "mass.in") - last(&run, "mass.out") - last(&run, "mass.stored");
        assert!(balance.abs() <= 1e-10 * last(&run, "mass.out"), "{}: {balance}", run.label);
        let given = last(&run, "energy.external") + last(&run, "energy.fluid");
        let kept = last(&run, "energy.elastic") + last(&run, "energy.dissipated");
        assert!((given - kept).abs() <= 1e-8 * kept, "{}: {given} {kept}", run.label);
    }
    // Cells of second order overshoot there, and say so.
    let missed = scene.set("mesh.order=2").set("time.instants=[1.0e-4]").set("expect=").on(1);
    assert!(missed.column("below_top.pressure")[0] > 1.1);
    assert!(missed.screen.contains("oscillates with cells of second order"), "{}", missed.screen);
}

/// The pressure at the end converges with the second order of the cells, on an average: errors of
/// the time are a part of those of the last level.
#[test]
fn terzaghi_converges() {
    let error = |cells: usize| {
        let run = Scene::shipped("terzaghi/case.yaml")
            .in_any_steps()
            .set(&format!("mesh.column.cells=[1, {cells}]"))
            .set("time.tolerance=1.0e-6")
            .set("expect=")
            .on(1);
        (last(&run, "base.pressure") - 0.685445767).abs()
    };
    let errors = [4, 8, 16, 32].map(error);
    let order = (errors[0] / errors[3]).log2() / 3.0;
    println!("errors {errors:?}, order {order:.2} on an average");
    assert!(errors.windows(2).all(|pair| pair[1] < 0.4 * pair[0]), "{errors:?}");
    assert!(order > 1.8, "{errors:?}");
}

#[test]
fn wtnv147() {
    let flat = Scene::shipped("wtnv147/case.yaml");
    let deep = flat
        .set("mesh.column={size: [1, 1, 5], cells: [2, 1, 5]}")
        .set("boundary.0.displacement.y=0")
        .set("boundary.1.displacement.y=0")
        .set("boundary.2.displacement.y=0")
        .set("boundary.3.displacement.y=0")
        .set("boundary.4={on: front, displacement: {x: 0, y: 0, z: 0}}")
        .set("boundary.5={on: back, displacement: {x: 0, y: 0, z: 0}}")
        .set("probes=[{name: half, at: [0.5, 0.5, 2]}, {name: above, at: [0.5, 0.5, 3]}]");
    for (scene, ranks) in [(&flat, 1), (&flat, 3), (&deep, 2)] {
        let run = scene.on(ranks);
        let expectations = run.report["expectations"].as_array().expect("a list");
        assert!(expectations.iter().all(|e| e["met"] == true), "{}", run.label);
    }
}

/// Porous rock of two kinds, from 1 to 4 m the stiffer and tighter one.
pub const TWO_ROCKS: &str = "
materials:
  sandstone:
    z: [0, 1]
    elastic: {young_modulus: 5.0e9, poisson_ratio: 0.2}
    porous: {biot: 0.8, porosity: 0.2, permeability: 1.0e-15, viscosity: 1.0e-3,
             fluid_compressibility: 4.5e-10, fluid_density: 1000, density: 2300}
  rock:
    z: [1, 4]
    elastic: {young_modulus: 2.0e10, poisson_ratio: 0.25}
    porous: {biot: 0.7, porosity: 0.1, permeability: 1.0e-17, viscosity: 1.0e-3,
             fluid_compressibility: 4.5e-10, fluid_density: 1000, density: 2500}
";

/// Fluid that is pressed into a cohesive interface opens it and flows into porous rock of two
/// kinds, with gravity and a flux through one side.
const DRIVEN: &str = "
mesh: {column: {size: [1, 1, 4], bodies: [{cells: [2, 2, 4]}, {cells: [3, 3, 5]}]}}
interfaces:
  - name: joint
    z: 2
    law: {linear_softening: {strength: 1.0e6, fracture_energy: 2000}}
    fluid: {pressure: {table: [[0, 0], [100, 2.0e6], [300, 0.5e6]]}, connected: true}
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}, pressure: 0}
  - {on: top, displacement: {x: 0, y: 0, z: 0}}
  - {on: left, flux: 1.0e-6}
gravity: [0, 0, -9.81]
time: {instants: [50, 75, 100, 200, 300], tolerance: 5.0e-2}
solver: {linear: mumps}
probes: [{name: mid, at: [0.5, 0.5, 1.25]}]
";

pub fn driven() -> Scene {
    Scene::new("driven", &[DRIVEN, TWO_ROCKS].concat())
}

#[test]
fn the_fluid_of_a_driven_interface_balances_on_any_ranks() {
    let scene = driven().in_any_steps();
    let one = scene.on(1);
    let opened = one.column("joint.normal_jump.max").into_iter().fold(0.0, f64::max);
    assert!(opened > 1e-6, "the fluid opens the interface: {opened}");
    for (index, inflow) in one.column("mass.in").iter().enumerate() {
        let [out, stored] = ["mass.out", "mass.stored"].map(|name| one.column(name)[index]);
        assert!((inflow - out - stored).abs() <= 1e-10 * inflow.abs(), "{inflow} {out} {stored}");
    }
    let others = [(2, "multigrid"), (3, "gamg"), (4, "hypre"), (2, "mumps")];
    for (index, (ranks, solver)) in others.into_iter().enumerate() {
        let scene = scene.set(&format!("solver.linear={solver}"));
        let run = if index == 3 { scene.scattered().on(ranks) } else { scene.on(ranks) };
        assert_close(&one, &run, 1e-8);
    }
}

/// External work and that of the fluid are trapezoidal between accepted states: exact on the line
/// along which a node unloads, nearly so along the one on which it softens, and where it gives way
/// with an error that falls with the square of the step. All nodes give way before 75 s, soften to
/// 100 s, where the pressure turns, and unload.
#[test]
fn the_work_on_a_driven_interface_is_that_of_its_branches() {
    let gaps = |steps: usize| {
        let early = (1..=steps).map(|n| 75.0 * n as f64 / steps as f64);
        let instants: Vec<String> =
            early.chain([100.0, 200.0, 300.0]).map(|time| time.to_string()).collect();
        let run = driven()
            .set(&format!("time={{instants: [{}]}}", instants.join(", ")))
            .in_any_steps()
            .on(1);
        let [external, fluid, elastic, dissipated] = ["external", "fluid", "elastic", "dissipated"]
            .map(|name| run.column(&format!("energy.{name}")).split_off(steps - 1));
        let held: Vec<f64> = elastic.iter().zip(&dissipated).map(|(a, b)| a + b).collect();
        let gaps: Vec<f64> = (0..4).map(|i| external[i] + fluid[i] - held[i]).collect();
        println!("{steps} steps to 75 s: gaps {gaps:?} of {held:?} J");
        // Softening turns a little while it opens; unloading goes along a line.
        assert!((gaps[1] - gaps[0]).abs() <= 1e-6 * held[1], "{steps} steps: {gaps:?} {held:?}");
        let unloading = gaps[2..].iter().map(|gap| (gap - gaps[1]).abs()).fold(0.0, f64::max);
        assert!(unloading <= 1e-10 * held[1], "{steps} steps: {gaps:?} {held:?}");
        (gaps[0].abs(), held[0])
    };
    let (coarse, fine) = (gaps(12), gaps(48));
    // Between 2 and 9 times less for each halving, by where within a step the nodes give way.
    assert!(fine.0 <= coarse.0 / 9.0, "{coarse:?} {fine:?}");
    assert!(fine.0 <= 1e-3 * fine.1, "{fine:?}");
}

/// What cancels in a fluid at rest is rounding, however long the step: dp/dz = -rho(p) g.
#[test]
fn a_column_comes_to_rest_in_a_step_of_any_length() {
    let (density, gravity, height, modulus) = (1000.0, 9.81, 10.0, 2.0e9);
    let at_base = -modulus * f64::ln_1p(-density * gravity * height / modulus);
    for (order, step) in [(1, "1.0e12"), (2, "1.0e12"), (1, "1.0e15")] {
        let run = Scene::shipped("terzaghi/case.yaml")
            .set("boundary.3={on: top, pressure: 0}")
            .set("materials.soil.porous.fluid_compressibility=5.0e-10")
            .set(&format!("gravity=[0, -{gravity}]"))
            .set(&format!("mesh.order={order}"))
            .set(&format!("time={{instants: [{step}]}}"))
            .set("expect=")
            .on(1);
        run.assert_column("base.pressure", &[at_base], 1e-8, 0.0);
        assert!(last(&run, "newton_iterations") <= 5.0, "{}: {:?}", run.label, run.corrections());
    }
}

/// A drained cube under an uneven load, to measure the linear solver by.
const CUBE: &str = "
mesh: {column: {size: [1, 1, 1], cells: [8, 8, 8]}}
materials:
  soil:
    elastic: {young_modulus: 1.0e7, poisson_ratio: 0.2}
    porous: {biot: 1, porosity: 0.3, permeability: 1.0e-11, viscosity: 1.0e-3,
             fluid_compressibility: 0, fluid_density: 1000, density: 2000}
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}
  - {on: left, displacement: {x: 0}}
  - {on: front, displacement: {y: 0}}
  - {on: top, traction: {z: {formula: \"-1000*(1+x+y*y)\"}}, pressure: 0}
  - {on: right, pressure: 0}
time: {instants: [1]}
solver: {linear: multigrid, petsc_options: -ksp_rtol 1e-8 -ksp_atol 0}
";

/// Iterations for eight digits, a mean over the corrections of a step (s), for a permeability (m2).
fn iterations(order: usize, cells: usize, step: &str, permeability: &str) -> f64 {
    let run = Scene::new("cube", CUBE)
        .set(&format!("mesh.order={order}"))
        .set(&format!("mesh.column.cells=[{cells}, {cells}, {cells}]"))
        .set(&format!("time.instants=[{step}]"))
        .set(&format!("materials.soil.porous.permeability={permeability}"))
        .on(1);
    last(&run, "linear_iterations") / last(&run, "newton_iterations")
}

/// Steps over seven decades, then permeabilities over twelve around the middle one.
const STEPS: [(&str, &str); 11] = [
    ("1.0e-3", "1.0e-11"),
    ("1.0e-2", "1.0e-11"),
    ("0.1", "1.0e-11"),
    ("1", "1.0e-11"),
    ("10", "1.0e-11"),
    ("100", "1.0e-11"),
    ("1.0e4", "1.0e-11"),
    ("1", "1.0e-17"),
    ("1", "1.0e-14"),
    ("1", "1.0e-8"),
    ("1", "1.0e-5"),
];

/// Iterations do not grow with the mesh; with the step and the permeability they stay between those
/// of the two limits, the drained one, where the mechanical block alone counts, and the undrained
/// one, where the fixed-stress approximation does.
fn sweep(order: usize, meshes: &[usize], bounds: [f64; 2]) {
    let mut all = Vec::new();
    for (step, permeability) in STEPS {
        let of = |cells: &usize| iterations(order, *cells, step, permeability);
        let of: Vec<f64> = meshes.iter().map(of).collect();
        println!("order {order}, step {step} s, {permeability} m2, {meshes:?} cells: {of:.1?}");
        let (least, most) = extremes(&of);
        assert!(most <= 1.25 * least, "step {step}, permeability {permeability}: {of:?}");
        all.extend(of);
    }
    let (least, most) = extremes(&all);
    println!("order {order}: {least:.1} to {most:.1}, a factor of {:.2}", most / least);
    assert!(least >= bounds[0] && most <= bounds[1], "{least} to {most}");
}

fn extremes(of: &[f64]) -> (f64, f64) {
    of.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), v| (least.min(*v), most.max(*v)))
}

#[test]
fn linear_iterations_do_not_depend_on_the_mesh() {
    sweep(1, &[8, 16], [6.0, 16.0]);
    sweep(2, &[4, 8], [6.0, 18.0]);
}

/// Steps of one length start from the span of the corrections before.
#[test]
fn linear_iterations_become_fewer_where_steps_are_alike() {
    let scene = Scene::new("cube", CUBE)
        .set("solver.petsc_options=")
        .set("time.instants=[0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4]");
    for order in [1, 2] {
        let run = scene.set(&format!("mesh.order={order}")).on(order);
        let [linear, newton] = ["linear_iterations", "newton_iterations"].map(|n| run.column(n));
        println!("order {order}: {linear:?} iterations in {newton:?} corrections");
        assert!(newton[7] <= newton[0] && linear[7] <= 0.8 * linear[0], "{linear:?}");
    }
}

/// Elimination takes both fields together: what it leaves out depends on the state and is small.
/// Also where an interface opens, on any number of ranks.
#[test]
fn elimination_takes_both_fields_together() {
    for (order, step) in [(1, "1.0e-6"), (2, "1.0e-6"), (1, "1"), (2, "1.0e8")] {
        let scene = Scene::new("cube", CUBE)
            .set("solver.linear=mumps")
            .set(&format!("mesh.order={order}"))
            .set("mesh.column.cells=[4, 4, 4]")
            .set(&format!("time.instants=[{step}]"));
        let run = scene.on(order);
        assert_eq!(last(&run, "linear_iterations"), last(&run, "newton_iterations"));
    }
    let scene = driven().in_any_steps();
    for (order, ranks) in [(1, 1), (2, 2), (1, 3)] {
        let run = scene.set(&format!("mesh.order={order}")).scattered().on(ranks);
        let [linear, newton] = ["linear_iterations", "newton_iterations"]
            .map(|name| run.column(name).iter().sum::<f64>());
        println!("order {order} on {ranks} ranks: {linear} iterations in {newton} corrections");
        assert!(linear <= 2.0 * newton, "{}: {linear} in {newton}", run.label);
    }
}

/// Half a minute.
#[test]
#[ignore = "the same on finer meshes"]
fn linear_iterations_do_not_depend_on_finer_meshes() {
    sweep(1, &[8, 16, 24], [6.0, 16.0]);
    sweep(2, &[8, 12], [6.0, 18.0]);
}

#[test]
fn a_run_with_flow_goes_on_on_other_ranks() {
    let scene = driven().in_any_steps();
    let whole = scene.on(1);
    for (order, from, to, instant) in [(1, 1, 2, 2), (2, 2, 3, 3), (1, 3, 1, 4)] {
        let scene = scene.set(&format!("mesh.order={order}"));
        let whole = if order == 1 { &whole } else { &scene.on(1) };
        let run = scene.stopped(from, &format!("history:0:term:{instant}"), to);
        for name in ["joint.normal_jump.max", "mid.pressure", "mass.in", "energy.fluid", "time"] {
            let scale = whole.column(name).iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            for (a, b) in whole.column(name).iter().zip(run.column(name)) {
                assert!((a - b).abs() <= 1e-9 * scale, "{}: {name}: {a} and {b}", run.label);
            }
        }
    }
}
