//! The rows of the weighted jump that one secondary facet in space contributes.

use super::facet::SpaceFacet;
use super::overlap::overlaps;
use crate::element::{QuadraturePoint, Shape};
use crate::error::{Error, Result};
use crate::interface::mortar::rows::{Contribution, Opposite, contributions, points_of};
use crate::interface::mortar::{EdgeBasis, MOST_NODES};

/// The primary side of one secondary facet.
#[derive(Debug, Clone, Copy)]
pub enum Partners<'a> {
    /// One facet with a node at the place of each of its nodes.
    Twin {
        /// The primary facet, of the same shape.
        facet: &'a SpaceFacet,
        /// For each local secondary node the local primary one at the same place.
        order: &'a [usize],
    },
    /// All facets that may overlap it, each once (see [`super::candidates_in_space`]). One that has
    /// its nodes at the same places is taken for its twin. Those that are farther away than the
    /// size of either facet do not count.
    Near(&'a [&'a SpaceFacet]),
    /// The same however far away they are.
    Across(&'a [&'a SpaceFacet]),
}

/// What one secondary facet contributes, and how much of it found a partner.
#[derive(Debug, Clone, PartialEq)]
pub struct SpaceRows {
    /// The rows: by kept node in the order of the facet (corners, edges, inside), and by group of
    /// components with the same dropped nodes. None where nothing is covered.
    pub contributions: Vec<Contribution>,
    /// Area of the facet, m2 (length, m, of a line).
    pub area: f64,
    /// The part of it that the primary side covers, m2 (m).
    pub covered: f64,
    /// Of each node of the facet, in its order; the same for all components.
    pub shares: Vec<Share>,
}

/// How much of the integral of a node's function is covered, on one facet or on all together.
///
/// Functions of second order can have negative integrals over parts of a facet, and those of first
/// order small ones. A node whose share over all its facets [is too small](Share::is_too_small)
/// must be dropped: else its own weight could vanish. So where sides do not cover each other,
/// integrate twice: with `dropped` empty, which gives the shares and no rows; and with those nodes
/// dropped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Share {
    /// Its global identity.
    pub node: u64,
    /// Integral over the covered part, m2 (m).
    pub covered: f64,
    /// Integral over the whole facet, m2 (m).
    pub whole: f64,
}

/// The least part of a node's integral with which it carries a multiplier, by the order of its
/// facets: dropped functions of second order hand over negative integrals, which are smaller.
const LEAST_SHARE: [f64; 2] = [0.01, 0.1];

impl Share {
    /// Whether the node cannot carry a multiplier, by the sums over all its facets, which are of
    /// this order (1 or 2).
    pub fn is_too_small(&self, order: usize) -> bool {
        self.covered <= LEAST_SHARE[order - 1] * self.whole
    }
}

/// Parts of a facet that may be covered twice, relative to its area: of plane and of curved ones.
const TWICE: [f64; 2] = [1e-9, 0.05];

/// A facet of which no more than this part is covered counts as not covered if the functions of its
/// nodes cannot be told apart there.
const NEGLIGIBLE: f64 = 5e-2;

