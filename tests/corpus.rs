//! Every hostile input that is kept, through the functions that read what the user gives.
//!
//! `scripts/fuzz.sh` looks for more of them.

#[path = "fuzz/src/lib.rs"]
mod targets;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

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

#[test]
fn meshes_of_med() {
    let bench = targets::mesh::med::Bench::new();
    replay("tests/fuzz/corpus/med", 20, |recipe| {
        bench.read(recipe, &NoMeter);
    });
    assert!(bench.read(b"", &NoMeter), "an unchanged file is read");
    bench.close();
}

/// The recipe that changes nothing is gone on from; no other one may end in anything but words.
#[test]
fn checkpoints() {
    let bench = targets::checkpoint::Bench::new();
    replay("tests/fuzz/corpus/checkpoint", 20, |recipe| {
        bench.restart(recipe);
    });
    assert!(bench.restart(b""), "an unchanged checkpoint is gone on from");
    bench.close();
}
