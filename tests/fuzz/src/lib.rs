//! The functions that read what a user gives, as the program calls them on rank 0, for hostile
//! input.
//!
//! Each takes any bytes and returns, or panics where the program broke its promise: what is wrong
//! is told in words, and what is accepted can be computed. The fuzz targets feed them, and
//! `tests/corpus.rs` replays every input that is kept.

pub mod checkpoint;
pub mod mesh;

use std::path::Path;

use column_hpc::case::{Case, Formula, Value};
use column_hpc::error::{Error, Result};
use column_hpc::mesh::Column;
use column_hpc::run::describe;

/// The name of every case here.
const NAME: &str = "case.yaml";

/// A case for overrides to change: all kinds of sections in it.
pub const BASE: &str = "\
mesh:
  column: {size: [1, 1, 5], bodies: [{cells: [1, 1, 2]}, {cells: [2, 1, 3], order: 2}]}
materials:
  rock:
    elastic: {young_modulus: 5.8e9, poisson_ratio: 0}
interfaces:
  - name: joint
    z: 2.5
    law: {linear_softening: {strength: 1.1e6, fracture_energy: 900}}
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}
  - {on: top, displacement: {x: 0, y: 0, z: {table: [[0, 0], [1, 1.0e-4]]}}}
  - {on: right, traction: {x: {formula: \"1e3*t*min(x, z)\"}}}
initial: {imperfection: [{interface: joint, factor: 0.999}]}
time: {instants: [1, 2]}
output: {fields: [1], checkpoint: {every: 10 min}}
limits: {wall: 01:00:00}
probes: [{name: mid, at: [0.5, 0.5, 1.25]}]
expect:
  - {quantity: joint.normal_traction, at: 1, equals: 116000, relative: 1.0e-9}
";

/// Values that the walk through the nodes of an accepted case may evaluate here.
const MOST_VALUES: u64 = 100_000;

/// The text of a case file.
pub fn case(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    examine(Case::read(text, Path::new(NAME), &[]));
}

/// A list of `--set`, one on a line, applied to a case that is right.
pub fn set(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let overrides: Vec<String> = text.lines().map(str::to_owned).collect();
    examine(Case::read(BASE, Path::new(NAME), &overrides));
}

/// The text of a formula.
pub fn formula(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let formula = match Formula::parse(text) {
        Ok(formula) => formula,
        Err(reason) => return assert!(reason.contains("formula"), "no place in: {reason}"),
    };
    assert_eq!(Formula::parse(formula.text()).as_ref(), Ok(&formula));
    let here = formula.at([0.25, -1.0, 3.0], 0.5);
    let there = formula.at([1e300, f64::NAN, -0.0], 1e-300);
    if formula.is_constant() {
        assert!(here == there || here.is_nan() && there.is_nan(), "{here} {there}");
    }
    assert!(formula.varies_in_space() || !formula.uses_y());
    assert!(!formula.is_constant() || !formula.uses_t());
    let value = Value::Formula(formula);
    assert!(!value.is_zero() || value.at([0.0; 3], 0.0) == 0.0);
}

/// A refusal has words and is the user's fault; a case that is accepted is the same when it is read
/// from its resolved form or built of its sections, its column can be laid out, and it can be
/// described.
fn examine(read: Result<Case>) {
    let Some(case) = accepted(read) else { return };
    let again = Case::read(&case.resolved().to_string(), Path::new(NAME), &[]);
    assert!(again.as_ref() == Ok(&case), "resolved, it is {again:?}, was {case:?}");
    let built = Case::build(case.sections().clone());
    assert!(built.as_ref() == Ok(&case), "built, it is {built:?}, was {case:?}");
    let Some(column) = accepted(Column::new(&case)) else { return };
    let values = column.nodes() * (case.time.len() * (1 + case.boundary.len())) as u64;
    if values <= MOST_VALUES {
        accepted(describe(&case));
    }
}

/// What was accepted; panics when it was refused for another reason than the input.
pub fn accepted<T>(outcome: Result<T>) -> Option<T> {
    match outcome {
        Ok(value) => Some(value),
        Err(Error::Input(words)) => {
            assert!(!words.trim().is_empty(), "a refusal without words");
            None
        }
        Err(other) => panic!("not the input's fault: {other:?}"),
    }
}
