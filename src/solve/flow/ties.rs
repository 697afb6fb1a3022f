//! What gives both lips of an interface along which fluid flows one pressure.

use std::collections::BTreeMap;

use super::pressures::{Pressures, flowing};
use crate::assembly::Tie;
use crate::case::Case;
use crate::comm::Comm;
use crate::error::Result;
use crate::interface::{JumpRows, Multipliers, Sides, jump_rows};
use crate::mesh::{FarFacet, Lip, LocalMesh};
use crate::space::{Directory, Nodes};

/// Corners of both sides that are closer than this part of the facet's size are at one place.
const AT_ONE_PLACE: f64 = 1e-9;

/// A pressure that follows from others, by the names of the nodes.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::solve) struct NamedTie {
    node: u64,
    /// Whose pressures, and their parts.
    pub follows: Vec<(u64, f64)>,
}

/// The ties of the nodes of this rank's cells: secondary lips follow primary ones, and where
/// interfaces with fluid meet all copies of a node have one pressure. Collective.
///
/// # Errors
/// `Input` when the primary side does not cover the secondary side.
pub(in crate::solve) fn named_ties(
    comm: &Comm,
    case: &Case,
    sides: &[Sides],
    pressures: &Pressures<'_>,
    directory: &Directory<'_>,
) -> Result<Vec<NamedTie>> {
    let sides: Vec<Sides> = flowing(case, sides).map(|(_, side)| *side).collect();
    if sides.is_empty() {
        return Ok(Vec::new());
    }
    let nodes = &pressures.corners.nodes;
    let is_known = |node: usize| pressures.prescribed.entry_of(&nodes.marks[node]).is_some();
    let fixed = |name: u64| {
        let node = nodes.number(name).expect("a corner of the rank's own cell");
        [is_known(node) || nodes.marks[node].is_junction, false, false]
    };
    let multipliers = Multipliers { fixed: &fixed, is_lost: &|_| false };
    let (rows, _) = jump_rows(comm, pressures.corners, &sides, 1, &multipliers, directory)?;
    let leaders = leaders(comm, pressures, &sides);
    let leader_of = |name: u64| leaders.get(&name).copied().unwrap_or(name);
    let mut ties: Vec<NamedTie> = rows.iter().filter_map(|row| of_row(row, leader_of)).collect();
    for (node, name) in nodes.names.iter().enumerate() {
        if let Some(leader) = leaders.get(name)
            && !is_known(node)
        {
            ties.push(NamedTie { node: *name, follows: vec![(*leader, 1.0)] });
        }
    }
    Ok(ties)
}

/// The tie that a row is.
fn of_row(rows: &JumpRows<u64>, leader_of: impl Fn(u64) -> u64) -> Option<NamedTie> {
    let row = rows.rows[0].as_ref()?;
    let mut follows: Vec<(u64, f64)> = Vec::new();
    for (name, a) in &row.others {
        let name = leader_of(*name);
        match follows.iter_mut().find(|(other, _)| *other == name) {
            Some((_, part)) => *part -= a / row.own,
            None => follows.push((name, -a / row.own)),
        }
    }
    // Both copies of a node between two kept ones cancel.
    follows.retain(|(_, part)| *part != 0.0);
    Some(NamedTie { node: rows.node, follows })
}

/// The node whose pressure others have that lie where interfaces with fluid meet, by their names:
/// the lowest one whose pressure is prescribed, else the lowest one. Collective.
fn leaders(comm: &Comm, pressures: &Pressures<'_>, sides: &[Sides]) -> BTreeMap<u64, u64> {
    let mesh = pressures.corners;
    if !mesh.is_of_file() {
        return BTreeMap::new();
    }
    let mut pairs: Vec<u64> = sides.iter().flat_map(|side| pairs(mesh, side)).flatten().collect();
    let of_junctions = mesh.nodes.iter().filter(|(_, _, marks)| marks.is_junction);
    let known = of_junctions.filter(|(_, _, m)| pressures.prescribed.entry_of(m).is_some());
    // A pair of a node with itself tells that its pressure is prescribed.
    pairs.extend(known.flat_map(|(name, ..)| [name, name]));
    let told = comm.exchange(&vec![pairs; comm.size() as usize]);
    let all: Vec<[u64; 2]> =
        told.iter().flat_map(|list| list.as_chunks::<2>().0.to_vec()).collect();
    let mut groups = Groups::default();
    all.iter().for_each(|[a, b]| groups.join(*a, *b));
    let mut leader: BTreeMap<u64, u64> = BTreeMap::new();
    for [name, _] in all.iter().filter(|[a, b]| a == b) {
        let of_group = leader.entry(groups.first(*name)).or_insert(*name);
        *of_group = (*of_group).min(*name);
    }
    let members: Vec<u64> = groups.parent.keys().copied().collect();
    let lead = |name: u64| {
        let first = groups.first(name);
        (name, leader.get(&first).copied().unwrap_or(first))
    };
    members.into_iter().map(lead).filter(|(name, leader)| name != leader).collect()
}

