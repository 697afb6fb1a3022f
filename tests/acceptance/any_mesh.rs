//! Meshes from files: the reference column, turned by 30 degrees about (1, 2, 3), of cells of all
//! kinds, whose sides match or not, gives the history of the straight column.

use crate::scene::{Run, Scene};

/// The rotation, row by row.
pub const TURN: [[f64; 3]; 3] = [
    [0.875_595_017_799_836, -0.381_752_634_837_842, 0.295_970_083_958_616],
    [0.420_031_090_899_431, 0.904_303_859_846_027_7, -0.076_212_936_863_828_7],
    [-0.238_552_399_866_232_6, 0.191_048_305_048_595_6, 0.952_151_929_923_013_8],
];

/// What moves the top along the axis of the column, and across it, at the instants from 0 on.
const PULLED: [f64; 9] = [0.0, -1e-4, 1e-4, 1e-3, 5e-4, 1.2e-3, 1.7e-3, 1.7e-3, -1e-4];
const PUSHED: [f64; 9] = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1e-3, 0.0];

/// The answers of the straight column (Pa, m, -): see cases/wtnv146/case.yaml.
const TRACTION: [f64; 8] = [
    -116e3,
    116e3,
    1_017_312.072_892_938_5,
    508_656.036_446_469_25,
    697_585.421_412_300_7,
    0.0,
    0.0,
    -116e3,
];
const JUMP: [f64; 8] = [
    0.0,
    0.0,
    1.230_068_337_129_840_6e-4,
    6.150_341_685_649_203e-5,
    5.986_332_574_031_89e-4,
    1.7e-3,
    1.7e-3,
    0.0,
];

