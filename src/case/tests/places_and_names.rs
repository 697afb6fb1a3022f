//! Planes too close for cells, names that are no names of files, and words of other YAML.

use super::mistakes::message;
use super::*;

/// Planes that would be one: whatever the units, and whatever lies between them.
#[test]
fn planes_too_close_for_cells_are_refused() {
    let apart = |what: &str, z: &str, most: &str| {
        format!(
            "is {what}, got {z}; cells between them need more than {most} m, 1e-9 of the height: \
             move it, or leave it out"
        )
    };
    let upper = "interfaces.1={name: upper, z: 2.500000001, law: {tied: {}}}";
    let bodies =
        "mesh.column={size: [1, 1, 5], bodies: [{cells: [1, 1, 2]}, {cells: [1, 1, 600]}]}";
    let height = |cells: &str, size: &str| format!("mesh.column={{cells: {cells}, size: {size}}}");
    for (assignments, path, expected) in [
        (
            vec!["interfaces.0.z=5e-9"],
            "interfaces.0.z",
            apart("5.00e-9 m from the bottom", "5e-9", "5e-9"),
        ),
        (
            vec!["interfaces.0.z=4.999999999"],
            "interfaces.0.z",
            apart("1.00e-9 m from the top", "4.999999999", "5e-9"),
        ),
        (
            vec![upper],
            "interfaces.1.z",
            apart("1.00e-9 m from the interface before it at 2.5", "2.500000001", "5e-9"),
        ),
        (
            vec!["interfaces.0.z=2e-6", &height("[1, 1, 5]", "[1e3, 1e3, 5e3]")],
            "interfaces.0.z",
            apart("2.00e-6 m from the bottom", "2e-6", "5e-6"),
        ),
        (
            vec!["interfaces.0.z=4.9999999", bodies],
            "mesh.column.bodies.1.cells.2",
            "makes cells 1.67e-10 m thick, got 600; they must be thicker than 5e-9 m, 1e-9 of the \
             height: give fewer"
                .to_owned(),
        ),
        (
            vec![&height("[1, 1, 5]", "[1, 1e-200, 5]")],
            "mesh.column.size.1",
            "must be between 1e-50 and 1e50 m, got 1e-200".to_owned(),
        ),
    ] {
        let assignments = [&assignments[..], &["probes="]].concat();
        let text = message("mesh", "mesh", &assignments);
        let text = text.lines().find(|line| line.contains(path)).unwrap_or(&text);
        assert!(text.ends_with(&format!("{path} {expected}")), "{text}\n{expected}");
    }
    let elastic = "elastic: {young_modulus: 1, poisson_ratio: 0}";
    let layers = [("seam", "2, 2.000000009"), ("upper", "2.000000009, 5")];
    let [seam, upper] = layers.map(|(name, z)| format!("materials.{name}={{z: [{z}], {elastic}}}"));
    let text = message("mesh", "mesh", &["materials.rock.z=[0, 2]", &seam, &upper]);
    let expected = "materials.seam.z is 9.00e-9 m thick, got [2, 2.000000009]; a layer must be \
                    thicker than 1e-8 m, 2e-9 of the height: leave it out";
    assert!(text.ends_with(expected), "{text}");
}

/// Names that file systems would not keep apart, or not take.
#[test]
fn names_of_interfaces_are_names_of_files() {
    let long = "a".repeat(201);
    for (name, expected) in [
        ("bulk", "cannot be `bulk`: bulk is the name of the field files".to_owned()),
        ("BULK", "cannot be `BULK`: bulk is the name of the field files".to_owned()),
        ("upper", "`upper` is taken".to_owned()),
        (
            "Upper",
            "`Upper` is `upper` but for capital letters, and their field files would be one where \
             the file system does not tell them apart"
                .to_owned(),
        ),
        (&long, "has 201 characters; names of files and columns may have up to 200".to_owned()),
    ] {
        let first = "interfaces.0.name=upper";
        let second = format!("interfaces.1={{name: {name}, z: 3, law: {{tied: {{}}}}}}");
        let text = message("mesh", "mesh", &["expect=[]", first, &second]);
        assert!(text.ends_with(&format!("interfaces.1.name {expected}")), "{text}");
    }
    let long = format!("interfaces.0.name={}", "a".repeat(200));
    for name in ["interfaces.0.name=bulk_mesh", "interfaces.0.name=bulk_000003", &long] {
        assert_eq!(good(&["expect=[]", name]).interfaces.len(), 1);
    }
}

/// Tools for YAML 1.1 take some words for true and false.
#[test]
fn words_that_became_true_or_false_are_told() {
    let so = "so; put it in quotes,";
    for (from, to, expected) in [
        (
            "{on: top",
            "{true: top",
            format!(
                "12:6: boundary.1.true is not a known key: tools for YAML 1.1 write the key on {so} 'on':"
            ),
        ),
        (
            "{x: 0, y: 0, z: 0}",
            "{x: 0, true: 0, z: 0}",
            format!(
                "11:39: boundary.0.displacement.true is not a known key: tools for YAML 1.1 write the \
                 key y {so} 'y':"
            ),
        ),
        (
            "time:",
            "solver: {stability: false}\ntime:",
            format!(
                "13:21: solver.stability must be auto, off, warn, follow or stop, got `false`: tools \
                 for YAML 1.1 write the word off {so} 'off'"
            ),
        ),
        (
            "linear_softening: {strength: 1.1e6, fracture_energy: 900}",
            "tied: {friction: 0.6}",
            "9:18: interfaces.0.law.tied.friction is not a known key; interfaces.0.law.tied has \
             none, write {}"
                .to_owned(),
        ),
        (
            "time:",
            "initial: {strain: 3}\ntime:",
            "13:11: initial.strain is not a known key (known: equilibrium, imperfection, \
             pressure, stress)"
                .to_owned(),
        ),
        ("time:", "initial: {}\ntime:", "13:10: initial has no entries".to_owned()),
    ] {
        assert_eq!(message(from, to, &[]), format!("case.yaml:{expected}"));
    }
}
