//! Wrong input: its exact message, once, with status 2, the same from `check` and from a run on
//! one or two ranks.

use super::{Answer, Folder, SCENE};

/// The scene with a change, and what is said of it.
struct Wrong {
    from: &'static str,
    to: &'static str,
    says: &'static str,
}

const TABLE: &str = "{table: [[0, 0], [1, 1.0e-3]]}";

const WRONG: &[Wrong] = &[
    Wrong {
        from: "young_modulus",
        to: "young_modulos",
        says: "case.yaml:3:30: materials.rock.elastic.young_modulos is not a known key; did you \
               mean `young_modulus`? (known: density, poisson_ratio, thermal_expansion, \
             young_modulus)",
    },
    Wrong {
        from: "5.8e9",
        to: "stiff",
        says: "case.yaml:3:45: materials.rock.elastic.young_modulus must be a number, got the \
               text `stiff`",
    },
    Wrong {
        from: "5.8e9",
        to: "-5.8e9",
        says: "case.yaml:3:45: materials.rock.elastic.young_modulus must be positive, got -5.8e9",
    },
    Wrong {
        from: "ratio: 0",
        to: "ratio: 0.5",
        says: "case.yaml:3:67: materials.rock.elastic.poisson_ratio must be below 0.5, got 0.5",
    },
    Wrong {
        from: "z: 2.5",
        to: "z: 7",
        says: "case.yaml:5:22: interfaces.0.z must lie inside the column, in (0, 5), got 7",
    },
    Wrong {
        from: "z: 2.5",
        to: "z: 5.0e-9",
        says: "case.yaml:5:22: interfaces.0.z is 5.00e-9 m from the bottom, got 5e-9; cells between \
               them need more than 5e-9 m, 1e-9 of the height: move it, or leave it out",
    },
    Wrong {
        from: "900}}}",
        to: "900}}}\n  - {name: lower, z: 1, law: {tied: {}}}",
        says: "case.yaml:6:22: interfaces.1.z must be above the interface before it at 2.5, got 1",
    },
    Wrong {
        from: "on: top",
        to: "on: tpo",
        says: "case.yaml:8:10: boundary.1.on cannot be `tpo`; did you mean `top`? (known: bottom, \
               top, left, right, front, back, all)",
    },
    Wrong {
        from: "1.0e-3]]}}}",
        to: "1.0e-3]]}}}\n  - {on: top, displacement: {z: 2.0e-3}}",
        says: "case.yaml:9:33: boundary.2.displacement.z disagrees with boundary.1 (top): 0.002 \
               against 5e-4 at time 0.5 on the nodes of both",
    },
    Wrong {
        from: "x: 0, y: 0, z: {table: [[0, 0], [1, 1.0e-3]]}}}",
        to: "x: 0, y: 0, z: {formula: \"1e-3*t*(1+x)\"}}}\n  \
             - {on: left, displacement: {z: {formula: \"1e-3*t*(z/5+z/5*y)\"}}}",
        says: "boundary.1 (top) and boundary.2 (left) prescribe different values of \
               displacement.z at their common point (0, 1, 5) m at time 0.5: 5e-4 and 1e-3 m; \
               make them agree there, or leave the component out of one of them",
    },
    Wrong {
        from: "x: 0, y: 0, z: {table",
        to: "z: {table",
        says: "case.yaml:6:1: boundary leaves a body free: body 2 (between joint and the top) can \
               move freely: translation along x, translation along y, rotation about z; prescribe \
               displacements that prevent it, or choose a law that holds; a contact holds what is \
               pressed on it along its normal, and nothing sideways without friction",
    },
    Wrong {
        from: "cells: [1, 1, 6]",
        to: "cells: [1, 0, 6]",
        says: "case.yaml:2:45: mesh.column.cells.1 must be at least 1, got 0",
    },
    Wrong {
        from: "cells: [1, 1, 6]",
        to: "cells: [1000, 1000, 10000]",
        says: "case.yaml:2:34: mesh.column.cells make too many unknowns: 1000 x 1000 x 10000 \
               cells, refined 0 times, have up to 30069048009 displacement components; at most \
               2147483647 can be numbered",
    },
    Wrong {
        from: "[[0, 0], [1, 1.0e-3]]",
        to: "[[1, 0], [0, 1.0e-3]]",
        says: "case.yaml:8:62: boundary.1.displacement.z.table.1 has time 0 after 1; the times \
               must rise",
    },
    Wrong {
        from: "1.1e6",
        to: ".nan",
        says: "case.yaml:5:62: interfaces.0.law.linear_softening.strength must be finite, got NaN",
    },
    Wrong {
        from: "900}",
        to: ".inf}",
        says: "case.yaml:5:86: interfaces.0.law.linear_softening.fracture_energy must be finite, \
               got inf",
    },
    Wrong {
        from: "900}",
        to: "900, augmentation: 0.25}",
        says: "case.yaml:5:105: interfaces.0.law.linear_softening.augmentation must be above 0.5: \
               r = 3.361111111111111e8 Pa/m has to exceed the softening slope \
               6.722222222222222e8 Pa/m, got 0.25",
    },
    Wrong {
        from: "time:",
        to: "initial: {imperfection: [{interface: joint, factor: {formula: \"1-2*x\"}}]}\ntime:",
        says: "initial.imperfection.0: the factor is -1 at (1, 0, 2.5) m; the formula must give \
               positive finite numbers on the whole interface",
    },
    Wrong {
        from: "900}}}",
        to: "900}}, initial: {damage: {formula: \"2*x\"}}}",
        says: "interfaces.0.initial.damage: it is 2 at (1, 0, 2.5) m; it must be between 0 and 1 on \
               the whole interface",
    },
    Wrong {
        from: TABLE,
        to: "{formula: \"1e-4*t/(1-x)\"}",
        says: "boundary.1 (top): displacement.z is inf at (1, 0, 5) m at time 0.5; the formula \
               must give finite numbers on the whole surface at every instant",
    },
    Wrong {
        from: TABLE,
        to: "{formula: \"1e-4*t/(1-t)\"}",
        says: "boundary.1 (top): displacement.z is inf at (0, 0, 5) m at time 1; the formula must \
               give finite numbers on the whole surface at every instant",
    },
    Wrong {
        from: "displacement: {x: 0, y: 0, z: {table: [[0, 0], [1, 1.0e-3]]}}",
        to: "traction: {z: {formula: \"1e5/(1-t)\"}}",
        says: "boundary.1 (top): traction.z is inf at (0.21132486540518708, 0.21132486540518708, \
               4.999999999999999) m at time 1; the formula must give finite numbers wherever the \
               load acts, at every instant",
    },
    Wrong {
        from: "instants: [0.5, 1]",
        to: "instants: [1, 0.5]",
        says: "case.yaml:9:22: time.instants.1 must be above the instant before it at 1, got 0.5",
    },
    Wrong {
        from: "time:",
        to: "solver: {petsc_options: mumps}\ntime:",
        says: "case.yaml:9:25: solver.petsc_options must be written as `-name value -name value`, \
               got `mumps`",
    },
];

