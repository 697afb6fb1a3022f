//! What is told of a run as a whole, for its report.

use crate::case::Case;
use crate::comm::Comm;
use crate::error::Result;
use crate::mesh::FarFacet;
use crate::report::{LeftOut, LinearSolver, Model as Modelled, Partition, Ran, memory};
use crate::runtime::Runtime;
use crate::solve::Model;
use crate::timers::{Timers, Timings};

/// What all ranks together took.
pub struct Measured {
    /// How the model was shared out.
    pub partition: Partition,
    /// Seconds by phase, of the slowest rank.
    pub timings: Timings,
    /// Sum over ranks of the largest resident memory (bytes).
    pub memory: Option<u64>,
    /// Bulk cells.
    pub cells: u64,
}

impl Measured {
    /// Collective.
    pub fn of(comm: &Comm, timers: &Timers, model: &Model<'_>) -> Self {
        let partition = partition_of(comm, model);
        let timings = timers.slowest(comm);
        let memory = memory::peak(comm);
        let cells = comm.sum_u64(model.mesh.cells.len() as u64);
        Self { partition, timings, memory, cells }
    }
}

/// The options for PETSc that nothing asked for, in words. Local.
pub fn unused_options(runtime: &Runtime) -> Result<Vec<String>> {
    let unused = runtime.petsc.unused_options()?.into_iter();
    Ok(unused.map(|option| format!("the PETSc option {option} was not used")).collect())
}

/// What was modelled. Local.
pub fn modelled(case: &Case) -> Modelled {
    Modelled {
        physics: case.physics.name().into(),
        dimension: case.dim as u8,
        elements: case.formulations(),
        left_out: case
            .left_out
            .iter()
            .map(|sentence| {
                let (what, why) = sentence.split_once(": ").unwrap_or((sentence, ""));
                LeftOut { what: what.into(), why: why.into() }
            })
            .collect(),
    }
}

/// The linear solver that was chosen, and what ran. Local.
pub fn linear_solver(runtime: &Runtime, model: &Model<'_>) -> Result<LinearSolver> {
    let nothing = model.choice.options.is_empty();
    let ran = if nothing { Vec::new() } else { model.stepper.ran()? };
    let ran = ran.into_iter().map(|r| Ran {
        prefix: r.prefix,
        method: r.method,
        preconditioner: r.preconditioner,
        package: r.package,
    });
    Ok(LinearSolver {
        choice: model.choice.preset.into(),
        why: model.choice.why.clone(),
        ran: ran.collect(),
        petsc_options: runtime.petsc.user_options()?,
    })
}

/// How cells and interface nodes are shared out. Collective.
fn partition_of(comm: &Comm, model: &Model<'_>) -> Partition {
    let (mesh, all) = (&model.mesh, &model.stepper.problem.all);
    let mut cut = 0;
    for side in &model.sides {
        for facet in mesh.on_lip(side.interface, side.secondary) {
            let facing = mesh.across(side.interface, side.secondary, *facet);
            let elsewhere = |far: &&FarFacet| mesh.cells.binary_search(&far.cell).is_err();
            cut += facing.iter().filter(elsewhere).count() as u64;
        }
    }
    let gather = |n: usize| -> Vec<u64> {
        comm.gather(&[n as u64]).map_or_else(Vec::new, |lists| lists.concat())
    };
    let held = all.nodes.len() - all.nodes.owned;
    let ghosts = comm.sum_u64(held as u64);
    Partition {
        cells: gather(mesh.cells.len()),
        interface_nodes: gather(all.owned_secondary()),
        ghosts: gather(held),
        neighbours: gather(all.nodes.neighbours()),
        cut_pairs: comm.sum_u64(cut),
        ghost_share: ghosts as f64 / all.nodes.total as f64,
        cells_before_distribution: mesh.coarse_cells,
    }
}
