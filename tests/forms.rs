//! The saddle-point form against the condensed one: the same iterations, history and fields.

#[allow(dead_code)] // this program uses a part of it
mod common;
#[path = "common/served.rs"]
mod served;

use std::fs;
use std::path::{Path, PathBuf};

/// Differences allowed, over the largest value of the kind in the run.
const TOLERANCE: f64 = 1.0e-9;

/// Bending on top of opening: nodes soften, break and close one after the other, and slide.
const TILTED: &str = r#"
title: tilted softening column
mesh: {column: {size: [1.0, 1.0, 4.0], cells: [3, 3, 6]}}
materials: {rock: {elastic: {young_modulus: 5.8e9, poisson_ratio: 0.25}}}
interfaces:
  - {name: joint, z: 2.0, law: {linear_softening: {strength: 1.1e6, fracture_energy: 900.0}}}
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}
  - on: top
    displacement: {x: {formula: "1e-4*t"}, y: 0, z: {formula: "t*1e-4*(1+2*x+y) - max(t-6,0)*1e-3"}}
time: {instants: [2, 4, 6, 7]}
probes: [{name: lip, at: [0.4, 0.7, 2.0]}]
"#;

/// Other cells on either side, multipliers below, opening here and contact there.
const NON_MATCHING: &str = r#"
title: non-matching block, partly damaged, partly in contact
mesh: {column: {size: [1.0, 1.0, 1.0], bodies: [{cells: [4, 3, 3]}, {cells: [3, 2, 2]}]}}
materials: {rock: {elastic: {young_modulus: 5.8e9, poisson_ratio: 0.2}}}
interfaces:
  - name: joint
    z: 0.5
    law: {linear_softening: {strength: 1.1e6, fracture_energy: 90.0}}
    secondary: lower
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}
  - {on: top, displacement: {x: 0, y: 0, z: {formula: "t*6e-4*(x-0.4)"}}}
  - {on: right, traction: {z: {formula: "1e5*t"}}}
time: {instants: [0.5, 1, 1.5]}
probes: [{name: inside, at: [0.3, 0.3, 0.8]}]
"#;

/// A middle body of one layer, whose cells touch both interfaces; plane strain.
const THIN_LAYER: &str = r#"
title: thin layer between two interfaces
mesh: {column: {size: [2.0, 1.0], bodies: [{cells: [4, 2]}, {cells: [5, 1]}, {cells: [3, 2]}]}}
materials: {rock: {elastic: {young_modulus: 5.8e9, poisson_ratio: 0.3}}}
interfaces:
  - {name: low, z: 0.4, law: {linear_softening: {strength: 1.1e6, fracture_energy: 90.0}}, secondary: upper}
  - {name: high, z: 0.5, law: {linear_softening: {strength: 9.0e5, fracture_energy: 90.0}}, secondary: lower}
boundary:
  - {on: bottom, displacement: {x: 0, z: 0}}
  - {on: left, displacement: {x: 0}}
  - {on: top, displacement: {z: {formula: "t*1e-4*(x-0.3)"}}}
time: {instants: [1, 2, 3, 4]}
solver: {tolerance: 1.0e-12}
probes: [{name: inside, at: [0.9, 0.45]}]
"#;

/// At the first iterate of a load nothing has moved, and contact has no length of its own.
const PUSHED: &str = r#"
title: body force on two held bodies in contact
mesh: {column: {size: [1.0, 1.0], cells: [2, 2]}}
materials: {rock: {elastic: {young_modulus: 5.8e9, poisson_ratio: 0.2}}}
interfaces: [{name: joint, z: 0.3, law: {contact: {}}}]
boundary:
  - {on: bottom, displacement: {x: 0, z: 0}}
  - {on: top, displacement: {x: 0, z: 0}}
body_force: {x: 1000, z: -1000}
time: {instants: [1]}
"#;

#[test]
fn load_on_contact_at_rest() {
    compare("pushed", PUSHED, true, &[1, 2]);
}

#[test]
fn wtnv146() {
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/wtnv146/case.yaml");
    compare("wtnv146", &fs::read_to_string(case).expect("a case of the package"), true, &[1, 2]);
}

#[test]
fn tilted_softening_column() {
    compare("tilted", TILTED, true, &[1, 2]);
}

#[test]
fn non_matching_with_damage_and_contact() {
    compare("non_matching", NON_MATCHING, true, &[1, 2]);
}

/// Strength and augmentation that vary from node to node.
#[test]
fn imperfect_softening_column() {
    let factor = "factor: {formula: \"1 - 0.2*x + 0.1*y\"}";
    let initial = format!("initial: {{imperfection: [{{interface: joint, {factor}}}]}}\n");
    compare("imperfect", &format!("{TILTED}{initial}"), true, &[1, 2]);
}

/// The components of a node beside the held side have different weights. There the condensed form
/// makes its tangent symmetric, and takes other iterations to the same solution. On 4 ranks some
/// own no secondary node.
#[test]
fn thin_layer_between_two_interfaces() {
    compare("thin_layer", THIN_LAYER, false, &[1, 2, 4]);
}

/// A side held in one direction and tractions that mix the components, in 3D.
#[test]
fn non_matching_held_in_part() {
    let top = "  - {on: top, displacement: {x: 0, y: 0,";
    let held = "  - {on: left, displacement: {x: 0}}\n  - {on: top, displacement: {y: 0,";
    assert!(NON_MATCHING.contains(top));
    let case = NON_MATCHING.replace(top, held) + "solver: {tolerance: 1.0e-12}\n";
    compare("held_in_part", &case, false, &[1, 2]);
}

