//! The linear solver: presets, the choice between them, and how far systems are solved.

use crate::case::{Case, Form, Linear};
use crate::mesh::Column;
use crate::petsc::LinearTolerance;

/// A preset and why it was chosen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LinearChoice {
    /// Its name in the case file.
    pub preset: &'static str,
    /// Why, in words.
    pub why: String,
    /// PETSc options and their values; those of the user override them.
    pub options: Vec<(&'static str, &'static str)>,
}

/// Options of MUMPS: LDL^T, which also serves when softening makes the tangent indefinite.
const MUMPS: &[(&str, &str)] = &[
    ("ksp_type", "preonly"),
    ("pc_type", "cholesky"),
    ("pc_factor_mat_solver_type", "mumps"),
    ("mat_mumps_icntl_14", "100"),
];

/// LU for the saddle-point form, whose tangent is not symmetric.
const MUMPS_LU: &[(&str, &str)] = &[
    ("ksp_type", "preonly"),
    ("pc_type", "lu"),
    ("pc_factor_mat_solver_type", "mumps"),
    ("mat_mumps_icntl_14", "40"),
];

/// Conjugate gradients with smoothed aggregation, which needs the rigid-body modes.
const GAMG: &[(&str, &str)] = &[
    ("ksp_type", "cg"),
    ("ksp_max_it", "500"),
    ("pc_type", "gamg"),
    ("pc_gamg_threshold", "0.02"),
    ("pc_gamg_agg_nsmooths", "1"),
    ("pc_gamg_coarse_eq_limit", "1000"),
    // Eigenvalues must not outlive their matrix: with those of another branch of the laws the
    // smoother can become indefinite.
    ("pc_gamg_use_sa_esteig", "false"),
    ("mg_levels_ksp_type", "chebyshev"),
    ("mg_levels_pc_type", "jacobi"),
];

/// Conjugate gradients with BoomerAMG by unknowns: several times faster here than its defaults.
const HYPRE: &[(&str, &str)] = &[
    ("ksp_type", "cg"),
    ("ksp_max_it", "500"),
    ("pc_type", "hypre"),
    ("pc_hypre_type", "boomeramg"),
    ("pc_hypre_boomeramg_strong_threshold", "0.5"),
    ("pc_hypre_boomeramg_coarsen_type", "HMIS"),
    ("pc_hypre_boomeramg_interp_type", "ext+i"),
    ("pc_hypre_boomeramg_P_max", "4"),
    ("pc_hypre_boomeramg_agg_nl", "1"),
    ("pc_hypre_boomeramg_relax_type_all", "Chebyshev"),
];

/// Conjugate gradients with geometric multigrid; the levels come from the mesh.
const LEVELS: &[(&str, &str)] = &[
    ("ksp_type", "cg"),
    ("ksp_max_it", "500"),
    ("pc_type", "mg"),
    ("mg_coarse_ksp_type", "preonly"),
    ("mg_coarse_pc_type", "cholesky"),
    ("mg_coarse_pc_factor_mat_solver_type", "mumps"),
    ("mg_coarse_mat_mumps_icntl_14", "100"),
];

/// Name of the preset that needs a hierarchy of meshes.
pub const MULTIGRID: &str = "multigrid";

/// The presets by name; a new one is a line here.
const PRESETS: &[(&str, &[(&str, &str)])] =
    &[("mumps", MUMPS), ("gamg", GAMG), ("hypre", HYPRE), (MULTIGRID, LEVELS)];

/// Direct elimination is taken up to this many operations per unknown. Eight instants of the column:
/// MUMPS against BoomerAMG 2.0 to 2.6 s at 9e4 (8 x 8 x 40 cells), 10.4 to 8.7 s at 4e5 (12 x 12 x 60).
const DIRECT_LIMIT: f64 = 2.5e5;
/// Cells more stretched than this spoil aggregation.
const STRETCH_LIMIT: f64 = 3.0;

