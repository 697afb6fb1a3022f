//! The jump of the displacement at the nodes of the secondary side, as rows over nodal values.
//!
//! At node i and component c the jump is g = sum over k of a_k u_k: own coefficient, coefficients
//! of the primary side, and of secondary nodes whose component c is prescribed and which therefore
//! carry no multiplier. An unknown is named by its node and component: the name of the node times
//! the number of components, plus the component. The rows come from the dual mortar basis (Popp,
//! Wohlmuth, Gee, Wall, SIAM J. Sci. Comput. 34, 2012), component by component; the owner of a
//! secondary node owns its rows, and every rank that holds the node has a copy.

use super::facet_terms::{Term, Uncovered, WEIGHT, integrate};
use super::heirs::{Heirs, Multipliers, held_facets, lost_facets};
use super::sides::Sides;
use crate::comm::Comm;
use crate::error::Result;
use crate::mesh::LocalMesh;
use crate::space::{AtNode, Directory};

/// The jump of one component at one secondary node.
#[derive(Debug, Clone, PartialEq)]
pub struct JumpRow<N> {
    /// Integral of the multiplier basis function (m2; 2D: m): the weight of the node.
    pub weight: f64,
    /// Coefficient of the unknown that the row belongs to.
    pub own: f64,
    /// Coefficients of other unknowns.
    pub others: Vec<(N, f64)>,
}

/// A row at work: `own` is the unknown that it belongs to.
impl<N: Copy> JumpRow<N> {
    /// The jump of a field, whose value at an unknown is `at`.
    #[inline]
    pub fn trace(&self, own: N, at: impl Fn(N) -> f64) -> f64 {
        self.own * at(own) + self.trace_of_others(at)
    }

    /// The part of [`JumpRow::trace`] that comes from the other unknowns.
    #[inline]
    pub fn trace_of_others(&self, at: impl Fn(N) -> f64) -> f64 {
        self.others.iter().map(|(other, a)| a * at(*other)).sum()
    }

    /// The transpose of [`JumpRow::trace`]: the forces of one on the jump, given to `add` unknown
    /// by unknown.
    #[inline]
    pub fn spread(&self, own: N, force: f64, mut add: impl FnMut(N, f64)) {
        add(own, self.own * force);
        self.spread_to_others(force, add);
    }

    /// The transpose of [`JumpRow::trace_of_others`].
    #[inline]
    pub fn spread_to_others(&self, force: f64, mut add: impl FnMut(N, f64)) {
        for (other, a) in &self.others {
            add(*other, a * force);
        }
    }

    /// All unknowns with their coefficients, the own one last.
    #[inline]
    pub fn coefficients(&self, own: N) -> impl Iterator<Item = (N, f64)> {
        self.others.iter().copied().chain([(own, self.own)])
    }
}

/// The rows of one secondary node, one per component; none where the component is prescribed.
#[derive(Debug, Clone, PartialEq)]
pub struct JumpRows<N> {
    /// The node.
    pub node: N,
    /// The interface it belongs to.
    pub interface: usize,
    /// Components of the field at every node.
    pub components: usize,
    /// One row per component that has a multiplier.
    pub rows: [Option<JumpRow<N>>; 3],
}

impl<N> JumpRows<N> {
    /// Whether any component has a multiplier.
    pub fn has_multiplier(&self) -> bool {
        self.rows.iter().any(Option::is_some)
    }

    /// The area (2D: length) that counts for the energy of the node: that of the normal component,
    /// else the mean of those that have a multiplier.
    pub fn law_weight(&self, dim: usize) -> f64 {
        if let Some(normal) = &self.rows[dim - 1] {
            return normal.weight;
        }
        let weights = || self.rows.iter().flatten().map(|r| r.weight);
        weights().sum::<f64>() / weights().count().max(1) as f64
    }
}

