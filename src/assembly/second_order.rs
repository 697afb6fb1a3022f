//! Forces of several like boxes of second order at once: the sweep over the cells without a matrix.
//!
//! Every array holds a number of each cell of a batch side by side, as wide as the processor's
//! vectors. The stiffness acts by its blocks between modes of like parity.

#![allow(clippy::needless_range_loop)] // index notation over several arrays at once

use crate::bulk::{Block, MOST_ROWS, Parity, lattice_places};
use crate::element::Shape;
use crate::simd::{Kernel, widest};
use crate::sparse::Real;

/// Cells of a batch.
const LANES: usize = 8;
/// Nodes of the largest cell.
const NODES: usize = 27;

/// A number of each cell of a batch.
type Lanes<T> = [T; LANES];

/// Like cells side by side; behind the last cell the first one stands again.
struct Batch {
    prototype: u32,
    cells: u16,
}

/// A set of cells in batches.
#[derive(Default)]
pub struct SecondOrderSweep {
    dim: usize,
    batches: Vec<Batch>,
    /// Local nodes, by batch, place in the cell's lattice and cell.
    nodes: Vec<u32>,
}

impl SecondOrderSweep {
    /// Puts cells into batches: each has `3^dim` local nodes and the index of its prototype.
    pub fn new<'a>(dim: usize, cells: impl Iterator<Item = (&'a [u32], u32)>) -> Self {
        let mut sweep = Self { dim, batches: Vec::new(), nodes: Vec::new() };
        let places = lattice_places(Shape::of(dim, 2));
        let mut batch: Vec<&[u32]> = Vec::with_capacity(LANES);
        let mut current = 0;
        for (nodes, prototype) in cells {
            if batch.len() == LANES || prototype != current {
                sweep.close(current, &places, &mut batch);
            }
            current = prototype;
            batch.push(nodes);
        }
        sweep.close(current, &places, &mut batch);
        sweep
    }

    fn close(&mut self, prototype: u32, places: &[usize], batch: &mut Vec<&[u32]>) {
        let Some(first) = batch.first() else { return };
        let start = self.nodes.len();
        self.nodes.resize(start + places.len() * LANES, 0);
        for lane in 0..LANES {
            let nodes = batch.get(lane).unwrap_or(first);
            for (node, place) in nodes.iter().zip(places) {
                self.nodes[start + place * LANES + lane] = *node;
            }
        }
        self.batches.push(Batch { prototype, cells: batch.len() as u16 });
        batch.clear();
    }

    /// Adds the forces K u of the cells to `force` (N), both `dim` numbers per local node, the
    /// forces in two parts: those of the first nodes, then those of the others. `stiffness` gives
    /// the split form of a prototype. `magnitude` gets the sum of the lengths of the cells' nodal
    /// forces, one per local node. Local.
    pub fn add_forces<'a, T: Real + 'a>(
        &self,
        stiffness: impl Fn(u32) -> &'a Parity<T>,
        u: &[T],
        force: [&mut [T]; 2],
        magnitude: Option<&mut [f64]>,
    ) {
        let pass = Pass { sweep: self, stiffness, u, force, magnitude };
        if self.dim == 2 {
            widest(Dim::<_, _, 2, 9>(pass));
        } else {
            widest(Dim::<_, _, 3, 27>(pass));
        }
    }
}

/// One pass over the cells of a sweep.
struct Pass<'s, T, F> {
    sweep: &'s SecondOrderSweep,
    stiffness: F,
    u: &'s [T],
    force: [&'s mut [T]; 2],
    magnitude: Option<&'s mut [f64]>,
}

/// A pass in `DIM` dimensions with `N` nodes per cell.
struct Dim<'s, T, F, const DIM: usize, const N: usize>(Pass<'s, T, F>);

