//! Gauss and Seidel's sweeps over the owned nodes, with inverted blocks of the diagonal.
//!
//! A sweep forward from zero and one backward are each other's transpose: between them the cycle is
//! symmetric. Entries of other ranks are those of before the sweep. Half the sizes of the couplings
//! to them, on the diagonal, keep the sweeps convergent on any number of ranks (Baker, Falgout,
//! Kolev and Yang, SIAM J. Sci. Comput. 33, 2011).

use crate::simd::{self, Kernel};
use crate::sparse::{BlockRows, Gathered, Halo, times, with_sizes};

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
    rows: BlockRows<f32>,
    /// Place of the block of the diagonal in each row.
    diagonal: Vec<u32>,
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
        let place = |i| matrix.place(i, i as u32).expect("a diagonal block") as u32;
        let inverse = inverse_blocks(matrix, Some(&extra));
        Self {
            rows: matrix.to_single(),
            diagonal: (0..matrix.len()).map(place).collect(),
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
        with_sizes!(self.of.rows, forward, self.of, self.b, self.x)
    }
}

#[inline(always)]
fn forward<const H: usize, const W: usize>(of: &Smoother, b: &[f32], x: &mut [f32]) {
    let mut room = Gathered::default();
    for i in 0..of.rows.len() {
        let (row, below) = (of.rows.row(i), of.diagonal[i] as usize);
        let length = row.columns.len() * W;
        let known = times::<f32, H, W>(&row.columns[..below], row.values, length, x, &mut room);
        let mut left = [0.0; H];
        for h in 0..H {
            left[h] = b[i * H + h] - known[h];
        }
        x[i * H..][..H].copy_from_slice(&apply(&of.inverse[i * H * H..][..H * H], left));
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
        with_sizes!(self.of.rows, left, self.of, self.x, self.r)
    }
}

#[inline(always)]
fn left<const H: usize, const W: usize>(of: &Smoother, x: &[f32], r: &mut [f32]) {
    let mut room = Gathered::default();
    for (i, r) in r.chunks_exact_mut(H).enumerate() {
        let (row, above) = (of.rows.row(i), of.diagonal[i] as usize + 1);
        let length = row.columns.len() * W;
        let columns = &row.columns[above..];
        let values = row.values.get(above * W..).unwrap_or_default();
        let beyond = times::<f32, H, W>(columns, values, length, x, &mut room);
        for h in 0..H {
            r[h] = of.extra[i * H + h] * x[i * H + h] - beyond[h];
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
        with_sizes!(self.of.rows, backward, self.of, self.b, self.x)
    }
}

#[inline(always)]
fn backward<const H: usize, const W: usize>(of: &Smoother, b: &[f32], x: &mut [f32]) {
    let mut room = Gathered::default();
    for i in (0..of.rows.len()).rev() {
        let row = of.rows.row(i);
        let product =
            times::<f32, H, W>(row.columns, row.values, row.columns.len() * W, x, &mut room);
        let mut left = [0.0; H];
        for h in 0..H {
            left[h] = b[i * H + h] - product[h];
        }
        let change = apply(&of.inverse[i * H * H..][..H * H], left);
        for h in 0..H {
            x[i * H + h] += change[h];
        }
    }
}
