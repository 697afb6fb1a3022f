//! Whether the machine has the memory and the disk space that a run will need, before it starts.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::case::{Case, Fields};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::mesh::MeshFacts;
use crate::report::memory::entry;
use crate::solve::model::memory::memory;
use crate::solve::{LinearChoice, MULTIGRID};

/// Part of the memory that is available that a run may take.
const USABLE: f64 = 0.95;

/// Refuses a run that cannot fit into the memory of the nodes or onto the disk of `directory`, if
/// it writes into one. Collective.
///
/// # Errors
/// `Input` with what is needed, what is there and what would fit.
pub fn check(
    comm: &Comm,
    case: &Case,
    mesh: &MeshFacts,
    choice: &LinearChoice,
    directory: Option<&Path>,
) -> Result<()> {
    let ranks = comm.size() as usize;
    let need = memory(choice.preset, case, mesh, ranks) / ranks as f64;
    let mine = rustix::system::uname().nodename().to_string_lossy().into_owned();
    let names = comm.exchange(&vec![mine.clone().into_bytes(); ranks]);
    let mut nodes: BTreeMap<&[u8], usize> = BTreeMap::new();
    for name in &names {
        *nodes.entry(name).or_default() += 1;
    }
    let here = nodes.get(mine.as_bytes()).copied().unwrap_or(1);
    let shares = Ranks { all: ranks, here };
    let local = match available() {
        Some(bytes) if need * here as f64 > USABLE * bytes => {
            Err(Error::Input(too_large(case, mesh, choice, shares, bytes)))
        }
        _ => Ok(()),
    };
    comm.agree(local)?;
    let Some(directory) = directory else { return Ok(()) };
    let free = if comm.is_root() { free(directory) } else { None };
    let needed = disk(case, mesh);
    comm.agree(match free {
        Some(bytes) if needed > bytes => Err(Error::Input(format!(
            "the results need about {}, {} has {}: give fewer instants to output.fields, or another \
             directory with --output",
            size(needed),
            directory.display(),
            size(bytes)
        ))),
        _ => Ok(()),
    })
}

/// How many ranks there are.
#[derive(Clone, Copy)]
struct Ranks {
    all: usize,
    /// On this node.
    here: usize,
}

/// What is wrong and what would fit, in words.
fn too_large(
    case: &Case,
    mesh: &MeshFacts,
    choice: &LinearChoice,
    ranks: Ranks,
    available: f64,
) -> String {
    let Ranks { all: ranks, here } = ranks;
    let preset = choice.preset;
    let need = memory(preset, case, mesh, ranks) * here as f64 / ranks as f64;
    let mut text = format!(
        "solver.linear: {preset} needs about {} on a node with {here} of {ranks} ranks, and {} are \
         available there",
        size(need),
        size(available)
    );
    // More nodes of this kind, each with as many ranks as this one.
    let fits = |nodes: usize| {
        memory(preset, case, mesh, nodes * here) / nodes as f64 <= USABLE * available
    };
    let nodes = (2..=4096).find(|nodes| fits(*nodes));
    if let Some(nodes) = nodes {
        text += &format!("; it would fit on {nodes} such nodes, {} ranks in all", nodes * here);
    }
    let lighter = memory(MULTIGRID, case, mesh, ranks) * here as f64 / ranks as f64;
    if preset != MULTIGRID && lighter <= USABLE * available {
        text += &format!("; solver.linear: {MULTIGRID} would need about {}", size(lighter));
    }
    if nodes.is_none() {
        text += "; take a coarser mesh";
    }
    text
}

/// Bytes of the field files, the checkpoints and the history, about.
pub fn disk(case: &Case, mesh: &MeshFacts) -> f64 {
    let instants = match &case.output.fields {
        Fields::All => case.time.len(),
        Fields::None => 0,
        Fields::Times(times) => times.len(),
    };
    let (nodes, cells) = (mesh.nodes as f64, mesh.cells as f64);
    let per_cell = mesh.nodes_per_cell as f64;
    // Position and name; connectivity, offset, type, name, material, rank.
    let grid = if instants > 0 { nodes * 32.0 + cells * (8.0 * per_cell + 25.0) } else { 0.0 };
    // Displacement; stress. Pressure; effective stress. Flux and porosity.
    let mut data = nodes * 24.0 + cells * 48.0;
    let mut row = 16.0 * mesh.dim as f64;
    if case.has_pressure() {
        data += nodes * 8.0 + cells * 48.0;
    }
    if case.flow.is_some() {
        data += cells * 32.0;
        row += 16.0;
    }
    let checkpoints = 2.0 * nodes * row;
    let history = (case.time.len() * case.columns().len()) as f64 * 25.0;
    grid + instants as f64 * data + checkpoints + history
}

/// Memory that is free on this node, or that a control group leaves this process (bytes).
fn available() -> Option<f64> {
    let bytes = entry("/proc/meminfo", "MemAvailable:")? as f64;
    let number = |name: &str| -> Option<f64> {
        fs::read_to_string(Path::new("/sys/fs/cgroup").join(name)).ok()?.trim().parse().ok()
    };
    let group = number("memory.max").map(|most| most - number("memory.current").unwrap_or(0.0));
    Some(bytes.min(group.unwrap_or(f64::INFINITY)))
}

/// Free space of the file system that will hold a directory (bytes).
fn free(directory: &Path) -> Option<f64> {
    let there = directory.ancestors().find(|path| path.is_dir()).unwrap_or(Path::new("."));
    let system = rustix::fs::statvfs(there).ok()?;
    Some(system.f_bavail as f64 * system.f_frsize as f64)
}

fn size(bytes: f64) -> String {
    if bytes < 1e9 { format!("{:.0} MB", bytes / 1e6) } else { format!("{:.1} GB", bytes / 1e9) }
}
