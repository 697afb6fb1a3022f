//! Panels of lines and points over two scales, and the legend beside them.

use plotters::prelude::{DrawingBackend, RGBColor};

use super::canvas::{Anchor, Canvas, Drawn, Figure, Frame, INK, width};
use super::labels::labels;
use super::scale::Scale;
use super::strokes::{COLORS, Look, cross, joined, marker, without_needless};

const GREY: RGBColor = RGBColor(130, 130, 130);
const GRID: RGBColor = RGBColor(228, 228, 228);
const ZERO: RGBColor = RGBColor(176, 176, 176);

/// Heights of text.
pub(crate) const TITLE: f64 = 17.0;
pub(crate) const TEXT: f64 = 13.0;

/// A line of a panel.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Line {
    /// In the legend; nothing there if it is empty.
    pub name: String,
    /// In the order in which they are joined.
    pub points: Vec<(f64, f64)>,
    /// Ranges of y at some x.
    pub spreads: Vec<(f64, f64, f64)>,
    /// Where runs of it failed.
    pub failed: Vec<f64>,
    /// Number of its colour and marker; none for a grey line of dashes that guides the eye.
    pub style: Option<usize>,
    pub look: Look,
    /// Beside the points; none, or one for each.
    pub labels: Vec<String>,
}

impl Line {
    /// Without ranges and failures.
    pub fn new(name: &str, points: Vec<(f64, f64)>, style: Option<usize>, look: Look) -> Self {
        let (spreads, failed, labels) = (Vec::new(), Vec::new(), Vec::new());
        Self { name: name.to_owned(), points, spreads, failed, style, look, labels }
    }
}

/// One pair of axes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Panel {
    pub x: Scale,
    pub y: Scale,
    pub x_label: String,
    pub y_label: String,
    pub lines: Vec<Line>,
    /// Points that no other beats, with rising x.
    pub front: Vec<(f64, f64)>,
}

/// Panels side by side with one legend.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Panels {
    pub title: String,
    pub panels: Vec<Panel>,
    /// Whether the legend is below the panels, not beside them.
    pub below: bool,
}

const PANEL: (f64, f64) = (520.0, 400.0);
const MARGIN: f64 = 16.0;
/// Room left of a panel for its numbers and its label.
const BEFORE: f64 = 74.0;
/// Height of a line of the legend.
const ENTRY: f64 = 21.0;

impl Panels {
    fn legend(&self) -> Vec<(Mark, String)> {
        let mut entries: Vec<(Mark, String)> = Vec::new();
        for line in self.panels.iter().flat_map(|panel| &panel.lines) {
            let mark = line.style.map_or(Mark::Guide, |style| Mark::Line(style, line.look));
            if !line.name.is_empty() && !entries.iter().any(|(_, name)| *name == line.name) {
                entries.push((mark, line.name.clone()));
            }
        }
        if self.panels.iter().any(|panel| !panel.front.is_empty()) {
            entries.push((Mark::Front, "Pareto front".to_owned()));
        }
        if self.panels.iter().flat_map(|panel| &panel.lines).any(|line| !line.failed.is_empty()) {
            entries.push((Mark::Failed, "failed".to_owned()));
        }
        entries
    }

    fn legend_width(&self) -> f64 {
        let widths = self.legend().into_iter().map(|(_, name)| width(&name, TEXT));
        widths.fold(0.0, f64::max) + 50.0
    }

    fn panels_width(&self) -> f64 {
        PANEL.0 * self.panels.len() as f64
    }

    /// Where each entry of the legend begins.
    fn places(&self, legend: &[(Mark, String)]) -> Vec<(f64, f64)> {
        if !self.below {
            let left = MARGIN + self.panels_width();
            return (0..legend.len()).map(|i| (left, 58.0 + ENTRY * i as f64)).collect();
        }
        let (left, top) = (MARGIN + BEFORE, PANEL.1 + 56.0);
        let (mut x, mut y) = (left, top);
        let mut places = Vec::new();
        for (_, name) in legend {
            let wide = 0.85 * width(name, TEXT) + 54.0;
            if x > left && x + wide > 2.0 * MARGIN + self.panels_width() {
                (x, y) = (left, y + ENTRY);
            }
            places.push((x, y));
            x += wide;
        }
        places
    }
}

/// Zero stands out.
fn grid(text: &str) -> RGBColor {
    if text == "0" { ZERO } else { GRID }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Mark {
    Line(usize, Look),
    Guide,
    Front,
    Failed,
}

impl Figure for Panels {
    fn size(&self) -> (u32, u32) {
        let beside = if self.below { 0.0 } else { self.legend_width() };
        let wide = self.panels_width() + beside + 2.0 * MARGIN;
        let title = width(&self.title, TITLE) + 2.0 * MARGIN;
        let lowest = self.places(&self.legend()).last().map_or(0.0, |place| place.1);
        let high = (PANEL.1 + 50.0).max(lowest + ENTRY);
        (wide.max(title) as u32, high as u32)
    }

    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>) -> Drawn {
        canvas.text(&self.title, (MARGIN, 22.0), TITLE, INK, Anchor::Left)?;
        for (number, panel) in self.panels.iter().enumerate() {
            let left = MARGIN + PANEL.0 * number as f64;
            // Room for numbers and labels.
            let frame = Frame {
                left: left + BEFORE,
                top: 46.0,
                wide: PANEL.0 - 92.0,
                high: PANEL.1 - 56.0,
            };
            panel.draw(canvas, frame)?;
        }
        let legend = self.legend();
        for ((left, y), (mark, name)) in self.places(&legend).into_iter().zip(legend) {
            let (from, to, middle) = ((left, y), (left + 30.0, y), (left + 15.0, y));
            match mark {
                Mark::Line(style, look) => {
                    joined(canvas, &[from, to], style, look)?;
                    if look.has_markers() {
                        marker(canvas, middle, style)?;
                    }
                }
                Mark::Guide => canvas.dashes(&[from, to], GREY, 1.2)?,
                Mark::Front => {
                    canvas.circle(middle, 8.0, INK, Some(1.6))?;
                }
                Mark::Failed => cross(canvas, middle, INK)?,
            }
            canvas.text(&name, (left + 38.0, y), TEXT, INK, Anchor::Left)?;
        }
        Ok(())
    }
}

