//! Where methods fail: the cases of `cases/stability` and their families. Each experiment states
//! the signature of the method that fails and of the one that does not; `scripts/stability.sh`
//! makes docs/stability.md of the numbers that are printed here.

#![allow(clippy::print_stdout)] // the numbers, with --nocapture

mod elements;
mod interfaces;
mod paths;
mod rates;

use crate::scene::{Run, Scene};
use std::fs;
use std::path::Path;

const YOUNG: f64 = 5.8e9;
const STRENGTH: f64 = 1.1e6;
const ENERGY: f64 = 900.0;
const CRITICAL: f64 = 2.0 * ENERGY / STRENGTH;

/// A case of the suite without its expectations, which hold for the base variant alone.
fn family(name: &str) -> Scene {
    base(name).set("expect=[]").in_any_steps()
}

fn base(name: &str) -> Scene {
    Scene::shipped(&format!("stability/{name}.yaml"))
}

/// Prints a number, a list or a text under its name, for the page.
fn measured(key: &str, value: impl Into<serde_json::Value>) {
    println!("measured {}", serde_json::json!({"key": key, "value": value.into()}));
}

/// Tells how often the branches cycled and how many steps were cut.
fn trouble(run: &Run) -> [usize; 2] {
    ["the branches cycle with period", "halved"]
        .map(|word| run.screen.lines().filter(|l| l.contains(word)).count())
}

fn sum(values: &[f64]) -> f64 {
    values.iter().sum()
}

fn near(label: &str, found: f64, exact: f64, absolute: f64) {
    assert!((found - exact).abs() <= absolute, "{label}: {found:e} for {exact:e}");
}

/// Every base case meets its expectations, and gives the same on other numbers of ranks; where it
/// is not unique, and only there, this is reported, and on every number.
#[test]
fn every_base_case_on_other_numbers_of_ranks() {
    base_cases(|number, name| match name {
        "two_equal_interfaces" => &[2, 7],
        _ if number % 5 == 0 => &[4],
        _ if number % 2 == 0 => &[2],
        _ => &[3],
    });
}

/// The same with every number of ranks for each, for the page.
#[test]
#[ignore = "a minute: cargo test --release --test acceptance every_base_case -- --ignored"]
fn every_base_case_on_1_2_3_4_7_ranks() {
    measured("ranks", base_cases(|_, _| &[2, 3, 4, 7]));
}

/// Every base case on one rank and on those that `others` gives for its number and name; what the
/// page tells of each.
fn base_cases(others: fn(usize, &str) -> &'static [usize]) -> Vec<serde_json::Value> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/stability");
    let mut names: Vec<String> = fs::read_dir(directory)
        .expect("the cases")
        .map(|e| e.expect("an entry").path().file_stem().expect("a name").to_string_lossy().into())
        .collect();
    names.sort();
    assert_eq!(names.len(), 15, "{names:?}");
    let mut rows = Vec::new();
    for (number, name) in names.iter().enumerate() {
        let scene = base(name).in_any_steps();
        let one = scene.on(1);
        let unique = one.told("bifurcations").is_empty();
        assert_eq!(unique, name != "two_equal_interfaces", "{name}: {:?}", one.report);
        let mut largest = 0.0_f64;
        for ranks in others(number, name) {
            let run = scene.on(*ranks);
            one.assert_same(&run, 1e-8);
            assert_eq!(run.told("bifurcations").is_empty(), unique, "{}", run.label);
            largest = largest.max(one.difference(&run));
        }
        let met = one.report["expectations"].as_array().expect("a list").len();
        rows.push(serde_json::json!([name, met, largest, unique]));
    }
    rows
}
