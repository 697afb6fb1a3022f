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
use super::unsymmetric::norm;
use super::{Problem, condensed};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::petsc::FurtherSolve;
use crate::solve::model::Platens;

/// A motion is free where what resists it is less than this part of what would if nothing but the
/// platen moved.
const FREE: f64 = 1e-11;

/// What the balance of platens is called in messages.
const BALANCE: &str = "the balance of a platen (boundary: rigid)";

/// The forces of a change of all unknowns, where the state is linearised.
pub(in crate::solve) type Product<'p> = dyn Fn(&Problem<'_>, &[f64]) -> Vec<f64> + 'p;

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

/// The change of the unknowns with each free motion, and what resists these.
struct Columns {
    /// E_ff^-1 E_fp R - R: a correction that lets the motion grow by 1.
    along: Vec<Vec<f64>>,
    /// R^T E along.
    border: DMatrix<f64>,
    /// S, each motion scaled by what would resist it if nothing else moved.
    schur: DMatrix<f64>,
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
        free: &[bool],
        product: &Product<'_>,
        solve: &mut FurtherSolve<'_>,
    ) -> Result<()> {
        let columns = match self.columns.take() {
            Some(columns) => columns,
            None => match self.columns(problem, free, product, solve) {
                Ok(columns) => columns,
                Err(Error::Numerics(words)) => {
                    (self.failure, self.is_unsolved) = (Some(words), true);
                    correction.fill(0.0);
                    return Ok(());
                }
                Err(other) => return Err(other),
            },
        };
        if let Some(words) = self.free_motion(&columns) {
            if problem.convergence.accepted_force() == 0.0 && problem.corrections == 0 {
                return Err(Error::Input(words));
            }
            self.failure = Some(words);
            correction.fill(0.0);
            return Ok(());
        }
        let mut y = correction.to_vec();
        keep(&mut y, free);
        let forces = product(problem, &y);
        let mut answer = self.platens.times(|i| forces[i]);
        problem.comm.sum(&mut answer);
        let missing = self.platens.load.iter().zip(&self.platens.free);
        let missing = missing.map(|(load, k)| self.residual[0][*k] - load - answer[*k]);
        let missing = DVector::from_vec(missing.collect());
        let Some(change) = columns.border.clone().lu().solve(&missing) else {
            return Err(Error::Bug("a border of platens that is singular".into()));
        };
        for (change, along) in change.iter().zip(&columns.along) {
            correction.iter_mut().zip(along).for_each(|(y, along)| *y += change * along);
        }
        self.columns = Some(columns);
        Ok(())
    }

    fn columns(
        &self,
        problem: &Problem<'_>,
        free: &[bool],
        product: &Product<'_>,
        solve: &mut FurtherSolve<'_>,
    ) -> Result<Columns> {
        let (comm, count) = (problem.comm, self.platens.free.len());
        let (mut along, mut forces) = (Vec::new(), Vec::new());
        let mut held = vec![0.0; count];
        for (place, k) in self.platens.free.iter().enumerate() {
            let mut moved = self.platens.column(*k, problem.all.nodes.owned * problem.all.dim);
            moved.resize(free.len(), 0.0);
            let mut rhs = product(problem, &moved);
            held[place] = self.platens.times(|i| rhs[i])[*k];
            keep(&mut rhs, free);
            let (mut column, size) = (vec![0.0; rhs.len()], norm(comm, &rhs));
            if size > 0.0 {
                solve(&rhs, &mut column)?;
                problem.add_unsymmetric(&mut column, size, solve)?;
            }
            keep(&mut column, free);
            column.iter_mut().zip(&moved).for_each(|(column, moved)| *column -= moved);
            forces.push(product(problem, &column));
            along.push(column);
        }
        comm.sum(&mut held);
        let border = border(comm, &self.platens, &forces);
        let schur = energies(problem, &along, &forces);
        let scale = |i: usize| held[i].abs().sqrt().max(f64::MIN_POSITIVE).recip();
        let schur = DMatrix::from_fn(count, count, |i, j| scale(i) * schur[(i, j)] * scale(j));
        Ok(Columns { along, border, schur })
    }

    /// A motion that nothing resists, in words.
    fn free_motion(&self, columns: &Columns) -> Option<String> {
        let eigen = SymmetricEigen::new(columns.schur.clone());
        let count = columns.along.len();
        let none = (0..count).find(|i| eigen.eigenvalues[*i].abs() <= FREE)?;
        let motion = eigen.eigenvectors.column(none);
        let most = (0..count).max_by(|i, j| motion[*i].abs().total_cmp(&motion[*j].abs()))?;
        Some(format!(
            "{}: nothing holds the platen, and the body it is on, against this motion; prescribe a \
             displacement on another surface of the body, join it to one that is held, or give the \
             motion fixed or a value",
            self.platens.name(self.platens.free[most])
        ))
    }
}

