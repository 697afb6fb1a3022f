//! Flow on meshes from files: boxes are boxes, meshes may be turned, and no fluid gets lost.

use crate::cubes::{Blocks, Cut, turned};
use crate::scene::{Run, Scene};

const ZERO: [f64; 3] = [0.0; 3];

/// What a column is of: its scale is that of all its like.
fn kind(name: &str) -> String {
    let last = name.rsplit('.').find(|part| !["min", "max", "mean"].contains(part));
    let last = last.unwrap_or(name);
    let axes = ["_x", "_y", "_z", "_1", "_2"];
    let last = axes.iter().find_map(|axis| last.strip_suffix(axis)).unwrap_or(last);
    match last {
        "normal_jump" | "sliding" | "displacement" => "length".into(),
        "normal_traction" | "shear_traction" => "traction".into(),
        "reaction" | "force" => "force".into(),
        other => other.into(),
    }
}

/// Every column of `one` that `named` gives a name in `other` agrees with it, to a part of the
/// largest of its kind; fluxes to that part of what is injected, in all at least 20.
fn assert_agree(one: &Run, other: &Run, part: f64, named: impl Fn(&str) -> Option<String>) {
    let names: Vec<&String> = one.table.columns.iter().collect();
    let mut count = 0;
    for name in &names {
        let Some(there) = named(name) else { continue };
        if name.ends_with("_iterations") || other.table.column(&there).is_none() {
            continue;
        }
        let alike = names.iter().filter(|of| kind(of) == kind(name));
        let least: f64 = if kind(name).starts_with("flux") { 1e-2 } else { 1e-12 };
        let scale = alike.flat_map(|of| one.column(of)).fold(least, |m, v| m.max(v.abs()));
        for (a, b) in one.column(name).iter().zip(other.column(&there)) {
            assert!((a - b).abs() <= part * scale, "{}: {name}: {a} and {b}", other.label);
        }
        count += 1;
    }
    assert!(count > 20, "{}: {count}", other.label);
}

/// The name of a column of a box in the file of the same box, whose last axis is the `last` one.
fn in_file(last: &'static str) -> impl Fn(&str) -> Option<String> {
    move |name| {
        let shear = |name: &str| {
            let name = name.replace("shear_traction_x", "shear_traction_1");
            let name = name.replace("shear_traction_y", "shear_traction_2");
            name.replace("sliding_x", "sliding_1").replace("sliding_y", "sliding_2")
        };
        let along = |name: &str| match name.strip_suffix("_z") {
            Some(before) => format!("{before}_{last}"),
            None => name.to_owned(),
        };
        Some(along(&shear(name)))
    }
}

/// The mesh of a file as value of a case.
fn mesh(blocks: &Blocks, is_turned: bool, order: usize) -> String {
    let raised = if order == 2 { ", raise_order: 2" } else { "" };
    format!("mesh={{file: \"{}\"{raised}}}", blocks.write(is_turned))
}

/// A shipped case without its expectations, as it is and on the mesh of a file of the same box.
fn both(name: &str, blocks: &Blocks, order: usize) -> [Scene; 2] {
    let case = Scene::shipped(name).set("expect=[]");
    let of_file = case.set(&mesh(blocks, false, order));
    [case.set(&format!("mesh.order={order}")), of_file]
}

#[test]
fn the_column_of_terzaghi_is_that_of_a_box() {
    let blocks = Blocks::default().block(ZERO, [1.0, 10.0, 0.0], [1, 16, 0], Cut::Squares);
    let blocks = blocks.faces(&[1.0, 10.0]);
    for order in [1, 2] {
        let [of_box, of_file] = both("terzaghi/case.yaml", &blocks, order);
        let of_file = of_file
            .set("boundary.0={on: bottom, displacement: {x: 0, y: 0}}")
            .set("boundary.3={on: top, traction: {normal: -1}, pressure: 0}");
        let of_box = of_box.on(1);
        assert_agree(&of_box, &of_file.on(1), 1e-10, in_file("y"));
        if order == 1 {
            assert_agree(&of_box, &of_file.scattered().on(3), 1e-10, in_file("y"));
            let hypre = of_file.set("solver.linear=hypre");
            assert_agree(&of_box, &hypre.on(2), 1e-9, in_file("y"));
        }
    }
}

