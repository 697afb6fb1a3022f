//! Every hostile input that is kept, through the functions that read what the user gives.
//!
//! `scripts/fuzz.sh` looks for more of them.

#[path = "fuzz/src/lib.rs"]
mod targets;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use proptest::prelude::*;
use targets::mesh::NoMeter;

/// An input takes no longer.
const LONGEST: Duration = Duration::from_secs(5);

/// The files of a directory of the project, by name, with what they hold.
fn files(directory: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join(directory);
    let entries = std::fs::read_dir(&directory).expect("a directory of the project");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    paths.retain(|path| path.is_file());
    paths.sort();
    paths.into_iter().map(|path| (path.clone(), std::fs::read(path).expect("a file"))).collect()
}

/// Replays a directory, which holds at least `count` inputs.
fn replay(directory: &str, count: usize, target: impl Fn(&[u8])) {
    let inputs = files(directory);
    assert!(inputs.len() >= count, "{} inputs in {directory}", inputs.len());
    for (path, bytes) in inputs {
        let started = Instant::now();
        target(&bytes);
        let took = started.elapsed();
        assert!(took < LONGEST, "{} took {took:?}", path.display());
    }
}

#[test]
fn cases() {
    replay("tests/fuzz/corpus/case", 8, targets::case);
}

#[test]
fn formulas() {
    replay("tests/fuzz/corpus/formula", 10, targets::formula);
}

#[test]
fn overrides() {
    replay("tests/fuzz/corpus/set", 5, targets::set);
}

#[test]
fn meshes_of_gmsh() {
    replay("tests/fuzz/corpus/gmsh", 20, |bytes| targets::mesh::gmsh(bytes, &NoMeter));
    replay("tests/meshes", 20, |bytes| targets::mesh::gmsh(bytes, &NoMeter));
}

/// One after the other: MPI starts a process that keeps whatever is open at that moment, and with
/// it HDF5's locks of files, and when MPI ends it ends HDF5 for the whole process.
#[test]
fn files_of_hdf5() {
    meshes_of_med();
    changed_files_of_med_are_read_or_refused_in_words();
    checkpoints();
}

fn meshes_of_med() {
    let bench = targets::mesh::med::Bench::new();
    replay("tests/fuzz/corpus/med", 20, |recipe| {
        bench.read(recipe, &NoMeter);
    });
    assert!(bench.read(b"", &NoMeter), "an unchanged file is read");
    bench.close();
}

fn word(words: &'static [&'static str]) -> impl Strategy<Value = &'static str> {
    prop::sample::select(words)
}

/// Whole numbers as they are wrong by a little or by much.
fn number() -> impl Strategy<Value = i64> {
    prop_oneof![-3..40_i64, any::<i64>(), Just(i64::MIN), Just(i64::MAX), Just(1 << 32)]
}

/// A line of a recipe for a MED file.
fn change() -> impl Strategy<Value = String> {
    let kinds =
        word(&["i8", "i16", "i32", "i64", "u32", "u64", "f32", "f64", "names", "text", "pairs"]);
    let layouts = word(&["plain", "chunked", "packed", "summed", "reduced", "compact", "square"]);
    let length = prop_oneof![0..100_u64, Just(1 << 40), Just(1 << 61), any::<u64>()];
    let reals = word(&["nan", "inf", "-inf", "1e308", "-1e308", "1e-320", "0", "1.5"]);
    let of_attributes = word(&["i64", "i32", "u64", "f64", "list", "text", "words", "none"]);
    let names = word(&["HE8", "QU4", "TE4", "PO1", "NOD", "NUM", "FAM", "GRO", "NOM", "x"]);
    let attributes = word(&["0", "1", "2", "3", "NBR", "NUM", "ESP", "PFL"]);
    let one = || 0..60_u32;
    prop_oneof![
        3 => (one(), 0..400_u32, number()).prop_map(|(d, e, v)| format!("set {d} {e} {v}")),
        1 => (one(), 0..100_u32, reals).prop_map(|(d, e, v)| format!("set {d} {e} {v}")),
        2 => (one(), kinds, layouts, length)
            .prop_map(|(d, kind, layout, n)| format!("as {d} {kind} {layout} {n}")),
        3 => (one(), attributes, of_attributes, number())
            .prop_map(|(o, name, kind, v)| format!("attribute {o} {name} {kind} {v}")),
        1 => one().prop_map(|o| format!("drop {o}")),
        1 => (one(), names).prop_map(|(o, name)| format!("rename {o} {name}")),
        1 => (word(&["hard", "soft", "external"]), one(), one())
            .prop_map(|(kind, o, to)| format!("link {kind} {o} {to}")),
        1 => (0..30_000_u32, any::<u8>()).prop_map(|(at, byte)| format!("byte {at} {byte}")),
        1 => (0..4_000_u32, number()).prop_map(|(at, value)| format!("word {at} {value}")),
    ]
}

/// Changes by chance, beside those that fuzzing found. `PROPTEST_CASES` makes them more.
fn changed_files_of_med_are_read_or_refused_in_words() {
    let bench = targets::mesh::med::Bench::new();
    let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::default() };
    let recipes = (0..11_u32, prop::collection::vec(change(), 1..5));
    let outcome = proptest::test_runner::TestRunner::new(config).run(&recipes, |(file, lines)| {
        let recipe = format!("file {file}\n{}", lines.join("\n"));
        let _ = bench.read(recipe.as_bytes(), &NoMeter);
        Ok(())
    });
    bench.close();
    outcome.unwrap_or_else(|found| panic!("{found}"));
}

/// The recipe that changes nothing is gone on from; no other one may end in anything but words.
fn checkpoints() {
    let bench = targets::checkpoint::Bench::new();
    replay("tests/fuzz/corpus/checkpoint", 20, |recipe| {
        bench.restart(recipe);
    });
    assert!(bench.restart(b""), "an unchanged checkpoint is gone on from");
    bench.close();
}