/// Leaves what is solved for.
fn keep(of: &mut [f64], free: &[bool]) {
    of.iter_mut().zip(free).filter(|(_, free)| !**free).for_each(|(of, _)| *of = 0.0);
}

/// R^T of the forces of each column. Collective.
fn border(comm: &Comm, platens: &Platens, forces: &[Vec<f64>]) -> DMatrix<f64> {
    let count = forces.len();
    let mut border = DMatrix::zeros(count, count);
    for (j, force) in forces.iter().enumerate() {
        let sums = platens.times(|unknown| force[unknown]);
        platens.free.iter().enumerate().for_each(|(i, k)| border[(i, j)] = sums[*k]);
    }
    comm.sum(border.as_mut_slice());
    border
}

/// The energies of pairs of columns (J), which are exact to the square of what the solutions lack.
/// Collective.
fn energies(problem: &Problem<'_>, along: &[Vec<f64>], forces: &[Vec<f64>]) -> DMatrix<f64> {
    let size = problem.all.nodes.owned * problem.all.dim;
    let pair = |i: usize, j: usize| -> f64 {
        along[i].iter().zip(&forces[j]).take(size).map(|(u, f)| u * f).sum()
    };
    let mut energies = DMatrix::from_fn(along.len(), along.len(), pair);
    problem.comm.sum(energies.as_mut_slice());
    0.5 * (&energies + energies.transpose())
}

impl Problem<'_> {
    /// Whether any platen follows its load. Local: the same on all ranks.
    pub(in crate::solve) fn has_free_platens(&self) -> bool {
        self.platens.as_ref().is_some_and(|system| !system.platens.free.is_empty())
    }

    /// Takes the forces on platens out of the balance `f` of all unknowns. Collective.
    pub(super) fn see_platens(&mut self, f: &[f64]) {
        let Some(system) = &mut self.platens else { return };
        let (dim, u) = (self.all.dim, &self.displacement);
        let cancelling = |i: usize| rounding(self.stiffness[i / dim] * u[i]);
        let sums = [
            system.platens.times(|i| f[i]),
            system.platens.times_magnitude(|i| f[i]),
            system.platens.times_magnitude(cancelling),
        ];
        let mut all = sums.concat();
        self.comm.sum(&mut all);
        let count = system.platens.freedoms.len();
        system.residual = std::array::from_fn(|i| all[i * count..][..count].to_vec());
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

    /// Lets the platens move in a correction of the unknowns of which `free` are solved for.
    /// Collective.
    ///
    /// # Errors
    /// `Input` where nothing holds a platen at the start; `System` when PETSc fails.
    pub(in crate::solve) fn move_platens(
        &mut self,
        correction: &mut [f64],
        free: &[bool],
        product: &Product<'_>,
        solve: &mut FurtherSolve<'_>,
    ) -> Result<()> {
        if !self.has_free_platens() {
            return Ok(());
        }
        let Some(mut system) = self.platens.take() else { return Ok(()) };
        let moved = system.step(self, correction, free, product, solve);
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
        if !self.has_free_platens() {
            return Ok(None);
        }
        let Some(mut system) = self.platens.take() else { return Ok(None) };
        let mut columns = system.columns.take();
        if let (None, Some(solve)) = (&columns, solve) {
            let free = condensed::free_components(&self.all, &self.interfaces);
            let found = system.columns(self, &free, &|problem, u| problem.forces_of(u), solve);
            columns = match found {
                Ok(found) => Some(found),
                Err(error) => {
                    self.platens = Some(system);
                    return Err(error);
                }
            };
        }
        let softening = columns.as_ref().and_then(|columns| self.lowest_of(columns));
        system.columns = columns;
        self.platens = Some(system);
        Ok(softening)
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
