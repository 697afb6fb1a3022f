//! Gauss and Seidel's sweeps over the owned nodes, with inverted blocks of the diagonal.
//!
//! A sweep forward from zero and one backward are each other's transpose: between them the cycle is
//! symmetric. Entries of other ranks are those of before the sweep. Half the sizes of the couplings
//! to them, on the diagonal, keep the sweeps convergent on any number of ranks (Baker, Falgout,
//! Kolev and Yang, SIAM J. Sci. Comput. 33, 2011).

use super::by_columns::{ByColumns, Way, with_size};
use crate::simd::{self, Kernel};
use crate::sparse::{BlockRows, Halo};

/// The inverse of the block of the diagonal of each row, with `extra` on its diagonal.
pub fn inverse_blocks(matrix: &BlockRows<f64>, extra: Option<&[f64]>) -> Vec<f64> {
    let n = matrix.height;
    let mut inverses = vec![0.0; matrix.len() * n * n];
    let mut block = vec![0.0; n * n];
    for (i, inverse) in inverses.chunks_exact_mut(n * n).enumerate() {
        let place = matrix.place(i, i as u32).expect("a diagonal block");
        matrix.block(i, place, &mut block);
        if let Some(extra) = extra {
            for (d, extra) in block.iter_mut().step_by(n + 1).zip(&extra[i * n..]) {
                *d += extra;
            }
        }
        if invert(&mut block, n) {
            inverse.copy_from_slice(&block);
            continue;
        }
        // No such block is positive definite: its diagonal alone.
        matrix.block(i, place, &mut block);
        for (to, d) in inverse.iter_mut().step_by(n + 1).zip(block.iter().step_by(n + 1)) {
            *to = d.abs().max(f64::MIN_POSITIVE).recip();
        }
    }
    inverses
}

/// Inverts a symmetric positive definite block in place; tells whether it could.
fn invert(block: &mut [f64], n: usize) -> bool {
    for k in 0..n {
        let pivot = block[k * n + k];
        if pivot.is_nan() || pivot <= 0.0 {
            return false;
        }
        let inverse = pivot.recip();
        let row: [f64; 6] = std::array::from_fn(|j| if j < n { block[k * n + j] } else { 0.0 });
        for i in (0..n).filter(|i| *i != k) {
            let factor = block[i * n + k] * inverse;
            for j in (0..n).filter(|j| *j != k) {
                block[i * n + j] -= factor * row[j];
            }
            block[i * n + k] = -factor;
        }
        for j in 0..n {
            block[k * n + j] = if j == k { inverse } else { row[j] * inverse };
        }
    }
    true
}

/// The matrix of a level with its sweeps, in single precision.
pub struct Smoother {
    /// Left of the diagonal, and from it on: a sweep reads each as a stream.
    below: ByColumns,
    above: ByColumns,
    /// Inverses of these blocks, with the extra numbers.
    inverse: Vec<f32>,
    /// What was added to the diagonal.
    extra: Vec<f32>,
}

impl Smoother {
    /// Of the owned rows of `matrix`. Local.
    pub fn new(matrix: &BlockRows<f64>, halo: &Halo) -> Self {
        let n = matrix.height;
        let mut extra = vec![0.0; matrix.len() * n];
        for (i, extra) in extra.chunks_exact_mut(n).enumerate() {
            let row = matrix.row(i);
            let own = row.columns.partition_point(|c| (*c as usize) < halo.owned);
            for (extra, row) in extra.iter_mut().zip(row.values.chunks_exact(row.columns.len() * n))
            {
                *extra = 0.5 * row[own * n..].iter().map(|a| a.abs()).sum::<f64>();
            }
        }
        let place = |i| matrix.place(i, i as u32).expect("a diagonal block");
        let inverse = inverse_blocks(matrix, Some(&extra));
        Self {
            below: ByColumns::new(matrix, |i| 0..place(i)),
            above: ByColumns::new(matrix, |i| place(i)..matrix.row(i).columns.len()),
            inverse: inverse.into_iter().map(|a| a as f32).collect(),
            extra: extra.into_iter().map(|a| a as f32).collect(),
        }
    }

    /// `x` = what a sweep forward makes of zero, at owned entries. Local.
    pub fn forward(&self, b: &[f32], x: &mut [f32]) {
        simd::widest(Forward { of: self, b, x });
    }

    /// `r` = what is left of the right-hand side after [`Smoother::forward`]; `x` has its ghosts.
    /// Local.
    pub fn left(&self, x: &[f32], r: &mut [f32]) {
        simd::widest(Left { of: self, x, r });
    }

    /// A sweep backward from `x`, which has its ghosts. Local.
    pub fn backward(&self, b: &[f32], x: &mut [f32]) {
        simd::widest(Backward { of: self, b, x });
    }
}

/// `y` = the square block `a` times `b`.
#[inline(always)]
fn apply<const H: usize>(a: &[f32], b: [f32; H]) -> [f32; H] {
    let mut y = [0.0; H];
    for (y, row) in y.iter_mut().zip(a.chunks_exact(H)) {
        for (a, b) in row.iter().zip(&b) {
            *y += a * b;
        }
    }
    y
}

struct Forward<'a> {
    of: &'a Smoother,
    b: &'a [f32],
    x: &'a mut [f32],
}

impl Kernel for Forward<'_> {
    #[inline(always)]
    fn run(self) {
        with_size!(self.of.below, forward, self.of, self.b, self.x)
    }
}

#[inline(always)]
fn forward<const N: usize, const L: usize>(of: &Smoother, b: &[f32], x: &mut [f32]) {
    for i in 0..of.below.len() {
        let known = of.below.blocks(i, 0).times::<N, L>(x, Way::Up);
        let left = std::array::from_fn(|h| b[i * N + h] - known[h]);
        x[i * N..][..N].copy_from_slice(&apply::<N>(&of.inverse[i * N * N..][..N * N], left));
    }
}

struct Left<'a> {
    of: &'a Smoother,
    x: &'a [f32],
    r: &'a mut [f32],
}

impl Kernel for Left<'_> {
    #[inline(always)]
    fn run(self) {
        with_size!(self.of.below, left, self.of, self.x, self.r)
    }
}

#[inline(always)]
fn left<const N: usize, const L: usize>(of: &Smoother, x: &[f32], r: &mut [f32]) {
    for (i, r) in r.chunks_exact_mut(N).enumerate() {
        let beyond = of.above.blocks(i, 1).times::<N, L>(x, Way::Up);
        for h in 0..N {
            r[h] = of.extra[i * N + h] * x[i * N + h] - beyond[h];
        }
    }
}

struct Backward<'a> {
    of: &'a Smoother,
    b: &'a [f32],
    x: &'a mut [f32],
}

impl Kernel for Backward<'_> {
    #[inline(always)]
    fn run(self) {
        with_size!(self.of.below, backward, self.of, self.b, self.x)
    }
}

#[inline(always)]
fn backward<const N: usize, const L: usize>(of: &Smoother, b: &[f32], x: &mut [f32]) {
    for i in (0..of.below.len()).rev() {
        let above = of.above.blocks(i, 0).times::<N, L>(x, Way::Down);
        let below = of.below.blocks(i, 0).times::<N, L>(x, Way::Down);
        let left = std::array::from_fn(|h| b[i * N + h] - above[h] - below[h]);
        let change = apply::<N>(&of.inverse[i * N * N..][..N * N], left);
        for h in 0..N {
            x[i * N + h] += change[h];
        }
    }
}
