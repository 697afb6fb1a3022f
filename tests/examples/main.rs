//! The examples, and what a program may rely on that runs cases from code, on 1 and 2 ranks.
//!
//! The sources of the examples are part of this program, which launches itself: `cargo test` with
//! the name of a test builds no examples, so that their own executables may be missing or old.

#![allow(clippy::print_stdout)] // the runner's own report

#[path = "../../examples/column.rs"]
mod column;
#[path = "../common/mod.rs"]
mod common;
mod library;
#[path = "../../examples/results.rs"]
mod results;
#[path = "../../examples/sweep.rs"]
mod sweep;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Output};

/// What of this program a launch of it runs.
const PART: &str = "COLUMN_HPC_EXAMPLE";

fn main() -> ExitCode {
    match std::env::var(PART).as_deref() {
        Ok("column") => column::main(),
        Ok("sweep") => sweep::main(),
        Ok("results") => results::main(),
        Ok("library") => library::main(),
        _ => {
            launch();
            ExitCode::SUCCESS
        }
    }
}

fn launch() {
    let place = std::env::temp_dir().join(format!("column-hpc-examples-{}", std::process::id()));
    std::fs::create_dir_all(&place).expect("the temporary directory is writable");
    for ranks in [1, 2] {
        prints_the_closed_form(ranks, &place);
        sweeps_within_one_process(ranks, &place);
        reads_the_results_of_a_run(ranks, &place);
        reads_the_results_of_the_program(ranks, &place);
        is_a_library(ranks, &place);
        println!("examples on {ranks} rank(s): ok");
    }
    let left: Vec<PathBuf> = std::fs::read_dir(&place)
        .expect("a directory of ours")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.to_string_lossy().contains("column-hpc"))
        .collect();
    assert!(left.is_empty(), "{left:?} are left behind");
    std::fs::remove_dir_all(place).expect("a directory of ours");
}

/// Runs a part of this program: on one rank directly.
fn run(part: &str, ranks: usize, place: &Path, args: &[&str]) -> Output {
    let own = std::env::current_exe().expect("a running program has a path");
    let own = own.to_str().expect("a path of letters");
    let temporary = format!("TMPDIR={}", place.display());
    let part = format!("{PART}={part}");
    let limit = common::TIME_LIMIT.as_secs().to_string();
    let words = [&[temporary.as_str(), &part, "timeout", &limit, own], args].concat();
    if ranks > 1 {
        return common::mpirun(ranks, "env", &words);
    }
    let _cores = common::Cores::wait(1);
    let mut command = Command::new("env");
    command.args(words).envs(common::environment()).output().expect("env is everywhere")
}

/// The lines that were printed, where all went well.
fn lines(output: &Output) -> Vec<String> {
    let [text, told] = [&output.stdout, &output.stderr].map(|b| String::from_utf8_lossy(b));
    assert!(output.status.success() && told.is_empty(), "{}\n{text}\n{told}", output.status);
    text.lines().map(str::to_owned).collect()
}

/// The numbers of a line.
fn numbers(line: &str) -> Vec<f64> {
    line.split_whitespace().filter_map(|word| word.parse().ok()).collect()
}

fn prints_the_closed_form(ranks: usize, place: &Path) {
    let lines = lines(&run("column", ranks, place, &[]));
    assert_eq!(lines.len(), 11, "{lines:?}");
    for (i, line) in lines[1..].iter().enumerate() {
        let [time, traction, exact] = numbers(line)[..] else { panic!("{line}") };
        assert_eq!(time, (i + 1) as f64 / 10.0);
        assert!((traction - exact).abs() < 2.0e-3, "{line}");
    }
    assert_eq!(numbers(&lines[5])[2], 1_017_312.073);
}

fn sweeps_within_one_process(ranks: usize, place: &Path) {
    let lines = lines(&run("sweep", ranks, place, &[]));
    assert_eq!(lines.len(), 7, "{lines:?}");
    let rows: Vec<Vec<f64>> = lines[1..].iter().map(|line| numbers(line)).collect();
    for (i, row) in rows.iter().enumerate() {
        assert_eq!((row[0], row[1]), ([0.5e6, 1.0e6, 1.5e6][i / 2], [32.0, 128.0][i % 2]));
        assert_eq!(row[4], 900.0, "{}", lines[i + 1]);
        assert!(i < 2 || row[3] > rows[i - 2][3], "a stronger joint carries more: {lines:?}");
    }
}

fn reads_the_results_of_a_run(ranks: usize, place: &Path) {
    let lines = lines(&run("results", ranks, place, &[]));
    assert_eq!(lines[0], "A block: 100 unknowns, 3 instants");
    assert_eq!(lines.len(), 4, "{lines:?}");
    for (line, time) in lines[1..].iter().zip([0.1, 0.3, 0.5]) {
        assert!(line.starts_with(&format!("joint at {time} s: widest ")), "{line}");
        assert!(line.contains(" m at (1, 0, 1) m; history "), "{line}");
        let [field, .., told] = numbers(line)[1..] else { panic!("{line}") };
        assert_eq!(field, told);
    }
    assert!(lines[3].contains("widest 5.000000e-3 m"), "torn off: {}", lines[3]);
}

fn reads_the_results_of_the_program(ranks: usize, place: &Path) {
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/two_interfaces/case.yaml");
    let directory = place.join("results");
    let [case, name] = [&case, &directory].map(|path| path.to_str().expect("a path of letters"));
    let words = [case, "--output", name, "--quiet"];
    let done = common::mpirun(ranks, env!("CARGO_BIN_EXE_column-hpc"), &words);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let read = lines(&run("results", ranks, place, &[name]));
    assert!(read.len() > 2, "{read:?}");
    for line in &read[1..] {
        let [field, .., told] = numbers(line)[1..] else { panic!("{line}") };
        assert_eq!(field, told, "{line}");
    }
    std::fs::remove_dir_all(&directory).expect("a directory of ours");

    let refused = run("results", ranks, place, &[name]);
    let told = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{told}");
    let told: Vec<&str> = told.lines().filter(|line| line.starts_with("error: ")).collect();
    assert!(
        matches!(told[..], [one] if one.ends_with("is no directory: there is no history.csv in it"))
    );
}

fn is_a_library(ranks: usize, place: &Path) {
    let printed = lines(&run("library", ranks, place, &[]));
    assert!(printed.is_empty(), "a run from code says nothing: {printed:?}");
}
