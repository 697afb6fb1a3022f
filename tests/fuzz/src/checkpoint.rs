//! The file of `--restart`, as someone would make it who knows how checkpoints are made.
//!
//! An input is a recipe, one change of a real checkpoint on a line. Changes of what is stored come
//! before the file is written by the program itself, so that the checksums are right; then those
//! of the layout; then those of single bytes. What is no change is passed over.

use std::fs;
use std::path::PathBuf;

use column_hpc::cli::RunOptions;
use column_hpc::comm::Rows;
use column_hpc::error::{Error, Result};
use column_hpc::output::checkpoint::{Checkpoint, NEWEST, write};
use column_hpc::output::publisher::Publisher;
use column_hpc::run::run_case;
use column_hpc::runtime::Runtime;
use column_hpc::timers::Timers;
use hdf5::{Dataset, File, Group};
use serde_json::Value;

/// A column of two bodies that opens, unloads, and opens again.
const CASE: &str = "\
mesh: {column: {size: [1, 5], cells: [1, 3]}}
materials: {rock: {elastic: {young_modulus: 5.8e9, poisson_ratio: 0.2}}}
interfaces:
  - {name: joint, z: 2.5, law: {linear_softening: {strength: 1.1e6, fracture_energy: 900}}}
boundary:
  - {on: bottom, displacement: {x: 0, z: 0}}
  - {on: top, displacement: {x: 0, z: {table: [[0, 0], [1, 1.2e-3], [2, 8.0e-4], [3, 1.4e-3]]}}}
time: {instants: [1, 2]}
solver: {linear: mumps, max_newton: 6, stability: off}
output: {checkpoint: {every: 1 instant}, fields: none}
";
/// The case that goes on.
const LONGER: &str = "time.instants=[1, 2, 3]";
const GROUP: &str = "checkpoint";
const MEMBERS: [&str; 5] = ["checksums", "interface", "interface_names", "meta", "nodal"];
/// Rows that a recipe may ask for.
const MOST_ROWS: usize = 100;

/// A real checkpoint, and a place for changed ones.
pub struct Bench {
    runtime: Runtime,
    timers: Timers,
    directory: PathBuf,
    meta: Value,
    nodal: Rows,
    interface: Rows,
}

/// What a recipe makes of the parts before they are written.
struct Parts {
    meta: Value,
    /// Changes of the text of `meta`.
    splices: Vec<(usize, usize, String)>,
    nodal: Rows,
    interface: Rows,
}

impl Bench {
    /// Starts MPI and PETSc and runs the case that is gone on from. Once in a process.
    pub fn new() -> Self {
        let runtime = Runtime::start(&[]).expect("MPI and PETSc");
        let directory =
            std::env::temp_dir().join(format!("column-hpc-restart-{}", std::process::id()));
        fs::create_dir_all(&directory).expect("a temporary directory");
        let empty = || Rows { width: 0, names: Vec::new(), values: Vec::new() };
        let mut bench = Self {
            runtime,
            timers: Timers::new(),
            directory,
            meta: Value::Null,
            nodal: empty(),
            interface: empty(),
        };
        fs::write(bench.directory.join("case.yaml"), CASE).expect("a directory of ours");
        bench.run(None).expect("the case");
        bench.read().expect("a checkpoint");
        bench
    }

    fn read(&mut self) -> hdf5::Result<()> {
        let file = File::open(self.directory.join("out").join(NEWEST))?;
        let member = |name: &str| file.dataset(&format!("{GROUP}/{name}"));
        let meta = member("meta")?.read_raw::<u8>()?;
        self.meta = serde_json::from_slice(&meta).expect("a description");
        let rows = |dataset: Dataset, names: Option<Vec<u64>>| -> hdf5::Result<Rows> {
            let shape = dataset.shape();
            let names = names.unwrap_or_else(|| (0..shape[0] as u64).collect());
            Ok(Rows { width: shape[1], names, values: dataset.read_raw::<f64>()? })
        };
        self.nodal = rows(member("nodal")?, None)?;
        let names = member("interface_names")?.read_raw::<u64>()?;
        self.interface = rows(member("interface")?, Some(names))?;
        Ok(())
    }