impl LinearChoice {
    /// The preset the case names, or the one that suits the size and shape of the problem.
    pub fn new(case: &Case, column: &Column) -> Self {
        if case.solver.form == Form::SaddlePoint {
            let why = "form: saddle_point, whose tangent is not symmetric: LU".into();
            return Self { preset: "mumps", why, options: MUMPS_LU.to_vec() };
        }
        match case.solver.linear {
            Linear::Mumps => Self::named("mumps", "asked for".into()),
            Linear::Gamg => Self::named("gamg", "asked for".into()),
            Linear::Hypre => Self::named("hypre", "asked for".into()),
            Linear::Multigrid => Self::named(MULTIGRID, "asked for".into()),
            Linear::Auto => Self::automatic(column),
        }
    }

    /// Memory per unknown (bytes) where it is not that of multigrid: the factors of MUMPS.
    pub fn bytes_per_unknown(&self) -> Option<f64> {
        (self.preset == "mumps").then_some(1.1e4)
    }

    fn named(preset: &'static str, why: String) -> Self {
        let options = PRESETS.iter().find(|(name, _)| *name == preset).map(|(_, o)| o.to_vec());
        Self { preset, why, options: options.unwrap_or_default() }
    }

    /// MUMPS while elimination is cheap: about 1.5 s^2 operations per unknown in a column whose
    /// cross-section holds s unknowns, 28 N in a compact body of N; else multigrid.
    fn automatic(column: &Column) -> Self {
        let dim = column.dim as f64;
        let unknowns = column.nodes() as f64 * dim;
        let mut lines = [0.0_f64; 3];
        for body in 0..column.bodies() {
            let n = column.extent(body);
            lines[0] = lines[0].max(n[0] as f64 + 1.0);
            lines[1] = lines[1].max(if column.dim == 2 { 1.0 } else { n[1] as f64 + 1.0 });
            lines[2] += n[2] as f64 + 1.0;
        }
        let longest = lines.iter().copied().fold(0.0, f64::max);
        let section = dim * lines.iter().product::<f64>() / longest;
        let operations = if column.dim == 2 {
            30.0 * section
        } else {
            (1.5 * section * section).min(28.0 * unknowns)
        };
        let stretch = (0..column.bodies()).map(|b| stretch(column, b)).fold(1.0, f64::max);
        let about = format!(
            "{unknowns:.0} unknowns, about {operations:.1e} operations per unknown to factorise"
        );
        if operations < DIRECT_LIMIT {
            Self::named("mumps", format!("{about}: elimination is cheapest"))
        } else if stretch > STRETCH_LIMIT {
            Self::named("hypre", format!("{about}; cells stretched {stretch:.1} times"))
        } else {
            Self::named("hypre", format!("{about}: multigrid is cheaper"))
        }
    }
}

/// Longest over shortest edge of the first cell of a body.
fn stretch(column: &Column, body: usize) -> f64 {
    let place = crate::mesh::CellPlace { body, at: [0; 3] };
    let (size, _) = column.cell_size(place);
    let edges = crate::mesh::axes(column.dim).iter().map(|a| size[*a]);
    edges.clone().fold(0.0, f64::max) / edges.fold(f64::INFINITY, f64::min)
}

/// How far the linear systems are solved: so far that one correction of a linear problem passes
/// the nonlinear test with a margin.
#[derive(Debug, Clone, Copy)]
pub struct LinearTarget {
    tolerance: f64,
}

/// Part of the nonlinear tolerance that a linear solve may use up.
const SHARE: f64 = 1e-2;
/// Reduction of the residual while no force scale is known yet, and never more than this.
const SMALLEST_REDUCTION: f64 = 1e-13;

impl LinearTarget {
    /// For the relative `tolerance` of the nonlinear test.
    pub fn new(tolerance: f64) -> Self {
        Self { tolerance }
    }

    /// The target for a residual of 2-norm `norm`, given the force scale of the accepted states.
    pub fn tolerance(&self, _norm: f64, force_scale: f64) -> LinearTolerance {
        LinearTolerance {
            relative: SMALLEST_REDUCTION,
            absolute: SHARE * self.tolerance * force_scale,
        }
    }
}
