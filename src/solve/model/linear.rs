//! The linear solver: presets, the choice between them, and how far systems are solved.

use crate::case::{Case, Form, Linear};
use crate::error::{Error, Result};
use crate::mesh::MeshFacts;
use crate::petsc::{LinearTolerance, Trial};

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

/// Options of MUMPS: LDL^T, which also serves when softening makes the tangent indefinite. One rank
/// factors the last part (`icntl_13`): of several together MUMPS does not count the negative
/// pivots.
const MUMPS: &[(&str, &str)] = &[
    ("ksp_type", "preonly"),
    ("pc_type", "cholesky"),
    ("pc_factor_mat_solver_type", "mumps"),
    ("mat_mumps_icntl_14", "100"),
    ("mat_mumps_icntl_13", "1"),
];

/// LU for a tangent that is not symmetric: of the saddle-point form, and with friction.
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

/// Conjugate gradients with smoothed aggregation in blocks, which is given to the preconditioner.
const BLOCKS: &[(&str, &str)] = &[("ksp_type", "cg"), ("ksp_max_it", "500"), ("pc_type", "shell")];

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
    ("pc_hypre_boomeramg_relax_type_all", "l1scaled-SOR/Jacobi"),
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

/// Name of the preset that needs the tangent in blocks.
pub const AGGREGATION: &str = "aggregation";

/// The presets by name; a new one is a line here.
const PRESETS: &[(&str, &[(&str, &str)])] = &[
    ("mumps", MUMPS),
    (AGGREGATION, BLOCKS),
    ("gamg", GAMG),
    ("hypre", HYPRE),
    (MULTIGRID, LEVELS),
];

/// Elimination is taken below this many unknowns: there it costs less than the levels of multigrid,
/// above it soon costs more than all of the rest.
const FEWEST_FOR_LEVELS: f64 = 3000.0;

/// Cells that grow by more than this serve point-wise smoothing badly.
const FLAT: f64 = 2.0;

/// Up to so many unknowns the mesh of a file is eliminated, in 2D and in 3D.
const MOST_OF_FILE: [f64; 2] = [3e5, 6e4];

/// Up to so many unknowns the coarsest of several levels is eliminated, in 2D and in 3D.
const MOST_OF_COARSEST: [f64; 2] = [3e5, 1e4];

/// Whether the coarsest of several levels with so many unknowns is eliminated.
pub fn eliminates_coarsest(dim: usize, unknowns: f64) -> bool {
    unknowns <= MOST_OF_COARSEST[dim - 2]
}

/// Elimination is taken below this many unknowns of a file with coarser meshes.
const FEWEST_NESTED: f64 = 1e4;

/// Above this Poisson's ratio multigrid needs more than a hundred iterations.
const HARD_TO_SMOOTH: f64 = 0.495;
/// Up to so many unknowns elimination then takes less time and bearable memory.
const MOST_FOR_ELIMINATION: f64 = 1.5e5;

impl LinearChoice {
    /// The preset the case names, or the one that suits the size and shape of the problem. Local.
    ///
    /// # Errors
    /// `Input` for multigrid on the mesh of a file without coarser ones.
    pub fn new(case: &Case, mesh: &MeshFacts) -> Result<Self> {
        let choice = Self::symmetric(case, mesh)?;
        Ok(if case.has_friction() { choice.for_friction() } else { choice })
    }

    /// As [`LinearChoice::new`], for a symmetric tangent but for that of the saddle-point form.
    fn symmetric(case: &Case, mesh: &MeshFacts) -> Result<Self> {
        if case.solver.form == Form::SaddlePoint {
            let why = "form: saddle_point, whose tangent is not symmetric: LU".into();
            return Ok(Self { preset: "mumps", why, options: MUMPS_LU.to_vec() });
        }
        let is_asked = case.solver.linear == Linear::Multigrid;
        if is_asked && case.mesh.file().is_some() && !mesh.has_coarser() {
            return Err(Error::Input(
                "solver.linear multigrid needs coarser meshes, which the mesh of a file has where \
                 mesh.refine makes it finer, its cells are of second order, or it is made of \
                 hexahedra (2D: quadrilaterals) in layers; take auto, aggregation or mumps"
                    .into(),
            ));
        }
        Ok(match case.solver.linear {
            Linear::Mumps => Self::named("mumps", "asked for".into()),
            Linear::Aggregation => Self::named(AGGREGATION, "asked for".into()),
            Linear::Gamg => Self::named("gamg", "asked for".into()),
            Linear::Hypre => Self::named("hypre", "asked for".into()),
            Linear::Multigrid => Self::named(MULTIGRID, "asked for".into()),
            Linear::Auto => Self::automatic(case, mesh),
        })
    }

