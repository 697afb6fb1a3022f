//! The correction on a path: of displacements, platens and load factor together.
//!
//! The tangent is solved with for the out-of-balance forces, for a growth of the loads, and for
//! each motion of a platen, with all else held. How much of each answer the correction has follows
//! from few equations: the balance of the platens, and that the quantity of the path takes its
//! value. Together they have a solution also where the platens alone have none: at the largest load
//! that they can carry.

use nalgebra::{DMatrix, DVector};

use super::path::{Answers, PathControl};
use super::platen_columns::{Linearised, keep};
use super::platens::{BesidePath, PlatenSystem};
use super::unsymmetric::norm;
use super::{Problem, condensed};
use crate::error::{Error, Result};
use crate::petsc::FurtherSolve;

/// Equations whose pivots fall below this part of the largest have no unique solution.
const SINGULAR: f64 = 1e-13;
/// The part of the right-hand side that a solution of such equations may miss.
const MISSED: f64 = 1e-8;

/// The answer of the unknowns to a growth of the loads, with platens held.
struct Growth {
    /// Whether an unknown is solved for.
    free: Vec<bool>,
    /// The change of the forces on all unknowns, before any of them answers.
    forces: Vec<f64>,
    /// What is solved for.
    along: Vec<f64>,
}

impl Problem<'_> {
    /// Makes the answer of the tangent to the out-of-balance forces a correction of displacements
    /// and load factor, of which `part` is taken. What cannot be found is noted as the failure of
    /// the path or of the platens. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub(super) fn correct_along_path(
        &mut self,
        correction: &mut [f64],
        part: f64,
        solve: &mut FurtherSolve<'_>,
    ) -> Result<()> {
        let Some(mut path) = self.path.take() else {
            return Err(Error::Bug("a correction along a path without one".into()));
        };
        let mut platens = self.platens.take();
        let corrected = match self.growth(&path, solve) {
            Ok(growth) => {
                self.combine(&mut path, platens.as_mut(), (correction, part), growth, solve)
            }
            Err(Error::Numerics(words)) => {
                (path.failure, path.is_unsolved) = (Some(words), true);
                correction.fill(0.0);
                Ok(())
            }
            Err(other) => Err(other),
        };
        (self.path, self.platens) = (Some(path), platens);
        corrected
    }

    /// The answer to a growth of the loads. Collective.
    fn growth(&self, path: &PathControl, solve: &mut FurtherSolve<'_>) -> Result<Growth> {
        let forces = path.load_forces(self.comm, &self.all, &self.interfaces);
        let free = condensed::free_components(&self.all, &self.interfaces);
        let mut rhs = forces.clone();
        keep(&mut rhs, &free);
        let (mut along, size) = (vec![0.0; rhs.len()], norm(self.comm, &rhs));
        if size > 0.0 {
            solve(&rhs, &mut along)?;
            self.add_unsymmetric(&mut along, size, solve)?;
        }
        keep(&mut along, &free);
        Ok(Growth { free, forces, along })
    }

    /// Puts the answers together to a correction, of which `part` is taken. Collective.
    fn combine(
        &self,
        path: &mut PathControl,
        platens: Option<&mut PlatenSystem>,
        (correction, part): (&mut [f64], f64),
        growth: Growth,
        solve: &mut FurtherSolve<'_>,
    ) -> Result<()> {
        let Growth { free, forces, mut along } = growth;
        let mut platens = platens.filter(|system| !system.platens.free.is_empty());
        let mut beside = BesidePath::default();
        if let Some(system) = &mut platens {
            let at = Linearised::new(&free, &|problem, u| problem.forces_of(u));
            let vectors = [&*correction, &along, &forces];
            match system.beside_path(self, vectors, &path.unit_of_platens, &at, solve)? {
                Some(found) => beside = found,
                None => {
                    correction.fill(0.0);
                    return Ok(());
                }
            }
        }
        let (comm, all, state) = (self.comm, &self.all, &self.interfaces);
        along.iter_mut().zip(&path.unit_displacement).for_each(|(along, unit)| *along -= unit);
        condensed::follow(all, state, correction);
        condensed::follow(all, state, &mut along);
        beside.along.iter_mut().for_each(|along| condensed::follow(all, state, along));
        let mut vectors = vec![&*correction, &along];
        vectors.extend(beside.along.iter().map(Vec::as_slice));
        let answers = path.answers(comm, all, state, &vectors);
        let Some((change, motions)) = shares(&beside, &answers, |change| path.limited(change))
        else {
            let free = platens.and_then(|system| system.fail_where_free());
            if free.is_none() {
                path.does_not_follow();
            }
            return Ok(());
        };
        path.factor += part * change;
        correction.iter_mut().zip(&along).for_each(|(y, along)| *y += change * along);
        for (change, along) in motions.iter().zip(&beside.along) {
            correction.iter_mut().zip(along).for_each(|(y, along)| *y += change * along);
        }
        correction.iter_mut().for_each(|c| *c *= part);
        Ok(())
    }
}

