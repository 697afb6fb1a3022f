//! Interfaces of a mesh that was cut: which nodes face each other, tips, junctions, normals.

use super::cells::Cells;
use super::cut::Copies;
use super::facet::WholeFacet;
use super::normals::{Measure, averaged};
use super::plan::Plan;
use super::request::{InterfacePlace, InterfaceRequest};
use super::types::{Facing, MAX_FACET_NODES, WholeInterface};
use super::view::View;
use super::words::{count, place, wrong};
use crate::error::Result;

/// More sectors than an interface has sides.
const CROSSED: usize = 3;

/// Makes the interfaces.
///
/// # Errors
/// `Input` for an interface that cuts nothing.
pub fn make(
    cells: &Cells,
    copies: &Copies,
    plans: Vec<Plan>,
    requests: &[InterfaceRequest],
    remarks: &mut Vec<String>,
) -> Result<Vec<WholeInterface>> {
    let view = cells.view();
    let shared = shared_nodes(view, copies, &plans);
    let mut interfaces = Vec::new();
    for (plan, request) in plans.into_iter().zip(requests) {
        let faces = if plan.is_cut { facing(view, copies, &plan) } else { Vec::new() };
        let tips = tips(view, &plan, &faces);
        let nodes = plan.lips.each_ref().map(|lip| {
            let nodes = lip.iter().flat_map(|facet| view.facet_nodes(*facet)).collect();
            sorted(nodes)
        });
        let is_shut = |node: &u32| tips.binary_search(node).is_ok();
        if plan.is_cut && nodes[0].iter().all(is_shut) {
            return Err(wrong(format!(
                "interface `{}` cuts nothing: all nodes of its facets lie on its own edge inside \
                 the mesh, which stays shut, as at {}; mesh it with at least two facets across",
                request.name,
                cells.describe_facet(plan.lips[0][0])
            )));
        }
        remarks.extend(remark_on_shut_facets(view, &plan, &tips, &request.name));
        let junctions = junctions(copies, &nodes, &shared);
        let normals = if plan.is_cut {
            normals_of_pairs(view, copies, &plan, &nodes)
        } else {
            normals_of_sides(view, &plan)
        };
        let has_gap = matches!(request.place, InterfacePlace::Between { has_gap: true, .. });
        let lips = plan.lips;
        interfaces.push(WholeInterface { lips, faces, tips, junctions, has_gap, normals });
    }
    Ok(interfaces)
}

/// Says which facets of an interface cannot open, as all their nodes are tips.
fn remark_on_shut_facets(view: View<'_>, plan: &Plan, tips: &[u32], name: &str) -> Option<String> {
    let is_shut = |facet: &&WholeFacet| {
        !tips.is_empty() && view.facet_nodes(**facet).all(|node| tips.binary_search(&node).is_ok())
    };
    let shut: Vec<&WholeFacet> = plan.lips[0].iter().filter(is_shut).collect();
    let first = shut.first()?;
    let lie = if shut.len() == 1 { "lies" } else { "lie" };
    Some(format!(
        "interface `{name}`: {} with all nodes on its edge inside the mesh {lie} shut, the first \
         at {}; a finer mesh there makes them smaller",
        count(shut.len(), "facet"),
        place(view.facet_centre(**first))
    ))
}

/// Nodes before cutting that lie on more than one interface, rising.
fn shared_nodes(view: View<'_>, copies: &Copies, plans: &[Plan]) -> Vec<u32> {
    let mut found = Vec::new();
    for plan in plans {
        let facets = plan.lips.iter().flatten();
        let nodes = facets.flat_map(|facet| view.facet_nodes(*facet));
        found.extend(sorted(nodes.map(|node| copies.origin(node)).collect()));
    }
    found.sort_unstable();
    let twice = found.chunk_by(|a, b| a == b).filter(|run| run.len() > 1);
    twice.map(|run| run[0]).collect()
}

fn facing(view: View<'_>, copies: &Copies, plan: &Plan) -> Vec<Facing> {
    let [lower, upper] = &plan.lips;
    let pair = |(lower, upper): (&_, &_)| {
        let mut order = [0; MAX_FACET_NODES];
        for (place, node) in order.iter_mut().zip(view.facet_nodes(*lower)) {
            let mut others = view.facet_nodes(*upper);
            let is_same = |other| copies.origin(other) == copies.origin(node);
            *place = others.position(is_same).unwrap_or_default() as u8;
        }
        Facing { order }
    };
    lower.iter().zip(upper).map(pair).collect()
}

/// Nodes that face themselves.
fn tips(view: View<'_>, plan: &Plan, faces: &[Facing]) -> Vec<u32> {
    let mut found = Vec::new();
    for ((lower, upper), facing) in plan.lips[0].iter().zip(&plan.lips[1]).zip(faces) {
        let mut row = [0; MAX_FACET_NODES];
        row.iter_mut().zip(view.facet_nodes(*upper)).for_each(|(place, node)| *place = node);
        let pairs = view.facet_nodes(*lower).zip(facing.order);
        found.extend(pairs.filter(|(n, to)| row[*to as usize] == *n).map(|(n, _)| n));
    }
    sorted(found)
}

/// Nodes of the lips with more than two sectors, or on another interface, or with a copy on both
/// lips that is cut.
fn junctions(copies: &Copies, nodes: &[Vec<u32>; 2], shared: &[u32]) -> Vec<u32> {
    let on_both = nodes[0].iter().filter(|node| nodes[1].binary_search(node).is_ok());
    let origins = on_both.map(|node| copies.origin(*node));
    let folded = sorted(origins.filter(|origin| copies.sectors(*origin) > 1).collect());
    let is_junction = |node: &u32| {
        let origin = copies.origin(*node);
        copies.sectors(origin) >= CROSSED
            || shared.binary_search(&origin).is_ok()
            || folded.binary_search(&origin).is_ok()
    };
    sorted(nodes.iter().flatten().copied().filter(is_junction).collect())
}

/// The normals of the lower facets at each node, given to all its copies on the lips.
fn normals_of_pairs(
    view: View<'_>,
    copies: &Copies,
    plan: &Plan,
    nodes: &[Vec<u32>; 2],
) -> Vec<(u32, [f64; 3])> {
    let measure = Measure::new();
    let mut parts = Vec::new();
    plan.lips[0].iter().for_each(|facet| measure.add(view, *facet, 1.0, &mut parts));
    parts.iter_mut().for_each(|(node, _)| *node = copies.origin(*node));
    let of_origins = averaged(parts);
    let all = sorted(nodes.iter().flatten().copied().collect());
    let of_node = |node: u32| {
        let place = of_origins.binary_search_by_key(&copies.origin(node), |(node, _)| *node);
        place.ok().map(|place| (node, of_origins[place].1))
    };
    all.into_iter().filter_map(of_node).collect()
}

/// The outward normals of the lower lip, and the inward ones of the upper lip.
fn normals_of_sides(view: View<'_>, plan: &Plan) -> Vec<(u32, [f64; 3])> {
    let measure = Measure::new();
    let mut parts = Vec::new();
    for (lip, sign) in plan.lips.iter().zip([1.0, -1.0]) {
        lip.iter().for_each(|facet| measure.add(view, *facet, sign, &mut parts));
    }
    averaged(parts)
}

/// In rising order, each once.
pub fn sorted(mut nodes: Vec<u32>) -> Vec<u32> {
    nodes.sort_unstable();
    nodes.dedup();
    nodes.shrink_to_fit();
    nodes
}
