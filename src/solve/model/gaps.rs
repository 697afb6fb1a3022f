//! The gaps of interfaces before anything moves.

use crate::assembly::Discretization;
use crate::case::Case;
use crate::comm::Comm;
use crate::interface::{JumpRows, Sides};
use crate::mesh::{Facet, LocalMesh};

/// What is given at the owned secondary nodes.
pub struct NodeData {
    /// As [`InterfaceState::factors`](super::InterfaceState).
    pub factors: Vec<f64>,
    /// As [`InterfaceState::gaps`](super::InterfaceState); 0 where the normal component has no
    /// multiplier.
    pub gaps: Vec<f64>,
    /// Damage from 0 to 1.
    pub damages: Vec<f64>,
}

/// Gaps below this part of the size of facets are those of coordinates with few digits.
const CLOSE: f64 = 1e-6;

/// Gaps up to so many times what the facets of two curved sides cut off are those of the facets.
const BY_FACETS: f64 = 2.0;

/// The gap of each owned secondary node (m): the jump of the positions along the normal, weighted
/// as that of the displacement is; negative where the sides have come into each other. 0 at
/// interfaces whose sides are taken for lying on each other or are nowhere farther apart than their
/// facets cut off the curve, which are told in words, and where the normal component has no
/// multiplier. Collective.
pub fn gaps(
    comm: &Comm,
    case: &Case,
    mesh: &LocalMesh,
    sides: &[Sides],
    all: &Discretization,
) -> (Vec<f64>, Vec<String>) {
    let owned = || all.secondary[..all.owned_secondary()].iter();
    let of = |rows: &JumpRows<u32>| {
        if sides[rows.interface].has_gap { gap(all, rows, case.axes) } else { 0.0 }
    };
    let mut gaps: Vec<f64> = owned().map(of).collect();
    // The widest gap of each interface, and whether one is wider than facets make it.
    let allowed = cut_off_at_nodes(mesh, sides, all);
    let mut most = vec![[0.0_f64; 2]; case.interfaces.len()];
    for (rows, gap) in owned().zip(&gaps) {
        let [widest, is_wider] = &mut most[rows.interface];
        *widest = widest.max(gap.abs());
        if gap.abs() > BY_FACETS * allowed[rows.node as usize] {
            *is_wider = 1.0;
        }
    }
    comm.max(most.as_flattened_mut());
    let is_closed = |interface: usize| most[interface][1] == 0.0;
    let mut words = Vec::new();
    for (interface, [widest, _]) in most.iter().enumerate() {
        if *widest > 0.0 && is_closed(interface) {
            let name = &case.interfaces[interface].name;
            words.push(format!(
                "interface {name}: gaps of up to {widest:.3e} m, no more than the facets of its \
                 curved sides cut off, are taken for closed"
            ));
        }
    }
    words.iter().for_each(|words| tracing::info!("gap        {words}"));
    for (rows, gap) in owned().zip(&mut gaps) {
        *gap = if is_closed(rows.interface) { 0.0 } else { *gap };
    }
    (gaps, words)
}

/// How far arcs bow over the facets of both sides at each owned node of a secondary lip (m): an
/// eighth of the square of a facet's length times the curvature, which the normals at the nodes of
/// its facets tell. 0 where the interface is flat, at one side of a kink too. Collective.
fn cut_off_at_nodes(mesh: &LocalMesh, sides: &[Sides], all: &Discretization) -> Vec<f64> {
    let mut sums = vec![[0.0_f64; 2]; all.nodes.len()];
    for side in sides.iter().filter(|side| side.has_gap) {
        let across = mesh.facts.interfaces[side.interface][side.primary().index()].cell[0];
        for facet in mesh.on_lip(side.interface, side.secondary) {
            let Some((cut_off, nodes)) = cut_off(all, mesh, *facet, across) else { continue };
            for node in nodes {
                let [sum, count] = &mut sums[node as usize];
                (*sum, *count) = (*sum + cut_off, *count + 1.0);
            }
        }
    }
    all.nodes.add_to_owners(sums.as_flattened_mut(), 2);
    let owned = sums[..all.nodes.owned].iter();
    owned.map(|[sum, count]| if *count > 0.0 { sum / count } else { 0.0 }).collect()
}

/// What a facet and one of length `across` (m) on the other side cut off, and the nodes of the
/// facet; none where fewer than two of them have a normal. Local.
fn cut_off(
    all: &Discretization,
    mesh: &LocalMesh,
    facet: Facet,
    across: f64,
) -> Option<(f64, Vec<u32>)> {
    let names = mesh.facet_nodes(facet).1.into_iter().map(|n| mesh.nodes.names[n as usize]);
    let nodes: Vec<u32> = names.filter_map(|name| all.nodes.local(name)).collect();
    let normal_at = |node: &u32| {
        let rows = &all.secondary[all.secondary_of[*node as usize]? as usize];
        rows.rows[all.dim - 1].as_ref()?;
        let normal = all.frames.rotation(*node)[all.dim - 1];
        Some((all.nodes.points[*node as usize], normal))
    };
    let known: Vec<_> = nodes.iter().filter_map(normal_at).collect();
    let distance =
        |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
    let mut most = 0.0_f64;
    for (i, (x, n)) in known.iter().enumerate() {
        for (y, m) in &known[..i] {
            let (length, angle) = (distance(x, y), distance(n, m));
            most = most.max((length.powi(2) + across.powi(2)) * angle / length / 8.0);
        }
    }
    (known.len() > 1).then_some((most, nodes))
}

/// The gaps of the interfaces that have any, in words. Collective.
pub fn gaps_in_words(comm: &Comm, case: &Case, all: &Discretization, gaps: &[f64]) -> Vec<String> {
    // The widest gap and the deepest overlap of each.
    let mut most = vec![[0.0_f64; 2]; case.interfaces.len()];
    for (rows, gap) in all.secondary.iter().zip(gaps) {
        let [widest, deepest] = &mut most[rows.interface];
        (*widest, *deepest) = (widest.max(*gap), deepest.max(-gap));
    }
    comm.max(most.as_flattened_mut());
    let mut words = Vec::new();
    for (interface, [widest, deepest]) in case.interfaces.iter().zip(most) {
        let name = &interface.name;
        if widest > 0.0 {
            words.push(format!("interface {name}: a gap of up to {widest:.3e} m at the start"));
        }
        if deepest > 0.0 {
            words.push(format!(
                "interface {name}: its sides have come into each other by up to {deepest:.3e} m at \
                 the start, which presses them; `gap: closed` takes them for lying on each other"
            ));
        }
    }
    words.iter().for_each(|words| tracing::info!("gap        {words}"));
    words
}

fn gap(all: &Discretization, rows: &JumpRows<u32>, axes: &[usize]) -> f64 {
    let dim = all.dim;
    let Some(row) = &rows.rows[dim - 1] else { return 0.0 };
    // From the node itself, so that places far from the origin lose no digits.
    let origin = all.nodes.points[rows.node as usize];
    let place = |node: u32| {
        let x = all.nodes.points[node as usize];
        std::array::from_fn(|c| axes.get(c).map_or(0.0, |axis| x[*axis] - origin[*axis]))
    };
    let at = |unknown: u32| {
        let (node, component) = (unknown / dim as u32, unknown % dim as u32);
        all.frames.unknowns(node, place)[component as usize]
    };
    let gap = row.trace(rows.own(dim - 1), at);
    let size = row.weight.abs().powf(1.0 / (dim as f64 - 1.0));
    if gap.abs() <= CLOSE * size { 0.0 } else { gap }
}
