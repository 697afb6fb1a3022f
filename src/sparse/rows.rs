//! Rows of blocks.

use super::real::Real;

/// Block rows over the entries of a vector of blocks.
///
/// Each of the `height` rows of a block row holds its numbers in one piece, block after block: a
/// product runs along it.
#[derive(Default)]
pub struct BlockRows<T> {
    /// Rows of a block.
    pub height: usize,
    /// Columns of a block.
    pub width: usize,
    /// First block of each block row, and the count of all.
    pub start: Vec<usize>,
    /// Block column of each block, rising within a row.
    pub columns: Vec<u32>,
    /// Row after row of each block row.
    pub values: Vec<T>,
}

/// One block row.
#[derive(Clone, Copy)]
pub struct Row<'a, T> {
    /// Block columns.
    pub columns: &'a [u32],
    /// `height` rows of `width` numbers for each block.
    pub values: &'a [T],
}

impl<T: Real> BlockRows<T> {
    /// Rows of zeros with these columns, which rise within each row.
    pub fn with_columns(
        [height, width]: [usize; 2],
        rows: impl IntoIterator<Item = Vec<u32>>,
    ) -> Self {
        let (mut start, mut columns) = (vec![0], Vec::new());
        for row in rows {
            columns.extend(row);
            start.push(columns.len());
        }
        columns.shrink_to_fit();
        let values = vec![T::ZERO; columns.len() * height * width];
        Self { height, width, start, columns, values }
    }

    /// Block rows.
    pub fn len(&self) -> usize {
        self.start.len().saturating_sub(1)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A block row.
    pub fn row(&self, row: usize) -> Row<'_, T> {
        let (from, to) = (self.start[row], self.start[row + 1]);
        let size = self.height * self.width;
        Row { columns: &self.columns[from..to], values: &self.values[from * size..to * size] }
    }

    /// The numbers of a block row, to be changed.
    pub fn row_mut(&mut self, row: usize) -> &mut [T] {
        let (from, to) = (self.start[row], self.start[row + 1]);
        let size = self.height * self.width;
        &mut self.values[from * size..to * size]
    }

    /// Place of a column in its row.
    pub fn place(&self, row: usize, column: u32) -> Option<usize> {
        self.columns[self.start[row]..self.start[row + 1]].binary_search(&column).ok()
    }

    /// Copies a block, row by row.
    pub fn block(&self, row: usize, place: usize, block: &mut [T]) {
        let of = self.row(row);
        let length = of.columns.len() * self.width;
        for (h, to) in block.chunks_exact_mut(self.width).enumerate() {
            to.copy_from_slice(&of.values[h * length + place * self.width..][..self.width]);
        }
    }

    /// Adds to a block, whose rows stand `stride` apart in `values`.
    pub fn add(&mut self, row: usize, place: usize, values: &[T], stride: usize) {
        let (width, blocks) = (self.width, self.start[row + 1] - self.start[row]);
        let length = blocks * width;
        for (h, to) in self.row_mut(row).chunks_exact_mut(length).enumerate() {
            let to = &mut to[place * width..][..width];
            to.iter_mut().zip(&values[h * stride..]).for_each(|(t, v)| *t += *v);
        }
    }

    /// The same in single precision.
    pub fn to_single(&self) -> BlockRows<f32> {
        BlockRows {
            height: self.height,
            width: self.width,
            start: self.start.clone(),
            columns: self.columns.clone(),
            values: self.values.iter().map(|v| v.to_single()).collect(),
        }
    }
}
