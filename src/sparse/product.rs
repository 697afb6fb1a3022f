//! Products of block rows with vectors of blocks.

use super::real::Real;
use super::rows::BlockRows;
use crate::simd::{self, Kernel};

/// Numbers at a time, for vectors of the processor.
const LANES: usize = 8;

/// Blocks of a row that are gathered at once.
const MOST: usize = 64;

/// Room for the entries that a row needs.
pub struct Gathered<T>([T; MOST * 6]);

impl<T: Real> Default for Gathered<T> {
    #[inline(always)]
    fn default() -> Self {
        Self([T::ZERO; MOST * 6])
    }
}

/// The product of `H` rows of `W` numbers a block with the entries of `x` at `columns`; `length` is
/// the length of a row in `values`.
#[inline(always)]
pub fn times<T: Real, const H: usize, const W: usize>(
    columns: &[u32],
    values: &[T],
    length: usize,
    x: &[T],
    Gathered(gathered): &mut Gathered<T>,
) -> [T; H] {
    let mut sums = [T::ZERO; H];
    for (part, columns) in columns.chunks(MOST).enumerate() {
        for (to, column) in gathered.chunks_exact_mut(W).zip(columns) {
            to.copy_from_slice(&x[*column as usize * W..][..W]);
        }
        let gathered = &gathered[..columns.len() * W];
        let whole = gathered.len() / LANES * LANES;
        for (h, sum) in sums.iter_mut().enumerate() {
            let row = &values[h * length + part * MOST * W..][..gathered.len()];
            let mut lanes = [T::ZERO; LANES];
            for (a, x) in row[..whole].chunks_exact(LANES).zip(gathered.chunks_exact(LANES)) {
                for lane in 0..LANES {
                    lanes[lane] += a[lane] * x[lane];
                }
            }
            for (a, x) in row[whole..].iter().zip(&gathered[whole..]) {
                *sum += *a * *x;
            }
            for half in [4, 2, 1] {
                for lane in 0..half {
                    let other = lanes[lane + half];
                    lanes[lane] += other;
                }
            }
            *sum += lanes[0];
        }
    }
    sums
}

/// Runs a function of the sizes of the blocks for those that occur.
macro_rules! with_sizes {
    ($rows:expr, $run:ident $(::<$real:ident>)?, $($argument:expr),*) => {
        match [$rows.height, $rows.width] {
            [2, 2] => $run::<$($real,)? 2, 2>($($argument),*),
            [2, 3] => $run::<$($real,)? 2, 3>($($argument),*),
            [3, 3] => $run::<$($real,)? 3, 3>($($argument),*),
            [3, 6] => $run::<$($real,)? 3, 6>($($argument),*),
            [6, 6] => $run::<$($real,)? 6, 6>($($argument),*),
            sizes => panic!("blocks of {sizes:?}"),
        }
    };
}
pub(crate) use with_sizes;

struct Product<'a, T> {
    rows: &'a BlockRows<T>,
    x: &'a [T],
    y: &'a mut [T],
}

#[inline(always)]
fn product<T: Real, const H: usize, const W: usize>(of: Product<'_, T>) {
    let mut room = Gathered::default();
    for (i, y) in of.y.chunks_exact_mut(H).enumerate() {
        let row = of.rows.row(i);
        let length = row.columns.len() * W;
        let product = times::<T, H, W>(row.columns, row.values, length, of.x, &mut room);
        y.copy_from_slice(&product);
    }
}

impl<T: Real> Kernel for Product<'_, T> {
    #[inline(always)]
    fn run(self) {
        with_sizes!(self.rows, product::<T>, self)
    }
}

impl<T: Real> BlockRows<T> {
    /// `y` = rows times `x`, which holds owned entries and ghosts. Local.
    pub fn multiply(&self, x: &[T], y: &mut [T]) {
        simd::widest(Product { rows: self, x, y });
    }
}
