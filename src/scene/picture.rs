//! A drawing or a chart with its name and what is said of it.

use crate::chart::{Panels, png, svg as chart_svg, width};
use crate::error::Result;

use super::drawing::{Align, Drawing, Paint, TEXT};
use super::labels::LINE;
use super::svg::svg;

/// A picture of a run.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Picture {
    /// Its name on a page.
    pub id: String,
    pub caption: String,
    content: Content,
}

#[derive(Debug, Clone, PartialEq)]
enum Content {
    Drawing(Drawing),
    Chart(Panels),
}

/// Wider than this it takes the whole width of a page (pixels).
const NARROW: f64 = 700.0;

impl Picture {
    pub fn drawn(id: &str, drawing: Drawing, caption: String) -> Self {
        Self { id: id.to_owned(), caption, content: Content::Drawing(drawing) }
    }

    pub fn charted(id: &str, panels: Panels, caption: String) -> Self {
        Self { id: id.to_owned(), caption, content: Content::Chart(panels) }
    }

    /// With what is said of it below, for a file of its own.
    pub fn captioned(mut self) -> Self {
        if let Content::Drawing(drawing) = &mut self.content {
            let most = ((drawing.width - 32.0) / width("m", TEXT)) as usize;
            let mut line = String::new();
            // Blanks that do not break stay.
            let words = self.caption.split(' ').filter(|word| !word.is_empty());
            for word in words.chain([""]) {
                if word.is_empty() || line.chars().count() + word.chars().count() > most {
                    let at = [16.0, drawing.height + 8.0];
                    drawing.write(std::mem::take(&mut line), at, TEXT, Paint::Soft, Align::Left);
                    drawing.height += LINE;
                }
                line += &format!("{word} ");
            }
            drawing.height += 8.0;
        }
        self
    }

    /// As SVG; `alone`: in a file of its own, not in a page.
    ///
    /// # Errors
    /// `Bug` when a chart cannot be drawn.
    pub fn svg(&self, alone: bool) -> Result<String> {
        match &self.content {
            Content::Drawing(drawing) => Ok(svg(drawing, alone)),
            Content::Chart(panels) => chart_svg(panels),
        }
    }

    /// As the bytes of a PNG file, for paper.
    ///
    /// # Errors
    /// `Bug` when it cannot be drawn.
    pub fn png(&self) -> Result<Vec<u8>> {
        match &self.content {
            Content::Drawing(drawing) => png(drawing),
            Content::Chart(panels) => png(panels),
        }
    }

    /// What it shows, for who cannot see it.
    pub fn words(&self) -> String {
        match &self.content {
            Content::Drawing(drawing) => drawing.words.clone(),
            Content::Chart(panels) => {
                let axes =
                    panels.panels.iter().map(|p| format!("{} over {}", p.y_label, p.x_label));
                format!("{}: {}", panels.title, axes.collect::<Vec<_>>().join("; "))
            }
        }
    }

    /// Whether it is for the whole width of a page.
    pub fn is_wide(&self) -> bool {
        match &self.content {
            Content::Drawing(drawing) => drawing.width > NARROW,
            Content::Chart(panels) => panels.panels.len() > 1,
        }
    }
}