impl Panel {
    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>, frame: Frame) -> Drawn {
        let plot = Plot { panel: self, canvas, frame };
        plot.axes()?;
        plot.lines()?;
        plot.markers()?;
        for line in &self.lines {
            let points = line.points.iter().map(|p| plot.at(*p));
            labels(canvas, &plot.frame, points.zip(&line.labels))?;
        }
        for point in self.front.iter().filter_map(|p| plot.at(*p)) {
            canvas.circle(point, 8.0, INK, Some(1.6))?;
        }
        Ok(())
    }
}

/// A panel in its place.
struct Plot<'a, B: DrawingBackend> {
    panel: &'a Panel,
    canvas: &'a Canvas<'a, B>,
    frame: Frame,
}

impl<B: DrawingBackend> Plot<'_, B> {
    fn right(&self) -> f64 {
        self.frame.left + self.frame.wide
    }

    fn bottom(&self) -> f64 {
        self.frame.top + self.frame.high
    }

    fn x_at(&self, x: f64) -> Option<f64> {
        self.panel.x.place(x).map(|place| self.frame.left + place * self.frame.wide)
    }

    /// Where a point of the two scales lies.
    fn at(&self, (x, y): (f64, f64)) -> Option<(f64, f64)> {
        let y = self.panel.y.place(y).map(|place| self.bottom() - place * self.frame.high);
        Some((self.x_at(x)?, y?))
    }

    /// The frame with its marks, their numbers and what the axes are called.
    fn axes(&self) -> Drawn {
        let (canvas, panel) = (self.canvas, self.panel);
        let Frame { left, top, wide, high } = self.frame;
        let (right, bottom) = (self.right(), self.bottom());
        let mut before = f64::NEG_INFINITY;
        for (place, text) in panel.x.marks() {
            let x = left + place * wide;
            canvas.line(&[(x, top), (x, bottom)], grid(&text), 1.0)?;
            canvas.line(&[(x, bottom), (x, bottom + 5.0)], INK, 1.0)?;
            // A number that would touch the one before is left out.
            let half = 0.5 * width(&text, TEXT);
            if x - half > before + 4.0 {
                canvas.text(&text, (x, bottom + 9.0), TEXT, INK, Anchor::Top)?;
                before = x + half;
            }
        }
        for (place, text) in panel.y.marks() {
            let y = bottom - place * high;
            canvas.line(&[(left, y), (right, y)], grid(&text), 1.0)?;
            canvas.line(&[(left - 5.0, y), (left, y)], INK, 1.0)?;
            canvas.text(&text, (left - 9.0, y), TEXT, INK, Anchor::Right)?;
        }
        let corners = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
        canvas.line(&corners, INK, 1.0)?;
        let below = (left + 0.5 * wide, bottom + 42.0);
        canvas.text(&panel.x_label, below, TEXT, INK, Anchor::Center)?;
        let beside = (left - 64.0, top + 0.5 * high);
        canvas.text(&panel.y_label, beside, TEXT, INK, Anchor::Upwards)
    }

    /// What joins points, and their ranges.
    fn lines(&self) -> Drawn {
        for line in &self.panel.lines {
            let color = line.style.map_or(GREY, |style| COLORS[style % COLORS.len()]);
            let points: Vec<(f64, f64)> = line.points.iter().filter_map(|p| self.at(*p)).collect();
            match line.style {
                Some(style) if points.len() > 1 => joined(self.canvas, &points, style, line.look)?,
                None if points.len() > 1 => {
                    self.canvas.dashes(&without_needless(&points), color, 1.2)?;
                }
                _ => {}
            }
            for (x, low, high) in &line.spreads {
                if let (Some(low), Some(high)) = (self.at((*x, *low)), self.at((*x, *high))) {
                    self.canvas.line(&[low, high], color, 1.2)?;
                }
            }
        }
        Ok(())
    }

    /// Markers of points, and crosses at the upper edge where runs failed.
    fn markers(&self) -> Drawn {
        let lines = &self.panel.lines;
        for line in lines {
            let Some(style) = line.style else { continue };
            for point in line.points.iter().filter(|_| line.look.has_markers()) {
                self.at(*point).map_or(Ok(()), |point| marker(self.canvas, point, style))?;
            }
            // Side by side, where runs of several lines failed at one place.
            let shift = 7.0 * (style as f64 - 0.5 * (lines.len() as f64 - 1.0));
            for x in line.failed.iter().filter_map(|x| self.x_at(*x)) {
                let x = (x + shift).clamp(self.frame.left, self.right());
                cross(self.canvas, (x, self.frame.top), COLORS[style % COLORS.len()])?;
            }
        }
        Ok(())
    }
}
