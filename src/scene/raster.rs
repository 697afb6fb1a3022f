//! A drawing as an image, by the means of the charts: the font is that of the program.

use plotters::prelude::{DrawingBackend, RGBColor};

use crate::chart::{Anchor, Canvas, Drawn, Figure};

use super::drawing::{Align, Drawing, Item, Paint, Place, Stroke};

impl Figure for Drawing {
    fn size(&self) -> (u32, u32) {
        (self.width.ceil() as u32, self.height.ceil() as u32)
    }

    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>) -> Drawn {
        for item in &self.items {
            match item {
                Item::Area { points, fill, edge, .. } => {
                    canvas.fill(points_of(points).as_slice(), color(*fill))?;
                    if let Some(edge) = edge {
                        let mut around = points_of(points);
                        around.extend(around.first().copied());
                        stroke(canvas, &around, *edge)?;
                    }
                }
                Item::Line { points, stroke: with } => stroke(canvas, &points_of(points), *with)?,
                Item::Text { text, at, size, paint, align } => {
                    let anchor = match align {
                        Align::Left => Anchor::Left,
                        Align::Middle => Anchor::Center,
                    };
                    canvas.text(text, (at[0], at[1]), *size, color(*paint), anchor)?;
                }
            }
        }
        Ok(())
    }
}

fn points_of(points: &[Place]) -> Vec<(f64, f64)> {
    points.iter().map(|[x, y]| (*x, *y)).collect()
}

fn color(paint: Paint) -> RGBColor {
    let [r, g, b] = paint.color();
    RGBColor(r, g, b)
}

/// A line as one area for each of its pieces: joints of short pieces would be spikes.
fn stroke<B: DrawingBackend>(
    canvas: &Canvas<'_, B>,
    points: &[(f64, f64)],
    stroke: Stroke,
) -> Drawn {
    let half = 0.5 * stroke.width.max(0.6);
    for pair in points.windows(2) {
        let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
        let long = (x1 - x0).hypot(y1 - y0);
        if long == 0.0 {
            continue;
        }
        let (dx, dy) = (half * (x1 - x0) / long, half * (y1 - y0) / long);
        let corners = [
            (x0 - dx - dy, y0 - dy + dx),
            (x1 + dx - dy, y1 + dy + dx),
            (x1 + dx + dy, y1 + dy - dx),
            (x0 - dx + dy, y0 - dy - dx),
        ];
        canvas.fill(&corners, color(stroke.paint))?;
    }
    Ok(())
}
