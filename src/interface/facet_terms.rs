//! What the facets of the secondary sides contribute to the rows of the jump.

use std::collections::BTreeSet;

use super::mortar::{
    Contribution, Partners, PlaneFacet, Share, SpaceFacet, facet_rows, facet_rows_in_space,
};
use super::sides::Sides;
use crate::comm::Comm;
use crate::element::Shape;
use crate::error::{Error, Result};
use crate::mesh::{Facet, FarFacet, LocalMesh};
use crate::space::Directory;

/// Marks the weight among the coefficients of a row.
pub const WEIGHT: u64 = u64::MAX;

/// One summand of a row on its way to the owner of the node.
#[derive(Debug, Clone, Copy)]
pub struct Term {
    pub node: u64,
    pub component: u64,
    pub other: u64,
    pub value: f64,
}

/// What the facets of a rank contribute.
#[derive(Debug, Default)]
pub struct Terms {
    /// Summands of rows.
    pub list: Vec<Term>,
    /// How much of the integrals of the nodes' functions is covered by the primary side.
    pub shares: Vec<Share>,
    /// What is known of the sides of each interface of the mesh of a file.
    pub fits: Vec<Fit>,
}

/// How two sides fit each other.
#[derive(Debug, Clone, Copy, Default)]
pub struct Fit {
    /// The largest mean distance of the sides at a node (m), and over the size of its facet.
    pub apart: [f64; 2],
    /// Area of the secondary side and the part of it that has a partner (m2).
    pub areas: [f64; 2],
}

/// Distances below this part of the size of facets are those of curved surfaces cut into facets,
/// or of coordinates with few digits.
const CLOSE: f64 = 1e-6;
/// Sides that are farther apart than this part of the size of facets have a gap.
const GAP: f64 = 0.05;

impl Fit {
    /// What is to be said of how the sides fit, the same on every rank. `name` is that of the
    /// interface. Collective.
    ///
    /// # Errors
    /// `Input` when no part has a partner, or the sides are apart by more than a part of the size
    /// of their facets.
    pub fn words(self, comm: &Comm, name: &str) -> Result<Vec<String>> {
        let (mut apart, mut areas) = (self.apart, self.areas);
        comm.max(&mut apart);
        comm.sum(&mut areas);
        let [distance, part] = apart;
        if areas[0] > 0.0 && areas[1] == 0.0 {
            return Err(Error::Input(format!(
                "interface {name}: no facet of one side lies across from one of the other, near \
                 enough and looking at it; the sides have to face each other, and the first group \
                 of `between` is the lower side"
            )));
        }
        if part > GAP {
            return Err(Error::Input(format!(
                "interface {name}: its sides are up to {distance:.3e} m apart, {:.1} % of the size \
                 of a facet there, and are to lie on each other: only a contact has a gap at the \
                 start, unless it is told `gap: closed`",
                100.0 * part
            )));
        }
        let mut words = Vec::new();
        if part > CLOSE {
            words.push(format!(
                "interface {name}: its sides are up to {distance:.3e} m apart and are taken for \
                 closed there"
            ));
        }
        if areas[1] < areas[0] * (1.0 - CLOSE) {
            words.push(format!(
                "interface {name}: {:.3} % of its secondary side, {:.4e} of {:.4e} m2, lie across \
                 from nothing and carry no traction",
                100.0 * (1.0 - areas[1] / areas[0]),
                areas[0] - areas[1],
                areas[0]
            ));
        }
        Ok(words)
    }
}

impl Terms {
    /// Adds what a facet contributes to the rows of a node.
    pub fn add(&mut self, side: &Sides, components: usize, row: &Contribution) {
        for component in (0..components).filter(|c| row.components[*c]) {
            let term =
                |other, value| Term { node: row.node, component: component as u64, other, value };
            let unknown = |node: u64| node * components as u64 + component as u64;
            let of = |sign: f64, (node, value): &(u64, f64)| term(unknown(*node), sign * value);
            self.list.push(term(WEIGHT, row.weight));
            self.list.extend(row.secondary.iter().map(|entry| of(side.sign(), entry)));
            self.list.extend(row.primary.iter().map(|entry| of(-side.sign(), entry)));
        }
    }
}