#[test]
fn the_slab_of_mandel_is_that_of_a_box() {
    let blocks = Blocks::default().block(ZERO, [1.0, 0.5, 0.0], [10, 2, 0], Cut::Squares);
    let blocks = blocks.faces(&[1.0, 0.5]);
    let pressed = "{table: [[0, -1.68704156e-06], [5.175, -1.7451e-06], [51.75, -1.88188e-06]]}";
    for order in [1, 2] {
        let [of_box, of_file] = both("mandel/case.yaml", &blocks, order)
            .map(|scene| scene.set("time.instants=[5.175, 51.75]").set("solver.tolerance=1.0e-12"));
        let of_box = of_box
            .set("mesh.column.cells=[10, 2]")
            .set("boundary.3.rigid=")
            .set(&format!("boundary.3.displacement={{z: {pressed}}}"))
            .on(1);
        let of_file = of_file
            .set("boundary.0.displacement={y: 0}")
            .set("boundary.3.rigid=")
            .set(&format!("boundary.3.displacement={{y: {pressed}}}"));
        assert_agree(&of_box, &of_file.on(if order == 1 { 1 } else { 3 }), 1e-10, in_file("y"));
    }
}

/// Two blocks with an interface between them; its groups are `below` and `above`.
fn pair(size: [f64; 3], counts: [[usize; 3]; 2], at: f64, cut: Cut, last: usize) -> Blocks {
    let (mut top, mut bottom) = (size, ZERO);
    (top[last], bottom[last]) = (at, at);
    let is_there = move |x: [f64; 3]| (x[last] - at).abs() < 1e-9;
    let blocks = Blocks::default().block(ZERO, top, counts[0], cut).group("below", is_there);
    let blocks = blocks.block(bottom, size, counts[1], cut).group("above", is_there);
    blocks.faces(&size[..=last])
}

#[test]
fn blocks_pushed_apart_are_those_of_boxes() {
    let softening = "{linear_softening: {strength: 1.1e6, fracture_energy: 900}}";
    let steps = "{table: [[0, 0], [1, 1.0e6], [2, 1.3e6], [3, 5.0e5], [4, 2.32e6]]}";
    for (case, height, counts, law, pressure) in [
        ("fluid_pressure/case.yaml", 2.0, [[2, 2, 2], [3, 3, 2]], "{contact: {}}", "1.0e6"),
        ("fluid_pressure/case_cohesive.yaml", 5.0, [[2, 2, 3]; 2], softening, steps),
    ] {
        let blocks = pair([1.0, 1.0, height], counts, height / 2.0, Cut::Hexahedra, 2);
        let [of_box, of_file] = both(case, &blocks, 1);
        let joint = format!(
            "{{name: joint, between: [below, above], law: {law}, fluid: {{pressure: {pressure}}}}}"
        );
        let of_file = of_file.set(&format!("interfaces.0={joint}"));
        assert_agree(&of_box.on(1), &of_file.on(2), 1e-10, in_file("z"));
    }
}

