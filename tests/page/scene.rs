//! The scene of a run: on its page, and as pictures of their own.

use std::fs;
use std::process::{Command, Stdio};

use super::browser::{Folder, PROGRAM, number};
use super::common;

/// The mesh, its shapes and its interfaces, of a plane and of a body, and without fields.
#[test]
fn the_scene_is_seen() {
    let folder = Folder::new();
    let page = folder.page("wtnv146/case_2d.yaml", "", &[], 0);
    page.is_sound();
    for id in ["mesh", "shape-displacement", "state-joint", "along-joint", "along-joint-2"] {
        assert!(page.ids().contains(&id), "{id} in {:?}", page.ids());
    }
    assert!(number(&page.chart("mesh")["paths"]) > 10.0);

    let page = folder.page("patch_nonmatching/case.yaml", "", &["--overwrite"], 0);
    page.is_sound();
    page.says("35 hexahedra of 8 nodes");

    let none = ["--overwrite", "--set", "output.fields=none"];
    let page = folder.page("wtnv146/case_2d.yaml", "", &none, 0);
    page.is_sound();
    page.says("No fields were written");
    assert!(!page.ids().contains(&"mesh"));
}

/// Pictures of a finished run, and what there is in the place of those that there are not.
#[test]
fn a_finished_run_is_drawn() {
    let folder = Folder::new();
    assert_eq!(folder.run("wtnv146/case.yaml", "", &[]).status.code(), Some(0));
    let plot = |options: &[&str]| {
        let answer = Command::new(PROGRAM)
            .arg("plot")
            .arg(folder.path("out"))
            .args(options)
            .envs(common::environment())
            .stdin(Stdio::null())
            .output()
            .expect("the program");
        let told = [answer.stdout, answer.stderr].map(|t| String::from_utf8_lossy(&t).into_owned());
        (answer.status.code(), told.concat())
    };
    for of in ["mesh", "displacement", "von_mises", "joint", "joint.damage", "joint.sliding"] {
        let (status, told) = plot(&["--of", of, "--at", "3"]);
        assert_eq!(status, Some(0), "{of}: {told}");
        let svg = fs::read_to_string(folder.path("out/plot.svg")).expect("a drawing");
        assert!(svg.contains("<path") && svg.ends_with("</svg>\n"), "{of}");
        let image = fs::read(folder.path("out/plot.png")).expect("an image");
        assert_eq!(&image[1..4], b"PNG", "{of}");
        assert!(told.contains("plot.svg") && told.contains("plot.png"), "{told}");
    }
    for (options, words) in [
        (["--of", "joint.damages", "--at", "3"], "did you mean `damage`?"),
        (["--of", "displacment", "--at", "3"], "did you mean `displacement`?"),
        (["--of", "mesh", "--output", "plot.png"], "ends in .svg"),
        (["--of", "mesh", "--at", "2.5"], "the nearest of 8 instants: 1, 2, 3, 4"),
    ] {
        let (status, told) = plot(&options);
        assert_eq!(status, Some(2), "{told}");
        assert!(told.contains(words), "{told}");
    }
}