    /// The choice in the place of multigrid for a mesh that has no coarser level: elimination, or
    /// what suits the mesh of a file.
    pub fn without_levels(self, case: &Case, mesh: &MeshFacts) -> Self {
        if case.mesh.file().is_some() {
            let other = Self::for_file(mesh.dim, mesh.nodes as f64 * mesh.dim as f64);
            let other = if case.has_friction() { other.for_friction() } else { other };
            return Self {
                why: format!("no coarser mesh serves multigrid; {}", other.why),
                ..other
            };
        }
        let why = format!("{}, but the mesh is too small for a coarser one", self.why);
        let choice = Self::named("mumps", why);
        if case.has_friction() { choice.for_friction() } else { choice }
    }

    /// The same with what suits a tangent that is not symmetric: LU in the place of L D L^T, GMRES
    /// in that of conjugate gradients, with a preconditioner of the symmetric part.
    fn for_friction(mut self) -> Self {
        const WHY: &str = "; friction makes the tangent unsymmetric";
        if !self.why.contains(WHY) {
            self.why.push_str(WHY);
        }
        if self.preset == "mumps" {
            self.options = MUMPS_LU.to_vec();
            return self;
        }
        // A preconditioner of ours rounds to single precision.
        let is_ours = matches!(self.preset, AGGREGATION | MULTIGRID);
        let method = if is_ours { "fgmres" } else { "gmres" };
        self.options.retain(|(name, _)| *name != "ksp_type");
        self.options.push(("ksp_type", method));
        self.options.push(("ksp_gmres_restart", "100"));
        self
    }

    /// The options of elimination, for where iterations of a matrix with so many `unknowns` lead
    /// nowhere; none where it would take too much memory. Local.
    pub fn elimination(
        case: &Case,
        unknowns: u64,
    ) -> Option<&'static [(&'static str, &'static str)]> {
        let options = if case.has_friction() { MUMPS_LU } else { MUMPS };
        (unknowns as f64 <= MOST_FOR_ELIMINATION).then_some(options)
    }

    /// No solver: the states of the model come from elsewhere.
    pub fn none(why: String) -> Self {
        Self { preset: "none", why, options: Vec::new() }
    }

    fn named(preset: &'static str, why: String) -> Self {
        let options = PRESETS.iter().find(|(name, _)| *name == preset).map(|(_, o)| o.to_vec());
        Self { preset, why, options: options.unwrap_or_default() }
    }

    /// Geometric multigrid, unless the problem is small or too close to incompressible for
    /// point-wise smoothing.
    fn automatic(case: &Case, mesh: &MeshFacts) -> Self {
        let unknowns = mesh.nodes as f64 * mesh.dim as f64;
        let largest = case.materials.iter().map(|m| m.poisson_ratio).fold(0.0, f64::max);
        if largest > HARD_TO_SMOOTH && unknowns < MOST_FOR_ELIMINATION {
            let why = format!(
                "{unknowns:.0} unknowns, poisson_ratio {largest}: iterations would be hundreds"
            );
            return Self::named("mumps", why);
        }
        if unknowns < FEWEST_FOR_LEVELS {
            return Self::named(
                "mumps",
                format!("{unknowns:.0} unknowns: elimination is cheapest"),
            );
        }
        if case.mesh.file().is_some() {
            return Self::nested(mesh, unknowns)
                .unwrap_or_else(|| Self::for_file(mesh.dim, unknowns));
        }
        // Cells that grow are long along one axis here and along another there.
        let grading = case.mesh.column().map(|column| &column.grading);
        let grows = |axis| grading.is_some_and(|of| of.along(axis).is_some_and(|g| g.ratio > FLAT));
        if (0..3).any(grows) {
            return Self::for_growing(case, mesh, unknowns);
        }
        let why = "coarser lattices of the column make iterations cheap and few";
        Self::named(MULTIGRID, format!("{unknowns:.0} unknowns: {why}"))
    }
}

