//! Facets of interfaces before the mesh is cut: found, checked, and turned to one side.

use std::collections::HashMap;

use super::cells::Cells;
use super::facet::WholeFacet;
use super::facets::{FacetTable, slot};
use super::groups::{FoundFacet, Groups};
use super::orient::orient;
use super::request::{InterfacePlace, InterfaceRequest};
use super::words::{count, place, wrong};
use crate::error::Result;

/// The facets of an interface.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Facets of the lower and the upper lip.
    pub lips: [Vec<WholeFacet>; 2],
    /// Whether the mesh is cut there: then the lips are pairs of facets.
    pub is_cut: bool,
}

/// What is known when interfaces are planned.
pub struct Known<'a> {
    pub cells: &'a Cells,
    pub table: &'a FacetTable,
    pub groups: &'a Groups<'a>,
    pub scale: f64,
}

/// Plans all interfaces.
///
/// # Errors
/// `Input` for groups that are not there, facets that do not lie inside (`on`) or at the boundary
/// (`between`), lips that share nodes, facets of two interfaces, and surfaces with one side.
pub fn plan(
    known: &Known,
    requests: &[InterfaceRequest],
    remarks: &mut Vec<String>,
) -> Result<Vec<Plan>> {
    let mut owners: HashMap<usize, usize> = HashMap::new();
    let mut plans = Vec::new();
    for (index, request) in requests.iter().enumerate() {
        let name = &request.name;
        let plan = match &request.place {
            InterfacePlace::On { group, flip } => plan_on(known, name, group, *flip, remarks)?,
            InterfacePlace::Between { lower, upper, .. } => {
                let lower = boundary(known, name, lower)?;
                let upper = boundary(known, name, upper)?;
                check_apart(known.cells, name, [&lower, &upper])?;
                Plan { lips: [lower, upper], is_cut: false }
            }
        };
        for facet in plan.lips.iter().flatten() {
            if let Some(other) = owners.insert(slot(*facet), index) {
                return Err(wrong(format!(
                    "interfaces `{}` and `{name}` have a facet in common: {}; leave it to one of \
                     them",
                    requests[other].name,
                    known.cells.describe_facet(*facet)
                )));
            }
        }
        plans.push(plan);
    }
    Ok(plans)
}

/// The facets of a group inside the mesh, with normals made one.
fn plan_on(
    known: &Known,
    name: &str,
    group: &str,
    flip: bool,
    remarks: &mut Vec<String>,
) -> Result<Plan> {
    let whose = format!("interface `{name}`");
    let index = known.groups.of_facets(group, &whose)?;
    let found = known.groups.facets(index, known.cells, known.table, known.scale)?;
    let outer: Vec<&FoundFacet> = found.iter().filter(|facet| facet.facets().count() < 2).collect();
    if let Some(first) = outer.first().and_then(|facet| facet.facets().next()) {
        return Err(wrong(format!(
            "{whose}: {} on the boundary of the mesh, of its group `{group}`, the first being {}; \
             an interface `on` a group lies inside a mesh that shares its nodes. Where bodies \
             share none, give both sides with `between: [LOWER, UPPER]`; where another program \
             split the mesh there, give the mesh as it was before",
            count(outer.len(), "facet") + if outer.len() == 1 { " lies" } else { " lie" },
            known.cells.describe_facet(first)
        )));
    }
    let pairs: Vec<[WholeFacet; 2]> =
        found.iter().filter_map(|f| Some([f.sides[0]?, f.sides[1]?])).collect();
    let own: Vec<WholeFacet> = pairs.iter().map(|pair| pair[0]).collect();
    let turned = orient(known.cells.view(), &own).map_err(|facet| {
        wrong(format!(
            "{whose}: its group `{group}` has one side only, as a Moebius strip has, seen at {}; \
             cut it into two interfaces",
            known.cells.describe_facet(facet)
        ))
    })?;
    let count_turned = turned.iter().filter(|turned| **turned).count();
    if count_turned > 0 {
        remarks.push(format!(
            "{whose}: {} of {} were turned, so that the normals are one over each piece",
            count_turned,
            count(turned.len(), "facet")
        ));
    }
    let mut lips = [Vec::new(), Vec::new()];
    for ([one, other], turned) in pairs.into_iter().zip(turned) {
        let is_lower = turned == flip;
        lips[0].push(if is_lower { one } else { other });
        lips[1].push(if is_lower { other } else { one });
    }
    Ok(Plan { lips, is_cut: true })
}

/// The facets of a group on the boundary of the mesh.
fn boundary(known: &Known, name: &str, group: &str) -> Result<Vec<WholeFacet>> {
    let whose = format!("interface `{name}`");
    let index = known.groups.of_facets(group, &whose)?;
    let found = known.groups.facets(index, known.cells, known.table, known.scale)?;
    let inner: Vec<&FoundFacet> = found.iter().filter(|facet| facet.facets().count() > 1).collect();
    if let Some(first) = inner.first().and_then(|facet| facet.facets().next()) {
        return Err(wrong(format!(
            "{whose}: {} between two cells that share their nodes, of its group `{group}`, the \
             first being {}; make the interface `on: {group}`, which cuts the mesh there",
            count(inner.len(), "facet") + if inner.len() == 1 { " lies" } else { " lie" },
            known.cells.describe_facet(first)
        )));
    }
    Ok(found.into_iter().flat_map(FoundFacet::facets).collect())
}

/// Refuses lips that share nodes.
fn check_apart(cells: &Cells, name: &str, lips: [&[WholeFacet]; 2]) -> Result<()> {
    let view = cells.view();
    let [lower, upper] = lips.map(|lip| {
        let mut nodes: Vec<u32> = lip.iter().flat_map(|f| view.facet_nodes(*f)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    });
    let common: Vec<u32> =
        lower.into_iter().filter(|node| upper.binary_search(node).is_ok()).collect();
    let Some(first) = common.first() else { return Ok(()) };
    Err(wrong(format!(
        "interface `{name}`: its two sides share {}, the first at {}; sides `between` which an \
         interface lies share none. Where another program split the mesh along a crack, it left \
         tips shut and crossings hinged: give the mesh as it was before, with the crack as a group \
         of facets, and `on: GROUP`",
        count(common.len(), "node"),
        place(cells.points[*first as usize])
    )))
}
