//! A grid of words and colours, by two axes.

use plotters::prelude::{DrawingBackend, RGBColor};

use super::canvas::{Anchor, Canvas, Drawn, Figure, INK, width};
use super::panel::{TEXT, TITLE};

/// What a cell holds, and how many of it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Entry {
    pub word: &'static str,
    /// Red, green, blue.
    pub color: [u8; 3],
    pub count: usize,
}

/// The grid.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Map {
    pub title: String,
    pub x_label: String,
    pub y_label: String,
    pub columns: Vec<String>,
    pub rows: Vec<String>,
    /// Row by row, the first at the top; the last entry of a cell gives its colour.
    pub cells: Vec<Vec<Vec<Entry>>>,
}

const ROW: f64 = 44.0;
const TOP: f64 = 50.0;
const MARGIN: f64 = 16.0;

impl Map {
    fn words(cell: &[Entry]) -> Vec<String> {
        let all: usize = cell.iter().map(|entry| entry.count).sum();
        cell.iter()
            .map(|entry| match all {
                1 => entry.word.to_owned(),
                _ => format!("{} {}/{all}", entry.word, entry.count),
            })
            .collect()
    }

    fn column_width(&self) -> f64 {
        let words = self.cells.iter().flatten().flat_map(|cell| Self::words(cell));
        let widest = words.chain(self.columns.iter().cloned()).map(|text| width(&text, TEXT));
        widest.fold(70.0, f64::max) + 16.0
    }

    fn row_height(&self) -> f64 {
        let lines = self.cells.iter().flatten().map(Vec::len).max().unwrap_or(1);
        ROW.max(20.0 * lines as f64 + 12.0)
    }

    /// Where the grid starts: right of the names of the rows.
    fn left(&self) -> f64 {
        let names = self.rows.iter().map(|name| width(name, TEXT)).fold(0.0, f64::max);
        MARGIN + 26.0 + names + 10.0
    }
}

impl Figure for Map {
    fn size(&self) -> (u32, u32) {
        let wide = self.left() + self.column_width() * self.columns.len() as f64 + MARGIN;
        let high = TOP + self.row_height() * self.rows.len() as f64 + 62.0;
        (wide.max(width(&self.title, TITLE) + 2.0 * MARGIN) as u32, high as u32)
    }

    fn draw<B: DrawingBackend>(&self, canvas: &Canvas<'_, B>) -> Drawn {
        canvas.text(&self.title, (MARGIN, 22.0), TITLE, INK, Anchor::Left)?;
        let (left, wide, high) = (self.left(), self.column_width(), self.row_height());
        for (j, name) in self.rows.iter().enumerate() {
            let top = TOP + high * j as f64;
            canvas.text(name, (left - 10.0, top + 0.5 * high), TEXT, INK, Anchor::Right)?;
            for (i, cell) in self.cells[j].iter().enumerate() {
                let x = left + wide * i as f64;
                let corners = [(x, top), (x + wide, top), (x + wide, top + high), (x, top + high)];
                let [red, green, blue] = cell.last().map_or([255; 3], |entry| entry.color);
                canvas.fill(&corners, RGBColor(red, green, blue))?;
                canvas.line(
                    &[corners[0], corners[1], corners[2], corners[3], corners[0]],
                    INK,
                    1.0,
                )?;
                let words = Self::words(cell);
                for (n, text) in words.iter().enumerate() {
                    let shift = 20.0 * (n as f64 - 0.5 * (words.len() as f64 - 1.0));
                    let middle = (x + 0.5 * wide, top + 0.5 * high + shift);
                    canvas.text(text, middle, TEXT, INK, Anchor::Center)?;
                }
            }
        }
        let bottom = TOP + high * self.rows.len() as f64;
        for (i, name) in self.columns.iter().enumerate() {
            let x = left + wide * (i as f64 + 0.5);
            canvas.text(name, (x, bottom + 8.0), TEXT, INK, Anchor::Top)?;
        }
        let middle = left + 0.5 * wide * self.columns.len() as f64;
        canvas.text(&self.x_label, (middle, bottom + 42.0), TEXT, INK, Anchor::Center)?;
        let middle = 0.5 * (TOP + bottom);
        canvas.text(&self.y_label, (MARGIN + 6.0, middle), TEXT, INK, Anchor::Upwards)
    }
}
