//! Horizontal planes: interfaces, ends of materials and cells must leave room between them.

use super::checker::Checker;
use crate::case::{Cells, ColumnSpec, InterfaceSpec, Material};
use crate::error::number_text;

/// Horizontal planes closer than this part of the height are one.
pub const CLOSEST_PLANES: f64 = 1e-9;

impl Checker<'_> {
    /// The layers must cover the column, each height once.
    pub(super) fn layers(&mut self, materials: &[Material], height: f64) {
        if let [only] = materials
            && only.z.is_none()
        {
            return;
        }
        let mut top = 0.0;
        for material in materials {
            let path = format!("materials.{}.z", material.name);
            let Some([low, high]) = material.z else {
                self.add(&path, "is missing; with several materials each has its heights");
                return;
            };
            if low >= high {
                self.add(&path, format!("must rise, got [{low}, {high}]"));
                return;
            }
            // Each end may become one with another plane.
            let thinnest = 2.0 * CLOSEST_PLANES * height;
            if high - low <= thinnest {
                let reason = format!(
                    "is {:.2e} m thick, got [{low}, {high}]; a layer must be thicker than {} m, {:e} \
                     of the height: leave it out",
                    high - low,
                    number_text(thinnest),
                    2.0 * CLOSEST_PLANES
                );
                self.add(&path, reason);
            }
            if low != top {
                let what = if low > top { "leaves a gap" } else { "overlaps" };
                self.add(&path, format!("{what} between {} and {}", low.min(top), low.max(top)));
            }
            top = high;
        }
        if top != height {
            let name = materials.last().map_or("", |material| &material.name);
            let reason = format!("ends at {top}, but the column is {height} high");
            self.add(&format!("materials.{name}.z"), reason);
        }
    }

    /// Refuses an interface too close to a plane below or to the top for cells between them.
    pub(super) fn distance(&mut self, path: &str, z: f64, below: Option<f64>, height: f64) {
        let closest = CLOSEST_PLANES * height;
        let lower = below.map_or(("the bottom".to_owned(), 0.0), |below| {
            (format!("the interface before it at {}", number_text(below)), below)
        });
        for (what, apart) in [(lower.0, z - lower.1), ("the top".to_owned(), height - z)] {
            if apart > 0.0 && apart <= closest {
                let reason = format!(
                    "is {apart:.2e} m from {what}, got {}; cells between them need more than {} m, \
                     {CLOSEST_PLANES:e} of the height: move it, or leave it out",
                    number_text(z),
                    number_text(closest),
                );
                self.add(path, reason);
            }
        }
    }

    /// Refuses bodies whose own cells would be thinner than planes are told apart.
    pub(super) fn thickness(&mut self, column: &ColumnSpec, interfaces: &[InterfaceSpec]) {
        let Cells::Bodies(bodies) = &column.cells else { return };
        let closest = CLOSEST_PLANES * column.height();
        let ends = interfaces.iter().filter_map(InterfaceSpec::height).chain([column.height()]);
        let mut low = 0.0;
        for (index, (cells, high)) in bodies.iter().zip(ends).enumerate() {
            let thickness = (high - low) / cells[2] as f64;
            // Bodies that are too thin themselves have been told of.
            if thickness <= closest && high - low > closest {
                let last = self.dim - 1;
                let reason = format!(
                    "makes cells {thickness:.2e} m thick, got {}; they must be thicker than {} m, \
                     {CLOSEST_PLANES:e} of the height: give fewer",
                    cells[2],
                    number_text(closest)
                );
                self.add(&format!("mesh.column.bodies.{index}.cells.{last}"), reason);
            }
            low = high;
        }
    }
}
