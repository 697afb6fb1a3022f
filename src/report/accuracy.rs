//! What is told of a search for the mesh that gives a wanted accuracy.

use std::collections::BTreeMap;

use serde::Serialize;

/// The search: what was found, how exact it is, what it cost.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Accuracy {
    /// The relative error that was asked for.
    pub asked: f64,
    /// Whether every estimate is within it.
    pub met: bool,
    /// Why the search ended, in words.
    pub why: String,
    /// Each quantity at each instant.
    pub quantities: Vec<Quantity>,
    /// All meshes that were tried, in their order.
    pub meshes: Vec<Mesh>,
    /// The place among them of the one whose results are those of the run.
    pub chosen: usize,
    /// Of all meshes: wall-clock time in s times ranks.
    pub core_seconds: f64,
}

/// A quantity at an instant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quantity {
    /// A column of `history.csv`.
    pub quantity: String,
    /// The instant (s).
    pub at: f64,
    /// Its value.
    pub value: f64,
    /// Estimate of the value minus the exact one.
    pub error: f64,
    /// The sum of the sizes of its parts, over the value, which is held against what was asked.
    pub relative: f64,
    /// What the error is made of.
    pub parts: Parts,
    /// Whether the differences of meshes behave as the estimate takes for granted.
    pub trusted: bool,
}

/// What an error is made of, each part with its sign.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parts {
    /// Of the mesh, by axis, and `mixed`: what the axes leave together and not one by one; the mesh
    /// of a file has one part, `refine`.
    pub mesh: BTreeMap<String, f64>,
    /// Of the interfaces, where that can be told from `mesh`: on lattices the planes across an
    /// interface are those of the bodies.
    pub interface: Option<f64>,
    /// Of the length of the steps; none along a path of dissipation, whose steps are the instants.
    pub time: Option<f64>,
    /// Of the tolerance of the solver.
    pub solver: f64,
}

/// A mesh that was tried.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Mesh {
    /// What it was tried for: `base`, or which part is coarser or finer.
    pub purpose: String,
    /// Cells of each body along x, y, z; none for the mesh of a file.
    pub cells: Vec<[usize; 3]>,
    /// Largest over smallest cell along x, y, z.
    pub grading: [f64; 3],
    /// Refinements of the mesh of a file.
    pub refine: u32,
    /// Steps in the place of one.
    pub steps: u32,
    /// Tolerance of the solver.
    pub tolerance: f64,
    /// Its unknowns.
    pub unknowns: u64,
    /// Wall-clock time in s times ranks.
    pub core_seconds: f64,
    /// The quantities at the instants, in the order of `quantities`; none where it was not solved.
    pub values: Option<Vec<f64>>,
}