/// The change that makes `contact` of the interface, for the body that nothing holds.
const CONTACT: (&str, &str) =
    ("linear_softening: {strength: 1.1e6, fracture_energy: 900}", "contact: {}");

fn refused(answer: &Answer, says: &str, how: &str) {
    assert_eq!(answer.stderr, format!("error: {says}\n"), "{how}");
    assert_eq!((answer.status, answer.stdout.as_str()), (Some(2), ""), "{how}: {says}");
}

#[test]
fn wrong_input_is_told_once_by_check_and_by_runs_on_1_or_2_ranks() {
    for (number, Wrong { from, to, says }) in WRONG.iter().enumerate() {
        assert!(SCENE.contains(from), "{from}");
        let mut case = SCENE.replacen(from, to, 1);
        if *from == "x: 0, y: 0, z: {table" {
            case = case.replacen(CONTACT.0, CONTACT.1, 1);
        }
        let folder = Folder::with(&case);
        refused(&folder.run(1, &["check", "case.yaml"]), says, "check");
        let ranks = 1 + number % 2;
        refused(&folder.run(ranks, &["case.yaml"]), says, &format!("{ranks} ranks"));
        if number == 0 {
            refused(&folder.run(2, &["check", "case.yaml"]), says, "check on 2 ranks");
        }
    }
}