impl JumpRows<u32> {
    /// The unknown of a component of the node.
    #[inline]
    pub fn own(&self, component: usize) -> u32 {
        self.node * self.components as u32 + component as u32
    }

    /// The nodes of all rows: the secondary node, then each of the others once.
    pub fn nodes(&self) -> Vec<u32> {
        let mut nodes = vec![self.node];
        for (unknown, _) in self.rows.iter().flatten().flat_map(|r| &r.others) {
            let node = unknown / self.components as u32;
            if !nodes.contains(&node) {
                nodes.push(node);
            }
        }
        nodes
    }

    /// Coefficient of an unknown in the jump of a component, 0 where it has none.
    pub fn coefficient(&self, component: usize, unknown: u32) -> f64 {
        let Some(row) = &self.rows[component] else { return 0.0 };
        if unknown == self.own(component) {
            return row.own;
        }
        row.others.iter().find(|(n, _)| *n == unknown).map_or(0.0, |(_, a)| *a)
    }
}

impl JumpRows<u64> {
    /// The names of the nodes of all unknowns but the own ones.
    pub fn names_of_others(&self) -> impl Iterator<Item = u64> {
        let others = self.rows.iter().flatten().flat_map(|row| &row.others);
        others.map(|(unknown, _)| unknown / self.components as u64)
    }

    /// The same rows with the name of every node replaced.
    pub fn renamed(self, new: impl Fn(u64) -> u32) -> JumpRows<u32> {
        let components = self.components;
        let unknown = |name: u64| {
            let (node, component) = (name / components as u64, name % components as u64);
            new(node) * components as u32 + component as u32
        };
        let rename = |row: JumpRow<u64>| JumpRow {
            weight: row.weight,
            own: row.own,
            others: row.others.into_iter().map(|(n, a)| (unknown(n), a)).collect(),
        };
        JumpRows {
            node: new(self.node),
            interface: self.interface,
            components,
            rows: self.rows.map(|row| row.map(rename)),
        }
    }
}

/// The rows of all secondary nodes that this rank's cells touch, by rising name, of a field with so
/// many components; `nodes` tells which of them carry no multiplier.
///
/// With them comes what is to be said of how the sides of the mesh of a file fit each other, the
/// same on every rank. Collective: each rank integrates the facets of its own cells.
///
/// # Errors
/// `Input` when the primary side of a lattice does not cover the secondary side.
pub fn jump_rows(
    comm: &Comm,
    mesh: &LocalMesh,
    sides: &[Sides],
    components: usize,
    nodes: &Multipliers<'_>,
    directory: &Directory<'_>,
) -> Result<(Vec<JumpRows<u64>>, Vec<String>)> {
    let fixed = nodes.fixed;
    let mut terms = comm.agree(integrate(mesh, sides, components, fixed))?;
    let mut uncovered = Uncovered::default();
    while uncovered.grow(comm, directory, mesh.order(), &terms.shares) {
        let without = |name: u64| if uncovered.contains(name) { [true; 3] } else { fixed(name) };
        terms = comm.agree(integrate(mesh, sides, components, &without))?;
    }
    let lost = if mesh.is_of_file() { lost_facets(mesh, sides, nodes) } else { Vec::new() };
    let mut remarks = Vec::new();
    let held = if mesh.is_of_file() { held_facets(mesh, sides, nodes) } else { Vec::new() };
    if mesh.is_of_file() && comm.any(!lost.is_empty() || !held.is_empty()) {
        let without = |name: u64| if uncovered.contains(name) { [true; 3] } else { fixed(name) };
        let nodes = Multipliers { fixed: &without, is_lost: nodes.is_lost };
        let all = [&lost[..], &held[..]].concat();
        let heirs = Heirs::here(mesh, sides, &nodes).everywhere(comm, directory, mesh, &all);
        AtNode::agree(comm, heirs.check(mesh, sides, &lost))?;
        comm.agree(heirs.add_terms(mesh, sides, &all, &mut terms))?;
        let mut silent = heirs.silent(mesh, sides, &held);
        comm.sum(&mut silent);
        let silent = sides.iter().zip(silent).filter(|(_, area)| *area > 0.0);
        remarks.extend(silent.map(|(side, area)| nothing_passes(mesh, side, area)));
    }
    if mesh.is_of_file() && components == mesh.dim() {
        for side in sides {
            let fit = terms.fits[side.interface];
            let name = mesh.facts.names.get(side.interface);
            remarks.extend(fit.words(comm, name.map_or("", String::as_str))?);
        }
    }
    let terms = terms.list;
    let nodes: Vec<(u64, usize)> = mesh
        .nodes
        .iter()
        .filter_map(|(n, _, marks)| Some((n, sides.iter().position(|s| s.is_secondary(marks))?)))
        .collect();
    let received = send_to_owners(comm, directory, &terms);
    let mut rows = sum(received, components, &nodes, &directory.owned);
    let missing: Vec<u64> =
        nodes.iter().map(|n| n.0).filter(|n| directory.owned.binary_search(n).is_err()).collect();
    rows.extend(fetch(comm, directory, &rows, &missing));
    rows.sort_by_key(|r| r.node);
    Ok((rows, remarks))
}

