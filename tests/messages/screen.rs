//! Options of PETSc, what is printed, and scenes at the edge of what can be shared out.

use std::fs::File;
use std::process::{Command, Stdio};

use super::{Folder, PROGRAM, common};

#[test]
fn options_of_petsc_override_presets_and_unused_ones_are_reported() {
    let folder = Folder::new();
    let own =
        ["case.yaml", "--", "-ksp_type", "gmres", "-pc_type", "gamg", "-ksp_view", "-kps_rtol"];
    let answer = folder.run(2, &own);
    assert_eq!((answer.status, answer.stderr.as_str()), (Some(0), ""));
    for words in ["type: gmres", "type: gamg"] {
        assert!(answer.stdout.contains(words), "{words}");
    }
    let warning = "warning: the PETSc option -kps_rtol was not used\n";
    assert_eq!(answer.stdout.matches("warning: the PETSc option").count(), 1);
    assert_eq!(answer.stdout.matches(warning).count(), 1);

    let case = "solver.petsc_options=-ksp_type gmres -pc_type jacobi -ksp_view -kps_rtol 1e-3";
    let answer = folder.run(2, &["case.yaml", "--overwrite", "--set", case]);
    assert_eq!((answer.status, answer.stderr.as_str()), (Some(0), ""));
    assert!(answer.stdout.contains("type: gmres") && answer.stdout.contains("type: jacobi"));
    assert!(answer.stdout.contains("warning: the PETSc option -kps_rtol 1e-3 was not used\n"));
    // The command line wins over the case.
    let both = ["case.yaml", "--overwrite", "--set", case, "--", "-pc_type", "none"];
    assert!(folder.run(2, &both).stdout.contains("type: none"));
}

#[test]
fn quiet_runs_print_errors_only() {
    let folder = Folder::new();
    for ranks in [1, 2] {
        let answer = folder.run(ranks, &["case.yaml", "--quiet", "--", "-kps_rtol", "1"]);
        assert_eq!(
            (answer.status, answer.stdout.as_str(), answer.stderr.as_str()),
            (Some(0), "", "")
        );
        let answer = folder.run(ranks, &["case.yaml", "--quiet", "--set", "solver.max_newton=0"]);
        assert_eq!(answer.status, Some(2));
        assert!(answer.stdout.is_empty() && answer.stderr.starts_with("error: "), "{answer:?}");
    }
}

#[test]
fn a_file_of_a_launched_run_holds_plain_lines() {
    let folder = Folder::new();
    let place = folder.0.to_str().expect("a name of ours");
    let status = Command::new("mpirun")
        .args(["-n", "2", "--quiet", "env", "-C", place, PROGRAM, "case.yaml", "--verbose"])
        .envs(common::environment())
        .stdin(Stdio::null())
        .stdout(File::create(folder.path("log.txt")).expect("a folder of ours"))
        .stderr(Stdio::null())
        .status()
        .expect("mpirun");
    assert!(status.success());
    let log = folder.read("log.txt");
    assert!(!log.contains(['\x1b', '\r']), "{log:?}");
    let iterations: usize =
        folder.history("newton_iterations").iter().map(|n| n.parse::<usize>().expect("n")).sum();
    let lines = log.lines().filter(|line| line.starts_with("  correction ")).count();
    // One line for each correction, and one for the start of each of the two solves.
    assert_eq!(lines, iterations + 2, "{log}");
    let instants = log.lines().filter(|line| line.trim_start().starts_with("0.5000")).count();
    assert_eq!(instants, 1, "{log}");
}

#[test]
fn more_ranks_than_cells_change_nothing() {
    let one = Folder::new();
    assert_eq!(one.run(1, &["case.yaml", "--quiet"]).status, Some(0));
    let traction = |folder: &Folder| -> Vec<f64> {
        let column = folder.history("joint.normal_traction.mean");
        column.iter().map(|v| v.parse().expect("a number")).collect()
    };
    let expected = traction(&one);
    for linear in ["mumps", "gamg", "hypre"] {
        let folder = Folder::new();
        let place = folder.0.to_str().expect("a name of ours");
        let linear = format!("solver.linear={linear}");
        let args = [
            "-C",
            place,
            PROGRAM,
            "case.yaml",
            "--quiet",
            "--set",
            &linear,
            "--set",
            "output.fields=all",
        ];
        let output = common::mpirun(7, "env", &args);
        assert!(output.status.success(), "{linear}: {output:?}");
        for (a, b) in traction(&folder).iter().zip(&expected) {
            assert!((a - b).abs() < 1e-8 * 1.1e6, "{linear}: {a} {b}");
        }
    }
}

#[test]
fn an_interface_without_multipliers_has_empty_columns() {
    let side = "displacement: {x: 0, y: 0, z: {formula: \"1e-5*t*z\"}}";
    let left = format!("boundary.2={{on: left, {side}}}");
    let right = format!("boundary.3={{on: right, {side}}}");
    let expect = "expect=[{quantity: joint.normal_traction, at: 1, equals: 0, absolute: 1}]";
    let top = "boundary.1.displacement.z={formula: \"1e-5*t*z\"}";
    let folder = Folder::new();
    let overrides = ["--set", &left, "--set", &right, "--set", top, "--set", expect];
    let mut args = vec!["case.yaml", "--set", "output.fields=all"];
    args.extend(overrides);
    for ranks in [1, 2] {
        let answer = folder.run(ranks, &args);
        assert_eq!(answer.status, Some(1), "{answer:?}");
        let says = "error: 1 of 1 expectations missed; the first: joint.normal_traction at 1 should \
                    be 0e0 within 1e0, but the column is empty: it has no nodes; all of them are in \
                    out/report.json\n";
        assert_eq!(answer.stderr, says);
        for column in ["normal_traction.min", "shear_traction_x.max", "damage.mean"] {
            assert_eq!(folder.history(&format!("joint.{column}")), ["", ""], "{column}");
        }
        assert_eq!(folder.report()["expectations"][0]["met"], false);
    }
}
