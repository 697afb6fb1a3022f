//! The lowest eigenvalues of a tangent and their modes by LOBPCG (Knyazev, SIAM J. Sci. Comput. 23,
//! 2001), with the preconditioner or the factors at hand.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::comm::Comm;
use crate::error::Result;
use crate::petsc::TangentAt;

/// At least and at most so many iterations.
const ITERATIONS: [usize; 2] = [8, 60];
/// A positive eigenvalue that changes by less than this part of itself is taken as found.
const SETTLED: f64 = 1e-3;
/// A mode is exact enough with this residual over its eigenvalue.
const EXACT: f64 = 1e-4;
/// Eigenvalues that differ by less than this part count as one: its modes are any combination.
const SAME: f64 = 1e-2;
/// Directions that add less than this to the span of the others are left out.
const DEPENDENT: f64 = 1e-12;

/// When a search ends, if not at the most iterations.
#[derive(Clone, Copy, PartialEq)]
pub enum Until {
    /// A Rayleigh quotient below minus what rounding allows (N/m), which is a bound from above and
    /// proof enough, or a larger one that has settled.
    Proof(f64),
    /// The modes of the lowest eigenvalue are exact.
    Exact,
}

/// A vector and the tangent's product with it.
pub type WithProduct = (Vec<f64>, Vec<f64>);

/// The modes that belong to the lowest of the eigenvalues that are found from as many starts, of
/// unit length and orthogonal to each other, with the eigenvalue; none if the starts are zero.
/// Owned entries. Collective.
///
/// # Errors
/// `System` when PETSc fails.
pub fn lowest_modes(
    comm: &Comm,
    starts: Vec<Vec<f64>>,
    tangent: &mut TangentAt<'_>,
    until: Until,
) -> Result<Vec<(f64, Vec<f64>)>> {
    let block = starts.len();
    // Vectors with their products: the iterates, the preconditioned residuals, the last changes.
    let mut span = with_products(starts, tangent)?;
    let (mut iterates, mut values) = (block, Vec::new());
    let mut lowest = f64::INFINITY;
    for iteration in 0..ITERATIONS[1] {
        let found = least(comm, &span, block);
        let Some((value, _)) = found.first() else { break };
        let settled = (value - lowest).abs() <= SETTLED * value.abs();
        lowest = *value;
        let moved = span.len() > iterates;
        let changes: Vec<_> = found.iter().map(|(_, w)| combine(&span, w, iterates)).collect();
        span = found.iter().map(|(_, weights)| combine(&span, weights, 0)).collect();
        values = found.into_iter().map(|(value, _)| value).collect();
        iterates = span.len();
        let residual = |((x, jx), value): (&WithProduct, &f64)| -> Vec<f64> {
            jx.iter().zip(x).map(|(jx, x)| jx - value * x).collect()
        };
        let residuals: Vec<Vec<f64>> = span.iter().zip(&values).map(residual).collect();
        let done = match until {
            Until::Proof(rounding) => settled || lowest < -rounding,
            Until::Exact => are_exact(comm, &values, &residuals),
        };
        if done && iteration >= ITERATIONS[0] {
            break;
        }
        let directions: Result<Vec<_>> =
            residuals.iter().map(|r| tangent.precondition(r)).collect();
        span.extend(with_products(directions?, tangent)?);
        if moved {
            span.extend(changes);
        }
    }
    let modes = values.iter().zip(span).filter(|(value, _)| is_same(**value, lowest));
    Ok(modes.map(|(value, (x, _))| (*value, x)).collect())
}

/// The modes that belong to the lowest Rayleigh quotient over a span of vectors with their
/// products, at most `count`, with the quotient. Owned entries. Collective.
pub fn lowest_of(comm: &Comm, span: &[WithProduct], count: usize) -> Vec<(f64, Vec<f64>)> {
    let found = least(comm, span, count);
    let lowest = found.first().map_or(0.0, |(value, _)| *value);
    let own = found.into_iter().filter(|(value, _)| is_same(*value, lowest));
    own.map(|(value, weights)| (value, combine(span, &weights, 0).0)).collect()
}

/// Whether two eigenvalues count as one.
fn is_same(value: f64, lowest: f64) -> bool {
    value - lowest <= SAME * lowest.abs()
}

/// Whether the residuals of the lowest eigenvalue are small. Collective.
fn are_exact(comm: &Comm, values: &[f64], residuals: &[Vec<f64>]) -> bool {
    let mut squares: Vec<f64> =
        residuals.iter().map(|r| r.iter().map(|r| r * r).sum::<f64>()).collect();
    comm.sum(&mut squares);
    let own = values.iter().zip(squares).filter(|(value, _)| is_same(**value, values[0]));
    own.into_iter().all(|(value, square)| square.sqrt() <= EXACT * value.abs())
}

fn with_products(vectors: Vec<Vec<f64>>, tangent: &mut TangentAt<'_>) -> Result<Vec<WithProduct>> {
    let with_product = |v: Vec<f64>| tangent.multiply(&v).map(|product| (v, product));
    vectors.into_iter().map(with_product).collect()
}

/// The weighted sum of the vectors of a span from one of them on, with its product.
fn combine(span: &[WithProduct], weights: &[f64], from: usize) -> WithProduct {
    let size = span[0].0.len();
    let (mut sum, mut product) = (vec![0.0; size], vec![0.0; size]);
    for ((v, jv), weight) in span.iter().zip(weights).skip(from) {
        sum.iter_mut().zip(v).for_each(|(s, v)| *s += weight * v);
        product.iter_mut().zip(jv).for_each(|(s, v)| *s += weight * v);
    }
    (sum, product)
}

/// The least Rayleigh quotients over a span, at most `count`, rising, and the weights of their
/// vectors of unit length; none if the span is empty. Collective.
fn least(comm: &Comm, span: &[WithProduct], count: usize) -> Vec<(f64, Vec<f64>)> {
    let n = span.len();
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let mut sums = Vec::with_capacity(2 * n * n);
    for (a, _) in span {
        for (b, product) in span {
            sums.extend([dot(a, b), dot(a, product)]);
        }
    }
    comm.sum(&mut sums);
    let at = |kind: usize| {
        DMatrix::from_fn(n, n, |i, j| {
            0.5 * (sums[2 * (i * n + j) + kind] + sums[2 * (j * n + i) + kind])
        })
    };
    let (mass, energy) = (at(0), at(1));
    let scale = DMatrix::from_fn(n, n, |i, j| {
        if i == j && mass[(i, i)] > 0.0 { mass[(i, i)].sqrt().recip() } else { 0.0 }
    });
    let spectrum = SymmetricEigen::new(&scale * mass * &scale);
    let kept: Vec<usize> = (0..n).filter(|i| spectrum.eigenvalues[*i] > DEPENDENT).collect();
    if kept.is_empty() {
        return Vec::new();
    }
    let basis = DMatrix::from_fn(n, kept.len(), |i, j| {
        spectrum.eigenvectors[(i, kept[j])] / spectrum.eigenvalues[kept[j]].sqrt()
    });
    let basis = scale * basis;
    let reduced = SymmetricEigen::new(basis.transpose() * energy * &basis);
    let values = &reduced.eigenvalues;
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let pair = |i: &usize| {
        let weights = &basis * reduced.eigenvectors.column(*i);
        (values[*i], weights.iter().copied().collect())
    };
    order.iter().take(count).map(pair).collect()
}
