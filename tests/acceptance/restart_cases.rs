//! Stopped and restarted: every shipped case, and interfaces with names like those of files.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use column_hpc::case::{Case, ControlKind};

use crate::grid;
use crate::scene::{Kind, Scene, fresh};

fn complaint(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The case files of a directory and of those in it, without studies and searches, which begin
/// anew.
fn case_files(directory: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(directory).expect("a directory") {
        let path = entry.expect("an entry").path();
        let begins_anew = path.ends_with("studies") || path.ends_with("accuracy");
        if path.is_dir() && !begins_anew {
            case_files(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "yaml") {
            found.push(path);
        }
    }
}

/// The first case of every second folder.
#[test]
fn a_shipped_case_of_each_kind_stopped_after_its_first_instant() {
    let mut files = shipped();
    files.dedup_by(|later, first| later.parent() == first.parent());
    let files: Vec<PathBuf> = files.into_iter().step_by(2).collect();
    assert!(files.len() >= 14, "{files:?}");
    stopped_after_their_first_instant(&files);
}

#[test]
#[ignore = "two minutes: cargo test --release --test acceptance every_shipped_case -- --ignored"]
fn every_shipped_case_stopped_after_its_first_instant() {
    let files = shipped();
    assert!(files.len() >= 55, "{files:?}");
    stopped_after_their_first_instant(&files);
}

/// The shipped cases without the studies, folder by folder.
fn shipped() -> Vec<PathBuf> {
    let mut files = Vec::new();
    case_files(&root(), &mut files);
    files.sort();
    files
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("cases")
}

/// Each goes on to the results of a run without a stop; with interfaces and without any, with flow,
/// along paths, on the mesh of a file.
fn stopped_after_their_first_instant(files: &[PathBuf]) {
    let run = |number: usize| {
        let file = &files[number];
        let text = fs::read_to_string(file).expect("a case file");
        let case = Case::read(&text, file, &[]).expect("a case");
        let name =
            file.strip_prefix(root()).expect("a shipped case").to_string_lossy().into_owned();
        let mut scene = Scene::shipped(&name).set("expect=[]").in_any_steps();
        // A few instants tell as much as all; where the case has one, there is another half-way to
        // it.
        let mut times = case.time.clone();
        times.truncate(3);
        if let [only] = times[..] {
            times.insert(0, 0.5 * (case.start + only));
        }
        let dissipation = matches!(
            case.control.as_ref().map(|control| &control.kind),
            Some(ControlKind::Dissipation(_))
        );
        if !dissipation {
            scene = scene.set(&format!("time.instants={times:?}"));
        }
        let (whole, (before, after)) = (scene.on(1), [(1, 2), (2, 3), (3, 1)][number % 3]);
        let fault = format!("history:{}:term:1", before - 1);
        let label = format!("{name}, {before} to {after} ranks");
        let broken = scene.stopped(before, &fault, after);
        assert_eq!(whole.table.rows.len(), broken.table.rows.len(), "{label}");
        let stress = whole.largest(Kind::Traction).max(whole.largest(Kind::Pressure));
        // The meshes of files are about a metre wide and high, or larger.
        let [section, height] = case.mesh.column().map_or([1.0; 2], |c| [c.section(), c.height()]);
        let stiffness = case.materials.iter().map(|m| m.young_modulus).fold(0.0, f64::max);
        let difference = whole.difference_above(&broken, |kind| match kind {
            Kind::Reaction => stress * section,
            Kind::Area => section,
            Kind::Length => stress / stiffness * height,
            Kind::Angle => stress / stiffness,
            Kind::Moment => stress * section * height,
            Kind::Damage => 1.0,
            // Of what flows in and out; that into the rock may be a small part.
            Kind::Flux => whole.largest(Kind::Mass) / (times[times.len() - 1] - case.start),
            _ => f64::MIN_POSITIVE,
        });
        assert!(difference <= 1e-8, "{label}: {difference:e}");
    };
    // As many at once as the machine has room for.
    std::thread::scope(|scope| {
        let half = |first: usize| (first..files.len()).step_by(2).for_each(run);
        let other = scope.spawn(move || half(1));
        half(0);
        other.join().expect("the other half");
    });
}

/// A point of a field file and what it has there, in the order of the points.
fn field(directory: &Path, name: &str, step: usize, array: &str) -> Vec<[[f64; 3]; 2]> {
    let read = grid::read(&directory.join(format!("fields/{name}_{step:06}.vtkhdf")), array);
    assert_eq!(read.points.len(), read.values.len(), "{name} {step}");
    let mut rows: Vec<_> = read.points.into_iter().zip(read.values).map(|(p, v)| [p, v]).collect();
    rows.sort_by(|a, b| a.partial_cmp(b).expect("finite numbers"));
    rows
}

/// Whatever an interface is called, its files and the grids that restarts write are files of their
/// own.
#[test]
fn interfaces_named_like_files_of_fields() {
    let scene = |names: [&str; 3]| {
        let law = "law: {linear_softening: {strength: 1.1e6, fracture_energy: 900}}";
        let of = |name, z| format!("  - {{name: {name}, z: {z}, {law}}}\n");
        let yaml = format!(
            "mesh: {{column: {{size: [1, 1, 4], bodies: [{{cells: [1, 2, 1]}}, {{cells: [2, 2, 1]}}, \
             {{cells: [2, 3, 1]}}, {{cells: [3, 3, 2]}}]}}}}\n\
             materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.2}}}}}}\n\
             interfaces:\n{}{}{}boundary:\n  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}\n  \
             - {{on: top, displacement: {{x: 0, y: 0, z: {{formula: \"4e-5*t*(1+x)\"}}}}}}\n\
             time: {{instants: [1, 2, 3, 4]}}\n\
             output: {{fields: all, checkpoint: {{every: 1 instant}}}}\n",
            of(names[0], 1.0),
            of(names[1], 2.0),
            of(names[2], 3.0)
        );
        Scene::new("names", &yaml)
    };
    let plain = ["p", "q", "r"];
    let whole = fresh();
    let output = scene(plain).launch(1, &whole, "", &["--overwrite"]);
    assert_eq!(output.status.code(), Some(0), "{}", complaint(&output));
    for names in [["bulk_mesh", "a", "a_mesh"], ["bulk_000003", "A-mesh", "bulk_mesh_000003"]] {
        let (scene, directory) = (scene(names), fresh());
        for (ranks, instants, word) in [
            (1, "[1, 2]", vec!["--overwrite"]),
            (2, "[1, 2, 3]", vec!["--restart", "latest"]),
            (3, "[1, 2, 3, 4]", vec!["--restart", "latest"]),
        ] {
            let scene = scene.set(&format!("time.instants={instants}"));
            let output = scene.launch(ranks, &directory, "", &word);
            assert_eq!(
                output.status.code(),
                Some(0),
                "{names:?} {instants}: {}",
                complaint(&output)
            );
        }
        let files =
            plain.into_iter().zip(names).map(|(plain, name)| (plain, name, "traction", 1e-2));
        for (plain, name, array, most) in files.chain([("bulk", "bulk", "displacement", 1e-12)]) {
            let index = directory.join(format!("fields/{name}.vtkhdf.series"));
            let index = fs::read_to_string(index).expect("an index");
            assert_eq!(index.matches(&format!("\"{name}_00000")).count(), 4, "{index}");
            for step in 1..=4 {
                let one = field(&whole, plain, step, array);
                let other = field(&directory, name, step, array);
                assert_eq!(one.len(), other.len(), "{name} {step} {array}");
                for ([place, value], [other_place, other]) in one.iter().zip(&other) {
                    assert_eq!(place, other_place, "{name} {step} {array}");
                    let near = value.iter().zip(other).all(|(a, b)| (a - b).abs() <= most);
                    assert!(near, "{name} {step} {array} at {place:?}: {value:?} {other:?}");
                }
            }
        }
    }
}
