//! A run goes on with the mesh that it began with.

use std::fs;
use std::process::Output;

use crate::blocks::{Block, Blocks, even};
use crate::scene::{Scene, fresh};

fn status(output: &Output) -> Option<i32> {
    output.status.code()
}

fn complaint(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn another_mesh_under_the_same_name_is_refused() {
    let mut blocks = Blocks::default();
    for (number, name) in ["low", "high"].into_iter().enumerate() {
        let place = |[x, y, _]: [f64; 3]| [x, y + number as f64, 0.0];
        let names = [["base", "face"], ["lip", "head"]][number];
        let sides = [(1, false, names[0]), (1, true, names[1])];
        let planes = [even(2, 1.0), even(2, 1.0)];
        blocks.add(&Block { name, planes: &planes, order: 1, place: &place, sides: &sides });
    }
    let mesh = blocks.write();
    let yaml = format!(
        "
mesh: {{file: \"{mesh}\"}}
materials: {{rock: {{on: [low, high], elastic: {{young_modulus: 1.0e10, poisson_ratio: 0}}}}}}
interfaces: [{{name: joint, between: [face, lip], law: {{tied: {{}}}}}}]
boundary:
  - {{on: base, displacement: {{x: 0, y: 0}}}}
  - {{on: head, displacement: {{x: 0, y: {{formula: \"1e-4*t\"}}}}}}
time: {{instants: [1, 2]}}
"
    );
    let (scene, directory) = (Scene::new("file", &yaml), fresh());
    let output = scene.launch(1, &directory, "history:0:term:1", &[]);
    assert_eq!(status(&output), Some(75), "{}", complaint(&output));
    let before = fs::read_to_string(&mesh).expect("the mesh");
    // A node inside; and a group with one facet less.
    for (from, to) in [(" 0.5 0.5 0.0\n", " 0.5 0.6 0.0\n"), (" 1 2 2 2 ", " 1 2 0 0 ")] {
        let after = before.replacen(from, to, 1);
        assert_ne!(after, before);
        fs::write(&mesh, after).expect("a writable directory");
        let output = scene.launch(1, &directory, "", &["--restart", "latest"]);
        let text = complaint(&output);
        assert_eq!(status(&output), Some(2), "{text}");
        assert!(text.contains("checkpoint.h5: it is of another mesh than"), "{text}");
        assert!(text.contains(&mesh), "{text}");
    }
    fs::write(&mesh, before).expect("a writable directory");
    let output = scene.launch(2, &directory, "", &["--restart", "latest"]);
    assert_eq!(status(&output), Some(0), "{}", complaint(&output));
}
