//! Rows of square blocks in single precision, each block by its columns: what sweeps read.
//!
//! A sweep needs the entry that it has just written. So nothing is gathered: each column of a block
//! is multiplied by its entry, in as many sums as the processor can keep going.

use std::ops::Range;

use crate::sparse::BlockRows;

/// Numbers beyond the last block, which its last columns are read with.
const SLACK: usize = 8;

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
    /// Of the rows of `matrix`, rounded, the blocks at the places that `part` gives for a row.
    pub fn new(matrix: &BlockRows<f64>, part: impl Fn(usize) -> Range<usize>) -> Self {
        let n = matrix.height;
        let count: usize = (0..matrix.len()).map(|i| part(i).len()).sum();
        let (mut start, mut columns) = (vec![0], Vec::with_capacity(count));
        let mut values = vec![0.0; count * n * n + SLACK];
        let mut block = vec![0.0; n * n];
        for i in 0..matrix.len() {
            for place in part(i) {
                matrix.block(i, place, &mut block);
                let to = &mut values[columns.len() * n * n..][..n * n];
                for (k, to) in to.iter_mut().enumerate() {
                    *to = block[k % n * n + k / n] as f32;
                }
                columns.push(matrix.row(i).columns[place]);
            }
            start.push(columns.len());
        }
        Self { size: n, start, columns, values }
    }

    /// Number of block rows.
    pub fn len(&self) -> usize {
        self.start.len().saturating_sub(1)
    }

    /// The blocks of a row from the place `from` on.
    #[inline(always)]
    pub fn blocks(&self, row: usize, from: usize) -> Blocks<'_> {
        let (first, to) = (self.start[row], self.start[row + 1]);
        let from = (first + from).min(to);
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
            let mut block = vec![0.0; N * N];
            for (i, columns) in columns.iter().enumerate() {
                for (from, to, skip) in [(0, 9, 0), (0, 1, 0), (1, 9, 0), (0, 9, 1), (0, 9, 9)] {
                    let part = |row: usize| {
                        let end = matrix.row(row).columns.len();
                        from.min(end)..to.min(end)
                    };
                    let rows = ByColumns::new(&matrix, part);
                    let mut expected = [0.0; N];
                    for place in part(i).skip(skip) {
                        matrix.block(i, place, &mut block);
                        let x = &x[columns[place] as usize * N..][..N];
                        for (h, sum) in expected.iter_mut().enumerate() {
                            let row = &block[h * N..][..N];
                            *sum += row.iter().zip(x).map(|(a, x)| *a as f32 * x).sum::<f32>();
                        }
                    }
                    for way in [Way::Up, Way::Down] {
                        // Small whole numbers: exact in any order.
                        assert_eq!(rows.blocks(i, skip).times::<N, L>(&x, way), expected);
                    }
                }
            }
        }
        check::<2, 4>();
        check::<3, 4>();
        check::<6, 8>();
    }
}
