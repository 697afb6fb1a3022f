//! Runs with flow that begin in equilibrium (`initial.equilibrium`).

use crate::flow;
use crate::scene::{Run, Scene};

/// A sealed bar of 10 m between smooth walls with a pressure of 1 MPa in its pores, free at the
/// top.
const SWOLLEN: &str = "
mesh: {column: {size: [2, 10], cells: [2, 4]}}
materials:
  soil:
    elastic: {young_modulus: 1.0e10, poisson_ratio: 0}
    porous: {biot: 0.8, porosity: 0.3, permeability: 1.0e-11, viscosity: 1.0e-3,
             fluid_compressibility: 5.0e-10, fluid_density: 1000, density: 2000}
boundary:
  - {on: bottom, displacement: {x: 0, z: 0}}
  - {on: left, displacement: {x: 0}}
  - {on: right, displacement: {x: 0}}
initial: {pressure: 1.0e6, equilibrium: true}
time: {instants: [0.01, 1.0e6]}
probes: [{name: top, at: [1, 10]}]
";

/// The skeleton carries b p = E eps from the start, so that nothing happens afterwards; without
/// equilibrium the fluid has to spread the undeformed skeleton: S (p - p_0) + b eps = 0.
#[test]
fn the_skeleton_carries_the_initial_pressure() {
    let (force, width, height) = (0.8e6, 2.0, 10.0);
    for (order, ranks, solver) in [(1, 1, "mumps"), (2, 2, "mumps"), (1, 3, "hypre")] {
        let scene = Scene::new("swollen", SWOLLEN)
            .set(&format!("mesh.order={order}"))
            .set(&format!("solver.linear={solver}"));
        let run = scene.on(ranks);
        let strain = force / 1.0e10;
        run.assert_column("top.displacement_z", &[strain * height; 2], 1e-9, 0.0);
        run.assert_column("top.pressure", &[1.0e6; 2], 1e-9, 0.0);
        let energy = 0.5 * force * strain * width * height;
        for name in ["energy.elastic", "energy.fluid"] {
            run.assert_column(name, &[energy; 2], 1e-9, 0.0);
        }
        for name in ["mass.in", "mass.out", "mass.stored"] {
            run.assert_column(name, &[0.0; 2], 0.0, 1e-9);
        }
        let rigid = scene.set("initial.equilibrium=false").on(ranks);
        // Grains of K = E/3 yield to the pressure in the part 1 - b of the volume that is not b.
        let storage = 0.3 * 5.0e-10 + 0.5 * 0.2 * 3.0 / 1.0e10;
        let pressure = 1.0e6 * storage / (storage + 0.8 * 0.8 / 1.0e10);
        // Up to terms of the order of the strain, which linear theory leaves out.
        rigid.assert_column("top.pressure", &[pressure; 2], 2e-3, 0.0);
    }
}

/// A load that is there from the start, under a cohesive interface that it breaks in part.
fn driven() -> Scene {
    flow::driven()
        .in_any_steps()
        .set("initial={pressure: 2.0e5, equilibrium: true}")
        .set("interfaces.0.fluid.pressure={table: [[0, 1.8e6], [100, 2.0e6], [300, 0.5e6]]}")
        .set("time.instants=[50, 100, 200]")
}

#[test]
fn a_run_from_equilibrium_goes_on_wherever_it_was_stopped() {
    let scene = driven();
    let whole = scene.on(1);
    for (fault, from, to) in
        [("setup:0:term", 2, 1), ("residual:0:term", 1, 2), ("residual:0:term:20", 3, 2)]
    {
        assert_same(&whole, &scene.stopped(from, fault, to));
    }
}

fn assert_same(whole: &Run, run: &Run) {
    for name in whole.table.columns.iter().filter(|name| {
        ["joint.normal_jump", "mid.pressure", "mass.", "energy.", "time"]
            .iter()
            .any(|n| name.starts_with(n))
    }) {
        let scale = whole.column(name).iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        for (a, b) in whole.column(name).iter().zip(run.column(name)) {
            assert!((a - b).abs() <= 1e-9 * scale, "{}: {name}: {a} and {b}", run.label);
        }
    }
}
