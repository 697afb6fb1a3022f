//! Platens in Newton's method: the motions that follow from their loads.
//!
//! For the linear systems the unknowns of platens are prescribed, so that every solver serves. The
//! free motions q are a border of few columns: with the tangent E of all unknowns, f of those that
//! are solved for and p of those that platens move, u_p = R q,
//!
//! ```text
//! [ E_ff      E_fp R     ] [du]   [ r_f             ]
//! [ R^T E_pf  R^T E_pp R ] [dq] = [ R^T r_p - F     ]
//! ```
//!
//! Each column E_ff^-1 E_fp R is solved for once for a tangent, and the Schur complement S of the
//! motions is a matrix of that few rows. The correction is that of the whole system. By Sylvester's
//! law of inertia the tangent has as many negative eigenvalues as E_ff and S together.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::measure::rounding;
use super::platen_columns::{Columns, FREE, Linearised, energies, keep};
use super::unsymmetric::norm;
use super::{Problem, condensed};
use crate::error::{Error, Result};
use crate::petsc::FurtherSolve;
use crate::solve::model::Platens;

/// What the balance of platens is called in messages.
const BALANCE: &str = "the balance of a platen (boundary: rigid)";

/// The platens of a problem.
pub struct PlatenSystem {
    /// What they bind, and how they may move.
    pub platens: Platens,
    /// Of the tangent that was assembled last.
    columns: Option<Columns>,
    /// R^T f of all motions, of the magnitudes of f, and what rounding may leave of it.
    residual: [Vec<f64>; 3],
    /// Why the motions could not be found in the running step.
    failure: Option<String>,
    /// Whether that was a linear solve.
    pub is_unsolved: bool,
    /// What else than a platen the convergence test tells of.
    other: &'static str,
}

/// The equations of the free motions beside that of a path: R^T E along times their changes, and
/// the growth times that of the load factor, is what is missing.
#[derive(Default)]
pub(super) struct BesidePath {
    /// Corrections that let the motions grow by 1.
    pub along: Vec<Vec<f64>>,
    /// R^T E along.
    pub border: DMatrix<f64>,
    /// What makes motions comparable.
    pub scale: Vec<f64>,
    /// What is missing in their balance (N, N m).
    pub missing: DVector<f64>,
    /// What a growth of the load factor by 1 takes of that.
    pub growth: DVector<f64>,
}

/// What a platen does in a mode that lowers the energy.
pub(in crate::solve) struct SofteningPlatens {
    /// Negative eigenvalues of the Schur complement.
    pub count: usize,
    /// Rayleigh quotient of the mode (N/m).
    pub lowest: f64,
    /// The mode, in owned unknowns.
    pub mode: Vec<f64>,
}

impl PlatenSystem {
    /// At rest; `other` is what the convergence test tells of beside.
    pub fn new(platens: Platens, other: &'static str) -> Self {
        let residual = std::array::from_fn(|_| vec![0.0; platens.freedoms.len()]);
        Self { platens, columns: None, residual, failure: None, is_unsolved: false, other }
    }

    /// The forces of the platens on the body, by motion (N, N m). Local; as evaluated last.
    pub fn reactions(&self) -> &[f64] {
        &self.residual[0]
    }

    /// Forgets what belongs to a tangent.
    pub fn forget(&mut self) {
        self.columns = None;
    }

    /// Makes another solve possible.
    pub fn forget_failure(&mut self) {
        (self.failure, self.is_unsolved) = (None, false);
    }

    /// How far the platens are out of balance, over the size of their forces; `force` is that of
    /// nodes (N). Local.
    fn error(&self, force: f64) -> f64 {
        let [residual, size, rounding] = &self.residual;
        let of = |(load, k): (&f64, &usize)| {
            let missing = (residual[*k] - load).abs();
            let scale = size[*k].max(load.abs()).max(self.platens.levers[*k] * force);
            if missing <= rounding[*k] { 0.0 } else { missing / scale }
        };
        self.platens.load.iter().zip(&self.platens.free).map(of).fold(0.0, f64::max)
    }

    /// Lets the platens move in a correction of the unknowns, and what is not solved for as they
    /// ask. Collective.
    fn step(
        &mut self,
        problem: &Problem<'_>,
        correction: &mut [f64],
        at: &Linearised<'_>,
        solve: &mut FurtherSolve<'_>,
    ) -> Result<()> {
        if !self.prepare(problem, at, solve)? {
            correction.fill(0.0);
            return Ok(());
        }
        let missing = self.missing(problem, correction, at);
        let Some(columns) = &self.columns else { return Ok(()) };
        if let Some(words) = columns.free_motion(&self.platens) {
            if problem.convergence.accepted_force() == 0.0 && problem.corrections == 0 {
                return Err(Error::Input(words));
            }
            self.failure = Some(words);
            correction.fill(0.0);
            return Ok(());
        }
        let Some(change) = columns.border.clone().lu().solve(&missing) else {
            return Err(Error::Bug("a border of platens that is singular".into()));
        };
        columns.add(correction, change.as_slice());
        Ok(())
    }

