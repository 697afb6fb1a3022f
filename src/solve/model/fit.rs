//! Whether what is prescribed on the mesh of a file finds what it needs there.

mod fluid;

use super::special::{Carriers, special_of};
use crate::case::Case;
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::interface::{Heirs, Multipliers, Sides, lost_facets};
use crate::mesh::LocalMesh;
use crate::space::{AtNode, Prescribed};

/// Refuses loads on groups without facets, and fluid where there are no pores. Collective.
///
/// # Errors
/// `Input` that names the entry.
pub fn check(comm: &Comm, case: &Case, mesh: &LocalMesh) -> Result<()> {
    if !mesh.is_of_file() {
        return Ok(());
    }
    loads(case, mesh, |count| comm.sum_u64(count))?;
    fluid::check(comm, case, mesh)
}

/// As `check`, of a mesh that one rank holds whole; refuses also facets of interfaces at which
/// nothing would hold. Local.
///
/// # Errors
/// `Input` that names the entry, or the interface and the place.
pub fn check_whole(
    case: &Case,
    mesh: &LocalMesh,
    sides: &[Sides],
    prescribed: &Prescribed,
) -> Result<()> {
    if !mesh.is_of_file() {
        return Ok(());
    }
    loads(case, mesh, |count| count)?;
    let special = special_of(case, mesh, sides, prescribed);
    let carriers = Carriers { mesh, special: &special, prescribed };
    let (fixed, is_lost) = (|name| carriers.fixed(name), |name| carriers.is_lost(name));
    let nodes = Multipliers { fixed: &fixed, is_lost: &is_lost };
    let lost = lost_facets(mesh, sides, &nodes);
    let checked = Heirs::here(mesh, sides, &nodes).check(mesh, sides, &lost);
    checked.map_err(|AtNode(_, error)| error)
}

/// Whether some facets of interfaces in the mesh of a file have no multiplier of their own.
/// Collective.
pub fn has_lost_facets(comm: &Comm, case: &Case, mesh: &LocalMesh, sides: &[Sides]) -> bool {
    let prescribed = Prescribed::new(case);
    let special = special_of(case, mesh, sides, &prescribed);
    let carriers = Carriers { mesh, special: &special, prescribed: &prescribed };
    let (fixed, is_lost) = (|name| carriers.fixed(name), |name| carriers.is_lost(name));
    let nodes = Multipliers { fixed: &fixed, is_lost: &is_lost };
    comm.any(mesh.is_of_file() && !lost_facets(mesh, sides, &nodes).is_empty())
}

/// As local or collective as the `sum` over ranks is.
fn loads(case: &Case, mesh: &LocalMesh, sum: impl Fn(u64) -> u64) -> Result<()> {
    for (number, entry) in case.boundary.iter().enumerate() {
        let is_load = entry.traction.iter().chain([&entry.normal_traction]).any(Option::is_some);
        if !is_load && entry.normal_displacement.is_none() {
            continue;
        }
        let facets = mesh.on_surface(case.surface_bit(&entry.on)).len();
        if sum(facets as u64) == 0 {
            let what = if is_load { "a traction" } else { "a displacement along the normal" };
            return Err(Error::Input(format!(
                "boundary.{number} ({}): {what} acts on facets of the outer surface, of which the \
                 group has none: its elements are edges, points or nodes, or lie inside the mesh",
                entry.on.name()
            )));
        }
    }
    Ok(())
}
