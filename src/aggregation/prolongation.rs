//! The basis of a coarser level: motions of aggregates, smoothed once.

use std::collections::HashMap;

use super::aggregates::{Aggregates, NONE};
use super::smoother::inverse_blocks;
use crate::comm::Comm;
use crate::sparse::{BlockRows, Halo, Row};

/// Part of its length that a motion has to add to those before it.
const INDEPENDENT: f64 = 1e-6;

/// Over the largest eigenvalue: the step of the smoothing.
const STEP: f64 = 4.0 / 3.0;

/// Products with the matrix that find the largest eigenvalue.
const PRODUCTS: usize = 8;

/// Motions of the nodes: of each owned node `height` rows of `count` numbers.
pub struct Motions {
    /// Components of a node.
    pub height: usize,
    /// Motions.
    pub count: usize,
    /// Node after node.
    pub values: Vec<f64>,
}

impl Motions {
    /// Whether each node takes part in any motion.
    pub fn free(&self) -> Vec<bool> {
        let size = self.height * self.count;
        self.values.chunks_exact(size).map(|node| node.iter().any(|v| *v != 0.0)).collect()
    }
}

/// The motions of each aggregate at right angles to each other, at its nodes.
pub struct Tentative {
    /// Number of the aggregate of each owned node and ghost among all, or -1.
    pub aggregate: Vec<f64>,
    /// Blocks of all owned nodes and ghosts.
    pub blocks: Vec<f64>,
    /// The motions of the level above as motions of the aggregates.
    pub coarse: Motions,
}

impl Tentative {
    /// Of `aggregates`, the first of which has the number `first`. Collective.
    pub fn new(motions: &Motions, aggregates: &Aggregates, first: u64, halo: &Halo) -> Self {
        let Motions { height, count, values } = motions;
        let (height, count, size) = (*height, *count, height * count);
        let mut members = vec![Vec::new(); aggregates.count];
        for (node, aggregate) in aggregates.of.iter().enumerate().filter(|(_, a)| **a != NONE) {
            members[*aggregate as usize].push(node);
        }
        let mut blocks = vec![0.0; halo.len() * size];
        let mut coarse = vec![0.0; aggregates.count * count * count];
        let mut basis = Vec::new();
        for (nodes, coarse) in members.iter().zip(coarse.chunks_exact_mut(count * count)) {
            basis.clear();
            // Motion by motion.
            for k in 0..count {
                let of_node = |node: &usize| {
                    let rows = values[node * size..][..size].chunks_exact(count);
                    rows.map(move |row| row[k])
                };
                basis.extend(nodes.iter().flat_map(of_node));
            }
            make_orthonormal(&mut basis, nodes.len() * height, coarse);
            for (place, node) in nodes.iter().enumerate() {
                let block = &mut blocks[node * size..][..size];
                for (h, row) in block.chunks_exact_mut(count).enumerate() {
                    for (k, to) in row.iter_mut().enumerate() {
                        *to = basis[(k * nodes.len() + place) * height + h];
                    }
                }
            }
        }
        let number = |a: &u32| if *a == NONE { -1.0 } else { (first + u64::from(*a)) as f64 };
        let mut aggregate: Vec<f64> = aggregates.of.iter().map(number).collect();
        aggregate.resize(halo.len(), -1.0);
        halo.update(&mut aggregate, 1);
        halo.update(&mut blocks, size);
        Self { aggregate, blocks, coarse: Motions { height: count, count, values: coarse } }
    }
}

/// Makes the columns of `basis`, each of `length` numbers, orthonormal; `factors` become what
/// turns the new ones into the old ones, row by row. A column that depends on those before it
/// becomes zero.
fn make_orthonormal(basis: &mut [f64], length: usize, factors: &mut [f64]) {
    let count = basis.len().checked_div(length).unwrap_or(0);
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    for k in 0..count {
        let (before, rest) = basis.split_at_mut(k * length);
        let column = &mut rest[..length];
        let size = dot(column, column).sqrt();
        // Twice is enough.
        for _ in 0..2 {
            for (j, other) in before.chunks_exact(length).enumerate() {
                let part = dot(other, column);
                factors[j * count + k] += part;
                column.iter_mut().zip(other).for_each(|(c, o)| *c -= part * o);
            }
        }
        let left = dot(column, column).sqrt();
        if left > INDEPENDENT * size {
            factors[k * count + k] = left;
            column.iter_mut().for_each(|c| *c /= left);
        } else {
            column.fill(0.0);
        }
    }
}

/// The largest eigenvalue of D^-1 A with the blocks of the diagonal, by the power method from a
/// vector that is the same on any number of ranks; a few percent too small. Collective.
fn largest_eigenvalue(comm: &Comm, matrix: &BlockRows<f64>, halo: &Halo, inverse: &[f64]) -> f64 {
    let height = matrix.height;
    let start = |i: usize| {
        let number = halo.number(i / height) * 8 + (i % height) as u64;
        crate::hash::mix(number) as f64 / u64::MAX as f64 - 0.5
    };
    let mut x: Vec<f64> = (0..halo.len() * height).map(start).collect();
    let mut y = vec![0.0; halo.owned * height];
    let mut largest = 1.0;
    for _ in 0..PRODUCTS {
        matrix.multiply(&x, &mut y);
        let mut squares = [0.0; 2];
        let blocks = inverse.chunks_exact(height * height);
        for ((y, x), inverse) in y.chunks_exact(height).zip(x.chunks_exact_mut(height)).zip(blocks)
        {
            squares[0] += x.iter().map(|x| x * x).sum::<f64>();
            for (x, row) in x.iter_mut().zip(inverse.chunks_exact(height)) {
                *x = row.iter().zip(y).map(|(a, y)| a * y).sum();
            }
            squares[1] += x.iter().map(|x| x * x).sum::<f64>();
        }
        comm.sum(&mut squares);
        if squares[0] == 0.0 || squares[1] == 0.0 {
            break;
        }
        largest = (squares[1] / squares[0]).sqrt();
        let scale = squares[1].sqrt().recip();
        x[..y.len()].iter_mut().for_each(|x| *x *= scale);
        halo.update(&mut x, height);
    }
    largest
}

