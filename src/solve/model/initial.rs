//! The state of interfaces at the start, node by node.

use crate::assembly::Discretization;
use crate::case::{Case, NodeStart};
use crate::comm::Comm;
use crate::error::Result;
use crate::space::AtNode;

/// The states of nodes at the start, given as interface, name and place. Local.
///
/// # Errors
/// At the first node where a formula gives what cannot be, naming entry and place.
pub fn starts(
    case: &Case,
    nodes: impl Iterator<Item = (usize, u64, [f64; 3])>,
) -> std::result::Result<Vec<NodeStart>, AtNode> {
    let start = |(interface, node, point): (usize, u64, [f64; 3])| {
        let of = case.interfaces[interface].start_at(interface, point);
        of.map_err(|error| AtNode(node, error))
    };
    nodes.map(start).collect()
}

/// Interfaces, names and places of the owned secondary nodes. Local.
pub(in crate::solve) fn places(
    all: &Discretization,
) -> impl Iterator<Item = (usize, u64, [f64; 3])> {
    all.secondary[..all.owned_secondary()].iter().map(|rows| {
        let node = rows.node as usize;
        (rows.interface, all.nodes.names[node], all.nodes.points[node])
    })
}

/// Whether each interface holds its bodies together at the start, anywhere. Collective.
///
/// # Errors
/// As [`starts`].
pub(in crate::solve) fn joins(comm: &Comm, case: &Case, all: &Discretization) -> Result<Vec<bool>> {
    let starts = AtNode::agree(comm, starts(case, places(all)))?;
    let mut joins = vec![0.0; case.interfaces.len()];
    for ((interface, ..), start) in places(all).zip(starts) {
        if case.interfaces[interface].joins_with(start.damage) {
            joins[interface] = 1.0;
        }
    }
    comm.max(&mut joins);
    let known = case.interfaces.iter().map(|interface| interface.joins_at_start());
    Ok(known.zip(joins).map(|(known, joins)| known.unwrap_or(joins > 0.0)).collect())
}