    /// Finds the columns of the tangent, where they are not known; whether that succeeded.
    /// Collective.
    fn prepare(
        &mut self,
        problem: &Problem<'_>,
        at: &Linearised<'_>,
        solve: &mut FurtherSolve<'_>,
    ) -> Result<bool> {
        if self.columns.is_some() {
            return Ok(true);
        }
        match Columns::new(problem, &self.platens, at, solve) {
            Ok(columns) => self.columns = Some(columns),
            Err(Error::Numerics(words)) => {
                (self.failure, self.is_unsolved) = (Some(words), true);
                return Ok(false);
            }
            Err(other) => return Err(other),
        }
        Ok(true)
    }

    /// What is missing in the balance of the free motions after a correction that leaves platens
    /// where they are (N, N m). Collective.
    fn missing(
        &self,
        problem: &Problem<'_>,
        correction: &[f64],
        at: &Linearised<'_>,
    ) -> DVector<f64> {
        let mut y = correction.to_vec();
        keep(&mut y, at.free);
        let forces = (at.product)(problem, &y);
        let mut answer = self.platens.times(|i| forces[i]);
        problem.comm.sum(&mut answer);
        let residual = at.residual.unwrap_or(&self.residual[0]);
        let missing = self.platens.load.iter().zip(&self.platens.free);
        let missing = missing.map(|(load, k)| residual[*k] - load - answer[*k]);
        DVector::from_vec(missing.collect())
    }

    /// The equations of the free motions beside that of a path: of a correction with platens held,
    /// and of the answer `along` to a growth of the loads, whose `forces` are those on all unknowns
    /// and `unit` those on platens. None where they could not be found. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub(super) fn beside_path(
        &mut self,
        problem: &Problem<'_>,
        [correction, along, forces]: [&[f64]; 3],
        unit: &[f64],
        at: &Linearised<'_>,
        solve: &mut FurtherSolve<'_>,
    ) -> Result<Option<BesidePath>> {
        if !self.prepare(problem, at, solve)? {
            return Ok(None);
        }
        let missing = self.missing(problem, correction, at);
        let answer = (at.product)(problem, along);
        let mut growth = self.platens.times(|i| answer[i] - forces[i]);
        problem.comm.sum(&mut growth);
        let growth = self.platens.free.iter().zip(unit).map(|(k, unit)| growth[*k] + unit);
        let growth = DVector::from_vec(growth.collect());
        Ok(self.columns.as_ref().map(|columns| BesidePath {
            along: columns.along.clone(),
            border: columns.border.clone(),
            scale: columns.scale.clone(),
            missing,
            growth,
        }))
    }

    /// Takes note of a motion that nothing resists, where there is one. Local.
    pub(super) fn fail_where_free(&mut self) -> Option<&str> {
        let words = self.columns.as_ref()?.free_motion(&self.platens)?;
        Some(self.failure.insert(words).as_str())
    }
}

