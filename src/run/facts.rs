//! What a report tells of the model, its solver and how it is shared out.

use crate::case::Case;
use crate::comm::Comm;
use crate::error::Result;
use crate::report::{LeftOut, LinearSolver, Model as Modelled, Partition, Ran};
use crate::runtime::Runtime;
use crate::solve::Model;

/// What is modelled, and what is left out. Local.
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
pub fn partition_of(comm: &Comm, model: &Model<'_>) -> Partition {
    let (mesh, all) = (&model.mesh, &model.stepper.problem.all);
    let column = &mesh.column;
    let mut cut = 0;
    for cell in &mesh.cells {
        let place = column.cell_place(*cell);
        for side in model.sides.iter().filter(|s| s.cell_is_secondary(column, place)) {
            let facing = side.facing_cells(column, place);
            let elsewhere = |c: &&u64| mesh.cells.binary_search(c).is_err();
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
