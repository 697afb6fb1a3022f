//! What the checks of all sections share.

use std::collections::BTreeSet;

use crate::case::sections::{column_axes, file_axes};
use crate::input::problems::Problems;
use crate::input::tree::Node;

/// A case that is being checked: its tree, and the mistakes so far.
pub(crate) struct Checker<'a> {
    pub tree: &'a Node,
    pub problems: Problems<'a>,
    /// Sections that could not be read and hold placeholders.
    pub broken: BTreeSet<String>,
    /// Whether the mesh comes from a file.
    pub is_of_file: bool,
    /// The dimension of that mesh, once it has been read.
    pub dim_of_file: Option<usize>,
    /// 2 or 3.
    pub dim: usize,
    /// The coordinate axes of the components.
    pub axes: &'static [usize],
    /// Whether both are those of the mesh; of a mesh that has not been read they are the most that
    /// it may have.
    pub knows_dimension: bool,
    pub left_out: Vec<String>,
    /// On which surfaces something is prescribed in any stage, whether a displacement, and whether
    /// that of a platen; none where there are no stages.
    pub surfaces_of_stages: Vec<(String, [bool; 2])>,
    /// The end of the stage whose supports and loads the case has (s); none where they are those
    /// of all instants.
    pub end_of_stage: Option<f64>,
}

impl<'a> Checker<'a> {
    /// Of a tree that `broken` sections have been found in; of a mesh file that has been read with
    /// its dimension.
    pub fn new(
        tree: &'a Node,
        problems: Problems<'a>,
        broken: BTreeSet<String>,
        dim_of_file: Option<usize>,
    ) -> Self {
        Self {
            tree,
            problems,
            broken,
            is_of_file: false,
            dim_of_file,
            dim: 2,
            axes: column_axes(2),
            knows_dimension: true,
            left_out: Vec::new(),
            surfaces_of_stages: Vec::new(),
            end_of_stage: None,
        }
    }
}

impl Checker<'_> {
    /// Takes the dimension of a column.
    pub fn is_column(&mut self, dim: usize) {
        (self.dim, self.axes) = (dim, column_axes(dim));
    }

    /// Takes what is known of a mesh file.
    pub fn is_file(&mut self) {
        let dim = self.dim_of_file.unwrap_or(3);
        (self.dim, self.axes) = (dim, file_axes(dim));
        (self.is_of_file, self.knows_dimension) = (true, self.dim_of_file.is_some());
    }

    /// Whether the mesh is known not to extend along an axis.
    pub fn lacks(&self, axis: usize) -> bool {
        self.knows_dimension && self.sound(&["mesh"]) && !self.axes.contains(&axis)
    }

    /// What is said of a component along an axis that the mesh lacks.
    pub fn lack(&self) -> &'static str {
        if self.is_of_file {
            "does not exist: the mesh lies in the plane z = 0, with components along x and y"
        } else {
            "does not exist in 2D"
        }
    }

    pub fn add(&mut self, path: &str, reason: impl std::fmt::Display) {
        self.problems.add(self.tree, path, reason);
    }

    /// Whether all these sections hold what the file says.
    pub fn sound(&self, sections: &[&str]) -> bool {
        sections.iter().all(|section| !self.broken.contains(*section))
    }
}
