//! The jump of the displacement at the nodes of the secondary side, as rows over nodal values.
//!
//! At node i and component c the jump is g = sum over k of a_k u_k: own coefficient, coefficients
//! of the primary side, and of secondary nodes whose component c is prescribed and which therefore
//! carry no multiplier. The rows come from the dual mortar basis (Popp, Wohlmuth, Gee, Wall, SIAM
//! J. Sci. Comput. 34, 2012), component by component; the owner of a secondary node owns its rows,
//! and every rank that holds the node has a copy.

use super::mortar::{PlaneFacet, facet_rows};
use super::sides::Sides;
use crate::comm::Comm;
use crate::element::Shape;
use crate::error::Result;
use crate::mesh::LocalMesh;
use crate::space::Directory;

/// The jump of one component at one secondary node.
#[derive(Debug, Clone, PartialEq)]
pub struct JumpRow<N> {
    /// Integral of the multiplier basis function (m2; 2D: m): the weight of the node.
    pub weight: f64,
    /// Coefficient of the node itself.
    pub own: f64,
    /// Coefficients of other nodes.
    pub others: Vec<(N, f64)>,
}

/// A row at work: `node` is the one that it belongs to.
impl<N: Copy> JumpRow<N> {
    /// The jump of a field, whose component at a local node is `at`.
    #[inline]
    pub fn trace(&self, node: N, at: impl Fn(N) -> f64) -> f64 {
        self.own * at(node) + self.trace_of_others(at)
    }

    /// The part of [`JumpRow::trace`] that comes from the other nodes.
    #[inline]
    pub fn trace_of_others(&self, at: impl Fn(N) -> f64) -> f64 {
        self.others.iter().map(|(other, a)| a * at(*other)).sum()
    }

    /// The transpose of [`JumpRow::trace`]: the forces of one on the jump, given to `add` node by
    /// node.
    #[inline]
    pub fn spread(&self, node: N, force: f64, mut add: impl FnMut(N, f64)) {
        add(node, self.own * force);
        self.spread_to_others(force, add);
    }

    /// The transpose of [`JumpRow::trace_of_others`].
    #[inline]
    pub fn spread_to_others(&self, force: f64, mut add: impl FnMut(N, f64)) {
        for (other, a) in &self.others {
            add(*other, a * force);
        }
    }

    /// All nodes with their coefficients, the own one last.
    #[inline]
    pub fn coefficients(&self, node: N) -> impl Iterator<Item = (N, f64)> {
        self.others.iter().copied().chain([(node, self.own)])
    }
}

/// The rows of one secondary node, one per component; none where the component is prescribed.
#[derive(Debug, Clone, PartialEq)]
pub struct JumpRows<N> {
    /// The node.
    pub node: N,
    /// The interface it belongs to.
    pub interface: usize,
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
    /// The nodes of all rows: the secondary node, then each of the others once.
    pub fn nodes(&self) -> Vec<u32> {
        let mut nodes = vec![self.node];
        for (node, _) in self.rows.iter().flatten().flat_map(|r| &r.others) {
            if !nodes.contains(node) {
                nodes.push(*node);
            }
        }
        nodes
    }

    /// Coefficient of a node in the jump of a component, 0 where it has none.
    pub fn coefficient(&self, component: usize, node: u32) -> f64 {
        let Some(row) = &self.rows[component] else { return 0.0 };
        if node == self.node {
            return row.own;
        }
        row.others.iter().find(|(n, _)| *n == node).map_or(0.0, |(_, a)| *a)
    }
}

impl JumpRows<u64> {
    /// The same rows with every name replaced.
    pub fn renamed(self, new: impl Fn(u64) -> u32) -> JumpRows<u32> {
        let rename = |row: JumpRow<u64>| JumpRow {
            weight: row.weight,
            own: row.own,
            others: row.others.into_iter().map(|(n, a)| (new(n), a)).collect(),
        };
        JumpRows {
            node: new(self.node),
            interface: self.interface,
            rows: self.rows.map(|row| row.map(rename)),
        }
    }
}

/// Marks the weight among the coefficients of a row.
const WEIGHT: u64 = u64::MAX;

/// One summand of a row on its way to the owner of the node.
#[derive(Debug, Clone, Copy)]
pub(super) struct Term {
    node: u64,
    component: u64,
    other: u64,
    value: f64,
}

/// The rows of all secondary nodes that this rank's cells touch, by rising name, of a field with so
/// many components; `fixed` tells which of them carry no multiplier at a node.
///
/// Collective: each rank integrates the facets of its own cells.
///
/// # Errors
/// `Input` when the primary side does not cover the secondary side.
pub fn jump_rows(
    comm: &Comm,
    mesh: &LocalMesh,
    sides: &[Sides],
    components: usize,
    fixed: &dyn Fn(u64) -> [bool; 3],
    directory: &Directory<'_>,
) -> Result<Vec<JumpRows<u64>>> {
    let terms = comm.agree(integrate(mesh, sides, components, fixed))?;
    let nodes: Vec<(u64, usize)> = mesh
        .nodes
        .iter()
        .filter_map(|(n, _, marks)| Some((n, sides.iter().position(|s| s.is_secondary(marks))?)))
        .collect();
    let received = send_to_owners(comm, directory, &terms);
    let mut rows = sum(received, sides, &nodes, &directory.owned);
    let missing: Vec<u64> =
        nodes.iter().map(|n| n.0).filter(|n| directory.owned.binary_search(n).is_err()).collect();
    rows.extend(fetch(comm, directory, &rows, &missing));
    rows.sort_by_key(|r| r.node);
    Ok(rows)
}

