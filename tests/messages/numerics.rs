//! Numerics that fail: status 3, with words, the place and what stays valid; expectations that are
//! missed: status 1; states that cycle.

use super::{Answer, Folder, PULLED};

const STIFF: &str = "interface joint gives way over its whole area in this step: the column, with \
                     2.900e8 Pa/m, gives back more energy than the interface takes, which softens by \
                     up to 6.722e8 Pa/m (snap-back): no step is small enough, but control: {opening: \
                     {of: joint, equals: ...}} follows it";

/// Runs the scene with overrides (and what follows `--`).
fn run(folder: &Folder, ranks: usize, overrides: &[&str], petsc: &[&str]) -> Answer {
    let mut args = vec!["case.yaml", "--verbose"];
    args.extend(overrides.iter().flat_map(|one| ["--set", one]));
    if !petsc.is_empty() {
        args.push("--");
        args.extend(petsc);
    }
    folder.run(ranks, &args)
}

/// The run failed at the last of its two instants, or at the first with `times` empty.
fn assert_failed(folder: &Folder, answer: &Answer, times: &[&str]) {
    assert_eq!(answer.status, Some(3), "{}", answer.stderr);
    assert_eq!(folder.history("time"), times);
    let report = folder.report();
    assert_eq!(report["status"], "failed");
    let message = report["message"].as_str().expect("a message");
    assert!(answer.stderr.contains(message.lines().next().unwrap_or("?")), "{message}");
}

const FIRST: [&str; 1] = ["5.0000000000000000e-1"];

#[test]
fn a_snap_back_ends_in_words() {
    let folder = Folder::new();
    let long = [
        "mesh.column.size=[1, 1, 20]",
        "interfaces.0.z=10",
        "boundary.1.displacement.z={table: [[0, 0], [1, 4.0e-3]]}",
    ];
    let answer = run(&folder, 2, &long, &[]);
    assert_failed(&folder, &answer, &FIRST);
    let lines: Vec<&str> = answer.stderr.lines().collect();
    let begin = "error: no solution at time 0.94873046875, reached from 0.9482421875 with the \
                 smallest step 4.8828125e-4 (after 10 halvings): Newton's method cycles between 2 \
                 states of the interfaces (22 corrections, out of balance ";
    assert!(lines[0].starts_with(begin), "{}", answer.stderr);
    let end = "; the tangent was indefinite (3 negative pivots); interface joint at (0, 0, 10) m softened";
    assert!(lines[0].ends_with(end), "{}", answer.stderr);
    assert_eq!(lines[1], format!("error: {STIFF}"));
    assert_eq!(lines[2..], ["error: the results up to time 0.5 are valid, in out"]);
    // No endless cutting: a failed step costs a few corrections.
    let corrections = answer.stdout.lines().filter(|l| l.contains("correction ")).count();
    assert!(corrections < 400, "{corrections}");
}

#[test]
fn a_body_freed_by_rupture_is_named_with_its_interface() {
    let free = "body 2 (between joint and the top) can move freely: ";
    let all = "translation along x, translation along y, translation along z, rotation about x, \
               rotation about y, rotation about z; prescribe displacements that prevent it, or \
               choose a law that holds";
    for linear in ["solver.linear=mumps", "solver.linear=hypre"] {
        let folder = Folder::new();
        let answer = run(&folder, 2, &[PULLED, linear], &[]);
        assert_failed(&folder, &answer, &FIRST);
        let expected = format!(
            "error: interface joint ruptures: all of it softens or is broken, and without it \
             {free}{all}"
        );
        assert_eq!(answer.stderr.lines().nth(1), Some(expected.as_str()), "{}", answer.stderr);
        assert!(answer.stderr.starts_with("error: no solution at time 0.55"), "{}", answer.stderr);
    }
    // Held along z alone: the separation has a solution, and sideways nothing holds.
    let folder = Folder::new();
    let apart = "boundary.1={on: top, displacement: {z: {table: [[0, 0], [1, 2.0e-3]]}}}";
    let answer = run(&folder, 2, &[apart], &[]);
    assert_failed(&folder, &answer, &FIRST);
    let expected = format!(
        " interface joint has ruptured over its whole area: {free}\
         translation along x, translation along y, rotation about z; prescribe displacements that \
         prevent it, or choose a law that holds\nerror: the results up to time 0.5 are valid, in \
         out\n"
    );
    let (time, words) = answer.stderr["error: at time ".len()..].split_at(11);
    assert_eq!(words.trim_start_matches(|c: char| c.is_ascii_digit()), expected);
    // The critical jump is reached at 0.818, and steps are halved down to it.
    let exact = 2.0 * 900.0 / 1.1e6 / 2.0e-3;
    let time: f64 = time.parse().expect("a time");
    assert!((exact..exact + 1e-3).contains(&time), "{time}");
}

