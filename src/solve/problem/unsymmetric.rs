//! What the symmetric tangent lacks.
//!
//! Beside prescribed components the weights w of a node's components differ, and the tangent of its
//! forces w_c t_c(jump) is not symmetric. The matrix holds sqrt(w_c w_d) in place of w_c. What that
//! leaves out has a low rank, and is added to each correction: E y = f with E = S + U is solved by
//! GMRES with S as the preconditioner, from the answer of S. Without it stiff secants, as where a
//! point has just begun to soften, make Newton's method turn in circles.

use super::{Problem, condensed};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::interface::JumpRows;
use crate::petsc::FurtherSolve;
use crate::solve::guess::energy_projection::dot;
use crate::solve::model::interfaces::NodeResponse;

/// Solves with S at most.
const MOST: usize = 40;
/// The part of a correction that may be missing, and the part of what the answer of S lacks.
const PART: f64 = 1e-10;
const REDUCTION: f64 = 1e-4;
/// The part of a correction that may be missing where what is left out is more than the right-hand
/// side: S and E are soft in different directions there, and what is missing in the stiff ones is
/// much in the soft one.
const PART_OF_STIFF: f64 = 1e-13;
/// What is left out of a linear solve may be this part of its right-hand side: the next corrections
/// take away the rest.
const WEAK: f64 = 0.05;
/// Where they have not after so many corrections of a solve, the part that may be left out, since
/// stiff secants make much of little.
const MOST_WEAK: usize = 4;
const NEGLIGIBLE: f64 = 1e-9;

/// The derivative of a node's tractions times weights beyond the symmetric one (N/m); none where
/// there is nothing.
fn beyond(rows: &JumpRows<u32>, response: &NodeResponse, dim: usize) -> Option<[[f64; 3]; 3]> {
    let weight = |c: usize| rows.rows[c].as_ref().filter(|_| c < dim).map(|row| row.weight);
    let mut any = false;
    let beyond = std::array::from_fn(|c| {
        std::array::from_fn(|d| {
            let (Some(own), Some(other)) = (weight(c), weight(d)) else { return 0.0 };
            let free = !response.state.stuck[c] && !response.state.stuck[d];
            let tangent = response.state.tangent[c][d];
            if own == other || !free || tangent == 0.0 {
                return 0.0;
            }
            any = true;
            (own - (own * other).sqrt()) * tangent
        })
    });
    any.then_some(beyond)
}

impl Problem<'_> {
    /// The nodes at which U is, with what it has there. Local.
    fn unsymmetric_nodes(&self) -> impl Iterator<Item = (usize, [[f64; 3]; 3])> {
        let pairs = self.all.secondary.iter().zip(&self.interfaces.response).enumerate();
        pairs.filter_map(|(i, (rows, response))| Some((i, beyond(rows, response, self.all.dim)?)))
    }

    /// U y for a correction of the unknowns, with the `nodes` at which U is. Collective.
    fn times_beyond(&self, nodes: &[(usize, [[f64; 3]; 3])], free: &[bool], y: &[f64]) -> Vec<f64> {
        let (all, dim) = (&self.all, self.all.dim);
        let mut local = vec![0.0; all.nodes.len() * dim];
        let known = local.iter_mut().zip(y).zip(free);
        known.filter(|(_, free)| **free).for_each(|((local, y), _)| *local = *y);
        all.nodes.update_ghosts(&mut local, dim);
        let mut force = vec![0.0; local.len()];
        for (index, beyond) in nodes {
            let rows = &all.secondary[*index];
            // Where the unknown is the jump itself, the primary side takes no part.
            let is_jump = self.interfaces.response[*index].state.jump;
            let row = |c: usize| rows.rows[c].as_ref().expect("both components have a multiplier");
            let has = |c: usize| (0..dim).any(|d| beyond[c][d] != 0.0 || beyond[d][c] != 0.0);
            let mut jump = [0.0; 3];
            for c in (0..dim).filter(|c| has(*c)) {
                let at = |unknown: u32| local[unknown as usize];
                jump[c] = if is_jump[c] {
                    row(c).own * at(rows.own(c))
                } else {
                    row(c).trace(rows.own(c), at)
                };
            }
            for c in (0..dim).filter(|c| has(*c)) {
                let traction: f64 = (0..dim).map(|d| beyond[c][d] * jump[d]).sum();
                let mut add = |unknown: u32, f: f64| force[unknown as usize] += f;
                if is_jump[c] {
                    add(rows.own(c), row(c).own * traction);
                } else {
                    row(c).spread(rows.own(c), traction, add);
                }
            }
        }
        all.nodes.add_to_owners(&mut force, dim);
        force.truncate(free.len());
        force.iter_mut().zip(free).filter(|(_, free)| !**free).for_each(|(f, _)| *f = 0.0);
        force
    }

    /// Makes the answer `y` of the symmetric tangent to a right-hand side of 2-norm `size`,
    /// displacements first, that of the tangent itself. Whether that made a difference. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails. Where a linear solve fails, the answer stays as far as it has
    /// come.
    pub(in crate::solve) fn add_unsymmetric(
        &self,
        y: &mut [f64],
        size: f64,
        solve: &mut FurtherSolve<'_>,
    ) -> Result<bool> {
        let (comm, all) = (self.comm, &self.all);
        let nodes: Vec<_> = self.unsymmetric_nodes().collect();
        if !comm.any(!nodes.is_empty()) {
            return Ok(false);
        }
        let free = condensed::free_components(all, &self.interfaces);
        let missing = |y: &[f64]| self.times_beyond(&nodes, &free, y);
        let left_out = norm(comm, &missing(y));
        tracing::debug!(target: "newton", "  unsymmetric part  {:9.3e}", left_out / size);
        let part = if self.corrections < MOST_WEAK { WEAK } else { NEGLIGIBLE };
        if left_out <= part * size {
            return Ok(false);
        }
        // v + S^-1 U v.
        let mut apply = |v: &[f64]| -> Result<Vec<f64>> {
            let (mut rhs, mut image) = (missing(v), vec![0.0; v.len()]);
            rhs.resize(v.len(), 0.0);
            solve(&rhs, &mut image)?;
            image.iter_mut().zip(v).for_each(|(image, v)| *image += v);
            Ok(image)
        };
        let is_stiff = left_out > size;
        let enough = |size: f64, start: f64| {
            if is_stiff { PART_OF_STIFF * size } else { (PART * size).max(REDUCTION * start) }
        };
        match gmres(comm, y, enough, &mut apply) {
            Ok(solves) => {
                tracing::debug!(target: "newton", "  unsymmetric part in {solves} solves")
            }
            Err(Error::Numerics(_)) => {}
            Err(other) => return Err(other),
        }
        Ok(true)
    }
}