#[test]
fn supports_that_are_missing_sideways_are_named() {
    let folder = Folder::with(&SCENE.replace("x: 0, y: 0, ", ""));
    let says = "case.yaml:6:1: boundary leaves a body free: bodies 1 to 2 (the whole column) can \
                move freely: translation along x, translation along y, rotation about z; \
                prescribe displacements that prevent it, or choose a law that holds";
    refused(&folder.run(1, &["check", "case.yaml"]), says, "check");
    refused(&folder.run(2, &["case.yaml"]), says, "2 ranks");
}

#[test]
fn a_mesh_too_large_is_refused_before_memory_is_asked_for() {
    let case = SCENE.replace("[1, 1, 6]", "[1000, 1000, 10000]");
    let folder = Folder::with(&case);
    let limited = format!("ulimit -v 400000; exec {} check case.yaml", super::PROGRAM);
    let output = std::process::Command::new("sh")
        .args(["-c", &limited])
        .current_dir(&folder.0)
        .output()
        .expect("a shell");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(stderr.contains("make too many unknowns"), "{stderr}");
    assert_eq!(output.status.code(), Some(2));
}

/// 816 million unknowns fit into 32 bits, but their factors into no memory.
#[test]
fn a_run_that_cannot_fit_is_refused_with_what_would() {
    let folder = Folder::new();
    let large = ["mesh.column.cells=[400, 400, 1700]", "solver.linear=mumps"];
    let mut words = vec!["case.yaml", "--output", "out"];
    words.extend(large.iter().flat_map(|s| ["--set", s]));
    for ranks in [1, 2] {
        let answer = folder.run(ranks, &words);
        assert_eq!(answer.status, Some(2), "{answer:?}");
        let text = &answer.stderr;
        let begin = "error: solver.linear: mumps needs about ";
        assert!(text.starts_with(begin) && text.lines().count() == 1, "{text}");
        assert!(text.contains(&format!(" of {ranks} ranks, and ")), "{text}");
        assert!(text.contains("it would fit on") || text.contains("take a coarser mesh"), "{text}");
    }
}

#[test]
fn a_wrong_command_line_is_told_once() {
    let folder = Folder::new();
    for (args, says) in [
        (
            vec!["case.yaml", "--set", "solver.linaer=mumps"],
            "--set solver.linaer=mumps: \
          solver.linaer is not a known key; did you mean `linear`?",
        ),
        (vec!["case.yaml", "--set", "a.b"], "--set a.b: expected a.b.c=VALUE, but there is no `=`"),
        (vec!["case.yaml", "--ouput", "x"], "unexpected argument '--ouput' found"),
        (vec!["case.yaml", "other.yaml"], "unexpected argument 'other.yaml' found"),
        (vec!["none.yaml"], "none.yaml: there is no such case file"),
        (
            vec!["case.yaml", "--", "ksp_view"],
            "`ksp_view` is no PETSc option: after `--` come \
          options of PETSc, such as -ksp_monitor",
        ),
    ] {
        for ranks in [1, 2] {
            let answer = folder.run(ranks, &args);
            assert_eq!(answer.status, Some(2), "{answer:?}");
            assert!(answer.stderr.starts_with(&format!("error: {says}")), "{answer:?}");
            assert_eq!(answer.stderr.matches("error: ").count(), 1, "{answer:?}");
        }
    }
}

#[test]
fn check_and_schema_speak_once_under_mpirun() {
    let folder = Folder::new();
    let check = folder.run(2, &["check", "case.yaml"]);
    assert_eq!((check.status, check.stderr.as_str()), (Some(0), ""));
    assert_eq!(check.stdout.matches("the case is right\n").count(), 1, "{check:?}");
    let schema = folder.run(2, &["schema"]);
    assert_eq!((schema.status, schema.stderr.as_str()), (Some(0), ""));
    serde_json::from_str::<serde_json::Value>(&schema.stdout).expect("one JSON document");
    let version = folder.run(2, &["--version"]);
    assert_eq!(version.stdout.lines().count(), 1, "{version:?}");
}