/// Integrates the multiplier basis of a secondary facet against both sides, over the part of it
/// that the primary side covers.
///
/// The two sides look at each other: normals of facets point out of their bodies.
///
/// - A twin: over the true surface; the primary coefficients are the secondary ones permuted, bit
///   for bit.
/// - Others: in the plane of the secondary facet, or the planes of its flat pieces if it is curved,
///   along their normals; the area is that of the secondary surface. Linear fields make no jump
///   across a plane interface, whatever the facets; polynomials of the order of both sides make
///   none if the edges are straight.
///
/// # Arguments
/// * `dropped` per displacement component (2 or 3): bit b set says that the local node b of the
///   secondary facet carries no multiplier in that component
/// * `transformed` whether corners take a share of the edges ([`EdgeBasis`]): all facets of second
///   order of a side must say the same, and must say yes if one of them is a triangle
///
/// # Errors
/// `Input` if the facet has no area or a facet is turned in, if the primaries cover it twice, or
/// cover so small a part within it that it has no basis there; `Bug` if a triangle of second order
/// is not to be transformed, or the two sides of a row do not balance.
///
/// # Parallel
/// Local.
pub fn facet_rows_in_space(
    secondary: &SpaceFacet,
    partners: Partners,
    dropped: &[u16],
    transformed: bool,
) -> Result<SpaceRows> {
    if secondary.shape() == Shape::Tri6 && !transformed {
        return Err(Error::Bug(format!(
            "the multipliers of the triangle of second order at {} need the transformed basis",
            place(secondary)
        )));
    }
    let rule = secondary.rule();
    let area: f64 = rule.iter().map(|p| p.weight).sum();
    if !(area.is_finite() && area > 0.0) {
        return Err(bad(secondary, "has no area"));
    }
    let nodal = match transformed {
        true => EdgeBasis::transformed(secondary.shape(), 0),
        false => EdgeBasis::plain(secondary.shape()),
    };
    let whole = integrals(nodal, &rule);
    let covers = |points: &[QuadraturePoint], contributions: Vec<Contribution>| {
        let shares = integrals(nodal, points).into_iter().zip(whole).zip(secondary.nodes());
        let shares = shares.map(|((covered, whole), node)| Share { node: *node, covered, whole });
        let covered = points.iter().map(|p| p.weight).sum();
        SpaceRows { contributions, area, covered, shares: shares.collect() }
    };
    let rows = |points: &[QuadraturePoint], opposite: &Opposite| {
        let (shape, nodes) = (secondary.shape(), secondary.nodes());
        contributions(shape, nodes, points, opposite, dropped, transformed)
    };
    if let Some(twins) = twins(secondary, &partners) {
        let found = rows(&rule, &Opposite::Twin(twins));
        return Ok(covers(&rule, found.ok_or_else(|| bad(secondary, "is turned in"))?));
    }
    let (primaries, any_distance) = match partners {
        Partners::Near(primaries) => (primaries, false),
        Partners::Across(primaries) => (primaries, true),
        Partners::Twin { .. } => unreachable!("twins have been taken"),
    };
    let segments = overlaps(secondary, primaries, any_distance)
        .ok_or_else(|| bad(secondary, "or one across from it is turned in"))?;
    let points = points_of(&segments);
    let part = points.iter().map(|p| p.weight).sum::<f64>() / area;
    let is_flat = secondary.is_flat() && primaries.iter().all(|p| p.is_flat());
    if part > 1.0 + TWICE[usize::from(!is_flat)] {
        return Err(covered_twice(secondary, part));
    }
    match rows(&points, &Opposite::Segments(&segments)) {
        Some(found) if part > 0.0 => {
            found.iter().try_for_each(|row| balance(row, secondary, area))?;
            Ok(covers(&points, found))
        }
        None if part > NEGLIGIBLE => Err(hardly_covered(secondary, part)),
        _ => Ok(covers(&[], Vec::new())),
    }
}

/// The primary node of each local secondary node, if one facet has them all.
fn twins(secondary: &SpaceFacet, partners: &Partners) -> Option<Vec<u64>> {
    let named = |facet: &SpaceFacet, order: &[usize]| {
        order.iter().map(|l| facet.nodes()[*l]).collect::<Vec<_>>()
    };
    match partners {
        Partners::Twin { facet, order } => Some(named(facet, order)),
        Partners::Near(primaries) | Partners::Across(primaries) => {
            primaries.iter().find_map(|p| secondary.matching_nodes(p).map(|order| named(p, &order)))
        }
    }
}

/// The integrals of the functions of a basis.
fn integrals(nodal: EdgeBasis, points: &[QuadraturePoint]) -> [f64; MOST_NODES] {
    let mut sums = [0.0; MOST_NODES];
    for p in points {
        for (sum, value) in sums.iter_mut().zip(nodal.values(p.xi)) {
            *sum += p.weight * value;
        }
    }
    sums
}

/// A uniform translation makes no jump: both sides of the row have the same sum, to rounding.
fn balance(row: &Contribution, facet: &SpaceFacet, area: f64) -> Result<()> {
    let [here, there] = row.sums();
    // Where little of the facet is covered the basis has lost some digits.
    let size: f64 = row.secondary.iter().chain(&row.primary).map(|(_, c)| c.abs()).sum();
    if (here - there).abs() <= 1e-12 * size + 1e-9 * area {
        return Ok(());
    }
    Err(Error::Bug(format!(
        "mortar row of node {} at {}: the secondary coefficients add up to {here:e}, the primary \
         ones to {there:e} m2",
        row.node,
        place(facet)
    )))
}

fn bad(facet: &SpaceFacet, what: &str) -> Error {
    let place = place(facet);
    Error::Input(format!(
        "the interface facet at {place} {what}: check the shape of the cells there"
    ))
}

fn hardly_covered(facet: &SpaceFacet, part: f64) -> Error {
    Error::Input(format!(
        "only {:.3} % of the secondary facet at {} lie across from the primary side, somewhere in \
         its middle: too little for its multipliers; let the other side of the interface be the \
         secondary one, or refine this one",
        100.0 * part,
        place(facet)
    ))
}

fn covered_twice(facet: &SpaceFacet, fraction: f64) -> Error {
    Error::Input(format!(
        "the primary side of the interface overlaps itself on the secondary facet at {}: its \
         facets add up to {:.6} % of it; cells of one side must not penetrate each other",
        place(facet),
        100.0 * fraction
    ))
}

fn place(facet: &SpaceFacet) -> String {
    let [x, y, z] = facet.centre();
    format!("({x:.6}, {y:.6}, {z:.6}) m")
}
