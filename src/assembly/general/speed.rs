//! How fast the sweeps are beside the product with a matrix: `cargo test --release --lib
//! general::speed -- --ignored --nocapture`.

#![allow(clippy::print_stdout)] // the figures

use std::fs;

use super::testkit::{Grid, Shaken};
use crate::assembly::{CellSet, Cells};
use crate::bulk::Elastic;
use crate::element::Shape;

/// Processor time of this thread (s): the machine may have other work.
fn now() -> f64 {
    let text = fs::read_to_string("/proc/thread-self/schedstat").expect("times of Linux");
    1e-9 * text.split(' ').next().and_then(|ns| ns.parse().ok()).unwrap_or(f64::NAN)
}

/// The time of one of many calls (s).
fn time(mut act: impl FnMut()) -> f64 {
    const CALLS: u32 = 60;
    act();
    let start = now();
    (0..CALLS).for_each(|_| act());
    (now() - start) / f64::from(CALLS)
}

/// The assembled matrix by rows of blocks.
struct Blocks {
    dim: usize,
    start: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl Blocks {
    /// With the time of the matrices of the cells (s).
    fn new(cells: &Cells, nodes: usize, dim: usize) -> (Self, f64) {
        let mut lists = vec![Vec::new(); nodes];
        for cell in 0..cells.len() {
            for node in cells.nodes(cell) {
                lists[*node as usize].extend_from_slice(cells.nodes(cell));
            }
        }
        let (mut start, mut columns) = (vec![0], Vec::new());
        for mut list in lists {
            list.sort_unstable();
            list.dedup();
            columns.extend(list);
            start.push(columns.len());
        }
        let values = vec![1.0; columns.len() * dim * dim];
        let mut buffer = Vec::new();
        let mut sum = 0.0;
        let begin = now();
        for cell in 0..cells.len() {
            sum += cells.matrix(cell, &mut buffer)[0];
        }
        let seconds = now() - begin;
        assert!(sum > 0.0);
        (Self { dim, start, columns, values }, seconds)
    }

    fn multiply<const DIM: usize>(&self, x: &[f64], y: &mut [f64]) {
        let (x, y) = (x.as_chunks::<DIM>().0, y.as_chunks_mut::<DIM>().0);
        let blocks = self.values.as_chunks::<DIM>().0;
        for (row, y) in y.iter_mut().enumerate() {
            let mut sum = [0.0; DIM];
            for entry in self.start[row]..self.start[row + 1] {
                let x = &x[self.columns[entry] as usize];
                for (j, column) in blocks[entry * DIM..][..DIM].iter().enumerate() {
                    (0..DIM).for_each(|i| sum[i] += column[i] * x[j]);
                }
            }
            *y = sum;
        }
    }
}

#[test]
#[ignore = "prints times"]
fn figures() {
    for (shape, n, middles) in [
        (Shape::Hex8, 39, 0.0),
        (Shape::Tet10, 20, 0.0),
        (Shape::Tet10, 20, 0.02),
        (Shape::Tet4, 32, 0.0),
        (Shape::Prism6, 30, 0.0),
        (Shape::Pyramid5, 20, 0.0),
        (Shape::Hex27, 14, 0.0),
        (Shape::Prism18, 14, 0.0),
        (Shape::Quad4, 200, 0.0),
        (Shape::Quad9, 100, 0.0),
        (Shape::Tri6, 150, 0.0),
    ] {
        if std::env::var("ONLY").is_ok_and(|only| format!("{shape:?}") != only) {
            continue;
        }
        let grid = Grid::new(shape, n, Shaken { corners: 0.1, middles });
        let nodes = grid.points.len();
        for b_bar in [false, true] {
            let cells = grid.with(Elastic::new(5.8e9, 0.3), b_bar);
            let dim = shape.dim();
            let (blocks, seconds) = Blocks::new(&cells, nodes, dim);
            let u: Vec<f64> = (0..nodes * dim).map(|i| (i as f64).sin()).collect();
            let mut force = vec![0.0; u.len()];
            let sweep = time(|| cells.add_forces(CellSet::All, &u, &mut force, None));
            let product = time(|| match blocks.dim {
                2 => blocks.multiply::<2>(&u, &mut force),
                _ => blocks.multiply::<3>(&u, &mut force),
            });
            println!(
                "{shape:?} B-bar {b_bar} bent {}: {} cells, {} unknowns: {:.2} M cells/s, sweep \
                 {:.2} ms, matrix {:.2} ms ({:.0} MB), {:.2} us per matrix of a cell",
                middles > 0.0,
                cells.len(),
                u.len(),
                1e-6 * cells.len() as f64 / sweep,
                1e3 * sweep,
                1e3 * product,
                8e-6 * blocks.values.len() as f64,
                1e6 * seconds / cells.len() as f64,
            );
        }
    }
}
