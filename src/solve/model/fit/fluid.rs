//! Whether the fluid finds pores where it is to act on the mesh of a file.

use crate::case::Case;
use crate::comm::Comm;
use crate::error::{Error, Result, number_text};
use crate::mesh::{Lip, LocalMesh};
use crate::space::AtNode;

/// Refuses pressures and fluxes on groups without pores, films between lips without, and several
/// viscosities of one fluid. Collective.
///
/// # Errors
/// `Input` that names the entry, or the interface and the place.
pub fn check(comm: &Comm, case: &Case, mesh: &LocalMesh) -> Result<()> {
    if !case.has_pressure() {
        return Ok(());
    }
    let is_porous = |cell: usize| case.materials[mesh.prototype(cell).material].porous.is_some();
    boundary(comm, case, mesh, is_porous)?;
    AtNode::agree(comm, lips(case, mesh, is_porous))?;
    viscosity(comm, case, mesh)
}

/// Collective.
fn boundary(
    comm: &Comm,
    case: &Case,
    mesh: &LocalMesh,
    is_porous: impl Fn(usize) -> bool,
) -> Result<()> {
    let mut has_pores = vec![false; mesh.nodes.names.len()];
    for cell in (0..mesh.cells.len()).filter(|cell| is_porous(*cell)) {
        let corners = mesh.shape(cell).corners().nodes();
        mesh.cell_nodes(cell)[..corners].iter().for_each(|n| has_pores[*n as usize] = true);
    }
    for (number, entry) in case.boundary.iter().enumerate() {
        let bit = case.surface_bit(&entry.on);
        let facets = mesh.on_surface(bit).iter().filter(|f| is_porous(f.cell as usize)).count();
        let nodes = mesh.nodes.marks.iter().zip(&has_pores);
        let nodes = nodes.filter(|(marks, has_pores)| **has_pores && marks.is_on(bit)).count();
        let of_key = [
            ("pressure", entry.pressure.is_some(), nodes, "no corner of a porous cell"),
            (
                "flux",
                entry.flux.is_some(),
                facets,
                "no facet of a porous cell on the outer surface",
            ),
        ];
        for (key, _, found, what) in of_key.into_iter().filter(|(_, given, ..)| *given) {
            if comm.sum_u64(found as u64) == 0 {
                return Err(Error::Input(format!(
                    "boundary.{number}.{key}: {} has {what}; it acts on cells whose material has \
                     porous data (materials.NAME.porous)",
                    entry.on.name()
                )));
            }
        }
    }
    Ok(())
}

/// Local.
fn lips(
    case: &Case,
    mesh: &LocalMesh,
    is_porous: impl Fn(usize) -> bool,
) -> std::result::Result<(), AtNode> {
    let flowing = case.interfaces.iter().enumerate().filter(|(_, i)| i.film.is_some());
    for (index, interface) in flowing {
        for lip in Lip::BOTH {
            let mut facets = mesh.on_lip(index, lip).iter();
            let Some(facet) = facets.find(|facet| !is_porous(facet.cell as usize)) else {
                continue;
            };
            let node = mesh.facet_nodes(*facet).1[0] as usize;
            let [x, y, z] = mesh.nodes.points[node];
            let material = &case.materials[mesh.prototype(facet.cell as usize).material].name;
            let words = format!(
                "interfaces.{index}.fluid: it flows along {} and into both sides, but {material} \
                 on its {} side at ({x:.6}, {y:.6}, {z:.6}) m has no porous data \
                 (materials.{material}.porous)",
                interface.name,
                lip.name()
            );
            return Err(AtNode(mesh.nodes.names[node], Error::Input(words)));
        }
    }
    Ok(())
}

/// One fluid flows along all interfaces and in their sides. Collective.
fn viscosity(comm: &Comm, case: &Case, mesh: &LocalMesh) -> Result<()> {
    let mut most = [f64::NEG_INFINITY; 2];
    let flowing = (0..case.interfaces.len()).filter(|i| case.interfaces[*i].film.is_some());
    for facet in flowing.flat_map(|i| Lip::BOTH.map(|lip| mesh.on_lip(i, lip))).flatten() {
        let material = &case.materials[mesh.prototype(facet.cell as usize).material];
        if let Some(porous) = &material.porous {
            most = [most[0].max(porous.viscosity), most[1].max(-porous.viscosity)];
        }
    }
    comm.max(&mut most);
    let [high, low] = [most[0], -most[1]];
    if high > low {
        return Err(Error::Input(format!(
            "materials: the viscosity is {} in one material beside the interfaces with flow and {} \
             in another: one fluid flows along the interfaces and in their sides",
            number_text(low),
            number_text(high)
        )));
    }
    Ok(())
}
