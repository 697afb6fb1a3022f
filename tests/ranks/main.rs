//! Tests of what is collective, on 1, 2, 3 and 4 ranks.
//!
//! Started by `cargo test`, the program launches itself under `mpirun`; there it runs the functions
//! of the lists below in their order, the same on every rank. A word on the command line chooses
//! the tests whose names contain it. `mpirun -n N PROGRAM under-mpirun import FILE` measures the
//! import of a mesh, `compare CASE...` tells where meshes read in slabs differ from whole ones.

#![allow(clippy::print_stdout)] // the runner's own report

mod aggregation;
mod boxes;
mod comm;
#[path = "../common/mod.rs"]
mod common;
mod linear_algebra;
mod newton;
mod slabs;
mod tangent;

use column_hpc::runtime::Runtime;
use std::process::Output;
use std::thread;
use std::time::{Duration, Instant};

type Test = (&'static str, fn(&Runtime));

const TESTS: &[Test] = &[
    ("reductions", comm::reductions),
    ("broadcast_and_root", comm::broadcast_and_root),
    ("exchange_and_gather", comm::exchange_and_gather),
    ("agree_on_an_error", comm::agree_on_an_error),
    ("neighbours", comm::neighbours),
    ("vectors", linear_algebra::vectors),
    ("laplacian", linear_algebra::laplacian),
    ("blocks", linear_algebra::blocks),
    ("wrong_entries_are_errors", linear_algebra::wrong_entries_are_errors),
    ("presets_agree", newton::presets_agree),
    ("preconditioner_is_kept", newton::preconditioner_is_kept),
    ("callback_errors_come_back", newton::callback_errors_come_back),
    ("verdict_stops", newton::verdict_stops),
    ("indefinite_in_words", newton::indefinite_in_words),
    ("singular_in_words", newton::singular_in_words),
    ("iteration_limit_in_words", newton::iteration_limit_in_words),
    ("not_a_number_in_words", newton::not_a_number_in_words),
    ("user_options_win", newton::user_options_win),
    ("unused_options_are_found", newton::unused_options_are_found),
    ("tangent_by_differences", tangent::tangent_by_differences),
    ("tangent_in_refined_meshes", tangent::tangent_in_refined_meshes),
    ("boxes_give_the_sum_over_their_cells", boxes::give_the_sum_over_their_cells),
    ("aggregation_of_a_slender_beam", aggregation::of_a_slender_beam),
    ("aggregation_without_couplings", aggregation::without_couplings),
    ("slabs_are_those_read_whole", slabs::are_those_read_whole),
    ("slabs_tell_damage_alike", slabs::damage_is_told_alike),
    ("slabs_see_hinges", slabs::hinges_are_seen),
    ("log_stages", linear_algebra::log_stages),
];

/// First argument of a launch under `mpirun`; the second is a test's name or a way to end badly.
const INSIDE: &str = "under-mpirun";

/// In which a job ends after one of its ranks did, from the moment that it has its cores.
const SOON: Duration = Duration::from_secs(60);

/// Options of the command line that the tests of options look for.
const OPTIONS: &[&str] = &["-user_pc_type", "jacobi", "-user_ksp_rtol", "1e-3", "-kps_type", "cg"];

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    if args.first().is_some_and(|first| first == INSIDE) {
        return inside(&args[1..]);
    }
    if args.iter().any(|arg| arg == "--list") {
        return;
    }
    let filter = args.iter().find(|arg| !arg.starts_with('-')).map_or("", String::as_str);
    // Most of an ending is waiting, during which the tests have the cores.
    thread::scope(|scope| {
        if "endings".contains(filter) {
            scope.spawn(|| [2, 3].into_iter().for_each(endings));
        }
        (1..=4).for_each(|ranks| all(ranks, filter));
    });
    // Its panic is caught where nothing else can panic.
    if "endings".contains(filter) {
        time_limit();
    }
}

/// Runs the chosen tests on a number of ranks.
fn all(ranks: usize, filter: &str) {
    let start = Instant::now();
    let output = launch(ranks, &[INSIDE, "tests", filter]);
    let text = String::from_utf8_lossy(&output.stdout);
    print!("{text}");
    assert!(output.status.success(), "on {ranks} ranks: {}", stderr(&output));
    assert!(output.stderr.is_empty(), "noise on {ranks} ranks: {}", stderr(&output));
    let chosen = TESTS.iter().filter(|(name, _)| name.contains(filter)).count();
    assert_eq!(
        text.lines().filter(|line| line.ends_with(" ok")).count(),
        chosen,
        "on {ranks} ranks"
    );
    println!("{ranks} ranks: {chosen} tests passed in {:.1} s", start.elapsed().as_secs_f64());
}