/// The terms that the secondary facets of this rank's cells contribute.
pub(super) fn integrate(
    mesh: &LocalMesh,
    sides: &[Sides],
    components: usize,
    fixed: &dyn Fn(u64) -> [bool; 3],
) -> Result<Vec<Term>> {
    let mut terms = Vec::new();
    for side in sides {
        for facet in mesh.on_lip(side.interface, side.secondary) {
            let (shape, nodes) = mesh.lip_nodes(side.secondary, *facet);
            let names: Vec<u64> =
                nodes.iter().map(|node| mesh.nodes.names[*node as usize]).collect();
            let points = nodes.iter().map(|node| mesh.nodes.points[*node as usize]);
            let secondary = plane_facet(shape, &names, points);
            let primary: Vec<PlaneFacet> = mesh
                .across(side.interface, side.secondary, *facet)
                .iter()
                .map(|far| plane_facet(far.shape, &far.nodes, far.points.iter().copied()))
                .collect();
            let primary: Vec<&PlaneFacet> = primary.iter().collect();
            for row in facet_rows(&secondary, &primary, &dropped(&secondary, components, fixed))? {
                for component in (0..components).filter(|c| row.components[*c]) {
                    let term = |other, value| Term {
                        node: row.node,
                        component: component as u64,
                        other,
                        value,
                    };
                    terms.push(term(WEIGHT, row.weight));
                    terms.extend(row.secondary.iter().map(|(n, v)| term(*n, side.sign() * v)));
                    terms.extend(row.primary.iter().map(|(n, v)| term(*n, -side.sign() * v)));
                }
            }
        }
    }
    Ok(terms)
}

/// A facet in the plane of its interface.
fn plane_facet(shape: Shape, names: &[u64], points: impl Iterator<Item = [f64; 3]>) -> PlaneFacet {
    let corners = points.take(shape.corners().nodes()).map(|[x, y, _]| [x, y]);
    PlaneFacet::new(shape, names, &corners.collect::<Vec<_>>())
}

/// Per component, the nodes of a facet that carry no multiplier, one bit each.
fn dropped(facet: &PlaneFacet, components: usize, fixed: &dyn Fn(u64) -> [bool; 3]) -> Vec<u16> {
    let mut masks = vec![0u16; components];
    for (bit, node) in facet.nodes().iter().enumerate() {
        for (mask, fixed) in masks.iter_mut().zip(fixed(*node)) {
            *mask |= u16::from(fixed) << bit;
        }
    }
    masks
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
    sides: &[Sides],
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
            rows: [None, None, None],
        })
        .collect();
    for same in terms.chunk_by(|a, b| (a.node, a.component) == (b.node, b.component)) {
        let node = same[0].node;
        let total =
            |other: u64| -> f64 { same.iter().filter(|t| t.other == other).map(|t| t.value).sum() };
        let weight = total(WEIGHT);
        let others = same
            .chunk_by(|a, b| a.other == b.other)
            .filter(|group| group[0].other != WEIGHT && group[0].other != node)
            .map(|group| (group[0].other, group.iter().map(|t| t.value).sum::<f64>() / weight))
            .filter(|(_, coefficient)| coefficient.abs() > 1e-15)
            .collect();
        let at = rows.binary_search_by_key(&node, |r| r.node).expect("terms go to the owner");
        debug_assert!(rows[at].interface < sides.len());
        rows[at].rows[same[0].component as usize] =
            Some(JumpRow { weight, own: total(node) / weight, others });
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
    let mut words = vec![rows.node, rows.interface as u64];
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
        let interface = next() as usize;
        let rows = std::array::from_fn(|_| {
            (next() == 1).then(|| {
                let (weight, own) = (f64::from_bits(next()), f64::from_bits(next()));
                let n = next();
                let others = (0..n).map(|_| (next(), f64::from_bits(next()))).collect();
                JumpRow { weight, own, others }
            })
        });
        list.push(JumpRows { node, interface, rows });
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
        let nodes: Vec<u32> = row.coefficients(own).map(|(node, _)| node).collect();
        assert_eq!(nodes, [2, 0, 3]);
    }

    #[test]
    fn rows_survive_the_journey() {
        let row = JumpRow { weight: 0.25, own: -1.0, others: vec![(7, 0.5), (9, 1e-300)] };
        let one = JumpRows { node: 3, interface: 1, rows: [Some(row.clone()), None, Some(row)] };
        let two = JumpRows { node: 4, interface: 0, rows: [None, None, None] };
        let words = [pack(&one), pack(&two)].concat();
        assert_eq!(unpack(&words), [one, two]);
    }
}
