//! Labels beside points that never lie upon each other.

use plotters::prelude::DrawingBackend;

use super::canvas::{Anchor, Canvas, Drawn, Frame, INK, width};

/// Height of text.
const LABEL: f64 = 12.0;

/// Labels up and right of points; those of one place, and those that would lie upon each other,
/// side by side.
pub(super) fn labels<'l, B: DrawingBackend>(
    canvas: &Canvas<'_, B>,
    frame: &Frame,
    labels: impl Iterator<Item = (Option<(f64, f64)>, &'l String)>,
) -> Drawn {
    let mut places: Vec<((f64, f64), String)> = Vec::new();
    for (point, label) in labels.filter_map(|(point, label)| Some((point?, label))) {
        let same = |p: &(f64, f64)| (p.0 - point.0).hypot(p.1 - point.1) < 8.0;
        match places.iter_mut().find(|(p, _)| same(p)) {
            Some((_, text)) => *text = format!("{text}, {label}"),
            None => places.push((point, label.clone())),
        }
    }
    // Where a text begins and at which height, and on which side of its point.
    let lay = |(x, y): (f64, f64), text: &str| {
        let fits = x + 7.0 + width(text, LABEL) < frame.left + frame.wide;
        let (x, anchor) = if fits { (x + 7.0, Anchor::Left) } else { (x - 7.0, Anchor::Right) };
        // At the upper edge there is more room below.
        (x, if y - 16.0 > frame.top { y - 9.0 } else { y + 11.0 }, anchor)
    };
    let span = |point, text: &str| {
        let (x, y, anchor) = lay(point, text);
        let wide = width(text, LABEL);
        let from = if anchor == Anchor::Left { x } else { x - wide };
        (from, from + wide, y)
    };
    let clash = |a: &((f64, f64), String), b: &((f64, f64), String)| {
        let (a, b) = (span(a.0, &a.1), span(b.0, &b.1));
        a.0 < b.1 + 2.0 && b.0 < a.1 + 2.0 && (a.2 - b.2).abs() < LABEL + 2.0
    };
    let pairs = |count: usize| (0..count).flat_map(move |b| (0..b).map(move |a| (a, b)));
    while let Some((a, b)) = pairs(places.len()).find(|(a, b)| clash(&places[*a], &places[*b])) {
        let (_, text) = places.remove(b);
        places[a].1 = format!("{}, {text}", places[a].1);
    }
    for (point, text) in places {
        let (x, y, anchor) = lay(point, &text);
        canvas.text(&text, (x, y), LABEL, INK, anchor)?;
    }
    Ok(())
}
