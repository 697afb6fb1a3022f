//! The rows of the weighted jump that one secondary facet contributes.

use std::collections::BTreeMap;

use super::segments::{SegmentPoint, matching_nodes, overlap};
use super::{DualBasis, MOST_NODES, PlaneFacet};
use crate::element::QuadraturePoint;
use crate::error::{Error, Result};

/// What one secondary facet adds to the weighted jump of one of its nodes,
/// g_i = sum of `secondary` coefficients times u - sum of `primary` coefficients times u.
#[derive(Debug, Clone, PartialEq)]
pub struct Contribution {
    /// The node i that carries the multiplier.
    pub node: u64,
    /// The displacement components the row holds for (those with the same dropped nodes).
    pub components: [bool; 3],
    /// Integral of Phi_i over the facet, m2 (m in 2D).
    pub weight: f64,
    /// (secondary node k, integral of Phi_i N_k), m2: first i itself, then the dropped nodes of the
    /// facet; the other kept nodes are exactly zero and left out.
    pub secondary: Vec<(u64, f64)>,
    /// (primary node l, integral of Phi_i N_l over the facet), m2, by ascending node.
    pub primary: Vec<(u64, f64)>,
}

/// Parts of a facet that may stay uncovered, relative to its area.
const COVERED: f64 = 1e-12;

/// Integrates the multiplier basis of a secondary facet against both sides.
///
/// # Arguments
/// * `primaries` all primary facets that may overlap it, each once (see `candidates`)
/// * `dropped` per displacement component (2 or 3): bit b set says that the local node b of the
///   secondary facet carries no multiplier in that component
///
/// # Returns
/// One contribution per kept node and group of components with the same dropped nodes; none where
/// all nodes of the facet are dropped. If one of the primaries has the same nodes as the facet, its
/// coefficients are the secondary ones permuted, bit for bit. Else the basis is biorthogonal with
/// respect to the very points at which the primary side is sampled, so that what both sides can
/// represent is reproduced on facets of any shape.
///
/// # Errors
/// `Input` if the facet has no area, or if the primaries do not cover it exactly once; `Bug` if the
/// two sides of a row do not balance.
///
/// # Parallel
/// Local.
pub fn facet_rows(
    secondary: &PlaneFacet,
    primaries: &[&PlaneFacet],
    dropped: &[u16],
) -> Result<Vec<Contribution>> {
    let area = secondary.area();
    if !(area.is_finite() && area > 0.0) {
        return Err(Error::Input(format!(
            "the interface facet at {} has no area: check the mesh of the interface",
            place(secondary)
        )));
    }
    let twin = primaries.iter().find_map(|p| matching_nodes(secondary, p).map(|order| (p, order)));
    let (segments, points) = match twin {
        Some(_) => (Vec::new(), secondary.points()),
        None => {
            let segments = cover(secondary, primaries)?;
            let points = segments
                .iter()
                .flat_map(|(_, points)| points)
                .map(|p| QuadraturePoint { xi: p.xi, weight: p.weight })
                .collect();
            (segments, points)
        }
    };

    let mut out = Vec::new();
    for (first, &mask) in dropped.iter().enumerate() {
        if dropped[..first].contains(&mask) {
            continue;
        }
        let Some(basis) = DualBasis::new(secondary.shape(), &points, mask) else { continue };
        let components = std::array::from_fn(|c| dropped.get(c) == Some(&mask));
        let mut sampled = sample(&basis, &segments);
        for &i in basis.kept() {
            let others = (0..secondary.nodes().len()).filter(|k| !basis.kept().contains(k));
            let local: Vec<(usize, f64)> =
                std::iter::once(i).chain(others).map(|k| (k, basis.integrals(i)[k])).collect();
            let mut primary: Vec<(u64, f64)> = match &twin {
                Some((p, order)) => local.iter().map(|&(k, c)| (p.nodes()[order[k]], c)).collect(),
                None => std::mem::take(&mut sampled[i]).into_iter().collect(),
            };
            primary.sort_unstable_by_key(|&(node, _)| node);
            let row = Contribution {
                node: secondary.nodes()[i],
                components,
                weight: basis.weight(i),
                secondary: local.iter().map(|&(k, c)| (secondary.nodes()[k], c)).collect(),
                primary,
            };
            balance(&row, secondary, points.len())?;
            out.push(row);
        }
    }
    Ok(out)
}

type Segments<'a> = Vec<(&'a PlaneFacet, Vec<SegmentPoint>)>;

/// The integration points of each primary facet on the secondary one, which they cover once.
fn cover<'a>(secondary: &PlaneFacet, primaries: &[&'a PlaneFacet]) -> Result<Segments<'a>> {
    let mut segments = Vec::new();
    let mut covered = 0.0;
    for &primary in primaries {
        let mut points = Vec::new();
        covered += overlap(secondary, primary, &mut points);
        if !points.is_empty() {
            segments.push((primary, points));
        }
    }
    let fraction = covered / secondary.area();
    if (fraction - 1.0).abs() <= COVERED {
        return Ok(segments);
    }
    let what = if fraction < 1.0 { "does not cover" } else { "overlaps itself on" };
    Err(Error::Input(format!(
        "the primary side of the interface {what} the secondary facet at {}: its facets add up to \
         {:.6} % of it (difference {:.3e}); the two sides must fill the same part of the plane",
        place(secondary),
        100.0 * fraction,
        fraction - 1.0
    )))
}

/// For each local node i, the integrals of Phi_i against the basis of the primary nodes.
fn sample(basis: &DualBasis, segments: &Segments) -> [BTreeMap<u64, f64>; MOST_NODES] {
    let mut out: [BTreeMap<u64, f64>; MOST_NODES] = Default::default();
    let (mut phi, mut values) = ([0.0; MOST_NODES], [0.0; MOST_NODES]);
    for (primary, points) in segments {
        let mut sums = [[0.0; MOST_NODES]; MOST_NODES];
        for p in points {
            basis.values(p.xi, &mut phi);
            primary.shape().values(p.eta, &mut values);
            for &i in basis.kept() {
                for l in 0..primary.nodes().len() {
                    sums[i][l] += p.weight * phi[i] * values[l];
                }
            }
        }
        for &i in basis.kept() {
            for (l, &node) in primary.nodes().iter().enumerate() {
                *out[i].entry(node).or_insert(0.0) += sums[i][l];
            }
        }
    }
    out
}

/// A uniform translation makes no jump: both sides of the row have the same sum, to rounding.
fn balance(row: &Contribution, facet: &PlaneFacet, points: usize) -> Result<()> {
    let sum = |side: &[(u64, f64)]| side.iter().map(|(_, c)| c).sum::<f64>();
    let (here, there) = (sum(&row.secondary), sum(&row.primary));
    let tolerance = facet.area() * (1e-14_f64).max(points as f64 * f64::EPSILON);
    if (here - there).abs() <= tolerance {
        return Ok(());
    }
    Err(Error::Bug(format!(
        "mortar row of node {} at {}: the secondary coefficients add up to {here:e}, the primary \
         ones to {there:e} m2",
        row.node,
        place(facet)
    )))
}

fn place(facet: &PlaneFacet) -> String {
    let [x, y] = facet.centre();
    match facet.shape().dim() {
        1 => format!("{x:.6} m along the interface"),
        _ => format!("({x:.6}, {y:.6}) m in its plane"),
    }
}
