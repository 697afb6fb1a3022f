//! How the equations are solved.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The solver section of a case file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SolverSpec {
    /// The linear solver.
    pub linear: Linear,
    /// Largest out-of-balance force over the largest nodal force scale at convergence.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub tolerance: f64,
    /// Largest number of Newton corrections in one step.
    #[schemars(range(min = 1, max = 1000))]
    pub max_newton: usize,
    /// Options for PETSc, as on a command line.
    pub petsc_options: String,
    /// The algebraic form of the interface equations.
    pub form: Form,
    /// What is done about states that are not stable.
    pub stability: Stability,
    /// Whether each node stores the fluid of its share of a cell by its own pressure (with flow).
    pub lumped_storage: bool,
}

impl Default for SolverSpec {
    fn default() -> Self {
        SolverSpec {
            linear: Linear::Auto,
            tolerance: 1.0e-9,
            max_newton: 30,
            petsc_options: String::new(),
            form: Form::Condensed,
            stability: Stability::Auto,
            lumped_storage: false,
        }
    }
}

/// A linear solver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Linear {
    /// Chosen by size and shape
    Auto,
    /// Parallel sparse direct solver
    Mumps,
    /// Smoothed aggregation of blocks, in cycles of single precision.
    Aggregation,
    /// Algebraic multigrid by smoothed aggregation, with rigid-body modes
    Gamg,
    /// BoomerAMG
    Hypre,
    /// Geometric multigrid without a matrix, over coarser lattices of the same column, or over
    /// the meshes that `mesh.refine` makes of a file
    Multigrid,
}

/// What is done about states that are not stable: where the tangent of a softening state has a
/// negative eigenvalue.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Stability {
    /// States are tested where the linear solver meets an indefinite tangent, and reported; a
    /// smaller step is tried where that may lead elsewhere
    Auto,
    /// Nothing is tested
    Off,
    /// All states that soften are tested and reported
    Warn,
    /// All states that soften are tested; from one that is not stable the solution goes on along
    /// the unstable mode to one that is
    Follow,
    /// All states that soften are tested; a smaller step is tried, and where that is unstable too,
    /// the run ends
    Stop,
}

/// The algebraic form of the interface equations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// Displacements only; the multipliers are eliminated node by node
    Condensed,
    /// Displacements and multipliers together, a cross-check; needs mumps
    SaddlePoint,
}

/// Whether a smaller model may take the place of the one asked for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Reduce {
    /// Where its error is bounded by solver.tolerance and nothing that it leaves out can become
    /// unstable
    #[default]
    Auto,
    /// The model asked for is solved
    Never,
}
