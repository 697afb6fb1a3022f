//! What is meshed: a column and its cells, or the mesh of a file.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::GradingSection;

/// What is meshed, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshSpec {
    /// Where the cells come from.
    pub source: MeshSource,
    /// How the cells are integrated.
    pub formulation: Formulation,
    /// How many times the mesh is refined uniformly; each halves the cells along every axis.
    pub refine: u32,
}

/// Where cells come from.
#[derive(Debug, Clone, PartialEq)]
pub enum MeshSource {
    /// The boxes into which the program cuts a column.
    Boxes(ColumnSpec),
    /// A file.
    File(FileSpec),
}

/// A column that stands on z = 0, and how it is cut into cells.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnSpec {
    /// Lengths in m along x, (y,) z: two in 2D, three in 3D.
    pub size: Vec<f64>,
    /// The cells before refinement.
    pub cells: Cells,
    /// Order of the cells (1 or 2): one number for the whole column, or one for each body.
    pub orders: Vec<usize>,
    /// How they grow.
    pub grading: GradingSection,
}

/// A mesh that somebody else made.
#[derive(Debug, Clone, PartialEq)]
pub struct FileSpec {
    /// Where it is.
    pub path: PathBuf,
    /// Length in m of the unit of its coordinates.
    pub scale: f64,
    /// Whether cells of first order become cells of second order.
    pub raise_order: bool,
}

/// How the cells are integrated.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Formulation {
    /// B-bar in materials whose poisson_ratio is above 0.45, else full
    #[default]
    Auto,
    /// Full integration, which locks when the material is nearly incompressible
    Full,
    /// The volumetric strain projected on polynomials of one degree less than the order of the
    /// cell: its mean where that is 1
    BBar,
}

/// Cells along x, y, z; y is 1 in 2D.
#[derive(Debug, Clone, PartialEq)]
pub enum Cells {
    /// One grid for the whole column; interfaces inside a layer of cells split it in two.
    Uniform([usize; 3]),
    /// One grid for each body between interfaces, bottom to top.
    Bodies(Vec<[usize; 3]>),
}

/// The coordinate axes of the displacement components of a column: x, z in 2D and x, y, z in 3D.
pub fn column_axes(dim: usize) -> &'static [usize] {
    if dim == 2 { &[0, 2] } else { &[0, 1, 2] }
}

/// The coordinate axes of the displacement components on the mesh of a file: x, y in the plane
/// z = 0, and x, y, z in 3D.
pub fn file_axes(dim: usize) -> &'static [usize] {
    if dim == 2 { &[0, 1] } else { &[0, 1, 2] }
}

impl MeshSpec {
    /// The column, where that is what is meshed.
    pub fn column(&self) -> Option<&ColumnSpec> {
        match &self.source {
            MeshSource::Boxes(column) => Some(column),
            MeshSource::File(_) => None,
        }
    }

    /// The file, where the mesh comes from one.
    pub fn file(&self) -> Option<&FileSpec> {
        match &self.source {
            MeshSource::Boxes(_) => None,
            MeshSource::File(file) => Some(file),
        }
    }

    /// The order of the cells in words that follow `cells`; none for first order, and none for the
    /// cells of a file, which have orders of their own.
    pub fn order_words(&self) -> &'static str {
        match &self.source {
            MeshSource::Boxes(column) => column.order_words(),
            MeshSource::File(file) if file.raise_order => " raised to second order",
            MeshSource::File(_) => "",
        }
    }

    /// How often the mesh of a file is refined, in words that follow `cells`.
    pub fn refined_words(&self) -> String {
        match (&self.source, self.refine) {
            (MeshSource::Boxes(_), _) | (_, 0) => String::new(),
            (_, 1) => " after one refinement".to_owned(),
            (_, times) => format!(" after {times} refinements"),
        }
    }
}

impl ColumnSpec {
    /// Height of the column in m.
    pub fn height(&self) -> f64 {
        self.size[self.size.len() - 1]
    }

    /// Area of a section across the column in m2 (2D: m).
    pub fn section(&self) -> f64 {
        self.size[..self.size.len() - 1].iter().product()
    }

    fn order_words(&self) -> &'static str {
        match (self.orders.contains(&1), self.orders.contains(&2)) {
            (_, false) => "",
            (false, true) => " of second order",
            (true, true) => " of first and second order",
        }
    }

    /// Lengths along x, y, z in m; y is 0 in 2D.
    pub fn lengths(&self) -> [f64; 3] {
        match self.size[..] {
            [x, y, z] => [x, y, z],
            _ => [self.size[0], 0.0, self.height()],
        }
    }

    /// An upper bound of the number of displacement unknowns with `interfaces` interfaces and
    /// layers of cells split at `cuts` heights, after `refine` refinements; `None` where it exceeds
    /// every number.
    pub(crate) fn displacement_unknowns(
        &self,
        refine: u32,
        interfaces: usize,
        cuts: usize,
    ) -> Option<u128> {
        let dim = self.size.len();
        let factor = 1_u128.checked_shl(refine)?;
        let nodes = |(cells, order): ([usize; 3], usize), bodies: usize| -> Option<u128> {
            let factor = factor.checked_mul(order as u128)?;
            let along = |count: usize| (count as u128).checked_mul(factor)?.checked_add(1);
            let depth = if dim == 3 { along(cells[1])? } else { 1 };
            let layers = along(cells[2].checked_add(cuts)?)?.checked_add(bodies as u128 - 1)?;
            along(cells[0])?.checked_mul(depth)?.checked_mul(layers)
        };
        let total = match &self.cells {
            Cells::Uniform(cells) => nodes((*cells, self.orders[0]), interfaces + 1),
            Cells::Bodies(bodies) => {
                let mut bodies = bodies.iter().copied().zip(self.orders.iter().copied());
                bodies.try_fold(0_u128, |sum, body| sum.checked_add(nodes(body, 1)?))
            }
        };
        total?.checked_mul(dim as u128)
    }
}