#[test]
fn the_limit_of_corrections_is_told_with_the_place() {
    let folder = Folder::new();
    let answer = run(&folder, 1, &["solver.max_newton=1"], &[]);
    assert_failed(&folder, &answer, &FIRST);
    let first = answer.stderr.lines().next().unwrap_or_default();
    assert!(
        first.contains(
            "no convergence in 1 corrections (solver.max_newton): the largest out-of-balance \
             force is "
        ) && first.ends_with(" m; tolerance 1.0e-9"),
        "{first}"
    );
}

#[test]
fn a_linear_solver_that_fails_is_told_in_words() {
    let folder = Folder::new();
    let answer = run(&folder, 2, &["solver.linear=hypre"], &["-ksp_max_it", "1"]);
    assert_failed(&folder, &answer, &[]);
    assert!(
        answer.stderr.contains(
            "the linear solver failed: the limit of iterations was reached \
        (1, residual "
        ),
        "{}",
        answer.stderr
    );
    assert!(answer.stderr.contains("-ksp_max_it raises it"), "{}", answer.stderr);
    assert!(answer.stderr.ends_with("\nerror: no instant was reached\n"), "{}", answer.stderr);
}

#[test]
fn what_rounding_does_not_allow_is_told_with_its_size() {
    let soft = "materials.rock.elastic.young_modulus=1.0e3";
    let materials = "materials={soft: {elastic: {young_modulus: 1.0e3, poisson_ratio: 0.2}, z: [0, \
                     2.5]}, hard: {elastic: {young_modulus: 1.0e11, poisson_ratio: 0.2}, z: [2.5, 5]}}";
    for (changes, is_told) in [(materials, true), (soft, false)] {
        let folder = Folder::new();
        let answer = run(&folder, 1, &[changes, "solver.linear=mumps", "solver.max_newton=9"], &[]);
        let words = "error: rounding alone leaves about ";
        assert_eq!(answer.stderr.contains(words), is_told, "{}", answer.stderr);
        assert_eq!(answer.status, Some(if is_told { 3 } else { 0 }), "{}", answer.stderr);
    }
}

#[test]
fn what_fails_for_any_step_is_told_at_once() {
    let folder = Folder::new();
    let once = ["-pc_type", "hypre"];
    let answer = run(&folder, 2, &["solver.linear=mumps"], &once);
    assert_failed(&folder, &answer, &[]);
    let words = "the linear solver failed: -ksp_type preonly applies the preconditioner hypre once, \
                 which leaves ";
    assert!(answer.stderr.contains(words), "{}", answer.stderr);
    assert!(answer.stderr.contains("needs -ksp_type cg or gmres"), "{}", answer.stderr);
    assert!(!answer.stdout.contains("halved"), "{}", answer.stdout);
    let solver = &folder.report()["linear_solver"];
    let ran = serde_json::json!([{"method": "preonly", "preconditioner": "hypre", "package": "boomeramg"}]);
    assert_eq!((&solver["choice"], &solver["ran"]), (&"mumps".into(), &ran));
    assert_eq!(solver["petsc_options"], serde_json::json!(["-pc_type hypre"]));
    // A limit of 1 MB for the factors of 11 000 unknowns.
    let folder = Folder::new();
    let large = ["solver.linear=mumps", "mesh.column.cells=[12, 12, 20]"];
    let answer = run(&folder, 1, &large, &["-mat_mumps_icntl_23", "1"]);
    assert_eq!(answer.status, Some(4), "{}", answer.stderr);
    assert!(answer.stderr.contains("MUMPS INFOG(1) = -19"), "{}", answer.stderr);
    assert!(!answer.stdout.contains("halved"), "{}", answer.stdout);
}

