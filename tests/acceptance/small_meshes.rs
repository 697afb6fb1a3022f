//! Meshes of a few quadrilaterals, written by hand.

use crate::scene::{Failure, Run, Scene, fresh};
use std::fmt::Write as _;

/// A mesh of unit squares at these places, scaled; nodes at one place are one. Groups: `foot` (the
/// edges at y = 0), `side` (those of the first square at its right), `flap` (those of the last at
/// its top), `low` and `high` (those below squares at y = 1 and 2).
fn scene(squares: &[[f64; 2]], scale: [f64; 2], moved: &[f64], boundary: &str) -> Scene {
    let mut points: Vec<[f64; 2]> = Vec::new();
    let mut cells = Vec::new();
    for [x, y] in squares {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        cells.push(corners.map(|[i, j]| {
            let point = [x + i, y + j];
            let place = points.iter().position(|other| *other == point);
            place.unwrap_or_else(|| {
                points.push(point);
                points.len() - 1
            }) + 1
        }));
    }
    let mut nodes = String::new();
    for (i, [x, y]) in points.iter().enumerate() {
        let off = moved.get(i).unwrap_or(&0.0);
        let _ = writeln!(nodes, "{} {:e} {:e} 0", i + 1, scale[0] * x + off, scale[1] * y);
    }
    let mut elements = Vec::new();
    for (square, [a, b, _, _]) in squares.iter().zip(&cells) {
        if square[1] == 0.0 {
            elements.push(format!("1 2 1 1 {a} {b}"));
        }
    }
    for (group, height) in [(5, 1.0), (6, 2.0)] {
        for ([_, y], [_, _, c, d]) in squares.iter().zip(&cells) {
            if y + 1.0 == height && squares.iter().any(|[_, y]| *y == height) {
                elements.push(format!("1 2 {group} {group} {c} {d}"));
            }
        }
    }
    let ([_, right, above, _], [_, _, last, left]) = (cells[0], cells[cells.len() - 1]);
    elements.push(format!("1 2 2 2 {right} {above}"));
    elements.push(format!("1 2 3 3 {last} {left}"));
    elements.extend(cells.iter().map(|[a, b, c, d]| format!("3 2 4 4 {a} {b} {c} {d}")));
    let mut text = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n6\n1 5 \"low\"\n1 6 \"high\"\n1 1 \"foot\"\n1 2 \"side\"\n1 3 \
         \"flap\"\n2 4 \"body\"\n$EndPhysicalNames\n$Nodes\n{}\n{nodes}$EndNodes\n$Elements\n{}\n",
        points.len(),
        elements.len()
    );
    for (i, element) in elements.iter().enumerate() {
        let _ = writeln!(text, "{} {element}", i + 1);
    }
    let folder = fresh();
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join("squares.msh");
    std::fs::write(&path, text + "$EndElements\n").expect("a file");
    let yaml = format!(
        "
mesh: {{file: \"{}\"}}
materials: {{body: {{on: body, elastic: {{young_modulus: 1.0e9, poisson_ratio: 0.2}}}}}}
boundary: [{{on: foot, displacement: {{x: 0, y: 0}}}}, {{on: side, traction: {{x: 1.0e6}}}}{boundary}]
time: {{instants: [1]}}
",
        path.display()
    );
    Scene::new("squares", &yaml)
}

/// Parts that hang on the others by a node can turn about it, one by one or as a chain.
#[test]
fn parts_that_hang_on_nodes_are_refused() {
    let block = [[1.0, 0.0], [0.0, 0.0], [0.0, 1.0]];
    let with = |more: &[[f64; 2]], boundary: &str| -> Result<Run, Failure> {
        scene(&[&block, more].concat(), [1.0; 2], &[], boundary).attempt(2)
    };
    let held = ", {on: flap, displacement: {x: 0, y: 0}}";
    // A flap, and a chain of two, the further one worse off.
    for (more, nodes) in [(&[[2.0, 1.0]][..], "1 node"), (&[[2.0, 1.0], [3.0, 2.0]], "node")] {
        let failure = with(more, "").err().expect("a refusal");
        assert_eq!(failure.status, Some(2), "{}", failure.complaint);
        for words in ["can turn", nodes] {
            assert!(failure.complaint.contains(words), "{}", failure.complaint);
        }
        assert!(with(more, held).is_ok() || more.len() > 1);
    }
    // A bar on two hinges stands, three parts in a row between two feet do not.
    let feet = [[0.0, 0.0], [4.0, 0.0]];
    let bridge = |more: &[[f64; 2]]| scene(&[&feet, more].concat(), [1.0; 2], &[], "").attempt(1);
    let three = bridge(&[[1.0, 1.0], [2.0, 2.0], [3.0, 1.0]]);
    let failure = three.err().expect("a refusal");
    assert!(failure.complaint.contains("can turn"), "{}", failure.complaint);
    let one = bridge(&[[1.0, 1.0], [2.0, 1.0], [3.0, 1.0]]);
    assert!(one.is_ok(), "{}", one.err().map_or_else(String::new, |f| f.complaint));
}

/// Bodies that hold each other are not held by that: the rest breaks, and they slide together.
#[test]
fn bodies_that_can_only_move_together_are_found() {
    let stack = [[0.0, 0.0], [0.0, 1.0], [0.0, 2.0]];
    let laws = "\ninterfaces:\n  - {name: low, on: low, law: {linear_softening: {strength: 1.0e6, \
                fracture_energy: 9000}}}\n  - {name: high, on: high, law: {tied: {}}}\n# ";
    let lift = format!(", {{on: flap, displacement: {{y: {{formula: \"3e-2*t\"}}}}}}]{laws}");
    let scene = scene(&stack, [1.0; 2], &[], &lift).set("boundary.1.traction={x: 0}");
    for ranks in [1, 2] {
        let failure = scene.attempt(ranks).err().expect("a mechanism");
        assert_eq!(failure.status, Some(3), "{}", failure.complaint);
        for words in ["bodies 2, 3 can move freely together", "translation along x"] {
            assert!(failure.complaint.contains(words), "{}", failure.complaint);
        }
    }
}

/// Displacements far beyond the mesh, here by a stiffness in wrong units, end the run.
#[test]
fn displacements_that_go_astray_end_the_run() {
    let scene = scene(&[[0.0, 0.0]], [1.0; 2], &[], "");
    let soft = |modulus: &str| {
        scene.set(&format!("materials.body.elastic.young_modulus={modulus}")).attempt(2)
    };
    let failure = soft("1.0e-3").err().expect("an end");
    assert_eq!(failure.status, Some(3), "{}", failure.complaint);
    assert!(failure.complaint.contains("the displacements reach"), "{}", failure.complaint);
    assert!(soft("1.0e3").is_ok());
}

/// Sides that are even up to rounding carry their tractions.
#[test]
fn a_side_that_is_uneven_by_rounding_carries_its_traction() {
    for (scale, off) in [([0.7, 0.7], 1.2e-16), ([1.3, 0.4], -2.3e-16), ([2.0, 3.0], 4.5e-16)] {
        let scene = scene(&[[0.0, 0.0]], scale, &[0.0, off], "");
        for run in [scene.on(1), scene.set("mesh.raise_order=2").set("mesh.refine=1").on(2)] {
            let [found] = run.column("foot.reaction_x")[..] else { panic!("{}", run.label) };
            let expected = -1.0e6 * scale[1];
            assert!((found / expected - 1.0).abs() < 1e-9, "{}: {found}", run.label);
        }
    }
}

/// A mesh whose cells all run clockwise, as MEDCoupling writes them, under a uniform stress.
#[test]
fn a_mesh_seen_from_behind_carries_a_uniform_stress() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/meshes/med_clockwise.med");
    let yaml = format!(
        "
mesh: {{file: \"{path}\"}}
materials: {{rock: {{elastic: {{young_modulus: 1.0e9, poisson_ratio: 0.25}}}}}}
interfaces: [{{name: joint, on: joint, law: {{tied: {{}}}}}}]
boundary:
  - {{on: foot, displacement: {{y: 0}}}}
  - {{on: left, displacement: {{x: 0}}}}
  - {{on: head, traction: {{normal: -1.0e6}}}}
time: {{instants: [1]}}
"
    );
    let run = Scene::new("clockwise", &yaml).on(2);
    for (column, expected) in [
        ("joint.normal_traction.min", -1.0e6),
        ("joint.normal_traction.max", -1.0e6),
        // Its edges run so that the normal points down.
        ("joint.force_y", 3.0e6),
        ("foot.reaction_y", 3.0e6),
    ] {
        let found = run.column(column)[0];
        assert!((found / expected - 1.0).abs() < 1e-10, "{}: {column} {found}", run.label);
    }
}