#[test]
fn an_injection_is_that_between_boxes() {
    let blocks = pair([1.0, 4.0, 0.0], [[2, 2, 0], [3, 3, 0]], 2.0, Cut::Squares, 1);
    for order in [1, 2] {
        let [of_box, of_file] = both("injection/case.yaml", &blocks, order);
        let injection = "{table: [[0, 0.01], [40, 0.01], [40.000001, -0.01]]}";
        let joint = format!(
            "{{name: joint, between: [below, above], law: {{linear_softening: {{strength: 1.0e6, \
             fracture_energy: 500}}}}, fluid: {{injection: {injection}}}}}"
        );
        let of_box = of_box.set("time.instants=[20, 40, 45]").in_any_steps();
        let of_box = of_box.set(&format!("interfaces.0.fluid={{injection: {injection}}}")).on(1);
        let of_file = of_file
            .set("time.instants=[20, 40, 45]")
            .set(&format!("interfaces.0={joint}"))
            .set(
                "boundary=[{on: bottom, displacement: {x: 0, y: 0}}, {on: top, displacement: \
                  {x: 0, y: 0}}]",
            )
            .in_any_steps();
        assert_agree(&of_box, &of_file.on(if order == 1 { 3 } else { 1 }), 1e-9, in_file("y"));
    }
}

/// Porous rock in the mesh of a file.
const ROCK: &str = "
materials:
  rock:
    elastic: {young_modulus: 1.0e10, poisson_ratio: 0.25}
    porous: {biot: 0.8, porosity: 0.2, permeability: 1.0e-14, viscosity: 1.0e-3,
             fluid_compressibility: 5.0e-10, fluid_density: 1000, density: 2500}
solver: {tolerance: 1.0e-11}
";

/// Columns that do not change when all is turned: those without a direction, and of the surfaces
/// none.
fn without_direction(name: &str) -> Option<String> {
    let directed = ["displacement_", "reaction_", "shear_", "sliding_", "force_"];
    (!directed.iter().any(|word| name.contains(word))).then(|| name.to_owned())
}

/// The scene on a straight mesh and on the turned one; points and vectors turn with it.
fn straight_and_turned(blocks: &Blocks, order: usize, rest: &str, gravity: [f64; 3]) -> [Scene; 2] {
    [false, true].map(|is_turned| {
        let place = |v: [f64; 3]| if is_turned { turned(v) } else { v };
        let probes = [[0.3, 0.4, 0.3], [0.6, 0.6, 1.2]].map(place);
        let file = mesh(blocks, is_turned, order).replacen("mesh=", "mesh: ", 1);
        let yaml = format!(
            "{file}\n{ROCK}gravity: {:?}\nprobes: [{{name: a, at: {:?}}}, {{name: b, at: {:?}}}]\n\
             {rest}",
            place(gravity),
            probes[0],
            probes[1]
        );
        Scene::new("turned", &yaml).in_any_steps()
    })
}

/// What came in less what went out is there, to rounding.
fn assert_mass_balance(run: &Run) {
    let [inflow, outflow, stored] =
        ["in", "out", "stored"].map(|which| run.column(&format!("mass.{which}")));
    for ((inflow, outflow), stored) in inflow.iter().zip(&outflow).zip(&stored) {
        let apart = (inflow - outflow - stored).abs();
        assert!(apart <= 1e-11 * inflow.max(*outflow), "{}: {apart:e} kg", run.label);
    }
}

const CONSOLIDATION: &str = "
boundary:
  - {on: bottom, displacement: {normal: 0}}
  - {on: left, displacement: {normal: 0}}
  - {on: right, displacement: {normal: 0}}
  - {on: front, displacement: {normal: 0}}
  - {on: back, displacement: {normal: 0}}
  - {on: top, traction: {normal: -1.0e6}, pressure: 0}
time: {instants: [1.0e-3, 1, 10], theta: 0.6}
";

#[test]
fn turned_columns_consolidate_as_straight_ones() {
    for (cut, order, ranks) in
        [(Cut::Prisms, 2, 1), (Cut::Tetrahedra, 2, 1), (Cut::Pyramids, 1, 3), (Cut::Prisms, 1, 1)]
    {
        let blocks = Blocks::default().block(ZERO, [1.0, 1.0, 2.0], [1, 1, 4], cut);
        let blocks = blocks.faces(&[1.0, 1.0, 2.0]);
        let scenes = straight_and_turned(&blocks, order, CONSOLIDATION, [0.1, -0.2, -0.9]);
        let [straight, turned] = [scenes[0].on(1), scenes[1].scattered().on(ranks)];
        assert_agree_turned(&straight, &turned);
        // Undrained: biot/(S (lambda + 2 mu) + biot^2) of the load, far from the drained top.
        if order == 1 {
            let stored = 0.2 * 5e-10 + 0.6 * 0.2 * 1.5 / 1e10;
            let exact = 0.8e6 / (stored * 1.2e10 + 0.64);
            let found = straight.column("a.pressure")[0];
            assert!((found / exact - 1.0).abs() < 0.05, "{cut:?} {found} {exact}");
        }
    }
}

