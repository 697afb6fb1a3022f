//! How the unknowns answer to the free motions of platens, where the state is linearised.

use nalgebra::{DMatrix, SymmetricEigen};

use super::Problem;
use super::unsymmetric::norm;
use crate::error::Result;
use crate::petsc::FurtherSolve;
use crate::solve::model::Platens;

/// A motion is free where what resists it is less than this part of what would if nothing but the
/// platen moved.
pub(super) const FREE: f64 = 1e-11;

/// The forces of a change of all unknowns, where the state is linearised.
pub(in crate::solve) type Product<'p> = dyn Fn(&Problem<'_>, &[f64]) -> Vec<f64> + 'p;

/// A linearised state, with platens held.
pub(in crate::solve) struct Linearised<'p> {
    /// The unknowns that are solved for.
    pub free: &'p [bool],
    /// The forces of a change.
    pub product: &'p Product<'p>,
    /// R^T of what is out of balance, by motion (N, N m); none where it is that of the problem.
    pub residual: Option<&'p [f64]>,
    /// Whether solves leave out what is not symmetric.
    pub leaves_out: bool,
}

impl<'p> Linearised<'p> {
    /// Of the condensed form, whose matrix is symmetric.
    pub fn new(free: &'p [bool], product: &'p Product<'p>) -> Self {
        Self { free, product, residual: None, leaves_out: true }
    }
}

/// The change of the unknowns with each free motion, and what resists these.
pub(super) struct Columns {
    /// E_ff^-1 E_fp R - R: a correction that lets the motion grow by 1.
    pub along: Vec<Vec<f64>>,
    /// R^T E along.
    pub border: DMatrix<f64>,
    /// S, each motion scaled by what would resist it if nothing else moved.
    pub schur: DMatrix<f64>,
    /// What makes motions comparable: this times the root of what would resist each is 1.
    pub scale: Vec<f64>,
}

impl Columns {
    /// At a linearised state. Collective.
    ///
    /// # Errors
    /// Those of `solve`.
    pub fn new(
        problem: &Problem<'_>,
        platens: &Platens,
        at: &Linearised<'_>,
        solve: &mut FurtherSolve<'_>,
    ) -> Result<Self> {
        let (comm, count) = (problem.comm, platens.free.len());
        let (mut along, mut forces) = (Vec::new(), Vec::new());
        let mut held = vec![0.0; count];
        for (place, k) in platens.free.iter().enumerate() {
            let mut moved = platens.column(*k, problem.all.nodes.owned * problem.all.dim);
            moved.resize(at.free.len(), 0.0);
            let mut rhs = (at.product)(problem, &moved);
            held[place] = platens.times(|i| rhs[i])[*k];
            keep(&mut rhs, at.free);
            let (mut column, size) = (vec![0.0; rhs.len()], norm(comm, &rhs));
            if size > 0.0 {
                solve(&rhs, &mut column)?;
                if at.leaves_out {
                    problem.add_unsymmetric(&mut column, size, solve)?;
                }
            }
            keep(&mut column, at.free);
            column.iter_mut().zip(&moved).for_each(|(column, moved)| *column -= moved);
            forces.push((at.product)(problem, &column));
            along.push(column);
        }
        comm.sum(&mut held);
        let mut border = DMatrix::zeros(count, count);
        for (j, force) in forces.iter().enumerate() {
            let sums = platens.times(|unknown| force[unknown]);
            platens.free.iter().enumerate().for_each(|(i, k)| border[(i, j)] = sums[*k]);
        }
        comm.sum(border.as_mut_slice());
        let schur = energies(problem, &along, &forces);
        let scale = |held: &f64| held.abs().sqrt().max(f64::MIN_POSITIVE).recip();
        let scale: Vec<f64> = held.iter().map(scale).collect();
        let schur = DMatrix::from_fn(count, count, |i, j| scale[i] * schur[(i, j)] * scale[j]);
        Ok(Self { along, border, schur, scale })
    }

    /// Adds changes of the motions to a correction of the unknowns. Local.
    pub fn add(&self, correction: &mut [f64], changes: &[f64]) {
        for (change, along) in changes.iter().zip(&self.along) {
            correction.iter_mut().zip(along).for_each(|(y, along)| *y += change * along);
        }
    }

    /// A motion that nothing resists, in words. Local.
    pub fn free_motion(&self, platens: &Platens) -> Option<String> {
        let eigen = SymmetricEigen::new(self.schur.clone());
        let count = self.along.len();
        let none = (0..count).find(|i| eigen.eigenvalues[*i].abs() <= FREE)?;
        let motion = eigen.eigenvectors.column(none);
        let most = (0..count).max_by(|i, j| motion[*i].abs().total_cmp(&motion[*j].abs()))?;
        Some(format!(
            "{}: nothing holds the platen, and the body it is on, against this motion; prescribe a \
             displacement on another surface of the body, join it to one that is held, or give the \
             motion fixed or a value",
            platens.name(platens.free[most])
        ))
    }
}

/// Leaves what is solved for.
pub(super) fn keep(of: &mut [f64], free: &[bool]) {
    of.iter_mut().zip(free).filter(|(_, free)| !**free).for_each(|(of, _)| *of = 0.0);
}

/// The energies of pairs of columns (J), which are exact to the square of what the solutions lack.
/// Collective.
pub(super) fn energies(
    problem: &Problem<'_>,
    along: &[Vec<f64>],
    forces: &[Vec<f64>],
) -> DMatrix<f64> {
    let size = problem.all.nodes.owned * problem.all.dim;
    let pair = |i: usize, j: usize| -> f64 {
        along[i].iter().zip(&forces[j]).take(size).map(|(u, f)| u * f).sum()
    };
    let mut energies = DMatrix::from_fn(along.len(), along.len(), pair);
    problem.comm.sum(energies.as_mut_slice());
    0.5 * (&energies + energies.transpose())
}
