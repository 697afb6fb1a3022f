//! The coarsest level: every rank holds it whole and knows its inverse.

use nalgebra::DMatrix;

use super::prolongation::Motions;
use crate::comm::Comm;
use crate::error::Result;
use crate::sparse::{BlockRows, Halo};

/// Added to the diagonal, over its largest entry, where rounding has made a matrix indefinite.
const SHIFTS: [f64; 4] = [0.0, 1e-12, 1e-8, 1e-4];

/// The inverse of a small matrix.
pub struct Coarsest {
    inverse: Vec<f32>,
    size: usize,
}

impl Coarsest {
    /// Of rows that this rank holds all of. Local.
    pub fn new(matrix: &BlockRows<f64>) -> Self {
        let n = matrix.height;
        let size = matrix.len() * n;
        let mut dense = DMatrix::zeros(size, size);
        let mut block = vec![0.0; n * n];
        for i in 0..matrix.len() {
            for (place, j) in matrix.row(i).columns.iter().enumerate() {
                matrix.block(i, place, &mut block);
                for (h, row) in block.chunks_exact(n).enumerate() {
                    for (w, a) in row.iter().enumerate() {
                        dense[(i * n + h, *j as usize * n + w)] = *a;
                    }
                }
            }
        }
        let largest = dense.diagonal().amax();
        let factored = SHIFTS.iter().find_map(|shift| {
            let mut shifted = dense.clone();
            for i in 0..size {
                shifted[(i, i)] += shift * largest;
            }
            shifted.cholesky()
        });
        let inverse = match factored {
            Some(factors) => factors.inverse(),
            None => DMatrix::zeros(size, size),
        };
        Self { inverse: inverse.iter().map(|a| *a as f32).collect(), size }
    }

    /// Of no entry. Local.
    pub fn none() -> Self {
        Self { inverse: Vec::new(), size: 0 }
    }

    /// `x` = inverse times `b`. Local.
    pub fn solve(&self, b: &[f32], x: &mut [f32]) {
        if self.size == 0 {
            return;
        }
        for (x, row) in x.iter_mut().zip(self.inverse.chunks_exact(self.size)) {
            *x = row.iter().zip(b).map(|(a, b)| a * b).sum();
        }
    }
}

/// Rows and motions of all ranks, on every rank. Collective.
///
/// # Errors
/// `Bug` when the exchange does not fit.
pub fn rows_of_all(
    comm: &Comm,
    matrix: &BlockRows<f64>,
    halo: &Halo,
    motions: &Motions,
) -> Result<(BlockRows<f64>, Halo, Motions)> {
    let n = matrix.height;
    let size = n * motions.count;
    let mut packed = Vec::new();
    for i in 0..matrix.len() {
        let row = matrix.row(i);
        packed.push(row.columns.len() as f64);
        packed.extend(row.columns.iter().map(|c| halo.number(*c as usize) as f64));
        packed.extend_from_slice(row.values);
        packed.extend_from_slice(&motions.values[i * size..][..size]);
    }
    let lists = comm.exchange(&vec![packed; comm.size() as usize]);
    let mut all = Motions { height: n, count: motions.count, values: Vec::new() };
    let mut rows: Vec<(Vec<u32>, &[f64])> = Vec::new();
    for list in &lists {
        let mut rest = list.as_slice();
        while let [count, tail @ ..] = rest {
            let (columns, tail) = tail.split_at(*count as usize);
            let (values, tail) = tail.split_at(columns.len() * n * n);
            let (motions, tail) = tail.split_at(size);
            all.values.extend_from_slice(motions);
            rows.push((columns.iter().map(|c| *c as u32).collect(), values));
            rest = tail;
        }
    }
    let in_order = |columns: &[u32]| {
        let mut order: Vec<(u32, usize)> = columns.iter().copied().zip(0..).collect();
        order.sort_unstable();
        order
    };
    let columns = rows.iter().map(|(columns, _)| in_order(columns).iter().map(|c| c.0).collect());
    let mut whole = BlockRows::with_columns([n, n], columns);
    for (i, (columns, values)) in rows.iter().enumerate() {
        for (place, (_, at)) in in_order(columns).into_iter().enumerate() {
            whole.add(i, place, &values[at * n..], columns.len() * n);
        }
    }
    let halo = Halo::new(&comm.alone(), whole.len(), Vec::new())?;
    Ok((whole, halo, all))
}
