//! One drawing as SVG and as PNG. The font is part of the program: no machine needs to have one.

use std::sync::LazyLock;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontTransform, register_font};

use crate::error::{Error, Result};

/// Latin, Greek and some signs of DejaVu Sans; `DejaVuSans-LICENSE.txt` beside it.
static FONT: &[u8] = include_bytes!("DejaVuSans-subset.ttf");

/// Coordinates of the SVG per unit of the drawing: they are whole numbers.
const SHARP: u32 = 8;
/// Pixels of the PNG per unit of the drawing.
const FINE: u32 = 2;
/// Each of them is the mean of so many squared.
const SMOOTH: u32 = 2;

static REGISTERED: LazyLock<bool> = LazyLock::new(|| {
    let styles = [FontStyle::Normal, FontStyle::Bold];
    styles.into_iter().all(|style| register_font("sans-serif", style, FONT).is_ok())
});

/// The colour of text and lines.
pub(super) const INK: RGBColor = RGBColor(30, 30, 30);

/// The place of a pair of axes.
pub(super) struct Frame {
    pub left: f64,
    pub top: f64,
    pub wide: f64,
    pub high: f64,
}

/// What can be drawn.
pub(crate) trait Figure {
    /// Width and height.
    fn size(&self) -> (u32, u32);
    /// Draws it, whatever the backend.
    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>) -> Drawn;
}

/// The outcome of drawing: nothing, or what the backend said.
pub(crate) type Drawn = std::result::Result<(), String>;

/// Where text is put relative to its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Left,
    Center,
    Right,
    /// Below the point, centred.
    Top,
    /// Read from below, centred.
    Upwards,
}

/// A surface whose unit is the pixel of the SVG.
pub(crate) struct Canvas<'a, B: DrawingBackend> {
    area: &'a DrawingArea<B, Shift>,
    scale: f64,
}

impl<B: DrawingBackend> Canvas<'_, B> {
    fn point(&self, (x, y): (f64, f64)) -> (i32, i32) {
        ((x * self.scale).round() as i32, (y * self.scale).round() as i32)
    }

    fn put<E>(&self, element: &E) -> Drawn
    where
        for<'b> &'b E: plotters::element::PointCollection<'b, (i32, i32)>,
        E: plotters::element::Drawable<B>,
    {
        self.area.draw(element).map_err(|cause| cause.to_string())
    }

    fn stroke(&self, color: RGBColor, width: f64) -> ShapeStyle {
        ShapeStyle::from(color).stroke_width((width * self.scale).round().max(1.0) as u32)
    }

    /// A line through points.
    pub fn line(&self, points: &[(f64, f64)], color: RGBColor, width: f64) -> Drawn {
        let points: Vec<_> = points.iter().map(|p| self.point(*p)).collect();
        self.put(&PathElement::new(points, self.stroke(color, width)))
    }

    /// A line of dashes through points.
    pub fn dashes(&self, points: &[(f64, f64)], color: RGBColor, width: f64) -> Drawn {
        const DASH: f64 = 6.0;
        for pair in points.windows(2) {
            let (dx, dy) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
            let length = dx.hypot(dy);
            let pieces = (length / (2.0 * DASH)).ceil().clamp(1.0, 1000.0);
            for piece in 0..pieces as u32 {
                let at = |share: f64| {
                    let s = ((f64::from(piece) + share) / pieces).min(1.0);
                    (pair[0].0 + s * dx, pair[0].1 + s * dy)
                };
                self.line(&[at(0.0), at(0.55)], color, width)?;
            }
        }
        Ok(())
    }

    /// A filled polygon.
    pub fn fill(&self, corners: &[(f64, f64)], color: RGBColor) -> Drawn {
        let points: Vec<_> = corners.iter().map(|p| self.point(*p)).collect();
        self.put(&Polygon::new(points, color.filled()))
    }

    /// A circle, filled or as a ring.
    pub fn circle(&self, at: (f64, f64), radius: f64, color: RGBColor, ring: Option<f64>) -> Drawn {
        let style = match ring {
            Some(width) => self.stroke(color, width),
            None => color.filled(),
        };
        self.put(&Circle::new(self.point(at), (radius * self.scale).round() as i32, style))
    }

    /// Text of a height.
    pub fn text(
        &self,
        text: &str,
        at: (f64, f64),
        height: f64,
        color: RGBColor,
        anchor: Anchor,
    ) -> Drawn {
        let (h, v) = match anchor {
            Anchor::Left => (HPos::Left, VPos::Center),
            Anchor::Center | Anchor::Upwards => (HPos::Center, VPos::Center),
            Anchor::Right => (HPos::Right, VPos::Center),
            Anchor::Top => (HPos::Center, VPos::Top),
        };
        let mut font = ("sans-serif", height * self.scale).into_font();
        if anchor == Anchor::Upwards {
            font = font.transform(FontTransform::Rotate270);
        }
        let style = TextStyle::from(font).color(&color).pos(Pos::new(h, v));
        self.put(&Text::new(text.to_owned(), self.point(at), style))
    }
}