    /// Runs the case from its start, or goes on from a file.
    fn run(&self, restart: Option<String>) -> Result<bool> {
        let options = RunOptions {
            case: self.directory.join("case.yaml"),
            overrides: restart.iter().map(|_| LONGER.to_owned()).collect(),
            output: Some(self.directory.join("out")),
            overwrite: restart.is_none(),
            quiet: true,
            verbose: false,
            restart,
            report: false,
            petsc_options: Vec::new(),
        };
        run_case(&self.runtime, &self.timers, &options)
    }

    /// Goes on from what a recipe makes of the checkpoint; whether the program did.
    pub fn restart(&self, recipe: &[u8]) -> bool {
        let Ok(recipe) = std::str::from_utf8(recipe) else { return false };
        let lines: Vec<Vec<&str>> =
            recipe.lines().map(|line| line.split_whitespace().collect()).collect();
        let mut parts = Parts {
            meta: self.meta.clone(),
            splices: Vec::new(),
            nodal: self.nodal.clone(),
            interface: self.interface.clone(),
        };
        for line in &lines {
            parts.change(line);
        }
        let made = self.directory.join("made");
        fs::create_dir_all(&made).expect("a directory of ours");
        let file = made.join(NEWEST);
        parts.write(&self.runtime, &made);
        if let Ok(file) = File::open_rw(&file) {
            for line in &lines {
                // What HDF5 does not make is no input either.
                let _ = lay_out(&file, line);
            }
        }
        let mut bytes = fs::read(&file).expect("a file of ours");
        let before = bytes.clone();
        for line in &lines {
            change_bytes(&mut bytes, line);
        }
        if bytes != before {
            fs::write(&file, bytes).expect("a file of ours");
        }
        match self.run(Some(file.to_string_lossy().into_owned())) {
            Ok(_) => true,
            Err(Error::Input(words) | Error::Numerics(words)) => {
                assert!(!words.trim().is_empty(), "a refusal without words");
                false
            }
            Err(other) => panic!("not the input's fault: {other:?}"),
        }
    }

    /// Ends MPI and PETSc; afterwards nothing is left of the files.
    pub fn close(self) {
        let _ = fs::remove_dir_all(&self.directory);
    }
}

impl Parts {
    fn change(&mut self, line: &[&str]) -> Option<()> {
        match line {
            ["put", pointer, value @ ..] => {
                let value = serde_json::from_str(&value.join(" ")).ok()?;
                let (parent, key) = pointer.rsplit_once('/')?;
                match self.meta.pointer_mut(parent)? {
                    Value::Object(map) => drop(map.insert(key.to_owned(), value)),
                    Value::Array(list) if key == "-" => list.push(value),
                    Value::Array(list) => *list.get_mut(key.parse::<usize>().ok()?)? = value,
                    _ => return None,
                }
            }
            ["cut", pointer] => {
                let (parent, key) = pointer.rsplit_once('/')?;
                match self.meta.pointer_mut(parent)? {
                    Value::Object(map) => drop(map.remove(key)),
                    Value::Array(list) => {
                        let key = key.parse::<usize>().ok()?;
                        (key < list.len()).then(|| list.remove(key))?;
                    }
                    _ => return None,
                }
            }
            ["splice", start, length, text @ ..] => {
                self.splices.push((start.parse().ok()?, length.parse().ok()?, text.join(" ")));
            }
            ["value", "nodal", at, value] => {
                *self.nodal.values.get_mut(at.parse::<usize>().ok()?)? = value.parse().ok()?;
            }
            ["value", "interface", at, value] => {
                *self.interface.values.get_mut(at.parse::<usize>().ok()?)? = value.parse().ok()?;
            }
            ["name", at, value] => {
                let value = value.parse::<u64>().ok()?.min(u64::MAX - 1);
                *self.interface.names.get_mut(at.parse::<usize>().ok()?)? = value;
            }
            ["rows", "nodal", rows, width] => resize(&mut self.nodal, rows, width)?,
            ["rows", "interface", rows, width] => resize(&mut self.interface, rows, width)?,
            _ => return None,
        }
        Some(())
    }

