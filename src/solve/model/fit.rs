//! Whether what is prescribed on the mesh of a file finds what it needs there.

use super::special::{special_at, special_of};
use crate::case::Case;
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::interface::Sides;
use crate::mesh::{Facet, LocalMesh};
use crate::space::{AtNode, Prescribed};

/// Refuses loads on groups without facets, and facets of interfaces none of whose nodes carries a
/// multiplier: nothing would hold there. Collective.
///
/// # Errors
/// `Input` that names the entry, or the interface and the place.
pub fn check(
    comm: &Comm,
    case: &Case,
    mesh: &LocalMesh,
    sides: &[Sides],
    prescribed: &Prescribed,
) -> Result<()> {
    if !mesh.is_of_file() {
        return Ok(());
    }
    loads(case, mesh, |count| comm.sum_u64(count))?;
    AtNode::agree(comm, facets(case, mesh, sides, prescribed))
}

/// As [`check`], of a mesh that one rank holds whole. Local.
///
/// # Errors
/// As [`check`].
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
    facets(case, mesh, sides, prescribed).map_err(|AtNode(_, error)| error)
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

/// Local.
fn facets(
    case: &Case,
    mesh: &LocalMesh,
    sides: &[Sides],
    prescribed: &Prescribed,
) -> std::result::Result<(), AtNode> {
    let special = special_of(case, mesh, sides, prescribed);
    let is_left_out = |node: u32| {
        let at_odds = special_at(&special, node).is_some_and(|special| special.is_at_odds);
        at_odds || mesh.nodes.marks[node as usize].is_junction
    };
    let is_held = |node: u32| {
        let fixed = match special_at(&special, node) {
            Some(special) => special.fixed,
            None => prescribed.components_of(&mesh.nodes.marks[node as usize]),
        };
        fixed[..mesh.dim()].iter().all(|fixed| *fixed)
    };
    for side in sides {
        for facet in mesh.on_lip(side.interface, side.secondary) {
            let (_, nodes) = mesh.facet_nodes(*facet);
            let is_empty = nodes.iter().all(|node| is_left_out(*node) || is_held(*node));
            let any_left_out = nodes.iter().any(|node| is_left_out(*node) && !is_held(*node));
            if is_empty && any_left_out && !is_shut(mesh, side, *facet) {
                return Err(without_multipliers(case, mesh, side, &nodes));
            }
        }
    }
    Ok(())
}

/// Whether both sides share all nodes of a facet, beyond the edge of the interface.
fn is_shut(mesh: &LocalMesh, side: &Sides, facet: Facet) -> bool {
    let (_, nodes) = mesh.facet_nodes(facet);
    let is_own = |name: &u64| nodes.iter().any(|node| mesh.nodes.names[*node as usize] == *name);
    let across = mesh.across(side.interface, side.secondary, facet);
    across.iter().any(|far| far.nodes.iter().all(is_own))
}

fn without_multipliers(case: &Case, mesh: &LocalMesh, side: &Sides, nodes: &[u32]) -> AtNode {
    let node = nodes[0] as usize;
    let [x, y, z] = mesh.nodes.points[node];
    AtNode(
        mesh.nodes.names[node],
        Error::Input(format!(
            "interface {}: no node of its facet at ({x:.6}, {y:.6}, {z:.6}) m can carry a traction: \
             interfaces meet or end at them, or displacements are prescribed there that are neither \
             along nor across the interface; have at least two facets there, or take \
             mesh.raise_order: 2",
            case.interfaces[side.interface].name
        )),
    )
}