impl Problem<'_> {
    /// Whether any platen follows its load. Local: the same on all ranks.
    pub(in crate::solve) fn has_free_platens(&self) -> bool {
        self.platens.as_ref().is_some_and(|system| !system.platens.free.is_empty())
    }

    /// Takes the forces on platens out of the balance of all unknowns. Collective.
    pub(super) fn see_platens(&mut self, f: impl Fn(&Self, usize) -> f64) {
        let Some(mut system) = self.platens.take() else { return };
        let (dim, u) = (self.all.dim, &self.displacement);
        let cancelling = |i: usize| rounding(self.stiffness[i / dim] * u[i]);
        let sums = [
            system.platens.times(|i| f(self, i)),
            system.platens.times_magnitude(|i| f(self, i)),
            system.platens.times_magnitude(cancelling),
        ];
        let mut all = sums.concat();
        self.comm.sum(&mut all);
        let count = system.platens.freedoms.len();
        system.residual = std::array::from_fn(|i| all[i * count..][..count].to_vec());
        self.platens = Some(system);
    }

    /// How far the platens are out of balance, over the size of their forces. Local.
    pub(super) fn platen_error(&self) -> f64 {
        let error = |system: &PlatenSystem| system.error(self.convergence.force_scale());
        self.platens.as_ref().map_or(0.0, error)
    }

    /// What is beside the forces of nodes in the convergence test, with its name told; an error if
    /// the platens could not be moved. Local.
    pub(super) fn beside(&mut self, other: f64) -> std::result::Result<f64, String> {
        let platens = self.platen_error();
        let Some(system) = &self.platens else { return Ok(other) };
        self.convergence.other = if platens > other { BALANCE } else { system.other };
        match &system.failure {
            Some(words) => Err(words.clone()),
            None => Ok(other.max(platens)),
        }
    }

    /// Lets the platens move in a correction of the unknowns. Collective.
    ///
    /// # Errors
    /// `Input` where nothing holds a platen at the start; `System` when PETSc fails.
    pub(in crate::solve) fn move_platens(
        &mut self,
        correction: &mut [f64],
        at: &Linearised<'_>,
        solve: &mut FurtherSolve<'_>,
    ) -> Result<()> {
        if !self.has_free_platens() {
            return Ok(());
        }
        let Some(mut system) = self.platens.take() else { return Ok(()) };
        let moved = system.step(self, correction, at, solve);
        self.platens = Some(system);
        moved
    }

    /// What belongs to another tangent is forgotten. Local.
    pub(in crate::solve) fn forget_columns(&mut self) {
        self.platens.iter_mut().for_each(PlatenSystem::forget);
    }

    /// The forces of a change of the unknowns, without flow. Collective.
    pub(in crate::solve) fn forces_of(&self, change: &[f64]) -> Vec<f64> {
        let nothing = |_: &[f64], _: &mut [f64]| {};
        condensed::linear_forces(self.comm, &self.all, &self.interfaces, change.to_vec(), nothing)
    }

    /// Work of the loads on platens on the way from rest to the state that was evaluated last (J).
    /// Collective.
    pub(in crate::solve) fn work_on_platens(&self) -> f64 {
        let Some(PlatenSystem { platens, .. }) = &self.platens else { return 0.0 };
        let motions = platens.motions(self.comm, |i| self.displacement[i]);
        platens.load.iter().zip(&platens.free).map(|(load, k)| load * motions[*k]).sum()
    }

    /// The mode in which platens soften at the state that was evaluated last, which does lower the
    /// energy. Without a `solve` with the tangent there it is what the columns of the last
    /// correction tell. Without flow. Collective.
    ///
    /// # Errors
    /// Those of `solve`.
    pub(in crate::solve) fn softening_of_platens(
        &mut self,
        solve: Option<&mut FurtherSolve<'_>>,
    ) -> Result<Option<SofteningPlatens>> {
        if let Some(solve) = solve {
            self.find_columns(solve)?;
        }
        let columns = self.platens.as_ref().and_then(|system| system.columns.as_ref());
        Ok(columns.and_then(|columns| self.lowest_of(columns)))
    }

    /// The changes of the unknowns with the free motions, at the state that was evaluated last,
    /// where that is linearised; `solve` with the tangent there. Collective.
    ///
    /// # Errors
    /// Those of `solve`.
    pub(in crate::solve) fn answers_to_platens(
        &mut self,
        solve: &mut FurtherSolve<'_>,
    ) -> Result<Vec<Vec<f64>>> {
        self.find_columns(solve)?;
        let columns = self.platens.as_ref().and_then(|system| system.columns.as_ref());
        Ok(columns.map_or_else(Vec::new, |columns| columns.along.clone()))
    }

    /// Finds the columns of the tangent without flow, where they are not known. Collective.
    fn find_columns(&mut self, solve: &mut FurtherSolve<'_>) -> Result<()> {
        if !self.has_free_platens() {
            return Ok(());
        }
        let Some(mut system) = self.platens.take() else { return Ok(()) };
        let free = condensed::free_components(&self.all, &self.interfaces);
        let at = Linearised::new(&free, &|problem, u| problem.forces_of(u));
        let found = match system.columns.take() {
            Some(columns) => Ok(columns),
            None => Columns::new(self, &system.platens, &at, solve),
        };
        let found = found.map(|columns| system.columns = Some(columns));
        self.platens = Some(system);
        found
    }

    /// The mode of the columns that lowers the energy most, where the state is linearised.
    /// Collective.
    fn lowest_of(&self, columns: &Columns) -> Option<SofteningPlatens> {
        let forces: Vec<Vec<f64>> = columns.along.iter().map(|u| self.forces_of(u)).collect();
        let energies = energies(self, &columns.along, &forces);
        let count = columns.along.len();
        let scale = |i: usize| {
            let own = columns.schur[(i, i)].abs().max(FREE);
            (own / energies[(i, i)].abs().max(f64::MIN_POSITIVE)).sqrt()
        };
        let scaled = DMatrix::from_fn(count, count, |i, j| scale(i) * energies[(i, j)] * scale(j));
        let eigen = SymmetricEigen::new(scaled);
        let negative = (0..count).filter(|i| eigen.eigenvalues[*i] < -FREE);
        let least = negative
            .clone()
            .min_by(|i, j| eigen.eigenvalues[*i].total_cmp(&eigen.eigenvalues[*j]))?;
        let mut mode = vec![0.0; self.all.nodes.owned * self.all.dim];
        for (i, along) in columns.along.iter().enumerate() {
            let part = scale(i) * eigen.eigenvectors[(i, least)];
            mode.iter_mut().zip(along).for_each(|(mode, along)| *mode += part * along);
        }
        let lowest = eigen.eigenvalues[least] / norm(self.comm, &mode).powi(2);
        Some(SofteningPlatens { count: negative.count(), lowest, mode })
    }
}