fn assert_agree_turned(straight: &Run, turned: &Run) {
    let mut count = 0;
    for name in straight.table.columns.iter().filter(|name| without_direction(name).is_some()) {
        if name.ends_with("_iterations") {
            continue;
        }
        let alike = straight.table.columns.iter().filter(|of| kind(of) == kind(name));
        let alike = alike.filter(|of| without_direction(of).is_some());
        // Jumps of lips that hold and tractions of those that do not touch are rounding.
        let least: f64 = match kind(name).as_str() {
            "length" => 1e-6,
            "traction" => 1e2,
            _ => 1e-12,
        };
        let scale = alike.flat_map(|of| straight.column(of)).fold(least, |m, v| m.max(v.abs()));
        for (a, b) in straight.column(name).iter().zip(turned.column(name)) {
            assert!((a - b).abs() <= 1e-9 * scale, "{}: {name}: {a} and {b}", turned.label);
        }
        count += 1;
    }
    assert!(count >= 8, "{}: {count}", turned.label);
    assert_mass_balance(straight);
    assert_mass_balance(turned);
}

/// A block with a plane across it and one along it.
fn crossed(cut: Cut, most: f64) -> Blocks {
    Blocks::default()
        .block(ZERO, [1.0, 1.0, 1.5], [4, 1, 4], cut)
        .group("across", move |x| (x[2] - 0.75).abs() < 1e-9 && x[0] < most + 1e-9)
        .group("along", |x| (x[0] - 0.5).abs() < 1e-9)
        .faces(&[1.0, 1.0, 1.5])
}

const HELD: &str = "
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}
  - {on: top, traction: {normal: -1.0e4}}
  - {on: right, pressure: 0}
  - {on: bottom, flux: 1.0e-4}
time: {instants: [10, 40]}
";

#[test]
fn fluid_in_planes_that_cross() {
    let fluids = ["{injection: 0.02}", "{pressure: 1.0e5, connected: true}", "{pressure: 1.0e5}"];
    let laws = [
        "{linear_softening: {strength: 2.0e6, fracture_energy: 5000}}",
        "{tied: {}}",
        "{contact: {}}",
    ];
    for ((fluid, law), (cut, order, ranks)) in fluids.into_iter().zip(laws).zip([
        (Cut::Tetrahedra, 2, 1),
        (Cut::Hexahedra, 1, 3),
        (Cut::Prisms, 2, 2),
    ]) {
        let pair = ["across", "along"]
            .map(|name| format!("{{name: {name}, on: {name}, law: {law}, fluid: {fluid}}}"));
        // Contact alone would leave the parts free.
        let planes = if law.contains("contact") { &pair[..1] } else { &pair[..] };
        let rest = format!("{HELD}interfaces: [{}]\n", planes.join(", "));
        // Where the plane meets the drained side both must agree.
        let is_connected = fluid.contains("connected");
        let rest =
            if is_connected { rest.replace("pressure: 0}", "pressure: 1.0e5}") } else { rest };
        let blocks = crossed(cut, if planes.len() == 1 { 0.75 } else { 1.0 });
        let scenes = straight_and_turned(&blocks, order, &rest, [1.0, -2.0, -9.0]);
        let [straight, turned] = [scenes[0].on(1), scenes[1].scattered().on(ranks)];
        assert_agree_turned(&straight, &turned);
    }
}