#[test]
fn an_indefinite_tangent_is_solved_by_another_method() {
    let folder = Folder::new();
    let answer = run(&folder, 2, &["solver.linear=hypre"], &[]);
    assert_eq!(answer.status, Some(0), "{}", answer.stderr);
    assert!(answer.stdout.contains("GMRES takes the place of conjugate gradients"));
    let traction: f64 = folder.history("joint.normal_traction.mean")[1].parse().expect("a number");
    assert!((traction / 1017312.0728929382 - 1.0).abs() < 1e-9, "{traction}");
    // The user's own choice of a method is kept.
    let folder = Folder::new();
    let answer = run(&folder, 2, &["solver.linear=hypre"], &["-ksp_type", "cg"]);
    assert_failed(&folder, &answer, &FIRST);
    assert!(answer.stderr.contains("the tangent is indefinite (iteration "), "{}", answer.stderr);
}

#[test]
fn states_that_cycle_are_left_by_half_a_correction() {
    for form in ["solver.form=condensed", "solver.form=saddle_point"] {
        cycles_are_left(form);
    }
}

fn cycles_are_left(form: &str) {
    let folder = Folder::new();
    let scene = [
        form,
        "time.instants=[1]",
        "boundary.1.displacement.z={table: [[0, 0], [1, 1.14e-3]]}",
        "interfaces.0.law.linear_softening.augmentation=0.6",
    ];
    let answer = run(&folder, 1, &scene, &[]);
    assert_eq!((answer.status, answer.stderr.as_str()), (Some(0), ""));
    let cycle = "the branches cycle with period 2: 0.5 of each correction until they stay";
    assert!(answer.stdout.contains(cycle), "{}", answer.stdout);
    assert!(!answer.stdout.contains("halved"), "{}", answer.stdout);
    assert_eq!(folder.history("time"), ["1.0000000000000000e0"]);
    // Each solve judges its start, which is no correction, and every correction.
    let judged = |first: &str| answer.stdout.lines().filter(|l| l.starts_with(first)).count();
    let corrections = judged("  correction ") - judged("  correction   0");
    assert_eq!(folder.history("newton_iterations"), [corrections.to_string()]);
    assert!(corrections > 5, "{corrections}");
    // (K U - K delta_c) / (1 - K / h), K = 1.16e9 Pa/m.
    let (k, h, delta_c) = (1.16e9, 1.1e6 * 1.1e6 / 1800.0, 1800.0 / 1.1e6);
    let exact: f64 = k * (1.14e-3 - delta_c) / (1.0 - k / h);
    let traction: f64 = folder.history("joint.normal_traction.mean")[0].parse().expect("a number");
    assert!((traction / exact - 1.0).abs() < 1e-9, "{traction} {exact}");
}

#[test]
fn a_missed_expectation_ends_with_status_1_and_one_message() {
    let folder = Folder::new();
    let expect = "expect=[{quantity: joint.normal_traction, at: 0.5, equals: 580000, relative: \
                  1.0e-9}, {quantity: joint.damage, at: 1, equals: 1, absolute: 0.5}]";
    for ranks in [1, 2] {
        let answer = folder.run(ranks, &["case.yaml", "--quiet", "--set", expect]);
        assert_eq!((answer.status, answer.stdout.as_str()), (Some(1), ""));
        let begin = "error: 1 of 2 expectations missed; the first: joint.damage at 1 should be 1e0 \
                     within 5e-1, but it is 7.517";
        assert!(answer.stderr.starts_with(begin), "{}", answer.stderr);
        assert!(answer.stderr.ends_with("; all of them are in out/report.json\n"));
        assert_eq!(answer.stderr.lines().count(), 1);
        assert_eq!(folder.report()["status"], "expectation_missed");
    }
}

#[test]
fn a_path_without_pull_is_told() {
    let folder = Folder::new();
    let answer = folder.run(
        1,
        &[
            "case.yaml",
            "--set",
            "boundary.1.displacement.z=-1",
            "--set",
            "control={opening: {of: joint, equals: 1.0e-4}}",
        ],
    );
    assert_eq!(answer.status, Some(3), "{answer:?}");
    assert!(answer.stderr.contains("no interface is pulled or sheared by the loads"), "{answer:?}");
    assert_eq!(answer.stderr.matches("error: no solution").count(), 1, "{answer:?}");
}