/// Says that no traction passes where the displacement of a secondary side is prescribed.
fn nothing_passes(mesh: &LocalMesh, side: &Sides, area: f64) -> String {
    let name = mesh.facts.names.get(side.interface).map_or("", String::as_str);
    let unit = if mesh.dim() == 3 { "m2" } else { "m" };
    format!(
        "interface {name}: the displacement of {area:.4e} {unit} of its secondary side is \
         prescribed, and no traction passes there; let `secondary: {}` carry the multipliers",
        side.primary().name()
    )
}

/// The terms of the nodes this rank owns, from all ranks. Collective.
fn send_to_owners(comm: &Comm, directory: &Directory<'_>, terms: &[Term]) -> Vec<Term> {
    let nodes: Vec<u64> = terms.iter().map(|t| t.node).collect();
    let mut packed = vec![Vec::new(); comm.size() as usize];
    for (term, entry) in terms.iter().zip(directory.look_up(&nodes)) {
        packed[entry.owner as usize].extend([
            term.node,
            term.component,
            term.other,
            term.value.to_bits(),
        ]);
    }
    comm.exchange(&packed)
        .iter()
        .flat_map(|list| list.chunks_exact(4))
        .map(|t| Term { node: t[0], component: t[1], other: t[2], value: f64::from_bits(t[3]) })
        .collect()
}

/// Sums the terms to rows; nodes without any keep empty rows.
pub(super) fn sum(
    mut terms: Vec<Term>,
    components: usize,
    nodes: &[(u64, usize)],
    owned: &[u64],
) -> Vec<JumpRows<u64>> {
    // The order of summation must not depend on who integrated what.
    terms.sort_by(|a, b| {
        (a.node, a.component, a.other)
            .cmp(&(b.node, b.component, b.other))
            .then(a.value.total_cmp(&b.value))
    });
    let mut rows: Vec<JumpRows<u64>> = nodes
        .iter()
        .filter(|(node, _)| owned.binary_search(node).is_ok())
        .map(|(node, interface)| JumpRows {
            node: *node,
            interface: *interface,
            components,
            rows: [None, None, None],
        })
        .collect();
    for same in terms.chunk_by(|a, b| (a.node, a.component) == (b.node, b.component)) {
        let node = same[0].node;
        let total =
            |other: u64| -> f64 { same.iter().filter(|t| t.other == other).map(|t| t.value).sum() };
        let weight = total(WEIGHT);
        let own = node * components as u64 + same[0].component;
        let others = same
            .chunk_by(|a, b| a.other == b.other)
            .filter(|group| group[0].other != WEIGHT && group[0].other != own)
            .map(|group| (group[0].other, group.iter().map(|t| t.value).sum::<f64>() / weight))
            .filter(|(_, coefficient)| coefficient.abs() > 1e-15)
            .collect();
        let at = rows.binary_search_by_key(&node, |r| r.node).expect("terms go to the owner");
        rows[at].rows[same[0].component as usize] =
            Some(JumpRow { weight, own: total(own) / weight, others });
    }
    rows
}

