//! From the overlaps of one secondary facet to the rows of its nodes.

use std::collections::BTreeMap;

use super::edges::EdgeBasis;
use super::segments::SegmentPoint;
use super::{DualBasis, MOST_NODES};
use crate::element::{QuadraturePoint, Shape};

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
    ///
    /// Where corners take a share of the edges, the row of the middle of an edge also holds the two
    /// corners, which may have rows themselves; those of corners hold nothing more. So the rows
    /// have two levels: who eliminates the nodes takes the corners first.
    pub secondary: Vec<(u64, f64)>,
    /// (primary node l, integral of Phi_i N_l over the facet), m2, by ascending node.
    pub primary: Vec<(u64, f64)>,
}

impl Contribution {
    /// Sums of the secondary and of the primary coefficients, m2, which a uniform translation makes
    /// equal, to rounding.
    pub(super) fn sums(&self) -> [f64; 2] {
        [&self.secondary, &self.primary].map(|side| side.iter().map(|(_, c)| c).sum())
    }
}

/// The part of a primary facet that lies on the secondary one.
pub(super) struct Segment<'a> {
    pub shape: Shape,
    pub nodes: &'a [u64],
    pub points: Vec<SegmentPoint>,
}

/// The other side of a secondary facet.
pub(super) enum Opposite<'a> {
    /// The primary node of each local secondary node, which is at the same place.
    Twin(Vec<u64>),
    /// The parts of the primary facets that lie on it.
    Segments(&'a [Segment<'a>]),
}

/// One contribution per kept node and group of components with the same dropped nodes; none if the
/// points fill too small a part of the facet for a basis.
///
/// # Arguments
/// * `nodes` of the secondary facet of this `shape`
/// * `points` of integration, those of the segments where there are some
/// * `dropped` per component, one bit per local node
/// * `transformed` whether corners take a share of the edges ([`EdgeBasis`])
pub(super) fn contributions(
    shape: Shape,
    nodes: &[u64],
    points: &[QuadraturePoint],
    opposite: &Opposite,
    dropped: &[u16],
    transformed: bool,
) -> Option<Vec<Contribution>> {
    let mut out = Vec::new();
    let all = (1 << nodes.len()) - 1;
    for (first, &mask) in dropped.iter().enumerate() {
        if mask & all == all || dropped[..first].contains(&mask) {
            continue;
        }
        let nodal = match transformed {
            true => EdgeBasis::transformed(shape, mask),
            false => EdgeBasis::plain(shape),
        };
        let basis = DualBasis::to(nodal, points, mask)?;
        let mut sampled = match opposite {
            Opposite::Twin(_) => Default::default(),
            Opposite::Segments(segments) => sample(&basis, segments),
        };
        for &i in basis.kept() {
            let local = entries(&basis, i);
            let mut primary: Vec<(u64, f64)> = match opposite {
                Opposite::Twin(twins) => local.iter().map(|&(k, c)| (twins[k], c)).collect(),
                Opposite::Segments(_) => std::mem::take(&mut sampled[i]).into_iter().collect(),
            };
            primary.sort_unstable_by_key(|&(node, _)| node);
            out.push(Contribution {
                node: nodes[i],
                components: std::array::from_fn(|c| dropped.get(c) == Some(&mask)),
                weight: basis.weight(i),
                secondary: local.iter().map(|&(k, c)| (nodes[k], c)).collect(),
                primary,
            });
        }
    }
    Some(out)
}

/// Local nodes and coefficients of the row of i on its own side: i, then those dropped, then others
/// that are not zero.
fn entries(basis: &DualBasis, i: usize) -> Vec<(usize, f64)> {
    let integrals = basis.integrals(i);
    let is_kept = |k: &usize| basis.kept().contains(k);
    let dropped = (0..integrals.len()).filter(|k| !is_kept(k));
    let corners = (0..integrals.len()).filter(|k| *k != i && is_kept(k) && integrals[*k] != 0.0);
    std::iter::once(i).chain(dropped).chain(corners).map(|k| (k, integrals[k])).collect()
}

/// For each local node i, the integrals of Phi_i against the basis of the primary nodes.
fn sample(basis: &DualBasis, segments: &[Segment]) -> [BTreeMap<u64, f64>; MOST_NODES] {
    let mut out: [BTreeMap<u64, f64>; MOST_NODES] = Default::default();
    let (mut phi, mut values) = ([0.0; MOST_NODES], [0.0; MOST_NODES]);
    for segment in segments {
        let mut sums = [[0.0; MOST_NODES]; MOST_NODES];
        for p in &segment.points {
            basis.values(p.xi, &mut phi);
            segment.shape.values(p.eta, &mut values);
            for &i in basis.kept() {
                for l in 0..segment.nodes.len() {
                    sums[i][l] += p.weight * phi[i] * values[l];
                }
            }
        }
        for &i in basis.kept() {
            for (l, &node) in segment.nodes.iter().enumerate() {
                *out[i].entry(node).or_insert(0.0) += sums[i][l];
            }
        }
    }
    out
}

/// The points of all segments, on the secondary facet.
pub(super) fn points_of(segments: &[Segment]) -> Vec<QuadraturePoint> {
    let points = segments.iter().flat_map(|segment| &segment.points);
    points.map(|p| QuadraturePoint { xi: p.xi, weight: p.weight }).collect()
}
