//! The solver over several levels of meshes.

use super::model::linear::eliminates_coarsest;
use super::problem::block_tangent::BlockTangent;
use crate::error::Result;
use crate::multigrid::Hierarchy;
use crate::petsc::{KspSetup, Matrix, Snes};
use crate::runtime::Runtime;

/// The solver with levels of multigrid: a cycle of our own, or PETSc's where the user chooses a
/// preconditioner or the levels do not serve. Collective.
pub(super) fn with_levels(
    runtime: &Runtime,
    prefix: &str,
    axes: &'static [usize],
    matrix: Matrix,
    setup: &KspSetup,
    hierarchy: &mut Hierarchy,
) -> Result<Snes> {
    let (comm, petsc) = (&runtime.comm, &runtime.petsc);
    if petsc.has_option(&format!("{prefix}pc_type"))? || !hierarchy.serves_in_single_precision(comm)
    {
        hierarchy.assemble_coarsest(comm, petsc)?;
        let snes = Snes::with_levels(petsc, prefix, matrix, setup, &hierarchy.levels())?;
        hierarchy.take_smoothers(snes.smoothers()?);
        return Ok(snes);
    }
    // Before the preset's options are there too.
    let all = hierarchy.coarsest();
    let mut unknowns = [(all.nodes.owned * all.dim) as f64];
    comm.sum(&mut unknowns);
    let of_coarsest = format!("{prefix}mg_coarse_");
    let is_asked = petsc.has_option(&format!("{of_coarsest}pc_type"))?;
    let mut snes = Snes::new(petsc, prefix, matrix, &setup.with("pc_type", "shell"))?;
    let cycle = if is_asked || eliminates_coarsest(all.dim, unknowns[0]) {
        hierarchy.own_cycle(comm, petsc, &of_coarsest)?
    } else {
        let blocks = BlockTangent::new(comm, all, axes, hierarchy.coarsest_identity())?;
        hierarchy.own_cycle_above(comm, Box::new(blocks))
    };
    snes.precondition_by(cycle)?;
    Ok(snes)
}