impl LinearChoice {
    /// Multigrid where a file has coarser meshes.
    fn nested(mesh: &MeshFacts, unknowns: f64) -> Option<Self> {
        if !mesh.has_coarser() || unknowns < FEWEST_NESTED {
            return None;
        }
        let meshes = match (mesh.coarser.is_empty(), mesh.order) {
            (true, _) => "cells of first order",
            (false, 1) => "coarser meshes of the same bodies",
            (false, _) => "coarser meshes and cells of first order",
        };
        let why = format!("{unknowns:.0} unknowns: {meshes} make iterations cheap and few");
        Some(Self::named(MULTIGRID, why))
    }

    /// Cells that grow along an axis: iterations are several times as many, but with cells of
    /// second order in 3D they still cost a half of what elimination does, and a third of
    /// aggregation's.
    fn for_growing(case: &Case, mesh: &MeshFacts, unknowns: f64) -> Self {
        let orders = case.mesh.column().map_or(&[][..], |column| &column.orders);
        if mesh.dim == 2 || unknowns < FEWEST_NESTED || orders.iter().all(|order| *order == 1) {
            return Self::for_file(mesh.dim, unknowns);
        }
        let why = "coarser lattices make iterations cheap, though cells that grow make them many";
        Self::named(MULTIGRID, format!("{unknowns:.0} unknowns: {why}"))
    }

    /// The mesh of a file may have no coarser ones: elimination, up to where its fill costs more
    /// than iterations with smoothed aggregation, which knows the rigid motions of slender parts.
    fn for_file(dim: usize, unknowns: f64) -> Self {
        if unknowns < MOST_OF_FILE[dim - 2] {
            let why =
                format!("{unknowns:.0} unknowns of a mesh in {dim}D: elimination is cheapest");
            return Self::named("mumps", why);
        }
        let why = "aggregation of its nodes, which knows rigid motions, makes iterations few";
        Self::named(AGGREGATION, format!("{unknowns:.0} unknowns of a mesh in {dim}D: {why}"))
    }
}

/// How far the linear systems are solved: so far that one correction of a linear problem passes
/// the nonlinear test with a margin.
#[derive(Debug, Clone, Copy)]
pub struct LinearTarget {
    tolerance: f64,
}

/// Part of the nonlinear tolerance that a linear solve may use up whose state is not tried.
const SHARE: f64 = 0.05;
/// The same where its state is tried.
const SHARE_OF_TRIED: f64 = 0.025;
/// Of this share, what the solve aims at: its errors need not fall evenly.
const MARGIN: f64 = 0.5;
/// Where rounding leaves no more digits to find, this part of the nonlinear tolerance is enough.
const SHARE_OF_ROUNDING: f64 = 0.5;
/// A linear solve stops when the residual of the state it leads to is this many times its own.
const NONLINEAR: f64 = 10.0;
/// Reduction of the residual while no force scale is known yet, and never more than this.
const SMALLEST_REDUCTION: f64 = 1e-13;

impl LinearTarget {
    /// Until a trial tells what is enough.
    pub const UNTRIED: LinearTolerance =
        LinearTolerance { relative: SMALLEST_REDUCTION, absolute: 0.0 };

    /// For the relative `tolerance` of the nonlinear test.
    pub fn new(tolerance: f64) -> Self {
        Self { tolerance }
    }

    /// What a linear solve does that stands at a residual of 2-norm `norm`, of which `rounding` may
    /// be rounding, when the state it leads to has a residual of norm `reached` and is `excess`
    /// times the nonlinear tolerance away from a solution: the errors fall with the residual as
    /// long as it is the linear one, if not evenly. So what is aimed at is tried again.
    pub fn trial(&self, [norm, rounding]: [f64; 2], reached: f64, excess: f64) -> Trial {
        let share = if norm <= rounding { SHARE_OF_ROUNDING } else { SHARE_OF_TRIED };
        if !excess.is_finite() || (reached > NONLINEAR * norm && excess > share) {
            return Trial::Relinearise;
        }
        let absolute = if excess <= share { norm } else { MARGIN * norm * SHARE_OF_TRIED / excess };
        Trial::GoOn(Some(LinearTolerance { relative: SMALLEST_REDUCTION, absolute }))
    }

    /// The target for a residual of 2-norm `norm`, given the force scale of the accepted states.
    pub fn tolerance(&self, _norm: f64, force_scale: f64) -> LinearTolerance {
        LinearTolerance {
            relative: SMALLEST_REDUCTION,
            absolute: SHARE * self.tolerance * force_scale,
        }
    }
}
