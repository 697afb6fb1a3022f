//! Fluid that flows along an interface.

use crate::flow::{TWO_ROCKS, assert_close, last};
use crate::scene::{Run, Scene};

/// Lips held apart between two pressures; the rock stores nothing and yields 1e-6 of the opening.
const PLATES: &str = "
mesh: {column: {size: [2, 1], bodies: [{cells: [4, 2]}, {cells: [6, 3]}]}}
materials:
  rock:
    elastic: {young_modulus: 1.0e12, poisson_ratio: 0}
    porous: {biot: 1.0e-6, porosity: 1.0e-6, permeability: 1.0e-16, viscosity: 1.0e-3,
             fluid_compressibility: 0, fluid_density: 1000, density: 2300}
interfaces:
  - {name: joint, z: 0.5, law: {contact: {}}, fluid: {flow: true}}
boundary:
  - {on: bottom, displacement: {x: 0, z: 0}}
  - {on: top, displacement: {x: 0, z: 1.0e-4}}
  - {on: left, pressure: 100}
  - {on: right, pressure: 0}
time: {instants: [1000, 2000, 3000]}
solver: {tolerance: 1.0e-7}   # rounding of a stiff body that moves by more than it is strained
probes: [{name: quarter, at: [0.5, 0.5]}]
output: {fields: none}
";

/// The same in 3D.
fn deep(scene: &Scene) -> Scene {
    scene
        .set("mesh.column={size: [2, 1, 1], bodies: [{cells: [2, 2, 1]}, {cells: [3, 3, 1]}]}")
        .set("boundary.0.displacement.y=0")
        .set("boundary.1.displacement.y=0")
        .set("probes=[{name: quarter, at: [0.5, 0.5, 0.5]}]")
}

/// Volume that comes in per second at the end, when the film is full and the flow steady (m3/s).
fn rate(run: &Run) -> f64 {
    let mass = run.column("mass.in");
    (mass[2] - mass[1]) / 1000.0 / 1000.0
}

/// Between parallel plates the flow is rho w^3/(12 mu) dp/L, and the pressure is linear; the rock
/// adds k/mu.
#[test]
fn between_parallel_plates_the_cubic_law_holds() {
    let flat = Scene::new("plates", PLATES);
    for (scene, order, ranks) in
        [(flat.clone(), 1, 1), (flat.clone(), 2, 3), (deep(&flat), 1, 2), (deep(&flat), 2, 1)]
    {
        let run = scene.set(&format!("mesh.order={order}")).on(ranks);
        let exact = (1e-12 / 12e-3 + 1e-16 / 1e-3) * 100.0 / 2.0;
        assert!(
            (rate(&run) - exact).abs() <= 1e-5 * exact,
            "{}: {} {exact}",
            run.label,
            rate(&run)
        );
        assert!((last(&run, "quarter.pressure") - 75.0).abs() <= 75e-5, "{}", run.label);
        assert!((last(&run, "joint.pressure.max") - 100.0).abs() <= 1e-10, "{}", run.label);
        assert!((last(&run, "mass.stored") - 0.2).abs() <= 0.2e-5, "{}", run.label);
    }
}

/// Between tilted plates q = dp/(12 mu) over the integral of 1/w^3, with the second order of the
/// cells.
#[test]
fn between_tilted_plates_the_flow_converges() {
    let exact = 100.0 / (12e-3 * 0.75e12) + 1e-13 * 100.0 / 2.0;
    let error = |order: usize, cells: usize| {
        let run = Scene::new("tilted", PLATES)
            .set(&format!("mesh.order={order}"))
            .set(&format!("mesh.column.bodies=[{{cells: [{cells}, 1]}}, {{cells: [{cells}, 1]}}]"))
            .set("boundary.1.displacement.z={formula: \"1.0e-4*(1+x/2)\"}")
            .on(1);
        (rate(&run) - exact).abs() / exact
    };
    for order in [1, 2] {
        let errors = [4, 8, 16].map(|cells| error(order, cells));
        println!("order {order}: errors {errors:?}");
        assert!(errors.windows(2).all(|pair| pair[1] < 0.28 * pair[0]), "{errors:?}");
    }
}

