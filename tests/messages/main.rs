//! What a user is told when something goes wrong, and what is left on disk: the program itself,
//! alone and under `mpirun`.

#[path = "../common/mod.rs"]
mod common;
mod disk;
mod failure;
#[path = "../common/faults.rs"]
mod faults;
mod files;
mod input;
mod matrix;
mod meshes;
mod numerics;
mod screen;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};
use std::{env, fs};

/// The program.
const PROGRAM: &str = env!("CARGO_BIN_EXE_column-hpc");

/// A column that softens within its two instants. Its interface is on line 5, its top on line 8.
const SCENE: &str = "\
title: scene
mesh: {column: {size: [1, 1, 5], cells: [1, 1, 6]}}
materials: {rock: {elastic: {young_modulus: 5.8e9, poisson_ratio: 0}}}
interfaces:
  - {name: joint, z: 2.5, law: {linear_softening: {strength: 1.1e6, fracture_energy: 900}}}
boundary:
  - {on: bottom, displacement: {x: 0, y: 0, z: 0}}
  - {on: top, displacement: {x: 0, y: 0, z: {table: [[0, 0], [1, 1.0e-3]]}}}
time: {instants: [0.5, 1]}
output: {fields: none, directory: out}
";

/// The top of the column pulled by a force, with nothing else to hold it.
const PULLED: &str = "boundary.1={on: top, traction: {z: {table: [[0, 0], [1, 2.0e6]]}}}";

/// A folder of its own with `case.yaml` in it, gone when dropped.
struct Folder(PathBuf);

/// What a launch ended with.
#[derive(Debug)]
struct Answer {
    status: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Folder {
    /// With the scene as its case.
    fn new() -> Self {
        Self::with(SCENE)
    }

    fn with(case: &str) -> Self {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let name = format!("column-hpc-messages-{}-{number}", std::process::id());
        let path = env::temp_dir().join(name);
        fs::create_dir_all(&path).expect("the temporary directory is writable");
        fs::write(path.join("case.yaml"), case).expect("a folder of ours");
        Self(path)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).expect(name)
    }

    /// The program in this folder on `ranks` ranks; on 1 without `mpirun`.
    fn run(&self, ranks: usize, args: &[&str]) -> Answer {
        let folder = self.0.to_str().expect("a name of ours");
        let before = ["-C", folder, PROGRAM];
        let all: Vec<&str> = before.iter().chain(args).copied().collect();
        let output = if ranks == 1 {
            let _cores = common::Cores::wait(1);
            let mut alone = Command::new("env");
            alone.args(&all).envs(common::environment()).output().expect("env")
        } else {
            common::mpirun(ranks, "env", &all)
        };
        Answer {
            status: output.status.code(),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    /// The column `name` of the history, row by row.
    fn history(&self, name: &str) -> Vec<String> {
        let text = self.read("out/history.csv");
        let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned));
        let mut head = lines.next().expect("a line of names");
        let index = head.position(|column| column == name).expect(name);
        lines.map(|mut row| row.nth(index).expect("a row of the table")).collect()
    }

    fn report(&self) -> serde_json::Value {
        serde_json::from_str(&self.read("out/report.json")).expect("a complete report")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Every file below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut found = Vec::new();
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() { found.extend(files(&path)) } else { found.push(path) }
    }
    found.sort();
    found
}
