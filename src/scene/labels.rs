//! Names beside a scene, with lines that lead to what they name, and legends below.

use crate::chart::width;

use super::drawing::{Align, Drawing, Paint, Place, Stroke, TEXT};
use super::levels::{Levels, lit};
use super::symbols::head;
use super::view::{Camera, View};

/// Height of a line of text.
pub(super) const LINE: f64 = 17.0;
/// Room between labels.
const APART: f64 = 8.0;

/// What names a place of a scene.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Label {
    pub at: Place,
    pub name: String,
    pub lines: Vec<(String, Paint)>,
}

impl Label {
    fn height(&self) -> f64 {
        LINE * (1.0 + self.lines.len() as f64)
    }

    /// The width of the longest of its lines.
    pub fn width(&self) -> f64 {
        let lines = self.lines.iter().map(|(text, _)| text).chain([&self.name]);
        lines.map(|text| width(text, TEXT)).fold(0.0, f64::max)
    }
}

/// Where labels stand: from top to bottom, at this distance from the left edge.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stack {
    pub left: f64,
    pub top: f64,
}

/// Writes labels in the order of their places, none upon another, and returns where they end.
pub(crate) fn column(drawing: &mut Drawing, mut labels: Vec<Label>, place: Stack) -> f64 {
    labels.sort_by(|a, b| a.at[1].total_cmp(&b.at[1]).then(a.name.cmp(&b.name)));
    let mut end = place.top;
    for label in labels {
        let wanted = label.at[1] - 0.5 * LINE;
        let top = wanted.max(end);
        let y = top + 0.5 * LINE;
        let elbow = [place.left - 16.0, y];
        drawing.line(vec![label.at, elbow, [place.left - 5.0, y]], Stroke::new(Paint::Soft, 0.8));
        dot(drawing, label.at);
        drawing.text(label.name.clone(), [place.left, y], Align::Left);
        for (i, (text, paint)) in label.lines.iter().enumerate() {
            let y = y + LINE * (1.0 + i as f64);
            drawing.write(text.clone(), [place.left, y], TEXT, *paint, Align::Left);
        }
        end = top + label.height() + APART;
    }
    end
}

/// A small dot, as an area of eight corners.
fn dot(drawing: &mut Drawing, [x, y]: Place) {
    let corner = |i: u32| {
        let (sin, cos) = (f64::from(i) * std::f64::consts::FRAC_PI_4).sin_cos();
        [x + 2.6 * cos, y + 2.6 * sin]
    };
    let edge = Some(Stroke::new(Paint::Paper, 0.8));
    drawing.area((0..8).map(corner).collect(), Paint::Ink, edge);
}

/// The axes of space, their origin at a place.
pub(crate) fn axes(drawing: &mut Drawing, view: &View, at: Place) {
    const LENGTH: f64 = 30.0;
    for (c, name) in ["x", "y", "z"].into_iter().enumerate() {
        let mut way = [0.0; 3];
        way[c] = 1.0;
        let [right, up] = view.place(way);
        let size = right.hypot(up);
        if size < 0.2 {
            continue;
        }
        let end = [at[0] + LENGTH * right, at[1] - LENGTH * up];
        drawing.line(vec![at, end], Stroke::new(Paint::Soft, 1.2));
        let direction = [right / size, -up / size];
        head(drawing, end, direction, Paint::Soft);
        let text = [end[0] + 9.0 * direction[0], end[1] + 9.0 * direction[1]];
        drawing.write(name, text, TEXT, Paint::Soft, Align::Middle);
    }
}

/// A bar of a round length, with that length, and returns where it ends.
pub(crate) fn scale_bar(drawing: &mut Drawing, camera: &Camera, at: Place) -> f64 {
    const LONGEST: f64 = 110.0;
    let round = super::levels::round_up(LONGEST / camera.scale);
    let length = [1.0, 0.8, 0.5, 0.4, 0.25, 0.2, 0.1]
        .map(|factor| factor * round)
        .into_iter()
        .find(|length| length * camera.scale <= LONGEST)
        .unwrap_or(0.1 * round);
    let pixels = length * camera.scale;
    let end = [at[0] + pixels, at[1]];
    drawing.line(vec![at, end], Stroke::new(Paint::Soft, 1.4));
    for x in [at[0], end[0]] {
        drawing.line(vec![[x, at[1] - 4.0], [x, at[1] + 4.0]], Stroke::new(Paint::Soft, 1.4));
    }
    let text = crate::chart::Unit::text("m", length);
    let wide = width(&text, TEXT);
    drawing.write(text, [end[0] + 8.0, at[1]], TEXT, Paint::Soft, Align::Left);
    end[0] + 8.0 + wide
}

/// A legend from a place down; returns where it ends. `room`: how wide it may be.
pub(crate) fn legend(
    drawing: &mut Drawing,
    levels: &Levels,
    words: &str,
    [left, top]: Place,
    room: f64,
) -> f64 {
    const BAR: f64 = 13.0;
    let color = |band: usize| lit(levels.color(band), 1.0);
    let edge = Some(Stroke::new(Paint::Soft, 0.6));
    let block =
        |x: f64, y: f64, wide: f64| vec![[x, y], [x + wide, y], [x + wide, y + BAR], [x, y + BAR]];
    match levels {
        Levels::Bands { .. } => {
            let (texts, unit) = levels.marks();
            let title =
                if unit.is_empty() { words.to_owned() } else { format!("{words} [{unit}]") };
            let left = left + 12.0;
            drawing.text(title, [left, top + 0.5 * LINE], Align::Left);
            let y = top + LINE + 3.0;
            let wide = (room - 30.0).min(520.0) / levels.count() as f64;
            for band in 0..levels.count() {
                drawing.area(block(left + wide * band as f64, y, wide), color(band), edge);
            }
            // As many numbers as there is room for.
            let longest = texts.iter().map(|text| width(text, TEXT)).fold(0.0, f64::max) + 8.0;
            let stride = (longest / wide).ceil().max(1.0) as usize;
            for (i, text) in texts.iter().enumerate().filter(|(i, _)| i % stride == 0) {
                let at = [left + wide * i as f64, y + BAR + 10.0];
                drawing.write(text.clone(), at, TEXT, Paint::Soft, Align::Middle);
            }
            y + BAR + 10.0 + 0.5 * LINE
        }
        Levels::Even { text, .. } => {
            drawing.area(block(left, top + 2.0, 22.0), color(0), edge);
            let text = format!("{words}: {text} everywhere");
            drawing.text(text, [left + 30.0, top + 0.5 * LINE], Align::Left);
            top + LINE
        }
        Levels::Kinds(kinds) => {
            let (mut x, mut y) = (left, top);
            if !words.is_empty() {
                drawing.text(words, [left, top + 0.5 * LINE], Align::Left);
                y += LINE + 3.0;
            }
            for (band, (_, name)) in kinds.iter().enumerate() {
                let wide = 30.0 + width(name, TEXT) + 18.0;
                if x > left && x + wide > left + room {
                    (x, y) = (left, y + LINE + 3.0);
                }
                drawing.area(block(x, y + 2.0, 22.0), color(band), edge);
                drawing.text(name.clone(), [x + 30.0, y + 0.5 * LINE], Align::Left);
                x += wide;
            }
            y + LINE
        }
    }
}
