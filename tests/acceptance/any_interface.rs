//! Interfaces in meshes from files that lean, cross, branch, end inside and meet supports.

use std::process::Command;

use column_hpc::results::Directory;

use crate::blocks::{Block, Blocks, even};
use crate::scene::{PROGRAM, Run, Scene, fresh};

/// A scene on a mesh of `tests/meshes/interfaces`; `rest` holds interfaces, boundary and probes.
fn scene(mesh: &str, rest: &str) -> Scene {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/meshes/interfaces");
    let yaml = format!(
        "
mesh: {{file: \"{folder}/{mesh}.msh\"}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.3}}}}}}
time: {{instants: [1, 2]}}
{rest}
"
    );
    Scene::new(mesh, &yaml)
}

/// Displacement gradient of the patches.
const GRADIENT: [[f64; 3]; 3] =
    [[0.7e-4, 0.3e-4, 0.9e-4], [-0.2e-4, 0.4e-4, 0.6e-4], [0.5e-4, 0.1e-4, 1.1e-4]];
/// Where the displacement is compared (m).
const PROBE: [f64; 3] = [0.7, 0.3, 0.2];

/// Constant strain, prescribed on the whole outer boundary.
fn patch(mesh: &str, dim: usize, law: &str) -> Scene {
    let axes = &["x", "y", "z"][..dim];
    let component = |i: usize| {
        let terms: Vec<String> = axes
            .iter()
            .enumerate()
            .map(|(j, axis)| format!("({:e})*{axis}", GRADIENT[i][j]))
            .collect();
        format!("{}: {{formula: \"t*({})\"}}", axes[i], terms.join("+"))
    };
    let components: Vec<String> = (0..dim).map(component).collect();
    let rest = format!(
        "interfaces: [{{name: joint, on: joint, law: {law}}}]
boundary: [{{on: outer, displacement: {{{}}}}}]
probes: [{{name: p, at: {:?}}}]",
        components.join(", "),
        &PROBE[..dim]
    );
    scene(mesh, &rest)
}

fn check_patch(run: &Run, dim: usize) {
    for (i, axis) in ["x", "y", "z"].iter().enumerate().take(dim) {
        let exact: f64 = (0..dim).map(|j| GRADIENT[i][j] * PROBE[j]).sum();
        for (t, found) in run.column(&format!("p.displacement_{axis}")).iter().enumerate() {
            let exact = (t + 1) as f64 * exact;
            assert!((found - exact).abs() < 1e-14, "{}: {found} against {exact}", run.label);
        }
    }
    for statistic in ["min", "max"] {
        let jump = run.column(&format!("joint.normal_jump.{statistic}"));
        assert!(jump.iter().all(|jump| jump.abs() < 1e-15), "{}: {jump:?}", run.label);
    }
}

const TIED: &str = "{tied: {}}";
const COHESIVE: &str = "{linear_softening: {strength: 1.1e7, fracture_energy: 900}}";

/// Factors of a tangent in which a constraint is there twice, or nothing holds a node, have null
/// pivots, which MUMPS counts when it is asked to.
fn counting_pivots(scene: &Scene, more: &str) -> Scene {
    let asked = format!("solver.petsc_options=\"-mat_mumps_icntl_24 1 -ksp_view {more}\"");
    scene.set("solver.linear=mumps").set(&asked)
}

/// The null pivots of each factorisation that a screen tells.
fn null_pivots(screen: &str) -> Vec<usize> {
    let lines = screen.lines().filter(|line| line.contains("INFOG(28)"));
    let last = |line: &str| line.rsplit(':').next().map(|n| n.trim().parse().expect("a count"));
    lines.filter_map(last).collect()
}

fn check_pivots(scene: &Scene, ranks: usize, dim: usize) {
    let run = counting_pivots(scene, "").on(ranks);
    let counts = null_pivots(&run.screen);
    assert!(!counts.is_empty() && counts.iter().all(|n| *n == 0), "{}: {counts:?}", run.label);
    check_patch(&run, dim);
}

/// The count is one that can differ from 0: pivots far above rounding are taken for null.
#[test]
fn pivots_taken_for_null_are_counted() {
    let scene = counting_pivots(&patch("crossing", 2, TIED), "-mat_mumps_cntl_3 0.5");
    let screen = scene.attempt(1).map_or_else(|failure| failure.complaint, |run| run.screen);
    let counts = null_pivots(&screen);
    assert!(!counts.is_empty() && counts.iter().all(|n| *n > 0), "{counts:?}\n{screen}");
}

#[test]
fn two_that_cross() {
    check_pivots(&patch("crossing", 2, TIED), 1, 2);
    check_pivots(&patch("crossing", 2, COHESIVE).scattered(), 7, 2);
}

#[test]
fn those_of_a_refined_mesh() {
    check_patch(&patch("crossing", 2, COHESIVE).set("mesh.refine=2").scattered().on(3), 2);
    check_patch(&patch("branching", 2, TIED).set("mesh.refine=1").on(1), 2);
    let ending = patch("ending", 3, COHESIVE).set("mesh.refine=1");
    let exact = ending.on(2);
    check_patch(&exact, 3);
    let run = ending.set("solver.linear=multigrid").scattered().on(3);
    assert_eq!(run.report["linear_solver"]["choice"], "multigrid");
    let probe = |run: &Run| run.column("p.displacement_x");
    for (found, exact) in probe(&run).into_iter().zip(probe(&exact)) {
        assert!((found - exact).abs() < 1e-11, "{found} {exact}");
    }
}

#[test]
fn one_that_branches() {
    check_pivots(&patch("branching", 2, COHESIVE), 1, 2);
    check_patch(&patch("branching", 2, TIED).scattered().on(3), 2);
}

#[test]
fn one_that_ends_inside() {
    check_pivots(&patch("ending", 3, COHESIVE), 1, 3);
    check_patch(&patch("ending", 3, TIED).scattered().on(4), 3);
}

/// The components of nodes with a support and of their neighbours without one are the same.
#[test]
fn a_support_along_either_tangent() {
    let stress = [2e5, -1e5, 3e5];
    let load = |side: &str, stress: f64| {
        format!("{{on: {side}, traction: {{normal: {{formula: \"t*({stress:e})\"}}}}}}")
    };
    let held = |side: &str| format!("{{on: {side}, displacement: {{normal: 0}}}}");
    let sides = ["x", "y", "z"];
    let mut entries: Vec<String> = sides.iter().map(|side| held(&format!("{side}0"))).collect();
    entries.extend(sides.iter().zip(stress).map(|(side, s)| load(&format!("{side}1"), s)));
    let rest = format!(
        "interfaces: [{{name: joint, on: joint, law: {TIED}}}]
boundary: [{}]
probes: [{{name: p, at: [0.31, 0.37, 0.23]}}]",
        entries.join(", ")
    );
    let leaning = scene("leaning", &rest);
    for run in [leaning.on(1), leaning.set("solver.form=saddle_point").on(1), leaning.on(2)] {
        let trace: f64 = stress.iter().sum();
        for (i, x) in [0.31, 0.37, 0.23].iter().enumerate() {
            let strain = (1.3 * stress[i] - 0.3 * trace) / 5.8e9;
            let found = run.column(&format!("p.displacement_{}", sides[i]))[1];
            let exact = 2.0 * strain * x;
            assert!((found - exact).abs() < 1e-9 * 3e5 / 5.8e9, "{}: {found}", run.label);
        }
    }
}

/// At all nodes of a facet of the joint supports lean against it: the facet beside it acts there.
/// With supports on opposite sides, and on a mesh whose joint ends at a corner.
#[test]
fn facets_without_multipliers_get_those_of_their_neighbours() {
    let interfaces = |law: &str| format!("interfaces: [{{name: joint, on: joint, law: {law}}}]");
    let held = "{on: x0, displacement: {x: 0}}, {on: y0, displacement: {y: 0}}, \
                {on: z0, displacement: {z: 0}}";
    let stress = [2e5, -1e5, 3e5];
    let strain = |i: usize| (1.3 * stress[i] - 0.3 * stress.iter().sum::<f64>()) / 5.8e9;
    let drawn = |side: &str, axis: &str, i: usize| {
        format!(
            "{{on: {side}, displacement: {{{axis}: {{formula: \"t*({:e})*{axis}\"}}}}}}",
            strain(i)
        )
    };
    let pulled = |side: &str, i: usize| {
        format!("{{on: {side}, traction: {{normal: {{formula: \"t*({:e})\"}}}}}}", stress[i])
    };
    let of_rollers = [drawn("x1", "x", 0), drawn("y1", "y", 1), pulled("z1", 2)];
    let of_corner = [pulled("x1", 0), pulled("y1", 1), pulled("z1", 2)];
    for (mesh, loads, point) in
        [("rollers", of_rollers, [0.31, 0.37, 0.23]), ("corner", of_corner, [0.61, 0.37, 0.23])]
    {
        for (law, ranks) in [(TIED, 1), (COHESIVE, 3)] {
            let rest = format!(
                "{}
boundary: [{held}, {}]
probes: [{{name: p, at: {point:?}}}]",
                interfaces(law),
                loads.join(", ")
            );
            let run = scene(mesh, &rest).scattered().on(ranks);
            for (i, axis) in ["x", "y", "z"].iter().enumerate() {
                let found = run.column(&format!("p.displacement_{axis}"))[1];
                let exact = 2.0 * strain(i) * point[i];
                assert!((found - exact).abs() < 1e-13, "{}: {found} {exact}", run.label);
            }
        }
    }
}

/// A branch of one facet between a support and the interface it ends at: none of its nodes has a
/// multiplier, and those of the other interface transmit another traction. Whichever lip carries
/// the multipliers, which goes by the first facet of a file, the branch gets nodes of its own.
#[test]
fn a_branch_of_one_facet_has_a_traction_of_its_own() {
    let strain = 1e-4;
    for (secondary, law, ranks) in [("lower", TIED, 1), ("upper", COHESIVE, 1), ("lower", TIED, 3)]
    {
        let rest = format!(
            "interfaces: [{{name: joint, on: joint, secondary: {secondary}, law: {law}}}]
boundary:
  - {{on: x0, displacement: {{x: 0}}}}
  - {{on: y0, displacement: {{x: {{formula: \"t*{strain:e}*x\"}}, y: 0, z: 0}}}}
  - {{on: x1, traction: {{x: {{formula: \"t*{:e}\"}}}}}}
probes: [{{name: p, at: [0.31, 0.9, 0.2]}}]",
            5.8e9 * strain
        );
        let scene = scene("tee", &rest).set("materials.rock.elastic.poisson_ratio=0");
        let run = if ranks > 1 { scene.scattered().on(ranks) } else { scene.on(ranks) };
        for (axis, exact) in [("x", 2.0 * strain * 0.31), ("y", 0.0), ("z", 0.0)] {
            let found = run.column(&format!("p.displacement_{axis}"))[1];
            assert!((found - exact).abs() < 1e-14, "{}: {axis} {found}", run.label);
        }
    }
}

/// Strips of single facets between rollers and between each other: none of their nodes has a
/// multiplier, nor have those beside.
#[test]
fn facets_that_nothing_would_hold_get_nodes_inside() {
    let stress = 3e5;
    let strain = |axis: usize| stress * if axis == 2 { 1.0 } else { -0.3 } / 5.8e9;
    let interfaces = |law: &str| {
        ["a", "b", "c"].map(|name| format!("{{name: {name}, on: {name}, law: {law}}}")).join(", ")
    };
    let held = ["x", "y", "z"].iter().enumerate();
    let held = held.map(|(i, axis)| format!("{axis}: {{formula: \"t*({:e})*{axis}\"}}", strain(i)));
    let held = held.collect::<Vec<_>>().join(", ");
    for (law, ranks) in [(TIED, 1), (COHESIVE, 2), (TIED, 3)] {
        let rest = format!(
            "interfaces: [{}]
boundary:
  - {{on: z0, displacement: {{{held}}}}}
  - {{on: z1, traction: {{z: {{formula: \"t*{stress:e}\"}}}}}}
probes: [{{name: p, at: [0.31, 0.37, 0.23]}}]",
            interfaces(law)
        );
        let run = scene("strips", &rest).scattered().on(ranks);
        for (i, (axis, x)) in ["x", "y", "z"].iter().zip([0.31, 0.37, 0.23]).enumerate() {
            let found = run.column(&format!("p.displacement_{axis}"))[1];
            assert!((found - 2.0 * strain(i) * x).abs() < 1e-14, "{}: {found}", run.label);
        }
    }
}

/// Displacements are prescribed on the interface itself, neither along nor across it.
#[test]
fn supports_on_an_interface_that_leans_are_refused() {
    let rest = format!(
        "interfaces: [{{name: joint, on: joint, law: {TIED}}}]
boundary:
  - {{on: z0, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{on: joint, displacement: {{x: 0}}}}"
    );
    let scene = scene("leaning", &rest);
    let failure = scene.attempt(2).err().expect("a refusal");
    assert_eq!(failure.status, Some(2), "{}", failure.complaint);
    assert!(failure.complaint.contains("prescribe none on the interface"), "{}", failure.complaint);
    // The check of the case says it too.
    let case = &scene.words(&fresh())[0];
    let checked = Command::new(PROGRAM).args(["check", case]).output().expect("the program");
    let words = String::from_utf8_lossy(&checked.stderr);
    assert_eq!(checked.status.code(), Some(2), "{words}");
    assert!(words.contains("can carry a traction"), "{words}");
}

/// A quarter of a ring under a pressure inside; by its symmetry no shear acts between its two
/// halves, at the supports neither, whose nodes have no multiplier along the interface.
#[test]
fn tractions_of_a_bent_interface_are_normal_to_it_at_supports_too() {
    let mut blocks = Blocks::default();
    for (name, first, inner, outer) in [("core", 1.0, "bore", "out"), ("hull", 1.5, "in", "skin")] {
        let radial: Vec<f64> = even(2, 0.5).iter().map(|r| first + r).collect();
        let planes = [even(6, 1.0), radial];
        let place = |[part, r, _]: [f64; 3]| {
            let (sin, cos) = ((1.0 - part) * std::f64::consts::FRAC_PI_2).sin_cos();
            // Supports are exactly along the axes.
            [if part == 0.0 { 0.0 } else { r * cos }, if part == 1.0 { 0.0 } else { r * sin }, 0.0]
        };
        let sides = [(0, false, "x0"), (0, true, "y0"), (1, false, inner), (1, true, outer)];
        blocks.add(&Block { name, planes: &planes, order: 2, place: &place, sides: &sides });
    }
    let yaml = format!(
        "
mesh: {{file: \"{}\"}}
materials: {{rock: {{on: [core, hull], elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.3}}}}}}
interfaces: [{{name: joint, between: [out, in], law: {TIED}}}]
boundary:
  - {{on: x0, displacement: {{x: 0}}}}
  - {{on: y0, displacement: {{y: 0}}}}
  - {{on: bore, traction: {{normal: -1.0e6}}}}
time: {{instants: [1]}}
",
        blocks.write()
    );
    let run = Scene::new("ring", &yaml).with_fields().on(3);
    let fields = Directory::open(&run.directory).expect("results");
    let fields = fields.series("joint").and_then(|series| series.at(1.0)).expect("fields");
    let normals = fields.at_points("normal").expect("normals");
    let tractions = fields.at_points("traction").expect("tractions");
    assert_eq!(normals.rows().len(), 13);
    for (t, n) in tractions.rows().zip(normals.rows()) {
        let along: f64 = t.iter().zip(n).map(|(t, n)| t * n).sum();
        let shear = (0..3).map(|i| (t[i] - along * n[i]).powi(2)).sum::<f64>().sqrt();
        assert!(along < -2e5 && shear < 1e-3 * along.abs(), "{t:?} along {n:?}");
    }
}