/// A rank that fails, panics, aborts or is killed ends the job, with its status and its words.
fn endings(ranks: usize) {
    for (way, status, words) in [
        ("fails", 4, "disk full on rank 1"),
        ("panics", 101, "[rank 1] panicked at"),
        ("aborts", 7, "[rank 1] the file system is gone"),
        ("killed", 137, ""),
        ("doubts", 4, "error: SNESSetFromOptions failed: PETSc error"),
        ("doubts and meets", 4, "The other ranks did not see this error"),
    ] {
        // Ranks that wait for one that is gone would wait for ever.
        let program = program();
        let output = common::mpirun_within(SOON, ranks, &program, &[INSIDE, way]);
        assert_eq!(output.status.code(), Some(status), "{way}: {}", stderr(&output));
        assert!(stderr(&output).contains(words), "{way}: {}", stderr(&output));
        println!("{ranks} ranks: one {way}, status {status} ok");
    }
}

/// A launch that hangs is ended, and the message names it.
fn time_limit() {
    let program = program();
    let hang = || common::mpirun_within(Duration::from_secs(2), 2, &program, &[INSIDE, "hangs"]);
    std::panic::set_hook(Box::new(|_| ()));
    let panic = std::panic::catch_unwind(hang).expect_err("the launch hangs");
    let _ = std::panic::take_hook();
    let words = panic.downcast_ref::<String>().expect("a message");
    assert!(words.contains("hangs on 2 ranks was ended after 2 s"), "{words}");
    println!("2 ranks: one hangs, ended ok");
}

fn launch(ranks: usize, args: &[&str]) -> Output {
    common::mpirun(ranks, &program(), args)
}

fn program() -> String {
    let program = std::env::current_exe().expect("the test's own program");
    program.to_string_lossy().into_owned()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn inside(args: &[String]) {
    let options: Vec<String> = OPTIONS.iter().map(ToString::to_string).collect();
    let runtime = Runtime::start(&options).expect("MPI and PETSc start");
    match args[0].as_str() {
        "tests" => {
            let filter = args.get(1).map_or("", String::as_str);
            for (name, test) in TESTS.iter().filter(|(name, _)| name.contains(filter)) {
                test(&runtime);
                runtime.comm.barrier();
                if runtime.comm.is_root() {
                    println!("{name} ok");
                }
            }
            runtime.exit(0)
        }
        "import" => {
            slabs::measure(&runtime, &args[1..]);
            runtime.exit(0)
        }
        "compare" => {
            slabs::compare(&runtime, &args[1..]);
            runtime.exit(0)
        }
        way => end_badly(runtime, way),
    }
}

fn end_badly(runtime: Runtime, way: &str) {
    use column_hpc::error::Error;
    use column_hpc::petsc::{KspSetup, Snes, Vector};
    if runtime.comm.rank() == 1 {
        match way {
            "panics" => panic!("on purpose"),
            "aborts" => column_hpc::comm::abort(7, "the file system is gone"),
            // PETSc fails here, while the others wait for this rank in a collective call, or meet
            // it.
            "doubts" | "doubts and meets" => {
                let _ = runtime.petsc.set_option("ksp_type", "nonsense");
            }
            "hangs" => std::thread::sleep(Duration::from_secs(60)),
            "killed" => {
                let _ = std::process::Command::new("kill")
                    .args(["-KILL", &std::process::id().to_string()])
                    .status();
            }
            _ => {}
        }
    }
    if way.starts_with("doubts") {
        let matrix = linear_algebra::tridiagonal(&runtime.petsc, 8);
        let made = Snes::new(&runtime.petsc, "", matrix, &KspSetup::default());
        if made.is_ok() && way == "doubts" {
            let norm = Vector::new(&runtime.petsc, 4, 1).and_then(|vector| vector.norm2());
            unreachable!("rank 1 takes no part in {norm:?}");
        }
        let _ = runtime.comm.agree(made.map(drop));
        unreachable!("a rank that fails by itself ends the job");
    }
    let local = if runtime.comm.rank() == 1 {
        Err(Error::System("disk full on rank 1".into()))
    } else {
        Ok(())
    };
    // The ranks that live wait here for the one that does not.
    match runtime.comm.agree(local) {
        Ok(()) => runtime.exit(0),
        Err(error) => {
            if runtime.comm.is_root() {
                eprintln!("{error}");
            }
            runtime.exit(error.exit_status())
        }
    }
}