/// The basis of a coarser level at the nodes of a finer one.
pub struct Prolongation {
    /// Of the owned nodes; columns are places in `numbers`.
    pub rows: BlockRows<f64>,
    /// Numbers of aggregates among all: those of this rank, then others as they occur.
    pub numbers: Vec<u64>,
    /// Where each of the others stands.
    pub others: HashMap<u64, u32>,
    /// Aggregates of this rank.
    pub owned: usize,
}

impl Prolongation {
    /// The place of an aggregate, which is new perhaps.
    pub fn place(&mut self, number: u64) -> u32 {
        let first = self.numbers.first().copied().unwrap_or(0);
        match number.checked_sub(first).filter(|own| *own < self.owned as u64) {
            Some(own) => own as u32,
            None => *self.others.entry(number).or_insert_with(|| {
                self.numbers.push(number);
                (self.numbers.len() - 1) as u32
            }),
        }
    }

    /// Smooths the motions of the aggregates, of which this rank has `owned` from `first` on, with
    /// one damped Jacobi step over the blocks of the diagonal. Collective.
    pub fn new(
        comm: &Comm,
        matrix: &BlockRows<f64>,
        halo: &Halo,
        tentative: &Tentative,
        [first, owned]: [u64; 2],
    ) -> Self {
        let (height, width) = (matrix.height, tentative.coarse.count);
        let (size, square) = (height * width, height * height);
        let inverse = inverse_blocks(matrix, None);
        let step = STEP / largest_eigenvalue(comm, matrix, halo, &inverse);
        let mut found = Self {
            rows: BlockRows { height, width, start: vec![0], ..BlockRows::default() },
            numbers: (first..first + owned).collect(),
            others: HashMap::new(),
            owned: owned as usize,
        };
        let (mut columns, mut sums): (Vec<u32>, Vec<f64>) = (Vec::new(), Vec::new());
        for i in 0..matrix.len() {
            found.multiply_row(matrix.row(i), tentative, &mut columns, &mut sums);
            let own = found.aggregate(tentative, i);
            let inverse = &inverse[i * square..][..square];
            let own_block = &tentative.blocks[i * size..][..size];
            found.push(&columns, own, |at, block| {
                let sum = &sums[at * size..][..size];
                for (to, inverse) in block.chunks_exact_mut(width).zip(inverse.chunks_exact(height))
                {
                    for (a, sum) in inverse.iter().zip(sum.chunks_exact(width)) {
                        to.iter_mut().zip(sum).for_each(|(t, s)| *t -= step * a * s);
                    }
                }
                if Some(columns[at]) == own {
                    block.iter_mut().zip(own_block).for_each(|(t, b)| *t += b);
                }
            });
        }
        found
    }

    /// The place of the aggregate of a local node, if it is in one.
    fn aggregate(&mut self, tentative: &Tentative, node: usize) -> Option<u32> {
        let number = tentative.aggregate[node];
        (number >= 0.0).then(|| self.place(number as u64))
    }

    /// The blocks of a row times those of the aggregates, over the `columns` that occur.
    fn multiply_row(
        &mut self,
        row: Row<'_, f64>,
        tentative: &Tentative,
        columns: &mut Vec<u32>,
        sums: &mut Vec<f64>,
    ) {
        let [height, width] = [self.rows.height, self.rows.width];
        let (size, length) = (height * width, row.columns.len() * height);
        columns.clear();
        sums.clear();
        for (k, j) in row.columns.iter().enumerate() {
            let Some(column) = self.aggregate(tentative, *j as usize) else { continue };
            let at = match columns.iter().position(|c| *c == column) {
                Some(at) => at,
                None => {
                    columns.push(column);
                    sums.resize(columns.len() * size, 0.0);
                    columns.len() - 1
                }
            };
            let block = &tentative.blocks[*j as usize * size..][..size];
            let sum = &mut sums[at * size..][..size];
            for (h, sum) in sum.chunks_exact_mut(width).enumerate() {
                let a = &row.values[h * length + k * height..][..height];
                for (a, block) in a.iter().zip(block.chunks_exact(width)) {
                    sum.iter_mut().zip(block).for_each(|(s, b)| *s += a * b);
                }
            }
        }
    }

    /// Adds a row of blocks over `columns`, which rise in it; `fill` adds to the block of a place
    /// in `columns`.
    fn push(&mut self, columns: &[u32], own: Option<u32>, fill: impl Fn(usize, &mut [f64])) {
        let BlockRows { height, width, start, columns: all, values } = &mut self.rows;
        if own.is_none() && columns.is_empty() {
            start.push(all.len());
            return;
        }
        let mut order: Vec<usize> = (0..columns.len()).collect();
        order.sort_unstable_by_key(|at| columns[*at]);
        let length = order.len() * *width;
        let from = values.len();
        values.resize(from + length * *height, 0.0);
        let mut block = vec![0.0; *height * *width];
        for (place, at) in order.into_iter().enumerate() {
            block.fill(0.0);
            fill(at, &mut block);
            for (h, row) in block.chunks_exact(*width).enumerate() {
                values[from + h * length + place * *width..][..*width].copy_from_slice(row);
            }
            all.push(columns[at]);
        }
        start.push(all.len());
    }
}
