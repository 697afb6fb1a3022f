//! Which nodes move together.

use crate::sparse::{BlockRows, Halo};

/// Node in no aggregate.
pub const NONE: u32 = u32::MAX;

/// The aggregate of each owned node, and their number. Nodes that are not `free` are in none; those
/// of other ranks join no aggregate of this one.
pub struct Aggregates {
    /// Of each owned node, or [`NONE`].
    pub of: Vec<u32>,
    pub count: usize,
}

/// Sums of the squares of the diagonal blocks, at owned entries and ghosts.
fn diagonal_sizes(matrix: &BlockRows<f64>, halo: &Halo) -> Vec<f64> {
    let mut sizes = vec![0.0; halo.len()];
    let mut block = vec![0.0; matrix.height * matrix.width];
    for (i, size) in sizes[..halo.owned].iter_mut().enumerate() {
        let place = matrix.place(i, i as u32).expect("a diagonal block");
        matrix.block(i, place, &mut block);
        *size = block.iter().map(|a| a * a).sum();
    }
    sizes
}

/// Strong owned neighbours of each owned node, with the strength.
fn strong_neighbours(
    matrix: &BlockRows<f64>,
    halo: &Halo,
    free: &[bool],
    least: f64,
) -> BlockRows<f64> {
    let sizes = diagonal_sizes(matrix, halo);
    let (mut start, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    let width = matrix.width;
    let mut squares = Vec::new();
    for i in 0..matrix.len() {
        let row = matrix.row(i);
        squares.clear();
        squares.resize(row.columns.len(), 0.0);
        if free[i] {
            for part in row.values.chunks_exact(row.columns.len() * width) {
                for (square, block) in squares.iter_mut().zip(part.chunks_exact(width)) {
                    *square += block.iter().map(|a| a * a).sum::<f64>();
                }
            }
        }
        for (column, square) in row.columns.iter().zip(&squares) {
            let j = *column as usize;
            if j == i || j >= halo.owned || !free[i] || !free[j] {
                continue;
            }
            let strength = square / (sizes[i] * sizes[j]).sqrt();
            if strength > least * least {
                columns.push(*column);
                values.push(strength);
            }
        }
        start.push(columns.len());
    }
    BlockRows { height: 1, width: 1, start, columns, values }
}

impl Aggregates {
    /// Joins the owned nodes of a matrix that are `free`, where their coupling is more than `least`
    /// of the geometric mean of the diagonals. Local.
    pub fn new(matrix: &BlockRows<f64>, halo: &Halo, free: &[bool], least: f64) -> Self {
        let strong = strong_neighbours(matrix, halo, free, least);
        let mut found = Self { of: vec![NONE; halo.owned], count: 0 };
        found.take_whole_neighbourhoods(&strong, free);
        found.join_what_is_left(&strong, free);
        found.take_rests(&strong, free);
        found
    }

    fn take(&mut self, root: usize, neighbours: &[u32]) {
        self.of[root] = self.count as u32;
        for node in neighbours {
            if self.of[*node as usize] == NONE {
                self.of[*node as usize] = self.count as u32;
            }
        }
        self.count += 1;
    }

    /// A node and its neighbours, where none of them is taken.
    fn take_whole_neighbourhoods(&mut self, strong: &BlockRows<f64>, free: &[bool]) {
        for root in (0..self.of.len()).filter(|i| free[*i]) {
            let neighbours = strong.row(root).columns;
            let untaken = |node: &u32| self.of[*node as usize] == NONE;
            if self.of[root] == NONE && !neighbours.is_empty() && neighbours.iter().all(untaken) {
                self.take(root, neighbours);
            }
        }
    }

    /// Nodes beside aggregates join the one they are coupled to most.
    fn join_what_is_left(&mut self, strong: &BlockRows<f64>, free: &[bool]) {
        let whole = self.of.clone();
        for node in (0..whole.len()).filter(|i| free[*i] && whole[*i] == NONE) {
            let row = strong.row(node);
            let taken = row.columns.iter().zip(row.values);
            let taken = taken.filter(|(neighbour, _)| whole[**neighbour as usize] != NONE);
            if let Some((best, _)) = taken.max_by(|a, b| a.1.total_cmp(b.1)) {
                self.of[node] = whole[*best as usize];
            }
        }
    }

    /// The rest, with what is left around it.
    fn take_rests(&mut self, strong: &BlockRows<f64>, free: &[bool]) {
        for root in (0..self.of.len()).filter(|i| free[*i]) {
            if self.of[root] == NONE {
                self.take(root, strong.row(root).columns);
            }
        }
    }
}