/// The changes of the load factor, of which `limited` tells how much is taken, and of the motions
/// of platens; none where they do not follow.
fn shares(
    beside: &BesidePath,
    answers: &Answers,
    limited: impl Fn(f64) -> f64,
) -> Option<(f64, Vec<f64>)> {
    let (of_rest, of_growth) = (answers.changes[0], answers.changes[1]);
    let missing = answers.missing - of_rest;
    let count = beside.along.len();
    if count == 0 {
        let change = missing / of_growth;
        return change.is_finite().then(|| (limited(change), Vec::new()));
    }
    let largest = |values: &mut dyn Iterator<Item = f64>| {
        let most = values.fold(0.0, |most: f64, value| most.max(value.abs()));
        if most > 0.0 { most.recip() } else { 1.0 }
    };
    let s = DVector::from_row_slice(&beside.scale);
    let growth = beside.growth.component_mul(&s);
    let t = largest(&mut growth.iter().copied());
    let of_motions = DVector::from_row_slice(&answers.changes[2..]).component_mul(&s);
    let w = largest(&mut of_motions.iter().copied().chain([of_growth * t]));
    let held = DMatrix::from_fn(count, count, |i, j| s[i] * beside.border[(i, j)] * s[j]);
    let mut matrix = held.clone().resize(count + 1, count + 1, 0.0);
    matrix.view_mut((0, count), (count, 1)).copy_from(&(t * &growth));
    matrix.view_mut((count, 0), (1, count)).copy_from(&(w * of_motions.transpose()));
    matrix[(count, count)] = w * of_growth * t;
    let balance = beside.missing.component_mul(&s);
    let right = balance.clone().push(w * missing);
    let found = solution(&matrix, &right)?;
    let change = limited(t * found[count]);
    let mut motions = found.rows(0, count).into_owned();
    if change != t * found[count]
        && let Some(answer) = held.full_piv_lu().solve(&(balance - change * growth))
    {
        motions = answer;
    }
    Some((change, motions.component_mul(&s).as_slice().to_vec()))
}

/// The solution of a few equations; of those without a unique one the shortest. None where there is
/// none.
fn solution(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let factors = matrix.clone().full_piv_lu();
    let pivots = factors.u().diagonal().abs();
    if pivots.min() > SINGULAR * pivots.max() {
        return factors.solve(right).filter(|found| found.iter().all(|value| value.is_finite()));
    }
    let largest = matrix.amax();
    let found = matrix.clone().svd(true, true).solve(right, SINGULAR * largest).ok()?;
    let missed = (matrix * &found - right).norm();
    (missed <= MISSED * right.norm()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A spring of stiffness -1 under a platen that carries the load factor, whose path is told by
    /// the motion: the factor falls by what the motion grows. At the largest load the stiffness is
    /// 0, and the factor stays.
    #[test]
    fn a_platen_goes_over_its_largest_load() {
        for stiffness in [-1.0, 0.0, 2.0] {
            let beside = BesidePath {
                along: vec![vec![-1.0]],
                // A correction by -1 lets the motion grow by 1.
                border: DMatrix::from_element(1, 1, -stiffness),
                scale: vec![1.0],
                missing: DVector::from_element(1, 0.0),
                growth: DVector::from_element(1, 1.0),
            };
            let answers = Answers { missing: -0.25, changes: vec![0.0, 0.0, -1.0] };
            let (change, motions) = shares(&beside, &answers, |change| change).expect("a path");
            assert!((change - 0.25 * stiffness).abs() < 1e-15, "{change}");
            assert!((motions[0] - 0.25).abs() < 1e-15, "{motions:?}");
            // A factor that may change by less takes the motion with it.
            let Some((change, motions)) = shares(&beside, &answers, |change| 0.5 * change) else {
                panic!("a path");
            };
            assert!((change - stiffness * motions[0]).abs() < 1e-15, "{change} {motions:?}");
        }
    }

    #[test]
    fn what_nothing_resists_stays() {
        let matrix = DMatrix::from_row_slice(2, 2, &[2.0, 0.0, 0.0, 0.0]);
        let right = DVector::from_row_slice(&[4.0, 0.0]);
        assert_eq!(solution(&matrix, &right), Some(DVector::from_row_slice(&[2.0, 0.0])));
        assert_eq!(solution(&matrix, &DVector::from_row_slice(&[4.0, 1.0])), None);
    }
}