/// Fluid that is pressed into an interface between rocks that take up next to nothing holds the
/// lips apart by what was injected, w = m/rho; the law and the column give its pressure, p = t(w) +
/// E w/L.
#[test]
fn what_is_injected_between_rocks_that_store_nothing_opens_the_interface() {
    let flat = Scene::new(
        "closed",
        "
mesh: {column: {size: [1, 4], bodies: [{cells: [2, 2]}, {cells: [3, 3]}]}}
materials:
  rock:
    elastic: {young_modulus: 2.0e10, poisson_ratio: 0}
    porous: {biot: 1.0e-6, porosity: 1.0e-6, permeability: 1.0e-16, viscosity: 1.0e-3,
             fluid_compressibility: 1.0e-8, fluid_density: 1000, density: 2500}
interfaces:
  - name: joint
    z: 2
    law: {linear_softening: {strength: 1.0e6, fracture_energy: 500}}
    fluid: {injection: {table: [[0, 0.01], [40, 0.01], [40.001, -0.01], [50, -0.01], [50.001, 0.02]]}}
boundary:
  - {on: bottom, displacement: {x: 0, z: 0}}
  - {on: top, displacement: {x: 0, z: 0}}
time: {instants: [5, 20, 40, 45, 60, 90]}
output: {fields: none}
",
    );
    let deep = flat
        .set("mesh.column={size: [1, 1, 4], bodies: [{cells: [1, 2, 1]}, {cells: [2, 3, 1]}]}")
        .set("boundary.0.displacement.y=0")
        .set("boundary.1.displacement.y=0");
    let (strength, critical, stiffness) = (1e6, 1e-3, 2e10 / 4.0);
    for (scene, ranks) in [(&flat, 1), (&flat.set("mesh.order=2"), 2), (&deep, 3)] {
        let run = scene.in_any_steps().on(ranks);
        let mut largest = 0.0_f64;
        for (i, mass) in run.column("mass.stored").iter().enumerate() {
            let opening = run.column("joint.normal_jump.mean")[i];
            let denser = (1e-8 * run.column("joint.pressure.mean")[i]).exp();
            let error = (mass / 1000.0 - opening * denser).abs();
            assert!(error < 1e-3 * critical, "{}: {mass} {opening}", run.label);
            largest = largest.max(opening);
            let secant = (strength * (1.0 / largest - 1.0 / critical)).max(0.0);
            let pressure = secant * opening + stiffness * opening;
            for statistic in ["min", "max"] {
                let at = |name: &str| run.column(&format!("joint.{name}.{statistic}"))[i];
                let near = |value: f64, exact: f64, scale: f64| {
                    assert!(
                        (value - exact).abs() <= 1e-5 * scale,
                        "{}: {value} {exact}",
                        run.label
                    );
                };
                near(at("normal_jump"), opening, critical);
                near(at("pressure"), pressure, strength);
                near(at("normal_traction"), secant * opening, strength);
            }
        }
        assert!(largest > critical, "{}: it breaks in the end, {largest}", run.label);
        assert_eq!(last(&run, "joint.damage.min"), 1.0);
    }
}

/// Fluid is injected on one side of a cohesive interface between rocks of two kinds.
const INJECTED: &str = "
mesh: {column: {size: [1, 1, 4], bodies: [{cells: [2, 2, 3]}, {cells: [3, 3, 4]}]}}
interfaces:
  - name: joint
    z: 2
    law: {linear_softening: {strength: 1.0e6, fracture_energy: 2000}}
    fluid: {injection: {formula: \"2.0e-3*(1-x)\"}}
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}, pressure: 0}
  - {on: top, displacement: {x: 0, y: 0, z: 0}}
gravity: [0.5, 0, -9.81]
time: {instants: [10, 40, 100, 200], tolerance: 5.0e-2}
solver: {linear: mumps}
probes: [{name: mid, at: [0.5, 0.5, 1.25]}]
";

#[test]
fn an_injection_at_a_constant_rate_balances_on_any_ranks() {
    let scene = Scene::new("injected", &[INJECTED, TWO_ROCKS].concat()).in_any_steps();
    let one = scene.on(1);
    assert!(last(&one, "joint.normal_jump.min") > 1e-5, "it opens everywhere");
    for (time, inflow) in one.column("time").iter().zip(one.column("mass.in")) {
        assert!(inflow >= time * 1e-3 * (1.0 - 1e-12), "{inflow} in {time} s");
    }
    for (index, inflow) in one.column("mass.in").iter().enumerate() {
        let [out, stored] = ["mass.out", "mass.stored"].map(|name| one.column(name)[index]);
        assert!((inflow - out - stored).abs() <= 1e-10 * inflow.abs(), "{inflow} {out} {stored}");
    }
    // Most of a run on more ranks than cores is waiting for messages: two instants of it.
    let short = scene.set("time.instants=[10, 40]");
    let first = short.on(1);
    assert!(last(&first, "joint.normal_jump.max") > 1e-5, "it opens in part");
    for (index, (one, scene, ranks, solver)) in [
        (&one, &scene, 2, "multigrid"),
        (&first, &short, 3, "gamg"),
        (&first, &short, 4, "hypre"),
        (&one, &scene, 2, "mumps"),
    ]
    .into_iter()
    .enumerate()
    {
        let scene = scene.set(&format!("solver.linear={solver}"));
        let run = if index == 3 { scene.scattered().on(ranks) } else { scene.on(ranks) };
        assert_close(one, &run, 1e-8);
    }
    let second = short.set("mesh.order=2");
    assert_close(&second.on(1), &second.scattered().on(3), 1e-8);
}

