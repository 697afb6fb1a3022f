//! What a style looks like: colours, lines and markers.

use plotters::prelude::{DrawingBackend, RGBColor};

use super::canvas::{Canvas, Drawn};

/// Colours that the colour-blind tell apart (Okabe and Ito), without the yellow.
pub(crate) const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
];

/// Number of markers.
const MARKERS: usize = 5;

/// What is drawn of a line that has a style.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Look {
    /// A marker at each point, and what joins them.
    Marked,
    /// What joins the points.
    Joined,
    /// The markers.
    Points,
    /// What joins the points, broad, for what others lie on.
    Band,
}

impl Look {
    pub fn has_markers(self) -> bool {
        matches!(self, Look::Marked | Look::Points)
    }
}

/// What joins the points of a style.
pub(super) fn joined<B: DrawingBackend>(
    canvas: &Canvas<'_, B>,
    points: &[(f64, f64)],
    style: usize,
    look: Look,
) -> Drawn {
    let color = COLORS[style % COLORS.len()];
    match look {
        Look::Marked => canvas.line(points, color, 2.0),
        // What is dense would follow the pixels.
        Look::Joined => canvas.line(&without_needless(points), color, 2.0),
        Look::Band => canvas.line(&without_needless(points), color, 5.0),
        Look::Points => Ok(()),
    }
}

/// How far a point may be from the line that is drawn without it, in pixels.
const NEEDLESS: f64 = 0.1;

/// The points without which the line would be another one (Douglas and Peucker).
pub(super) fn without_needless(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut kept = vec![false; points.len()];
    let mut pieces = vec![(0, points.len().saturating_sub(1))];
    while let Some((first, last)) = pieces.pop() {
        if points.is_empty() {
            break;
        }
        (kept[first], kept[last]) = (true, true);
        let between = first + 1..last.max(first + 1);
        let off = |i: usize| from_line(points[i], points[first], points[last]);
        let farthest = between.max_by(|a, b| off(*a).total_cmp(&off(*b)));
        if let Some(middle) = farthest.filter(|i| off(*i) > NEEDLESS) {
            pieces.extend([(first, middle), (middle, last)]);
        }
    }
    points.iter().zip(kept).filter(|(_, kept)| *kept).map(|(point, _)| *point).collect()
}

/// How far a point is from the line between two others, ends included.
fn from_line(p: (f64, f64), from: (f64, f64), to: (f64, f64)) -> f64 {
    let along = (to.0 - from.0, to.1 - from.1);
    let length = along.0.powi(2) + along.1.powi(2);
    let share = (p.0 - from.0) * along.0 + (p.1 - from.1) * along.1;
    let share = if length > 0.0 { (share / length).clamp(0.0, 1.0) } else { 0.0 };
    (p.0 - from.0 - share * along.0).hypot(p.1 - from.1 - share * along.1)
}

/// The cross of a run that failed.
pub(super) fn cross<B: DrawingBackend>(
    canvas: &Canvas<'_, B>,
    at: (f64, f64),
    color: RGBColor,
) -> Drawn {
    const HALF: f64 = 5.5;
    for slope in [1.0, -1.0] {
        let ends = [(at.0 - HALF, at.1 - slope * HALF), (at.0 + HALF, at.1 + slope * HALF)];
        canvas.line(&ends, color, 2.2)?;
    }
    Ok(())
}

/// The marker of a style: shapes differ where colours come again, and between neighbours.
pub(super) fn marker<B: DrawingBackend>(
    canvas: &Canvas<'_, B>,
    at: (f64, f64),
    style: usize,
) -> Drawn {
    let color = COLORS[style % COLORS.len()];
    let r = 5.0;
    let corners = |offsets: &[(f64, f64)]| -> Vec<(f64, f64)> {
        offsets.iter().map(|(dx, dy)| (at.0 + dx * r, at.1 + dy * r)).collect()
    };
    match style % MARKERS {
        0 => canvas.circle(at, 4.5, color, None),
        1 => canvas.fill(&corners(&[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)]), color),
        2 => canvas.fill(&corners(&[(0.0, -1.2), (1.1, 0.8), (-1.1, 0.8)]), color),
        3 => canvas.fill(&corners(&[(0.0, -1.3), (1.1, 0.0), (0.0, 1.3), (-1.1, 0.0)]), color),
        _ => canvas.fill(&corners(&[(-1.1, -0.8), (1.1, -0.8), (0.0, 1.2)]), color),
    }
}