/// About the width of a text of a height.
pub(crate) fn width(text: &str, height: f64) -> f64 {
    0.56 * height * text.chars().count() as f64
}

/// The drawing as SVG text.
///
/// # Errors
/// `Bug` when the font or the backend fails.
pub(crate) fn svg(figure: &impl Figure) -> Result<String> {
    let mut text = String::new();
    let (width, height) = figure.size();
    let (wide, high) = (width * SHARP, height * SHARP);
    {
        let area = SVGBackend::with_string(&mut text, (wide, high)).into_drawing_area();
        draw(figure, &area, f64::from(SHARP))?;
    }
    let large = format!("width=\"{wide}\" height=\"{high}\" viewBox");
    Ok(text.replacen(&large, &format!("width=\"{width}\" height=\"{height}\" viewBox"), 1))
}

/// The drawing as the bytes of a PNG file.
///
/// # Errors
/// As [`svg`].
pub(crate) fn png(figure: &impl Figure) -> Result<Vec<u8>> {
    let (width, height) = figure.size();
    let factor = FINE * SMOOTH;
    let (large, rows) = ((width * factor) as usize, (height * factor) as usize);
    let mut pixels = vec![255; 3 * large * rows];
    {
        let size = (width * factor, height * factor);
        let area = BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area();
        draw(figure, &area, f64::from(factor))?;
    }
    let (width, height) = (width * FINE, height * FINE);
    let smooth = SMOOTH as usize;
    let mut small = Vec::with_capacity(3 * (width * height) as usize);
    for row in 0..height as usize {
        for column in 0..width as usize {
            for channel in 0..3 {
                let mut sum = 0_u32;
                for part in 0..smooth * smooth {
                    let (y, x) = (row * smooth + part / smooth, column * smooth + part % smooth);
                    sum += u32::from(pixels[3 * (y * large + x) + channel]);
                }
                small.push((sum / (SMOOTH * SMOOTH)) as u8);
            }
        }
    }
    let failed = |cause: png::EncodingError| Error::Bug(format!("chart: {cause}"));
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(&small).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(bytes)
}

fn draw<B: DrawingBackend>(
    figure: &impl Figure,
    area: &DrawingArea<B, Shift>,
    scale: f64,
) -> Result<()> {
    if !*REGISTERED {
        return Err(Error::Bug("chart: the font cannot be read".to_owned()));
    }
    let failed = |cause: String| Error::Bug(format!("chart: {cause}"));
    area.fill(&WHITE).map_err(|cause| failed(cause.to_string()))?;
    figure.draw(&Canvas { area, scale }).map_err(failed)?;
    area.present().map_err(|cause| failed(cause.to_string()))
}