/// The corners of both sides that lie at one place and carry no multiplier.
fn pairs(mesh: &LocalMesh, side: &Sides) -> Vec<[u64; 2]> {
    let mut found = Vec::new();
    for facet in mesh.on_lip(side.interface, side.secondary) {
        let (_, nodes) = mesh.facet_nodes(*facet);
        let at_junction = nodes.iter().filter(|n| mesh.nodes.marks[**n as usize].is_junction);
        let own: Vec<u32> = at_junction.copied().collect();
        if own.is_empty() {
            continue;
        }
        let across = mesh.across(side.interface, side.secondary, *facet);
        for node in own {
            let name = mesh.nodes.names[node as usize];
            let near = across.iter().flat_map(|far| near(far, mesh.nodes.points[node as usize]));
            found.extend(near.filter(|other| *other != name).map(|other| [name, other]));
        }
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// The nodes of a facet at a place.
fn near(far: &FarFacet, at: [f64; 3]) -> impl Iterator<Item = u64> {
    let square = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>();
    let size = far.points.iter().map(|x| square(x, &far.points[0])).fold(0.0, f64::max);
    let is_there = move |x: &[f64; 3]| square(x, &at) <= AT_ONE_PLACE * AT_ONE_PLACE * size;
    let places = far.nodes.iter().zip(&far.points);
    places.filter(move |(_, point)| is_there(point)).map(|(name, _)| *name)
}

/// Sets of names that belong together.
#[derive(Default)]
struct Groups {
    /// Of each name one below it in its set, or itself.
    parent: BTreeMap<u64, u64>,
}

impl Groups {
    fn join(&mut self, a: u64, b: u64) {
        [a, b].into_iter().for_each(|name| {
            self.parent.entry(name).or_insert(name);
        });
        let (low, high) = (self.first(a).min(self.first(b)), self.first(a).max(self.first(b)));
        self.parent.insert(high, low);
    }

    /// The lowest name of the set.
    fn first(&self, name: u64) -> u64 {
        let mut at = name;
        while let Some(below) = self.parent.get(&at).filter(|below| **below != at) {
            at = *below;
        }
        at
    }
}

/// The ties over local nodes. Local.
pub(in crate::solve) fn ties(named: &[NamedTie], nodes: &Nodes) -> (Vec<Tie>, Vec<Option<u32>>) {
    let local = |name: u64| nodes.local(name).expect("the row's nodes are held");
    let mut tie_of = vec![None; nodes.len()];
    let mut ties = Vec::new();
    for tie in named {
        let node = local(tie.node);
        let follows = tie.follows.iter().map(|(n, a)| (local(*n), *a)).collect();
        tie_of[node as usize] = Some(ties.len() as u32);
        ties.push(Tie { node, follows });
    }
    (ties, tie_of)
}

/// The local nodes on the lips from which fluid flows into the pores: each with its side, twice the
/// index of the interface and one more for the upper side, and the share of the side in it. A node
/// on several lips belongs to all of them alike. Collective.
pub(in crate::solve) fn on_lips(
    case: &Case,
    pressures: &Pressures<'_>,
    nodes: &Nodes,
) -> Vec<(u32, usize, f64)> {
    let (mesh, prescribed) = (pressures.corners, pressures.prescribed);
    if !mesh.is_of_file() {
        let side = |(node, marks)| {
            let (interface, lip) = prescribed.lip_of(marks)?;
            Some((node as u32, 2 * interface + lip.index(), 1.0))
        };
        return nodes.marks.iter().enumerate().filter_map(side).collect();
    }
    let mut all = Vec::new();
    let feeding = (0..case.interfaces.len()).filter(|i| case.has_flux(&case.interfaces[*i]));
    for interface in feeding {
        for lip in Lip::BOTH {
            let mut is_on = vec![0.0; nodes.len()];
            for facet in mesh.on_lip(interface, lip) {
                for node in mesh.facet_nodes(*facet).1 {
                    // Cells without pores have no such nodes.
                    if let Some(node) = nodes.local(mesh.nodes.names[node as usize]) {
                        is_on[node as usize] = 1.0;
                    }
                }
            }
            nodes.add_to_owners(&mut is_on, 1);
            nodes.update_ghosts(&mut is_on, 1);
            let there = (0_u32..).zip(is_on).filter(|(_, is_on)| *is_on > 0.0);
            all.extend(there.map(|(node, _)| (node, 2 * interface + lip.index(), 1.0)));
        }
    }
    let mut count = vec![0.0; nodes.len()];
    all.iter().for_each(|(node, ..)| count[*node as usize] += 1.0);
    all.iter_mut().for_each(|(node, _, share)| *share /= count[*node as usize]);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_of_a_set_is_found_however_it_grew() {
        let mut groups = Groups::default();
        [[9, 5], [7, 3], [5, 7], [20, 21]].into_iter().for_each(|[a, b]| groups.join(a, b));
        assert_eq!([3, 5, 7, 9, 20, 21].map(|n| groups.first(n)), [3, 3, 3, 3, 20, 20]);
    }

    #[test]
    fn copies_of_one_pressure_cancel_in_a_row() {
        let row = crate::interface::JumpRow {
            weight: 1.0,
            own: 2.0,
            others: vec![(4, -2.0), (8, 0.25), (9, -0.25)],
        };
        let rows = JumpRows { node: 1, interface: 0, components: 1, rows: [Some(row), None, None] };
        let tie = of_row(&rows, |name| if name == 9 { 8 } else { name });
        assert_eq!(tie, Some(NamedTie { node: 1, follows: vec![(4, 1.0)] }));
    }
}
