//! The mesh: a column and its cells, or a file.

use std::path::Path;

use super::checker::Checker;
use crate::case::sections::GradingSection;
use crate::case::sections::file::{CaseFile, ColumnSection};
use crate::case::{Cells, ColumnSpec, FileSpec, MeshSource, MeshSpec};
use crate::error::number_text;

/// Lengths (m) whose volumes and stiffnesses are numbers that a computer has.
const LENGTHS: std::ops::RangeInclusive<f64> = 1e-50..=1e50;

impl Checker<'_> {
    /// What is meshed; a unit square where the case does not say it. A file is sought from the
    /// folder of the case file at `path`.
    pub(super) fn mesh(&mut self, file: &CaseFile, path: &Path) -> MeshSpec {
        let section = &file.mesh;
        let source = match (&section.column, &section.file) {
            (Some(column), None) => self.column(file, column).map(MeshSource::Boxes),
            (None, Some(name)) => self.mesh_file(file, name, path).map(MeshSource::File),
            (Some(_), Some(_)) => {
                self.add("mesh.file", "cannot stand beside column; give one of them");
                None
            }
            (None, None) => {
                self.add("mesh", "needs a column or a file");
                None
            }
        };
        let source = source.unwrap_or_else(|| {
            self.broken.insert("mesh".to_owned());
            let cells = Cells::Uniform([1; 3]);
            let (size, orders, grading) = (vec![1.0; 2], vec![1], GradingSection::default());
            MeshSource::Boxes(ColumnSpec { size, cells, orders, grading })
        });
        MeshSpec { source, formulation: section.formulation, refine: section.refine }
    }

    fn column(&mut self, file: &CaseFile, column: &ColumnSection) -> Option<ColumnSpec> {
        self.is_column(column.size.len());
        let of_files = [
            ("scale", file.mesh.scale.is_some(), "give the size of the column in m"),
            ("raise_order", file.mesh.raise_order.is_some(), "a column takes order: 2"),
        ];
        for (key, _, instead) in of_files.iter().filter(|(_, given, _)| *given) {
            self.add(&format!("mesh.{key}"), format!("is for meshes from files; {instead}"));
        }
        let mut is_sound = true;
        for (index, length) in column.size.iter().enumerate() {
            let path = format!("mesh.column.size.{index}");
            if *length <= 0.0 {
                self.add(&path, format!("must be positive, got {}", number_text(*length)));
                is_sound = false;
            } else if !LENGTHS.contains(length) {
                let (least, most) = (LENGTHS.start(), LENGTHS.end());
                let got = number_text(*length);
                self.add(&path, format!("must be between {least:e} and {most:e} m, got {got}"));
                is_sound = false;
            }
        }
        let cells = match (&column.cells, &column.bodies) {
            (Some(cells), None) => Cells::Uniform(self.grid("mesh.column.cells", cells)?),
            (None, Some(bodies)) => {
                let grids = bodies.iter().enumerate().map(|(index, body)| {
                    self.grid(&format!("mesh.column.bodies.{index}.cells"), &body.cells)
                });
                // All of them are looked at.
                let grids: Vec<Option<[usize; 3]>> = grids.collect();
                Cells::Bodies(grids.into_iter().collect::<Option<_>>()?)
            }
            // They are found.
            (None, None) if file.accuracy.is_some() => Cells::Uniform([1; 3]),
            (both, _) => {
                let what = if both.is_some() { "has both" } else { "needs" };
                let word = if both.is_some() { "and" } else { "or" };
                self.add("mesh.column", format!("{what} cells {word} bodies; give one of them"));
                return None;
            }
        };
        let by_default = if file.accuracy.is_some() { 2 } else { 1 };
        let order = |given: Option<u32>| given.or(file.mesh.order).unwrap_or(by_default) as usize;
        let orders = match &column.bodies {
            Some(bodies) => bodies.iter().map(|body| order(body.order)).collect(),
            None => vec![order(None)],
        };
        let (size, grading) = (column.size.clone(), column.grading.clone().unwrap_or_default());
        is_sound.then_some(ColumnSpec { size, cells, orders, grading })
    }

    fn grid(&mut self, path: &str, cells: &[u64]) -> Option<[usize; 3]> {
        let count = |index: usize| usize::try_from(cells[index]).unwrap_or(usize::MAX);
        match (self.dim, cells.len()) {
            (2, 2) => Some([count(0), 1, count(1)]),
            (3, 3) => Some([count(0), count(1), count(2)]),
            (dim, length) => {
                self.add(path, format!("must have {dim} entries as size has, got {length}"));
                None
            }
        }
    }

    fn mesh_file(&mut self, file: &CaseFile, name: &str, path: &Path) -> Option<FileSpec> {
        self.is_file();
        let section = &file.mesh;
        if section.order.is_some() {
            let reason = "is for columns; the cells of a file have orders of their own, which \
                          raise_order: 2 raises";
            self.add("mesh.order", reason);
        }
        if name.trim().is_empty() {
            self.add("mesh.file", "is empty; it must name a mesh file, MSH or MED");
            return None;
        }
        let scale = section.scale.unwrap_or(1.0);
        if !LENGTHS.contains(&scale) {
            let (least, most) = (LENGTHS.start(), LENGTHS.end());
            let got = number_text(scale);
            let reason = format!("must be between {least:e} and {most:e} m, got {got}");
            self.add("mesh.scale", reason);
        }
        let path = path.parent().unwrap_or(Path::new("")).join(name);
        Some(FileSpec { path, scale, raise_order: section.raise_order.is_some() })
    }
}