/// Runs the case in both forms on each number of ranks and compares with the first run;
/// `same_iterations` where both forms make the same corrections.
fn compare(name: &str, case: &str, same_iterations: bool, ranks: &[usize]) {
    let place = std::env::temp_dir().join(format!("column-hpc-{name}-{}", std::process::id()));
    fs::create_dir_all(&place).expect("the temporary directory is writable");
    let file = place.join("case.yaml");
    fs::write(&file, case).expect("the temporary directory is writable");
    let reference = run(&place, &file, "condensed", ranks[0]);
    for n in ranks {
        for form in ["condensed", "saddle_point"] {
            let what = format!("{name}, {form} on {n} ranks");
            let directory = run(&place, &file, form, *n);
            compare_histories(&what, &reference, &directory, same_iterations);
            if *n == ranks[0] {
                compare_fields(&what, &reference, &directory);
            }
            let report = fs::read_to_string(directory.join("report.json")).expect("a report");
            assert_eq!(report.contains("form: saddle_point"), form == "saddle_point", "{what}");
        }
    }
    fs::remove_dir_all(place).expect("the directory is ours");
}

fn run(place: &Path, case: &Path, form: &str, ranks: usize) -> PathBuf {
    let output = place.join(format!("{form}_{ranks}"));
    if output.exists() {
        return output;
    }
    let set = format!("solver.form={form}");
    let [case, directory] = [case, &output].map(|p| p.to_string_lossy().into_owned());
    let args = ["run", &case, "--set", &set, "--output", &directory, "--quiet"];
    let ended = served::run(ranks, false, &args, common::TIME_LIMIT);
    let errors = String::from_utf8_lossy(&ended.stderr);
    assert!(ended.status.success(), "{form} on {ranks} ranks: {errors}");
    output
}

/// Names of the columns and the rows of `history.csv`; empty cells are 0.
fn history(directory: &Path) -> (Vec<String>, Vec<Vec<f64>>) {
    let text = fs::read_to_string(directory.join("history.csv")).expect("a history");
    let mut lines = text.lines();
    let names = lines.next().expect("a header").split(',').map(str::to_string).collect();
    let number = |cell: &str| if cell.is_empty() { 0.0 } else { cell.parse().expect("a number") };
    (names, lines.map(|line| line.split(',').map(number).collect()).collect())
}

fn compare_histories(what: &str, reference: &Path, directory: &Path, same_iterations: bool) {
    let ((names, expected), (other_names, found)) = (history(reference), history(directory));
    assert_eq!((&names, expected.len()), (&other_names, found.len()), "{what}");
    let kinds = ["iterations", "traction", "jump", "sliding", "damage", "reaction", "displacement"];
    let kind = |name: &str| kinds.iter().position(|k| name.contains(k));
    for (column, name) in names.iter().enumerate() {
        let alike = (0..names.len()).filter(|c| kind(&names[*c]) == kind(name));
        let scale = alike.flat_map(|c| expected.iter().map(move |row| row[c].abs()));
        let scale = scale.fold(0.0, f64::max);
        let counts = name.ends_with("iterations");
        if counts && !same_iterations {
            continue;
        }
        let allowed = if counts { 0.0 } else { TOLERANCE * scale };
        for (expected, found) in expected.iter().zip(&found) {
            let (expected, found) = (expected[column], found[column]);
            assert!((expected - found).abs() <= allowed, "{what}: {name}: {expected} {found}");
        }
    }
}

/// Compares every field of every file; for runs on the same number of ranks.
fn compare_fields(what: &str, reference: &Path, directory: &Path) {
    let fields = fs::read_dir(reference.join("fields")).expect("fields").flatten();
    let paths = fields.map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == "vtkhdf"));
    let mut compared = 0;
    for path in paths {
        let open = |path: &Path| hdf5::File::open(path).expect("a field file");
        let other = directory.join("fields").join(path.file_name().expect("a name"));
        let (expected, found) = (open(&path), open(&other));
        for group in ["VTKHDF/PointData", "VTKHDF/CellData"] {
            let Ok(members) = expected.group(group) else { continue };
            for name in members.member_names().expect("a group") {
                let read = |file: &hdf5::File| -> Vec<f64> {
                    let dataset = file.dataset(&format!("{group}/{name}")).expect("a dataset");
                    dataset.read_raw().expect("numbers")
                };
                let (expected, found) = (read(&expected), read(&found));
                assert_eq!(expected.len(), found.len(), "{what}: {name} in {}", path.display());
                // Where everything has cancelled only rounding is left: m, Pa, or counted.
                let floor = match name.as_str() {
                    "displacement" | "jump" => 1.0e-4,
                    "stress" | "traction" => 1.0e5,
                    _ => 1.0,
                };
                let scale = expected.iter().fold(floor, |m, v| f64::max(m, v.abs()));
                let far =
                    expected.iter().zip(&found).find(|(a, b)| (*a - *b).abs() > TOLERANCE * scale);
                assert!(far.is_none(), "{what}: {name} in {}: {far:?}", path.display());
                compared += expected.len();
            }
        }
    }
    assert!(compared > 0, "{what}: no fields");
}
