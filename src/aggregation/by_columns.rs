//! Rows of square blocks in single precision, each block by its columns: what sweeps read.
//!
//! A sweep needs the entry that it has just written. So nothing is gathered: each column of a block
//! is multiplied by its entry, in as many sums as the processor can keep going.

use crate::sparse::BlockRows;

/// Numbers beyond the last block, which its last columns are read with.
const SLACK: usize = 8;

/// Beyond the last block of any row.
pub const END: usize = u32::MAX as usize;

/// Block rows, each block by its columns.
pub struct ByColumns {
    /// Rows and columns of a block.
    pub size: usize,
    start: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f32>,
}

/// Neighbouring blocks of a row.
#[derive(Clone, Copy)]
pub struct Blocks<'a> {
    columns: &'a [u32],
    /// Of the blocks, and a little beyond.
    values: &'a [f32],
}

impl ByColumns {
    /// The rows of `matrix`, rounded.
    pub fn new(matrix: &BlockRows<f64>) -> Self {
        let n = matrix.height;
        let mut values = vec![0.0; matrix.values.len() + SLACK];
        let mut block = vec![0.0; n * n];
        let mut blocks = values.chunks_exact_mut(n * n);
        for i in 0..matrix.len() {
            for place in 0..matrix.row(i).columns.len() {
                matrix.block(i, place, &mut block);
                let Some(to) = blocks.next() else { continue };
                for (k, to) in to.iter_mut().enumerate() {
                    *to = block[k % n * n + k / n] as f32;
                }
            }
        }
        drop(blocks);
        Self { size: n, start: matrix.start.clone(), columns: matrix.columns.clone(), values }
    }

    /// Number of block rows.
    pub fn len(&self) -> usize {
        self.start.len().saturating_sub(1)
    }

    /// The blocks of a row from the place `from` up to `to`, or to its end.
    #[inline(always)]
    pub fn blocks(&self, row: usize, from: usize, to: usize) -> Blocks<'_> {
        let (first, end) = (self.start[row], self.start[row + 1]);
        let (from, to) = ((first + from).min(end), (first + to).min(end));
        let area = self.size * self.size;
        let values = &self.values[from * area..to * area + SLACK];
        Blocks { columns: &self.columns[from..to], values }
    }
}

/// Which way a sweep goes. One that goes down reads down: processors fetch ahead along a stream,
/// not along rows that rise while their places fall (a sweep in 15 ms for 53).
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// By rising place.
    Up,
    /// By falling place.
    Down,
}

impl Blocks<'_> {
    /// The blocks, of `N` rows and columns, times the entries of `x` at their columns; `L`: numbers
    /// read for a column, at least `N`.
    #[inline(always)]
    pub fn times<const N: usize, const L: usize>(self, x: &[f32], way: Way) -> [f32; N] {
        let mut sums = [[[0.0; L]; N]; 2];
        let count = self.columns.len();
        match way {
            Way::Up => {
                for place in 0..count {
                    self.add::<N, L>(place, x, &mut sums[place & 1]);
                }
            }
            Way::Down => {
                for place in (0..count).rev() {
                    self.add::<N, L>(place, x, &mut sums[place & 1]);
                }
            }
        }
        let [even, odd] = sums;
        std::array::from_fn(|h| even.iter().zip(&odd).map(|(even, odd)| even[h] + odd[h]).sum())
    }

    #[inline(always)]
    fn add<const N: usize, const L: usize>(
        self,
        place: usize,
        x: &[f32],
        sums: &mut [[f32; L]; N],
    ) {
        let block = &self.values[place * N * N..][..(N - 1) * N + L];
        let x = &x[self.columns[place] as usize * N..][..N];
        for (j, sums) in sums.iter_mut().enumerate() {
            for (l, sum) in sums.iter_mut().enumerate() {
                *sum += block[j * N + l] * x[j];
            }
        }
    }
}

/// Runs a function of the size of blocks and of the numbers read for a column, for those that
/// occur.
macro_rules! with_size {
    ($rows:expr, $run:ident, $($argument:expr),*) => {
        match $rows.size {
            2 => $run::<2, 4>($($argument),*),
            3 => $run::<3, 4>($($argument),*),
            6 => $run::<6, 8>($($argument),*),
            size => panic!("square blocks of {size}"),
        }
    };
}
pub(crate) use with_size;

#[cfg(test)]
mod tests {
    use super::*;

    /// Every part of a row, in both ways, against a sum over its blocks.
    #[test]
    fn blocks_by_their_columns_multiply_as_rows_do() {
        fn check<const N: usize, const L: usize>() {
            let columns = [vec![0, 2, 3], vec![1], vec![0, 1, 2, 3]];
            let mut matrix = BlockRows::<f64>::with_columns([N, N], columns.clone());
            let numbers = matrix.values.iter_mut().enumerate();
            numbers.for_each(|(k, value)| *value = ((k * 37) % 11) as f64 - 5.0);
            let x: Vec<f32> = (0..4 * N).map(|k| ((k * 5) % 7) as f32 - 3.0).collect();
            let rows = ByColumns::new(&matrix);
            let mut block = vec![0.0; N * N];
            for (i, columns) in columns.iter().enumerate() {
                for (from, to) in [(0, 9), (0, 1), (1, 9), (9, 9)] {
                    let mut expected = [0.0; N];
                    for place in from..to.min(columns.len()) {
                        matrix.block(i, place, &mut block);
                        let x = &x[columns[place] as usize * N..][..N];
                        for (h, sum) in expected.iter_mut().enumerate() {
                            let row = &block[h * N..][..N];
                            *sum += row.iter().zip(x).map(|(a, x)| *a as f32 * x).sum::<f32>();
                        }
                    }
                    for way in [Way::Up, Way::Down] {
                        // Small whole numbers: exact in any order.
                        assert_eq!(rows.blocks(i, from, to).times::<N, L>(&x, way), expected);
                    }
                }
            }
        }
        check::<2, 4>();
        check::<3, 4>();
        check::<6, 8>();
    }
}