impl<'a, T: Real + 'a, F: Fn(u32) -> &'a Parity<T>, const DIM: usize, const N: usize> Kernel
    for Dim<'_, T, F, DIM, N>
{
    #[inline(always)]
    fn run(self) {
        let Pass { sweep, stiffness, u, force, mut magnitude } = self.0;
        let u = u.as_chunks::<DIM>().0;
        let [first, others] = force.map(|part| part.as_chunks_mut::<DIM>().0);
        let mut value = [[[T::ZERO; LANES]; NODES]; DIM];
        let mut result = [[[T::ZERO; LANES]; NODES]; DIM];
        for (batch, nodes) in sweep.batches.iter().zip(sweep.nodes.chunks_exact(N * LANES)) {
            for (a, nodes) in nodes.chunks_exact(LANES).enumerate() {
                for lane in 0..LANES {
                    let of_node = &u[nodes[lane] as usize];
                    for c in 0..DIM {
                        value[c][a][lane] = of_node[c];
                    }
                }
            }
            for value in &mut value {
                to_modes::<T, N>(value);
            }
            for block in &stiffness(batch.prototype).blocks {
                match block.modes.len() {
                    4 => apply::<T, 4, DIM>(block, &value, &mut result),
                    5 => apply::<T, 5, DIM>(block, &value, &mut result),
                    6 => apply::<T, 6, DIM>(block, &value, &mut result),
                    9 => apply::<T, 9, DIM>(block, &value, &mut result),
                    _ => apply::<T, MOST_ROWS, DIM>(block, &value, &mut result),
                }
            }
            for result in &mut result {
                to_nodes::<T, N>(result);
            }
            let cells = batch.cells as usize;
            for (a, nodes) in nodes.chunks_exact(LANES).enumerate() {
                for lane in 0..cells {
                    let node = nodes[lane] as usize;
                    let target = if node < first.len() {
                        &mut first[node]
                    } else {
                        &mut others[node - first.len()]
                    };
                    for c in 0..DIM {
                        target[c] += result[c][a][lane];
                    }
                }
                if let Some(magnitude) = &mut magnitude {
                    for lane in 0..cells {
                        let square: f64 =
                            (0..DIM).map(|c| result[c][a][lane].to_double().powi(2)).sum();
                        magnitude[nodes[lane] as usize] += square.sqrt();
                    }
                }
            }
        }
    }
}

/// Along every axis: the outer values become their sum and their difference.
#[inline(always)]
fn to_modes<T: Real, const N: usize>(value: &mut [Lanes<T>; NODES]) {
    for_lines::<N>(|lower, upper| {
        let (low, high) = (value[lower], value[upper]);
        for lane in 0..LANES {
            value[lower][lane] = low[lane] + high[lane];
            value[upper][lane] = high[lane] - low[lane];
        }
    });
}

/// The transpose of [`to_modes`].
#[inline(always)]
fn to_nodes<T: Real, const N: usize>(value: &mut [Lanes<T>; NODES]) {
    for_lines::<N>(|lower, upper| {
        let (sum, step) = (value[lower], value[upper]);
        for lane in 0..LANES {
            value[lower][lane] = sum[lane] - step[lane];
            value[upper][lane] = sum[lane] + step[lane];
        }
    });
}

/// The lower and upper node of every line of three nodes, axis by axis.
#[inline(always)]
fn for_lines<const N: usize>(mut act: impl FnMut(usize, usize)) {
    let mut stride = 1;
    while stride < N {
        for a in 0..N {
            if a / stride % 3 == 0 {
                act(a, a + 2 * stride);
            }
        }
        stride *= 3;
    }
}

/// One block: its part of `result` is the matrix times its part of `value`.
#[inline(always)]
fn apply<T: Real, const ROWS: usize, const DIM: usize>(
    block: &Block<T>,
    value: &[[Lanes<T>; NODES]; DIM],
    result: &mut [[Lanes<T>; NODES]; DIM],
) {
    let modes: &[(usize, usize); ROWS] = block.modes[..].try_into().expect("rows of the block");
    let rows = block.matrix.as_chunks::<ROWS>().0;
    let mut own = [[T::ZERO; LANES]; ROWS];
    for (own, (c, m)) in own.iter_mut().zip(modes) {
        *own = value[*c][*m];
    }
    for (row, (c, m)) in rows.iter().zip(modes) {
        let mut sum = [T::ZERO; LANES];
        for j in 0..ROWS {
            for lane in 0..LANES {
                sum[lane] += row[j] * own[j][lane];
            }
        }
        result[*c][*m] = sum;
    }
}