/// What is injected into a plane that ends inside flows into the rock on both of its sides.
#[test]
fn fluid_in_a_plane_that_ends_inside() {
    let rest = format!(
        "{HELD}interfaces: [{{name: across, on: across, law: {{tied: {{}}}}, fluid: {{injection: \
         0.02}}}}]\n"
    );
    let scenes = straight_and_turned(&crossed(Cut::Pyramids, 0.75), 1, &rest, ZERO);
    let [straight, turned] = [scenes[0].on(1), scenes[1].scattered().on(4)];
    assert_agree_turned(&straight, &turned);
    let sides = ["lower", "upper"].map(|side| straight.column(&format!("across.flux_{side}")));
    for (lower, upper) in sides[0].iter().zip(&sides[1]) {
        assert!((lower + upper - 0.02).abs() < 1e-9, "{lower} and {upper}");
    }
}

/// Between stiff rocks that are held apart the flow along two planes that meet at right angles is
/// that along one of their length: rho w^3/(12 mu) times the difference of the pressures over it.
#[test]
fn fluid_flows_round_a_corner() {
    let is = |x: f64, at: f64| (x - at).abs() < 1e-9;
    let blocks = Blocks::default()
        .block(ZERO, [2.0, 1.0, 0.0], [4, 4, 0], Cut::Squares)
        .group("across", |x| is(x[1], 0.5) && x[0] < 1.0 + 1e-9)
        .group("along", |x| is(x[0], 1.0) && x[1] > 0.5 - 1e-9)
        .group("inlet", |x| is(x[0], 0.0) && (x[1] - 0.5).abs() < 0.26)
        .group("outlet", |x| is(x[1], 1.0) && (x[0] - 1.0).abs() < 0.51)
        .group("lid", |x| is(x[0], 0.0) && x[1] > 0.49 || is(x[1], 1.0) && x[0] < 1.01)
        .faces(&[2.0, 1.0]);
    for order in [1, 2] {
        let file = mesh(&blocks, false, order).replacen("mesh=", "mesh: ", 1);
        let yaml = format!(
            "{file}
materials:
  rock:
    elastic: {{young_modulus: 1.0e12, poisson_ratio: 0}}
    porous: {{biot: 1.0e-3, porosity: 1.0e-3, permeability: 1.0e-18, viscosity: 1.0e-3,
             fluid_compressibility: 5.0e-10, fluid_density: 1000, density: 2500}}
interfaces:
  - {{name: across, on: across, law: {{contact: {{}}}}, fluid: {{flow: true}}}}
  - {{name: along, on: along, law: {{contact: {{}}}}, fluid: {{flow: true}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0}}}}
  - {{on: right, displacement: {{x: 0, y: 0}}}}
  - {{on: lid, displacement: {{x: -1.0e-4, y: 1.0e-4}}}}
  - {{on: inlet, pressure: 1.0e3}}
  - {{on: outlet, pressure: 0}}
time: {{instants: [1000, 2000, 3000]}}
solver: {{tolerance: 1.0e-11}}
"
        );
        let run = Scene::new("corner", &yaml).in_any_steps().on(1);
        let out = run.column("mass.out");
        let (found, exact) = (out[2] - out[1], 1e3 * 1e3 * 1e-12 / 12e-3 * 1e3 / 1.5);
        assert!((found / exact - 1.0).abs() < 1e-3, "{}: {found} {exact}", run.label);
        assert_mass_balance(&run);
    }
}

#[test]
fn a_flux_inside_the_rock_is_refused() {
    let rest = "
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}
  - {on: across, flux: 1.0e-4}
time: {instants: [1]}
";
    let [scene, _] = straight_and_turned(&crossed(Cut::Hexahedra, 1.0), 1, rest, ZERO);
    let failure = scene.attempt(2).err().expect("a refusal");
    assert_eq!(failure.status, Some(2), "{}", failure.complaint);
    let words = "boundary.1.flux: across has no facet of a porous cell on the outer surface";
    assert!(failure.complaint.contains(words), "{}", failure.complaint);
}
