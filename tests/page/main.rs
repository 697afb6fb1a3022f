//! Pages of runs, looked at in a browser: what is drawn, where it is, and that nothing is fetched.

mod browser;
#[path = "../common/mod.rs"]
mod common;
mod scene;

use std::fs;
use std::path::Path;

use serde_json::Value;

use browser::{Folder, PROGRAM, number};

#[test]
fn a_run_that_is_stopped_and_goes_on_has_a_page_each_time() {
    let folder = Folder::new();
    let stopped = folder.page("wtnv146/case.yaml", "history:0:term:4", &[], 75);
    stopped.is_sound();
    assert_eq!(stopped.0["status"], "status wait");
    stopped.says("stopped after 4 of 8 instants");
    stopped.says("Not compared: the run did not come to its end.");
    assert_eq!(stopped.circles("interface-joint", 1).len(), 4);

    let whole = folder.page("wtnv146/case.yaml", "", &["--restart", "latest"], 0);
    whole.is_sound();
    assert_eq!(whole.0["title"], "WTNV146 in 3D");
    assert_eq!(whole.0["status"], "status good");
    whole.says("done, all 43 expectations met");
    assert_eq!((number(&whole.0["outcomes"]), number(&whole.0["missed"])), (43.0, 0.0));
    let expected = [
        "mesh",
        "shape-displacement",
        "shape-von_mises",
        "interface-joint",
        "map-joint",
        "load",
        "damage",
        "probes",
        "energy",
        "convergence",
    ];
    assert_eq!(whole.ids(), expected);
    // It opens and slides: eight instants in two panels, all on the law, softening and unloading.
    assert_eq!(whole.circles("interface-joint", 1).len(), 16);
    assert!(whole.farthest_from_law("interface-joint") < 1.0);
    // The undeformed state, and the instants.
    assert_eq!(whole.circles("load", 0).len(), 9);
    // Corrections and residuals.
    assert_eq!(whole.circles("convergence", 0).len(), 16);
    let words = |id: &str| -> Vec<&str> {
        let words = whole.chart(id)["words"].as_array().expect("words");
        words.iter().map(|word| word.as_str().expect("text")).collect()
    };
    for (id, label) in [
        ("mesh", "x, y, z held"),
        ("mesh", "moved x 1, z 1.7 mm"),
        ("mesh", "interface, linear softening"),
        ("shape-displacement", "displacement [mm]"),
        ("shape-von_mises", "von Mises stress [MPa]"),
        ("map-joint", "broken, in contact"),
        ("map-joint", "normal traction [MPa]"),
        ("interface-joint", "normal jump [mm]"),
        ("interface-joint", "normal traction [MPa]"),
        ("interface-joint", "shear traction along x [MPa]"),
        ("load", "displacement z of top [mm]"),
        ("load", "reaction z of top [MN]"),
        ("energy", "energy [J]"),
        ("convergence", "forces out of balance [N]"),
    ] {
        assert!(words(id).contains(&label), "{id}: {:?}", words(id));
    }

    // In the dark, whatever the screen of the machine.
    let dark = folder.look(|html| {
        assert_eq!(html.matches("@media(prefers-color-scheme:dark)").count(), 1);
        html.replace("@media(prefers-color-scheme:dark)", "@media all")
    });
    dark.is_sound();

    // The probe sees what is wrong.
    let wrong = folder.look(|html| {
        html.replacen("</h1>", "</h1><img src=\"http://127.0.0.1:9/picture.png\" alt=\"\">", 1)
            .replacen("\nnormal jump [mm]", &"normal jump [mm]".repeat(20), 1)
            .replacen("<circle cx=\"", "<circle cx=\"9", 1)
            .replacen("--soft:#5c5c5c", "--soft:#cccccc", 1)
    });
    assert_eq!(wrong.0["requests"][0], "http://127.0.0.1:9/picture.png");
    assert!(number(&wrong.0["contrast"]) < 4.5);
    let chart = wrong.chart("interface-joint");
    assert_eq!(number(&chart["lost"]), 1.0);
    for fault in ["outside", "clashes"] {
        assert!(!chart[fault].as_array().expect("a list").is_empty(), "{fault}");
    }
    assert!(wrong.farthest_from_law("interface-joint") > 100.0);

    // A run that is not asked for a page leaves none of another.
    assert_eq!(folder.run("wtnv146/case.yaml", "", &[]).status.code(), Some(0));
    assert!(!folder.path("out/report.html").exists());
}

