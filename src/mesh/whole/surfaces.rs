//! Named surfaces: found before the mesh is cut, with their nodes afterwards.

use super::cells::Cells;
use super::cut::Copies;
use super::facet::WholeFacet;
use super::facets::slot;
use super::lips::sorted;
use super::plan::Known;
use super::types::{WholeMesh, WholeSurface};
use super::words::{count, wrong};
use crate::error::Result;

/// The name that stands for every node where no group of facets, edges or nodes has it.
const ALL: &str = "all";

/// A surface before the mesh is cut.
pub enum Found {
    /// Facets with the cells on both sides.
    Facets(Vec<WholeFacet>),
    /// Nodes of edges, points or groups of nodes.
    Nodes(Vec<u32>),
    /// Every node.
    All,
}

/// Finds a surface.
///
/// # Errors
/// `Input` for a group that is not there, has cells, or lies on no cell.
pub fn find(known: &Known, name: &str) -> Result<Found> {
    let whose = format!("surface `{name}`");
    let dim = known.cells.dim();
    let (group, of_group) = match known.groups.of_surface(name, &whose) {
        Ok(found) => found,
        Err(_) if name == ALL => return Ok(Found::All),
        Err(error) => return Err(error),
    };
    if of_group + 1 == dim {
        let found = known.groups.facets(group, known.cells, known.table, known.scale)?;
        return Ok(Found::Facets(found.into_iter().flat_map(|facet| facet.facets()).collect()));
    }
    let nodes = known.groups.nodes(group, of_group, known.cells, known.scale)?;
    if nodes.is_empty() {
        return Err(wrong(format!("{whose}: no node of the group belongs to a cell")));
    }
    Ok(Found::Nodes(nodes))
}

/// The surface after cutting; `mates` are the pairs of facets that are left.
pub fn finish(
    cells: &Cells,
    mates: &[u32],
    copies: &Copies,
    name: &str,
    found: Found,
    remarks: &mut Vec<String>,
) -> WholeSurface {
    let facets = match found {
        Found::All => {
            let nodes = (0..cells.points.len() as u32).collect();
            return WholeSurface { facets: Vec::new(), nodes };
        }
        Found::Nodes(nodes) => {
            let nodes = sorted(nodes.into_iter().flat_map(|node| copies.of(node)).collect());
            return WholeSurface { facets: Vec::new(), nodes };
        }
        Found::Facets(facets) => facets,
    };
    let view = cells.view();
    let nodes = sorted(facets.iter().flat_map(|facet| view.facet_nodes(*facet)).collect());
    let all = facets.len();
    let is_outer = |facet: &WholeFacet| mates[slot(*facet)] == super::cells::NONE;
    let facets: Vec<WholeFacet> = facets.into_iter().filter(is_outer).collect();
    // Facets inside came from both cells.
    let inside = (all - facets.len()) / 2;
    if inside > 0 {
        let lie = if inside == 1 { "lies" } else { "lie" };
        remarks.push(format!(
            "surface `{name}`: {} {lie} inside the body, where only nodes can be prescribed",
            count(inside, "facet")
        ));
    }
    WholeSurface { facets, nodes }
}

impl WholeMesh {
    /// Which surfaces hold all nodes of some of the facets, and of all of them.
    pub(in crate::mesh) fn surfaces_of(&self, facets: &[WholeFacet]) -> [u128; 2] {
        let (mut some, mut all) = (0, 0);
        for (place, surface) in self.surfaces.iter().enumerate() {
            let is_on = |facet: &WholeFacet| {
                self.facet_nodes(*facet).all(|node| surface.nodes.binary_search(&node).is_ok())
            };
            some |= u128::from(facets.iter().any(is_on)) << place;
            all |= u128::from(!facets.is_empty() && facets.iter().all(is_on)) << place;
        }
        [some, all]
    }
}