/// The 2-norm over all ranks. Collective.
pub(in crate::solve) fn norm(comm: &Comm, v: &[f64]) -> f64 {
    product(comm, v, v).sqrt()
}

/// The inner product over all ranks. Collective.
fn product(comm: &Comm, a: &[f64], b: &[f64]) -> f64 {
    let mut sum = [dot(a, b)];
    comm.sum(&mut sum);
    sum[0]
}

/// Solves A x = b for `x`, which comes in as b and is where it starts: modified Gram and Schmidt,
/// Givens rotations. `enough` tells from the norms of b and of the first residual what may be left
/// of it. How often A was applied. Collective.
fn gmres(
    comm: &Comm,
    x: &mut [f64],
    enough: impl Fn(f64, f64) -> f64,
    apply: &mut dyn FnMut(&[f64]) -> Result<Vec<f64>>,
) -> Result<usize> {
    let size = norm(comm, x);
    let image = apply(x)?;
    let residual: Vec<f64> = x.iter().zip(&image).map(|(b, image)| b - image).collect();
    let start = norm(comm, &residual);
    let enough = enough(size, start);
    if !start.is_finite() || start <= enough {
        return Ok(1);
    }
    let scaled = |v: Vec<f64>, by: f64| v.into_iter().map(|v| v / by).collect::<Vec<f64>>();
    let mut basis = vec![scaled(residual, start)];
    let (mut columns, mut rotations) = (Vec::<Vec<f64>>::new(), Vec::<[f64; 2]>::new());
    let mut left = vec![start];
    while columns.len() < MOST && left[columns.len()].abs() > enough {
        let mut next = match apply(&basis[columns.len()]) {
            Ok(next) => next,
            Err(Error::Numerics(_)) => break,
            Err(other) => return Err(other),
        };
        let mut column = Vec::new();
        for v in &basis {
            let part = product(comm, v, &next);
            next.iter_mut().zip(v).for_each(|(next, v)| *next -= part * v);
            column.push(part);
        }
        let rest = norm(comm, &next);
        for (i, [cosine, sine]) in rotations.iter().enumerate() {
            let (a, b) = (column[i], column[i + 1]);
            (column[i], column[i + 1]) = (cosine * a + sine * b, cosine * b - sine * a);
        }
        let last = columns.len();
        let length = column[last].hypot(rest);
        if length == 0.0 || !length.is_finite() {
            break;
        }
        let [cosine, sine] = [column[last] / length, rest / length];
        column[last] = length;
        left.push(-sine * left[last]);
        left[last] *= cosine;
        rotations.push([cosine, sine]);
        columns.push(column);
        if rest <= f64::EPSILON * length {
            break;
        }
        basis.push(scaled(next, rest));
    }
    let parts = back_substitute(&columns, &left);
    for (part, v) in parts.iter().zip(&basis) {
        x.iter_mut().zip(v).for_each(|(x, v)| *x += part * v);
    }
    Ok(1 + columns.len())
}

/// Solves R p = r for the upper triangle R with these columns.
fn back_substitute(columns: &[Vec<f64>], right: &[f64]) -> Vec<f64> {
    let mut parts = vec![0.0; columns.len()];
    for i in (0..columns.len()).rev() {
        let later: f64 = (i + 1..columns.len()).map(|j| columns[j][i] * parts[j]).sum();
        parts[i] = (right[i] - later) / columns[i][i];
    }
    parts
}