/// Copies of the rows of nodes that other ranks own. Collective.
fn fetch(
    comm: &Comm,
    directory: &Directory<'_>,
    owned: &[JumpRows<u64>],
    missing: &[u64],
) -> Vec<JumpRows<u64>> {
    let mut wanted = vec![Vec::new(); comm.size() as usize];
    for (node, entry) in missing.iter().zip(directory.look_up(missing)) {
        wanted[entry.owner as usize].push(*node);
    }
    let replies: Vec<Vec<u64>> = comm
        .exchange(&wanted)
        .iter()
        .map(|list| {
            let at = |node: &u64| owned.binary_search_by_key(node, |r| r.node).ok();
            list.iter().filter_map(at).flat_map(|at| pack(&owned[at])).collect()
        })
        .collect();
    comm.exchange(&replies).iter().flat_map(|list| unpack(list)).collect()
}

fn pack(rows: &JumpRows<u64>) -> Vec<u64> {
    let mut words = vec![rows.node, rows.interface as u64, rows.components as u64];
    for row in &rows.rows {
        let Some(row) = row else {
            words.push(0);
            continue;
        };
        words.extend([1, row.weight.to_bits(), row.own.to_bits(), row.others.len() as u64]);
        words.extend(row.others.iter().flat_map(|(n, a)| [*n, a.to_bits()]));
    }
    words
}

fn unpack(words: &[u64]) -> Vec<JumpRows<u64>> {
    let mut words = words.iter().copied();
    let mut list = Vec::new();
    while let Some(node) = words.next() {
        let mut next = || words.next().expect("packed by `pack`");
        let (interface, components) = (next() as usize, next() as usize);
        let rows = std::array::from_fn(|_| {
            (next() == 1).then(|| {
                let (weight, own) = (f64::from_bits(next()), f64::from_bits(next()));
                let n = next();
                let others = (0..n).map(|_| (next(), f64::from_bits(next()))).collect();
                JumpRow { weight, own, others }
            })
        });
        list.push(JumpRows { node, interface, components, rows });
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_on_the_jump_are_spread_as_the_jump_is_taken() {
        let row = JumpRow { weight: 0.25, own: 2.0, others: vec![(2, -0.5), (0, -1.5)] };
        let (u, own) = ([3.0, 7.0, 5.0, 11.0], 3);
        let jump = row.trace(own, |node| u[node as usize]);
        assert_eq!(jump, 2.0 * 11.0 - 0.5 * 5.0 - 1.5 * 3.0);
        let mut force = [0.0; 4];
        row.spread(own, 4.0, |node, f| force[node as usize] += f);
        assert_eq!(force, [-6.0, 0.0, -2.0, 8.0]);
        let work: f64 = force.iter().zip(&u).map(|(f, u)| f * u).sum();
        assert_eq!(work, 4.0 * jump);
        let unknowns: Vec<u32> = row.coefficients(own).map(|(unknown, _)| unknown).collect();
        assert_eq!(unknowns, [2, 0, 3]);
    }

    #[test]
    fn rows_survive_the_journey() {
        let row = JumpRow { weight: 0.25, own: -1.0, others: vec![(7, 0.5), (9, 1e-300)] };
        let one = JumpRows {
            node: 3,
            interface: 1,
            components: 3,
            rows: [Some(row.clone()), None, Some(row)],
        };
        let two = JumpRows { node: 4, interface: 0, components: 3, rows: [None, None, None] };
        let words = [pack(&one), pack(&two)].concat();
        assert_eq!(unpack(&words), [one, two]);
    }
}