    /// As the program writes a checkpoint, with right checksums.
    fn write(&self, runtime: &Runtime, directory: &std::path::Path) {
        let mut meta = self.meta.to_string();
        for (start, length, text) in &self.splices {
            let start = boundary(&meta, *start);
            let end = boundary(&meta, start.saturating_add(*length));
            meta.replace_range(start..end, text);
        }
        let mut publisher = Publisher::default();
        let parts = Checkpoint { meta: &meta, nodal: &self.nodal, interface: &self.interface };
        // Names bound the slabs, which on one rank have no end.
        write(&runtime.comm, &mut publisher, directory, u64::MAX, &parts).expect("a checkpoint");
        publisher.finish().expect("a checkpoint on the disk");
    }
}

fn resize(part: &mut Rows, rows: &str, width: &str) -> Option<()> {
    let rows = rows.parse::<usize>().ok()?.min(MOST_ROWS);
    part.width = width.parse::<usize>().ok()?.clamp(1, MOST_ROWS);
    let next = part.names.last().map_or(0, |name| name.saturating_add(1));
    let more = (next..).take(rows.saturating_sub(part.names.len()));
    part.names.extend(more);
    part.names.truncate(rows);
    part.values.resize(rows * part.width, 0.0);
    Some(())
}

/// Changes of links, types and shapes.
fn lay_out(file: &File, line: &[&str]) -> hdf5::Result<()> {
    let none = || hdf5::Error::from("no change");
    let [word, name, rest @ ..] = line else { return Ok(()) };
    let group: Group = if *word == "top" { file.group("/")? } else { file.group(GROUP)? };
    let member = MEMBERS.contains(name).then_some(*name).ok_or_else(none);
    match (*word, rest) {
        ("top" | "add", ["soft"]) => group.link_soft("/checkpoint/nodal", name),
        ("top" | "add", ["external"]) => group.link_external("checkpoint.h5", "/checkpoint", name),
        ("top" | "add", ["group"]) => group.create_group(name).map(drop),
        ("drop", _) => group.unlink(member?),
        ("rename", [other]) => group.relink(member?, other),
        ("link", ["soft", target]) => {
            group.unlink(member?)?;
            group.link_soft(target, name)
        }
        ("link", ["hard", other]) => {
            group.unlink(member?)?;
            group.link_hard(other, name)
        }
        ("link", ["external", path]) => {
            group.unlink(member?)?;
            group.link_external(path, "/checkpoint/meta", name)
        }
        ("make", [kind, layout, shape @ ..]) => {
            group.unlink(member?)?;
            make(&group, name, kind, layout, shape)
        }
        _ => Ok(()),
    }
}

/// A dataset in the place of a member.
fn make(group: &Group, name: &str, kind: &str, layout: &str, shape: &[&str]) -> hdf5::Result<()> {
    let shape: Vec<usize> = shape.iter().filter_map(|n| n.parse().ok()).collect();
    let builder = match kind {
        "u8" => group.new_dataset::<u8>(),
        "i64" => group.new_dataset::<i64>(),
        "u64" => group.new_dataset::<u64>(),
        "f32" => group.new_dataset::<f32>(),
        "bool" => group.new_dataset::<bool>(),
        "text" => group.new_dataset::<hdf5::types::VarLenUnicode>(),
        "lists" => group.new_dataset::<hdf5::types::VarLenArray<f64>>(),
        "pairs" => group.new_dataset::<[f64; 2]>(),
        _ => group.new_dataset::<f64>(),
    };
    let builder = builder.shape(shape.clone());
    let builder = match layout {
        "chunked" => builder.chunk(shape),
        "packed" => builder.chunk(shape).deflate(1),
        "compact" => builder.layout(hdf5::dataset::Layout::Compact),
        "outside" => builder.external("checkpoint.h5", 0, 64),
        _ => builder,
    };
    builder.create(name).map(drop)
}

fn change_bytes(bytes: &mut Vec<u8>, line: &[&str]) -> Option<()> {
    match line {
        ["byte", at, value] => {
            let at = at.parse::<usize>().ok()?.checked_rem(bytes.len())?;
            bytes[at] = value.parse().ok()?;
        }
        ["truncate", length] => bytes.truncate(length.parse().ok()?),
        ["append", count] => {
            bytes.extend(std::iter::repeat_n(0xa5, count.parse::<usize>().ok()?.min(4096)));
        }
        _ => return None,
    }
    Some(())
}

/// The last place up to `place` at which a character begins.
fn boundary(text: &str, place: usize) -> usize {
    (0..=place.min(text.len())).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0)
}
