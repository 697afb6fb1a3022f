//! The stiffness of a box of second order, split by symmetry.
//!
//! Along each axis the three nodal values become the sum of the outer two, the middle one and the
//! difference of the outer two. Reflections of the box leave an isotropic stiffness unchanged, so
//! functions that are even or odd along the axes act only on those of matching parity: the matrix
//! falls into 8 blocks of at most 12 rows (2D: 4 of at most 5), an eighth of its entries.

use crate::element::Shape;

/// Rows of the largest block.
pub const MOST_ROWS: usize = 12;

/// What differs by less than this part of the largest entry is taken for zero.
const ZERO: f64 = 1e-12;

/// A block of the split stiffness: dense, between the modes it lists.
#[derive(Debug, Clone, PartialEq)]
pub struct Block<T = f64> {
    /// Component and mode of each row and column.
    pub modes: Vec<(usize, usize)>,
    /// Entries (N/m), row by row.
    pub matrix: Vec<T>,
}

/// K by parity. A mode is a number in base 3 whose digit of an axis says: 0 sum of the outer
/// values, 1 middle value, 2 difference of the outer ones; the first axis is the lowest digit.
#[derive(Debug, Clone, PartialEq)]
pub struct Parity<T = f64> {
    /// The blocks.
    pub blocks: Vec<Block<T>>,
}

impl Parity {
    /// From the dense matrix (rows over nodes, then components) of a box; none if it does not
    /// split: not a box, or not an isotropic material.
    pub fn new(matrix: &[f64], shape: Shape) -> Option<Self> {
        let (dim, n) = (shape.dim(), shape.nodes());
        let split = split(matrix, shape);
        let largest = split.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let class = |(c, m): (usize, usize)| parity(m, dim) ^ (1 << c);
        let all: Vec<(usize, usize)> = (0..dim).flat_map(|c| (0..n).map(move |m| (c, m))).collect();
        let entry = |(c, m): (usize, usize), (d, k): (usize, usize)| {
            split[(c * n + m) * n * dim + d * n + k]
        };
        for (row, column) in all.iter().flat_map(|r| all.iter().map(move |c| (*r, *c))) {
            if class(row) != class(column) && entry(row, column).abs() > ZERO * largest {
                return None;
            }
        }
        let block = |of: usize| {
            let modes: Vec<_> = all.iter().copied().filter(|mode| class(*mode) == of).collect();
            let rows = modes.iter().flat_map(|r| modes.iter().map(move |c| entry(*r, *c)));
            Block { matrix: rows.collect(), modes }
        };
        Some(Self { blocks: (0..1 << dim).map(block).collect() })
    }

    /// The same in single precision.
    pub fn to_single(&self) -> Parity<f32> {
        let single = |block: &Block| Block {
            modes: block.modes.clone(),
            matrix: block.matrix.iter().map(|k| *k as f32).collect(),
        };
        Parity { blocks: self.blocks.iter().map(single).collect() }
    }
}

/// The place of each node of a shape of second order when they are counted along the axes.
pub fn lattice_places(shape: Shape) -> Vec<usize> {
    let place = |x: &[f64; 3]| {
        (0..shape.dim()).map(|d| (x[d] + 1.0) as usize * 3_usize.pow(d as u32)).sum()
    };
    shape.node_points().iter().map(place).collect()
}

/// Bit i: whether the mode is odd along axis i.
fn parity(mode: usize, dim: usize) -> usize {
    (0..dim).map(|i| usize::from(digit(mode, i) == 2) << i).sum()
}

fn digit(number: usize, axis: usize) -> usize {
    number / 3_usize.pow(axis as u32) % 3
}

/// The matrix between modes, rows by component, then mode: E^T K E, where the columns of E are the
/// nodal values of a mode.
fn split(matrix: &[f64], shape: Shape) -> Vec<f64> {
    // Nodal value (lower, middle, upper) of sum, middle, difference.
    const E: [[f64; 3]; 3] = [[0.5, 0.0, -0.5], [0.0, 1.0, 0.0], [0.5, 0.0, 0.5]];
    let (dim, n) = (shape.dim(), shape.nodes());
    let places = lattice_places(shape);
    let value = |node: usize, mode: usize| -> f64 {
        (0..dim).map(|i| E[digit(places[node], i)][digit(mode, i)]).product()
    };
    let size = n * dim;
    let mut half = vec![0.0; size * size];
    for (row, (a, c)) in (0..n).flat_map(|a| (0..dim).map(move |c| (a, c))).enumerate() {
        for (d, k) in (0..dim).flat_map(|d| (0..n).map(move |k| (d, k))) {
            let sum: f64 = (0..n).map(|b| matrix[row * size + b * dim + d] * value(b, k)).sum();
            half[(c * n + a) * size + d * n + k] = sum;
        }
    }
    let mut split = vec![0.0; size * size];
    for (c, m) in (0..dim).flat_map(|c| (0..n).map(move |m| (c, m))) {
        for a in (0..n).filter(|a| value(*a, m) != 0.0) {
            let row = &half[(c * n + a) * size..][..size];
            let target = &mut split[(c * n + m) * size..][..size];
            target.iter_mut().zip(row).for_each(|(t, r)| *t += value(a, m) * r);
        }
    }
    split
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bulk::{Elastic, SplitForm, Stiffness};
    use crate::mesh::axes;

    #[test]
    fn the_blocks_give_the_energy_of_the_matrix() {
        for (dim, b_bar) in [(2, false), (3, false), (2, true), (3, true)] {
            let size = [0.5, if dim == 2 { 1.0 } else { 0.3 }, 0.2];
            let shape = Shape::of(dim, 2);
            let elastic = Elastic::new(5.8e9, 0.3);
            let stiffness = Stiffness::new(shape, size, elastic, axes(dim), b_bar);
            let SplitForm::Second(form) = &stiffness.form else { panic!("of first order") };
            let n = shape.nodes();
            assert_eq!(form.blocks.iter().map(|b| b.modes.len()).sum::<usize>(), n * dim);
            assert!(form.blocks.iter().all(|b| b.modes.len() <= MOST_ROWS));
            let u: Vec<f64> = (0..n * dim).map(|i| ((i * 7 + 3) % 11) as f64 - 5.0).collect();
            let mut force = vec![0.0; n * dim];
            stiffness.force(&u, &mut force);
            let exact: f64 = force.iter().zip(&u).map(|(f, u)| f * u).sum();
            // Modal values: sums, middles, differences along every axis.
            let places = lattice_places(shape);
            const T: [[f64; 3]; 3] = [[1.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 1.0]];
            let modal = |(c, m): (usize, usize)| -> f64 {
                let weight = |a: usize| -> f64 {
                    (0..dim).map(|i| T[digit(m, i)][digit(places[a], i)]).product()
                };
                (0..n).map(|a| weight(a) * u[a * dim + c]).sum()
            };
            let mut energy = 0.0;
            for Block { modes, matrix } in &form.blocks {
                let v: Vec<f64> = modes.iter().map(|mode| modal(*mode)).collect();
                for (row, left) in matrix.chunks_exact(v.len()).zip(&v) {
                    energy += left * row.iter().zip(&v).map(|(k, right)| k * right).sum::<f64>();
                }
            }
            assert!((energy / exact - 1.0).abs() < 1e-13, "{dim}: {energy} {exact}");
        }
    }

    #[test]
    fn other_matrices_do_not_split() {
        let mut matrix = vec![0.0; 18 * 18];
        matrix[1] = 1.0;
        assert!(Parity::new(&matrix, Shape::Quad9).is_none());
    }
}