#[test]
#[ignore = "a minute: cargo test --release --test acceptance film:: -- --ignored"]
fn an_injection_that_opens_everywhere_is_the_same_on_3_and_4_ranks() {
    let scene = Scene::new("injected", &[INJECTED, TWO_ROCKS].concat()).in_any_steps();
    let one = scene.on(1);
    for (ranks, solver) in [(3, "gamg"), (4, "hypre")] {
        assert_close(&one, &scene.set(&format!("solver.linear={solver}")).on(ranks), 1e-8);
    }
}

#[test]
fn an_injection_goes_on_on_other_ranks() {
    let scene = Scene::new("injected", &[INJECTED, TWO_ROCKS].concat()).in_any_steps();
    let whole = scene.on(1);
    assert_close(&whole, &scene.stopped(2, "history:0:term:2", 3), 1e-8);
}

/// Where branches change at instants, the work of the fluid is what is stored and dissipated;
/// inside a step its trapezoids cut the corner between sticking and softening.
#[test]
fn the_energy_of_an_injection_balances() {
    let scene = Scene::new(
        "energy",
        "
mesh: {column: {size: [1, 4], bodies: [{cells: [2, 3]}, {cells: [3, 4]}]}}
materials:
  rock:
    elastic: {young_modulus: 2.0e10, poisson_ratio: 0}
    porous: {biot: 0.6, porosity: 0.1, permeability: 1.0e-16, viscosity: 1.0e-3,
             fluid_compressibility: 4.5e-10, fluid_density: 1000, density: 2500}
interfaces:
  - name: joint
    z: 2
    law: {linear_softening: {strength: 1.0e6, fracture_energy: 500}}
    fluid: {injection: 0.01}
boundary:
  - {on: bottom, displacement: {x: 0, z: 0}}
  - {on: top, displacement: {x: 0, z: 0}}
  - {on: left, displacement: {x: 0}}
  - {on: right, displacement: {x: 0}}
time: {instants: [1]}
solver: {tolerance: 1.0e-11}
output: {fields: none}
",
    );
    // When the strength is reached, by secants over an interface that holds.
    let strong = scene.set("interfaces.0.law.linear_softening.strength=1.0e9");
    let traction = |time: f64| {
        let run = strong.set(&format!("time.instants=[{time:?}]")).on(1);
        last(&run, "joint.normal_traction.max") / 1e6 - 1.0
    };
    let (mut a, mut b) = (1.0, 2.0);
    let (mut at_a, mut at_b) = (traction(a), traction(b));
    for _ in 0..8 {
        let next = b - at_b * (b - a) / (at_b - at_a);
        (a, at_a, b) = (b, at_b, next);
        at_b = traction(b);
        if at_b.abs() < 1e-13 {
            break;
        }
    }
    assert!(at_b.abs() < 1e-11, "the strength is reached at {b} s: {at_b}");
    let instants = format!("time.instants=[{b:?}, {}, {}]", b + 10.0, b + 30.0);
    for ranks in [1, 2] {
        let run = scene.set(&instants).on(ranks);
        assert!(run.column("joint.damage.max")[0] < 1e-6);
        assert!(last(&run, "joint.damage.min") > 0.1, "{}", run.label);
        for i in 0..3 {
            let [external, fluid, elastic, dissipated] =
                ["external", "fluid", "elastic", "dissipated"]
                    .map(|name| run.column(&format!("energy.{name}"))[i]);
            let gap = external + fluid - elastic - dissipated;
            println!("{}: gap {gap:e} of {fluid:e} J", run.label);
            assert!(gap.abs() <= 1e-10 * fluid, "{}: {gap} of {fluid}", run.label);
        }
    }
    // Over the corner the gap falls with the square of the steps.
    let gap = |steps: usize| {
        let times: Vec<String> =
            (1..=steps).map(|i| format!("{}", 20.0 * i as f64 / steps as f64)).collect();
        let run = scene.set(&format!("time.instants=[{}]", times.join(", "))).on(1);
        let given = last(&run, "energy.external") + last(&run, "energy.fluid");
        let kept = last(&run, "energy.elastic") + last(&run, "energy.dissipated");
        (given - kept).abs() / kept
    };
    let gaps = [4, 16, 64].map(gap);
    println!("gaps with 4, 16, 64 steps: {gaps:?}");
    assert!(gaps[2] < 1e-3 && gaps[2] < 0.3 * gaps[0], "{gaps:?}");
}
