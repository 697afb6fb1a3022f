//! A drawing as SVG: short, the same bytes each time, for light and dark screens.

use std::fmt::Write;

use crate::html::escaped;

use super::drawing::{Align, Drawing, Item, Paint, Place, Stroke};

/// Coordinates of the SVG per pixel: they are whole numbers.
const SHARP: f64 = 10.0;

/// The drawing as SVG. `alone`: with a style of its own, not as a part of a page that has
/// [`dark_rules`].
pub(crate) fn svg(drawing: &Drawing, alone: bool) -> String {
    let (width, height) = (drawing.width.round(), drawing.height.round());
    let mut out = format!(
        "<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {} {}\" \
         xmlns=\"http://www.w3.org/2000/svg\"",
        width * SHARP,
        height * SHARP
    );
    if alone {
        let _ = write!(out, " role=\"img\" aria-label=\"{}\"", escaped(&drawing.words));
    }
    out.push_str(">\n");
    if alone {
        let _ = writeln!(
            out,
            "<style>@media(prefers-color-scheme:dark){{{}}}</style>\n\
             <rect width=\"100%\" height=\"100%\" fill=\"{}\"/>",
            dark_rules(),
            Paint::Paper.word()
        );
    }
    out.push_str(
        "<g fill=\"none\" stroke-linejoin=\"round\" stroke-linecap=\"round\" \
         font-family=\"DejaVu Sans,Verdana,sans-serif\">\n",
    );
    let mut path: Option<(String, u32)> = None;
    for item in &drawing.items {
        let (attributes, patch) = match item {
            Item::Area { fill, edge, patch, .. } => (area_style(*fill, *edge), *patch),
            Item::Line { stroke, .. } => (line_style(*stroke), 0),
            Item::Text { text, at, size, paint, align } => {
                end(&mut out, &mut path);
                let words = Words { text, at: *at, size: *size, paint: *paint, align: *align };
                words.write(&mut out);
                continue;
            }
        };
        // Areas of a patch that look alike are one path: they do not cover each other.
        if path.as_ref() != Some(&(attributes.clone(), patch)) || patch == u32::MAX {
            end(&mut out, &mut path);
            let _ = write!(out, "<path{attributes} d=\"");
            path = Some((attributes, patch));
        }
        match item {
            Item::Area { points, .. } => trace(&mut out, points, true),
            Item::Line { points, .. } => trace(&mut out, points, false),
            Item::Text { .. } => {}
        }
    }
    end(&mut out, &mut path);
    out.push_str("</g>\n</svg>\n");
    out
}

/// What a page needs for drawings in the dark.
pub(crate) fn dark_rules() -> String {
    let mut rules = String::new();
    for paint in Paint::NAMED {
        if let Some(dark) = paint.in_the_dark() {
            let word = paint.word();
            let _ = write!(
                rules,
                "svg [fill=\"{word}\"]{{fill:{dark}}}svg [stroke=\"{word}\"]{{stroke:{dark}}}"
            );
        }
    }
    rules
}

fn end(out: &mut String, path: &mut Option<(String, u32)>) {
    if path.take().is_some() {
        out.push_str("\"/>\n");
    }
}

fn area_style(fill: Paint, edge: Option<Stroke>) -> String {
    let edge = edge.map(line_style).unwrap_or_default();
    format!(" fill=\"{}\"{edge}", fill.word())
}

fn line_style(stroke: Stroke) -> String {
    let width = (stroke.width * SHARP).round();
    format!(" stroke=\"{}\" stroke-width=\"{width}\"", stroke.paint.word())
}

/// A run through points by its steps; nothing where it has no length.
fn trace(out: &mut String, points: &[Place], closed: bool) {
    let whole = |p: &Place| p.map(|c| (c * SHARP).round() as i64);
    let mut places: Vec<[i64; 2]> = points.iter().map(whole).collect();
    places.dedup();
    let Some(first) = places.first().copied() else { return };
    let _ = write!(out, "M{} {}", first[0], first[1]);
    let mut last = first;
    for (i, place) in places.iter().enumerate().skip(1) {
        out.push_str(if i == 1 { "l" } else { "" });
        for c in 0..2 {
            let step = place[c] - last[c];
            // A sign parts numbers as well as a blank does.
            let apart = if step < 0 || (i == 1 && c == 0) { "" } else { " " };
            let _ = write!(out, "{apart}{step}");
        }
        last = *place;
    }
    if places.len() == 1 {
        out.push_str("h0");
    }
    if closed {
        out.push('z');
    }
}

struct Words<'a> {
    text: &'a str,
    at: Place,
    size: f64,
    paint: Paint,
    align: Align,
}

impl Words<'_> {
    fn write(&self, out: &mut String) {
        let [x, y] = self.at;
        let anchor = match self.align {
            Align::Left => "",
            Align::Middle => " text-anchor=\"middle\"",
        };
        // The middle of small letters and capitals is about a third of the height above the line.
        let line = (y + 0.35 * self.size) * SHARP;
        let _ = writeln!(
            out,
            "<text x=\"{:.0}\" y=\"{line:.0}\" font-size=\"{:.0}\" fill=\"{}\"{anchor}>{}</text>",
            x * SHARP,
            self.size * SHARP,
            self.paint.word(),
            escaped(self.text)
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawing() -> Drawing {
        let mut drawing = Drawing::new(100.0);
        drawing.height = 50.0;
        drawing.words = "a & b".to_owned();
        for x in [0.0, 10.0] {
            let points = vec![[x, 0.0], [x + 9.0, 0.04], [x + 9.0, 9.0]];
            let edge = Some(Stroke::new(Paint::Edge, 0.7));
            drawing.items.push(Item::Area {
                points,
                fill: Paint::Color([1, 2, 255]),
                edge,
                patch: 3,
            });
        }
        drawing.line(vec![[1.0, 1.0], [2.0, 0.0]], Stroke::new(Paint::Ink, 1.0));
        drawing.text("x < 1", [5.0, 10.0], Align::Middle);
        drawing
    }

    #[test]
    fn areas_of_a_patch_share_a_path() {
        let text = svg(&drawing(), false);
        let path = "<path fill=\"#0102ff\" stroke=\"#2F3B45\" stroke-width=\"7\" \
                    d=\"M0 0l90 0 0 90zM100 0l90 0 0 90z\"/>";
        assert!(text.contains(path), "{text}");
        assert!(text.contains("stroke-width=\"10\" d=\"M10 10l10-10\"/>"), "{text}");
        assert!(text.contains("text-anchor=\"middle\">x &lt; 1</text>"), "{text}");
        assert!(!text.contains("<style>") && !text.contains("aria-label"));
        assert_eq!(text, svg(&drawing(), false));
    }

    #[test]
    fn a_drawing_alone_has_its_colours_for_the_dark() {
        let text = svg(&drawing(), true);
        assert!(text.contains("role=\"img\" aria-label=\"a &amp; b\""));
        for paint in Paint::NAMED {
            let rule = format!("[fill=\"{}\"]{{fill:", paint.word());
            assert_eq!(text.contains(&rule), paint.in_the_dark().is_some(), "{paint:?}");
        }
    }
}