/// The terms that the secondary facets of this rank's cells contribute.
pub fn integrate(
    mesh: &LocalMesh,
    sides: &[Sides],
    components: usize,
    fixed: &dyn Fn(u64) -> [bool; 3],
) -> Result<Terms> {
    let mut terms =
        Terms { fits: vec![Fit::default(); mesh.facts.interfaces.len()], ..Terms::default() };
    for side in sides {
        if mesh.is_of_file() {
            in_space(mesh, side, components, fixed, &mut terms)?;
            continue;
        }
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
            for row in
                facet_rows(&secondary, &primary, &dropped(secondary.nodes(), components, fixed))?
            {
                terms.add(side, components, &row);
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
fn dropped(nodes: &[u64], components: usize, fixed: &dyn Fn(u64) -> [bool; 3]) -> Vec<u16> {
    let mut masks = vec![0u16; components];
    for (bit, node) in nodes.iter().enumerate() {
        for (mask, fixed) in masks.iter_mut().zip(fixed(*node)) {
            *mask |= u16::from(fixed) << bit;
        }
    }
    masks
}

/// The terms of one side of the mesh of a file, whose facets lie anywhere in space.
fn in_space(
    mesh: &LocalMesh,
    side: &Sides,
    components: usize,
    fixed: &dyn Fn(u64) -> [bool; 3],
    terms: &mut Terms,
) -> Result<()> {
    let has_shares = side.secondary_facts(&mesh.facts).has_shares;
    for facet in mesh.on_lip(side.interface, side.secondary) {
        let (secondary, primary) = space_facets(mesh, side, *facet);
        let primary: Vec<&SpaceFacet> = primary.iter().collect();
        let without = dropped(secondary.nodes(), components, fixed);
        let is_transformed = has_shares && secondary.shape().order() == 2;
        let partners =
            if side.has_gap { Partners::Across(&primary) } else { Partners::Near(&primary) };
        let rows = facet_rows_in_space(&secondary, partners, &without, is_transformed)?;
        let fit = &mut terms.fits[side.interface];
        for row in rows.contributions.iter().filter(|_| !side.has_gap) {
            let distance = distance(row, &secondary, &primary);
            fit.apart[0] = fit.apart[0].max(distance);
            fit.apart[1] = fit.apart[1].max(distance / secondary.size());
        }
        fit.areas[0] += rows.area;
        fit.areas[1] += rows.covered;
        rows.contributions.iter().for_each(|row| terms.add(side, components, row));
        terms.shares.extend(rows.shares);
    }
    Ok(())
}

/// A secondary facet of the mesh of a file, and those that may face it.
pub fn space_facets(mesh: &LocalMesh, side: &Sides, facet: Facet) -> (SpaceFacet, Vec<SpaceFacet>) {
    let (shape, nodes) = mesh.facet_nodes(facet);
    let names: Vec<u64> = nodes.iter().map(|node| mesh.nodes.names[*node as usize]).collect();
    let points: Vec<[f64; 3]> =
        nodes.iter().map(|node| mesh.nodes.points[*node as usize]).collect();
    let axes = mesh.facts.axes;
    let across = mesh.across(side.interface, side.secondary, facet);
    let of = |far: &FarFacet| SpaceFacet::new(far.shape, &far.nodes, &far.points, axes);
    (SpaceFacet::new(shape, &names, &points, axes), across.iter().map(of).collect())
}

/// The mean distance of the two sides at the node of a row (m): the jump of the position.
fn distance(row: &Contribution, secondary: &SpaceFacet, primary: &[&SpaceFacet]) -> f64 {
    let place = |facet: &SpaceFacet, node: u64| {
        let place = facet.nodes().iter().position(|other| *other == node)?;
        Some(facet.points()[place])
    };
    let mut gap = [0.0; 3];
    let mut add = |at: Option<[f64; 3]>, a: f64| {
        let at = at.unwrap_or_default();
        gap.iter_mut().zip(at).for_each(|(gap, x)| *gap += a * x);
    };
    row.secondary.iter().for_each(|(node, a)| add(place(secondary, *node), *a));
    for (node, a) in &row.primary {
        add(primary.iter().find_map(|facet| place(facet, *node)), -a);
    }
    gap.iter().map(|x| x * x).sum::<f64>().sqrt() / row.weight.abs()
}

/// Nodes of secondary sides of which the primary side covers too little to carry a multiplier.
#[derive(Debug, Default)]
pub struct Uncovered {
    names: BTreeSet<u64>,
}

impl Uncovered {
    /// Whether a node is one.
    pub fn contains(&self, name: u64) -> bool {
        self.names.contains(&name)
    }

    /// Adds the nodes whose `shares`, of the facets of all ranks, are too small for facets of at
    /// most this `order`. Whether there are any that were not known. Collective.
    pub fn grow(
        &mut self,
        comm: &Comm,
        directory: &Directory<'_>,
        order: usize,
        shares: &[Share],
    ) -> bool {
        if !comm.any(!shares.is_empty()) {
            return false;
        }
        let nodes: Vec<u64> = shares.iter().map(|share| share.node).collect();
        let mut packed = vec![Vec::new(); comm.size() as usize];
        let owners: Vec<usize> =
            directory.look_up(&nodes).iter().map(|entry| entry.owner as usize).collect();
        for (share, owner) in shares.iter().zip(&owners) {
            packed[*owner].extend([share.node, share.covered.to_bits(), share.whole.to_bits()]);
        }
        let received = comm.exchange(&packed);
        let mut all: Vec<[u64; 3]> =
            received.iter().flat_map(|list| list.as_chunks::<3>().0.to_vec()).collect();
        // The order of summation must not depend on who integrated what.
        all.sort_unstable();
        let mut too_small = BTreeSet::new();
        for same in all.chunk_by(|a, b| a[0] == b[0]) {
            let sum = |of: usize| same.iter().map(|share| f64::from_bits(share[of])).sum::<f64>();
            let share = Share { node: same[0][0], covered: sum(1), whole: sum(2) };
            if share.is_too_small(order) {
                too_small.insert(share.node);
            }
        }
        let told: Vec<Vec<u64>> = received
            .iter()
            .map(|list| {
                let names = list.as_chunks::<3>().0.iter().map(|share| share[0]);
                names.filter(|name| too_small.contains(name)).collect()
            })
            .collect();
        let before = self.names.len();
        self.names.extend(comm.exchange(&told).into_iter().flatten());
        comm.any(self.names.len() > before)
    }
}