/// The column of a mesh file of `tests/meshes/turned`, whose interface is where `place` says.
fn column(mesh: &str, place: &str) -> Scene {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/meshes/turned");
    let components: Vec<String> = (0..3)
        .map(|i| {
            let at = |t: usize| TURN[i][0] * PUSHED[t] + TURN[i][2] * PULLED[t];
            let rows: Vec<String> = (0..9).map(|t| format!("[{t}, {:e}]", at(t))).collect();
            format!("{}: {{table: [{}]}}", ["x", "y", "z"][i], rows.join(", "))
        })
        .collect();
    let yaml = format!(
        "
mesh: {{file: \"{folder}/{mesh}.msh\"}}
materials:
  rock: {{on: [lower, upper], elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.0}}}}
interfaces:
  - name: joint
    {place}
    law: {{linear_softening: {{strength: 1.1e6, fracture_energy: 900.0, augmentation: 10.0}}}}
boundary:
  - {{on: foot, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{on: head, displacement: {{{}}}}}
time: {{instants: [1, 2, 3, 4, 5, 6, 7, 8]}}
",
        components.join(", ")
    );
    Scene::new("turned", &yaml)
}

const CONFORMING: &str = "on: joint";
const APART: &str = "between: [below, above]";

/// The history of the straight column, to 1e-9; 1e-3 Pa and 1e-12 m where it is 0.
fn check(run: &Run) {
    let is = |name: &str, exact: &[f64; 8], zero: f64| {
        for statistic in ["min", "max", "mean"] {
            let found = run.column(&format!("joint.{name}.{statistic}"));
            for (found, exact) in found.iter().zip(exact) {
                let allowed = if *exact == 0.0 { zero } else { 1e-9 * exact.abs() };
                assert!((found - exact).abs() <= allowed, "{}: {name} {found}", run.label);
            }
        }
    };
    is("normal_traction", &TRACTION, 1e-3);
    is("normal_jump", &JUMP, 1e-12);
    ["shear_traction_1", "shear_traction_2"].iter().for_each(|name| is(name, &[0.0; 8], 1e-3));
    for (t, area) in run.column("joint.area").iter().enumerate() {
        assert!((area - 1.0).abs() < 1e-12, "{}: {area}", run.label);
        for (i, axis) in ["x", "y", "z"].iter().enumerate() {
            let force = run.column(&format!("joint.force_{axis}"))[t];
            let exact = TURN[i][2] * TRACTION[t];
            let allowed = if exact == 0.0 { 1e-3 } else { 1e-9 * exact.abs() };
            assert!((force - exact).abs() <= allowed, "{}: {force}", run.label);
        }
    }
    let dissipated = run.column("energy.dissipated")[7];
    assert!((dissipated - 900.0).abs() < 900.0 * 1e-9, "{}: {dissipated}", run.label);
    let corrections: f64 = run.column("newton_iterations").iter().sum();
    assert!(corrections <= 14.0, "{}: {corrections} corrections", run.label);
}

#[test]
fn hexahedra() {
    let scene = column("hex8", CONFORMING);
    check(&scene.on(1));
    check(&scene.scattered().set("solver.linear=hypre").on(4));
    check(&scene.scattered().set("solver.linear=aggregation").on(3));
}

#[test]
fn hexahedra_of_second_order_that_do_not_match() {
    let scene = column("hex27-apart", APART);
    check(&scene.on(1));
    check(&scene.set("interfaces.0.secondary=lower").on(2));
    check(&scene.scattered().set("solver.linear=aggregation").on(4));
}

#[test]
fn prisms_of_second_order() {
    let scene = column("prism18", CONFORMING);
    check(&scene.set("solver.linear=gamg").on(3));
    check(&scene.set("solver.linear=aggregation").on(1));
}

#[test]
fn tetrahedra_that_do_not_match() {
    let scene = column("tet4-apart", APART);
    let run = scene.on(1);
    check(&run);
    // What the reader of the mesh says is in the report.
    let told = run.told("remarks");
    let is_told = |words: &String| words.starts_with("mesh: ") && words.contains("raise_order");
    assert!(told.iter().any(is_told), "{told:?}");
    check(&scene.scattered().on(3));
}

/// Iterations leave errors of forces: the digits of tractions that have fallen to a tenth, at
/// corners of little area, need more than those of the largest force.
#[test]
fn tetrahedra_that_do_not_match_by_iterations() {
    let scene = column("tet4-apart", APART);
    check(&scene.set("solver.linear=gamg").on(1));
    check(&scene.set("solver.linear=aggregation").on(1));
}

#[test]
fn tetrahedra_of_second_order() {
    let scene = column("tet10", CONFORMING).with_fields();
    check(&scene.on(1));
    check(&scene.scattered().on(2));
    check(&scene.set("solver.form=saddle_point").on(2));
}

#[test]
fn hexahedra_with_pyramids_on_tetrahedra() {
    check(&column("mixed-pair", APART).on(2));
}

/// Once refined by the program, cells of all kinds give the same.
#[test]
fn refined() {
    check(&column("mixed-pair", APART).set("mesh.refine=1").on(1));
    check(&column("prism18", CONFORMING).set("mesh.refine=1").on(1));
    check(&column("tet4-apart", APART).set("mesh.refine=1").scattered().on(3));
}

/// Below cells of second order multigrid has their corners as a level.
#[test]
fn second_order_with_multigrid() {
    for (name, interface, ranks) in
        [("tet10", CONFORMING, 3), ("prism18", CONFORMING, 1), ("hex27-apart", APART, 2)]
    {
        let run = column(name, interface).set("solver.linear=multigrid").scattered().on(ranks);
        assert_eq!(run.report["linear_solver"]["choice"], "multigrid");
        let [linear, corrections] = ["linear_iterations", "newton_iterations"]
            .map(|name| run.column(name).iter().sum::<f64>());
        assert!(linear <= 15.0 * corrections, "{}: {linear} over {corrections}", run.label);
        check(&run);
    }
}

/// The meshes that refinement makes are the levels of multigrid.
#[test]
fn refined_with_multigrid() {
    let scene = column("tet10", CONFORMING).set("mesh.refine=1").set("solver.linear=multigrid");
    let run = scene.on(3);
    assert_eq!(run.report["linear_solver"]["choice"], "multigrid");
    check(&run);
}