#[test]
fn a_run_that_fails_has_a_page_that_says_why() {
    let folder = Folder::new();
    // A force that nothing holds once the interface is broken.
    let torn = "boundary.1={on: top, traction: {z: {table: [[0, 0], [8, 3.0e+6]]}}}";
    let page = folder.page("wtnv146/case.yaml", "", &["--set", torn, "--set", "expect=[]"], 3);
    page.is_sound();
    assert_eq!(page.0["status"], "status bad");
    page.says("failed after 2 of 8 instants");
    let report = fs::read_to_string(folder.path("out/report.json")).expect("a report");
    let report: Value = serde_json::from_str(&report).expect("whole JSON");
    let message = report["message"].as_str().expect("a message");
    page.says(message.lines().next().expect("words"));
    assert_eq!(page.circles("interface-joint", 1).len(), 2);
    assert!(page.farthest_from_law("interface-joint") < 1.0);

    // In its first step: nothing to draw, and a page all the same.
    let torn = "boundary.1={on: top, traction: {z: 3.0e+6}}";
    let options = ["--overwrite", "--set", torn, "--set", "expect=[]"];
    let page = folder.page("wtnv146/case.yaml", "", &options, 3);
    page.is_sound();
    page.says("failed after 0 of 8 instants");
    page.says("No instant was reached");
    assert!(page.charts().is_empty());
}

#[test]
fn interfaces_paths_and_fluids_have_their_charts() {
    let folder = Folder::new();
    let missed = "expect.0.equals=12345.0";
    let page = folder.page("two_interfaces/case.yaml", "", &["--set", missed], 1);
    page.is_sound();
    assert_eq!(page.0["status"], "status bad");
    assert_eq!(number(&page.0["missed"]), 1.0);
    page.says("12345");
    for id in ["interface-strong", "interface-weak"] {
        assert_eq!(page.circles(id, 1).len(), 5);
        assert!(page.farthest_from_law(id) < 1.0, "{id}");
    }

    // A law whose answer depends on the step, in a mixed mode.
    let page = folder.page("laws/benzeggagh_kenane.yaml", "", &["--overwrite"], 0);
    page.is_sound();
    assert_eq!(page.circles("interface-joint", 1).len(), 34);
    assert!(page.farthest_from_law("interface-joint") < 1.0);

    let case = "snap_back/column_50m_dissipation.yaml";
    let page = folder.page(case, "", &["--overwrite"], 0);
    page.is_sound();
    page.says("The displacement is what the case prescribes times the load factor.");
    assert!(page.ids().contains(&"load-factor"), "{:?}", page.ids());
    assert!(page.farthest_from_law("interface-joint") < 1.0);
    // Snap-back: the displacement falls together with the reaction.
    let load = page.circles("load", 0);
    assert_eq!(load.len(), 22);
    assert!(load[1..].windows(2).all(|pair| pair[1].0 < pair[0].0 && pair[1].1 > pair[0].1));

    let page = folder.page("injection/case.yaml", "", &["--overwrite"], 0);
    page.is_sound();
    page.says("Warnings");
    page.says("The traction is the effective one");
    for id in ["pressure", "flux", "mass"] {
        assert!(page.ids().contains(&id), "{:?}", page.ids());
    }
    assert!(page.farthest_from_law("interface-joint") < 1.0);
}

#[test]
fn a_page_that_cannot_be_written_is_told_once_and_leaves_nothing() {
    let folder = Folder::new();
    fs::create_dir_all(folder.path("out/report.html")).expect("a folder of ours");
    let answer = folder.run("wtnv146/case_2d.yaml", "", &["--report"]);
    let told = String::from_utf8_lossy(&answer.stderr);
    assert_eq!(answer.status.code(), Some(4), "{told}");
    assert_eq!(told.lines().count(), 1, "{told}");
    assert!(
        told.contains("cannot write") && told.contains("report.html: Is a directory"),
        "{told}"
    );
    let report = fs::read_to_string(folder.path("out/report.json")).expect("a report");
    assert!(report.contains("\"status\": \"done\""));
    let left = fs::read_dir(folder.path("out")).expect("the directory").flatten();
    assert!(left.into_iter().all(|entry| !entry.file_name().to_string_lossy().contains(".tmp.")));

    // The same on several ranks, of which one writes.
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/wtnv146/case_2d.yaml");
    let [case, out] = [case, folder.path("several")];
    let args =
        [case.to_str().expect("a name"), "--report", "--output", out.to_str().expect("ours")];
    assert_eq!(common::mpirun(2, PROGRAM, &args).status.code(), Some(0));
    let html = fs::read_to_string(out.join("report.html")).expect("a page");
    assert!(html.contains("<dt>ranks</dt><dd>2</dd>"));
}
