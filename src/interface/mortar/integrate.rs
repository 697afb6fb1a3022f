//! The rows of the weighted jump that one secondary facet of a box contributes.

use super::PlaneFacet;
use super::rows::{Contribution, Opposite, Segment, contributions, points_of};
use super::segments::{matching_nodes, overlap};
use crate::error::{Error, Result};

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
    let (shape, nodes) = (secondary.shape(), secondary.nodes());
    let no_basis = || Error::Bug(format!("no dual basis on the facet at {}", place(secondary)));
    if let Some((primary, order)) = twin {
        let twins = Opposite::Twin(order.iter().map(|l| primary.nodes()[*l]).collect());
        let rows = contributions(shape, nodes, &secondary.points(), &twins, dropped, false);
        return rows.ok_or_else(no_basis);
    }
    let segments = cover(secondary, primaries)?;
    let (points, opposite) = (points_of(&segments), Opposite::Segments(&segments));
    let rows = contributions(shape, nodes, &points, &opposite, dropped, false);
    let rows = rows.ok_or_else(no_basis)?;
    rows.iter().try_for_each(|row| balance(row, secondary, points.len()))?;
    Ok(rows)
}

/// The integration points of each primary facet on the secondary one, which they cover once.
fn cover<'a>(secondary: &PlaneFacet, primaries: &[&'a PlaneFacet]) -> Result<Vec<Segment<'a>>> {
    let mut segments = Vec::new();
    let mut covered = 0.0;
    for &primary in primaries {
        let mut points = Vec::new();
        covered += overlap(secondary, primary, &mut points);
        if !points.is_empty() {
            segments.push(Segment { shape: primary.shape(), nodes: primary.nodes(), points });
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

/// A uniform translation makes no jump: both sides of the row have the same sum, to rounding.
fn balance(row: &Contribution, facet: &PlaneFacet, points: usize) -> Result<()> {
    let [here, there] = row.sums();
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
