//! The gaps of interfaces before anything moves.

use crate::assembly::Discretization;
use crate::case::Case;
use crate::comm::Comm;
use crate::interface::{JumpRows, Sides};

/// What is given at the owned secondary nodes.
pub struct NodeData {
    /// As [`InterfaceState::factors`](super::InterfaceState).
    pub factors: Vec<f64>,
    /// As [`InterfaceState::gaps`](super::InterfaceState); 0 where the normal component has no
    /// multiplier.
    pub gaps: Vec<f64>,
}

/// Gaps below this part of the size of facets are those of coordinates with few digits.
const CLOSE: f64 = 1e-6;

/// The gap of each owned secondary node (m): the jump of the positions along the normal, weighted
/// as that of the displacement is; negative where the sides have come into each other. 0 at
/// interfaces whose sides are taken for lying on each other, and where the normal component has no
/// multiplier. Local.
pub fn gaps(all: &Discretization, sides: &[Sides], axes: &[usize]) -> Vec<f64> {
    let owned = all.secondary[..all.owned_secondary()].iter();
    owned
        .map(|rows| if sides[rows.interface].has_gap { gap(all, rows, axes) } else { 0.0 })
        .collect()
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
