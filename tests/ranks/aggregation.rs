//! Matrices of blocks and smoothed aggregation on any number of ranks.

use column_hpc::aggregation::{Aggregation, Motions};
use column_hpc::comm::Comm;
use column_hpc::petsc::{LinearOperator, Preconditioner};
use column_hpc::runtime::Runtime;
use column_hpc::sparse::BlockMatrix;

/// Nodes along each axis of a beam of bars, the last one its length.
const NODES: [usize; 3] = [6, 6, 61];

/// A lattice of bars between neighbours, along edges and diagonals, shared out over the ranks by
/// layers; the first layer is held.
struct Bars {
    first: usize,
    owned: usize,
}

impl Bars {
    fn new(comm: &Comm) -> Self {
        let (rank, size) = (comm.rank() as usize, comm.size() as usize);
        let layer = NODES[0] * NODES[1];
        let from = |rank: usize| NODES[2] * rank / size * layer;
        Self { first: from(rank), owned: from(rank + 1) - from(rank) }
    }

    fn place(node: usize) -> [usize; 3] {
        [node % NODES[0], node / NODES[0] % NODES[1], node / (NODES[0] * NODES[1])]
    }

    /// Numbers of a node and all around it, rising.
    fn around(node: usize) -> Vec<i32> {
        let at = Self::place(node);
        let range = |c: usize| at[c].saturating_sub(1)..=(at[c] + 1).min(NODES[c] - 1);
        let mut around = Vec::new();
        for z in range(2) {
            for y in range(1) {
                around.extend(range(0).map(|x| (x + NODES[0] * (y + NODES[1] * z)) as i32));
            }
        }
        around
    }

    /// Bars along `d` resist its change of length; those at held nodes have rows of the identity.
    fn matrix(&self, comm: &Comm) -> BlockMatrix {
        let rows: Vec<Vec<i32>> = (self.first..self.first + self.owned).map(Self::around).collect();
        let mut matrix =
            BlockMatrix::new(comm, 3, self.owned, |i| rows[i].as_slice()).expect("a matrix");
        let held = |node: usize| Self::place(node)[2] == 0;
        for (i, around) in rows.iter().enumerate() {
            let node = self.first + i;
            let number = node as i32;
            if held(node) {
                let identity = [3.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 3.0];
                matrix.add_blocked(&[number], &[number], &identity).expect("a block");
            }
            // Each bar once, with the rows of both ends: those of ghosts go to their owners.
            for other in around.iter().filter(|other| **other > number) {
                let ends = [node, *other as usize];
                let [a, b] = ends.map(Self::place);
                let d: [f64; 3] = std::array::from_fn(|c| b[c] as f64 - a[c] as f64);
                let square: f64 = d.iter().map(|d| d * d).sum();
                for (k, sign) in [(0, 1.0), (1, 1.0), (0, -1.0), (1, -1.0)] {
                    let column = if sign > 0.0 { k } else { 1 - k };
                    if held(ends[k]) || held(ends[column]) {
                        continue;
                    }
                    let block: Vec<f64> =
                        (0..9).map(|e| sign * d[e / 3] * d[e % 3] / square.powi(2)).collect();
                    let [row, column] = [ends[k] as i32, ends[column] as i32];
                    matrix.add_blocked(&[row], &[column], &block).expect("a block");
                }
            }
        }
        comm.agree(matrix.assemble(comm)).expect("an exchange");
        matrix
    }

    fn motions(&self) -> Motions {
        let mut values = Vec::new();
        for node in self.first..self.first + self.owned {
            let [x, y, z] = Self::place(node).map(|c| c as f64 / 60.0);
            let free = if z == 0.0 { 0.0 } else { 1.0 };
            let rows = [
                [1.0, 0.0, 0.0, -y, 0.0, z],
                [0.0, 1.0, 0.0, x, -z, 0.0],
                [0.0, 0.0, 1.0, 0.0, y, -x],
            ];
            values.extend(rows.as_flattened().iter().map(|v| free * v));
        }
        Motions { height: 3, count: 6, values }
    }
}

fn dot(comm: &Comm, a: &[f64], b: &[f64]) -> f64 {
    let mut sum = [a.iter().zip(b).map(|(a, b)| a * b).sum()];
    comm.sum(&mut sum);
    sum[0]
}

/// Iterations of conjugate gradients until the residual has fallen by 1e10.
fn iterations(comm: &Comm, matrix: &BlockMatrix, cycle: &Aggregation, b: &[f64]) -> usize {
    let n = b.len();
    let (mut x, mut r, mut z, mut product) = (vec![0.0; n], b.to_vec(), vec![0.0; n], vec![0.0; n]);
    cycle.apply(&r, &mut z).expect("a correction");
    let (mut p, mut energy) = (z.clone(), dot(comm, &r, &z));
    let start = dot(comm, &r, &r);
    for iteration in 1..=200 {
        matrix.multiply(&p, &mut product);
        let step = energy / dot(comm, &p, &product);
        assert!(step > 0.0, "an indefinite cycle at iteration {iteration}");
        x.iter_mut().zip(&p).for_each(|(x, p)| *x += step * p);
        r.iter_mut().zip(&product).for_each(|(r, a)| *r -= step * a);
        if dot(comm, &r, &r) < 1e-20 * start {
            matrix.multiply(&x, &mut product);
            let left: Vec<f64> = product.iter().zip(b).map(|(a, b)| b - a).collect();
            assert!(dot(comm, &left, &left) < 1e-18 * start, "the true residual");
            return iteration;
        }
        cycle.apply(&r, &mut z).expect("a correction");
        let next = dot(comm, &r, &z);
        p.iter_mut().zip(&z).for_each(|(p, z)| *p = z + next / energy * *p);
        energy = next;
    }
    panic!("200 iterations");
}

/// The product does not feel the rigid motions of free nodes; the cycle is symmetric and needs the
/// same iterations for a slender beam on any number of ranks.
pub fn of_a_slender_beam(runtime: &Runtime) {
    let comm = &runtime.comm;
    let bars = Bars::new(comm);
    let matrix = bars.matrix(comm);
    let motions = bars.motions();
    let mut product = vec![0.0; bars.owned * 3];
    for k in 0..6 {
        let motion: Vec<f64> = motions.values.chunks_exact(6).map(|row| row[k]).collect();
        matrix.multiply(&motion, &mut product);
        for (i, product) in product.chunks_exact(3).enumerate() {
            let away = Bars::place(bars.first + i)[2] > 1;
            assert!(!away || product.iter().all(|f| f.abs() < 1e-12), "motion {k} at {i}");
        }
    }
    let cycle = Aggregation::new(comm, &matrix, motions).expect("levels");
    let wave = |shift: f64| -> Vec<f64> {
        let number = |i: usize| (bars.first * 3 + i) as f64;
        (0..bars.owned * 3).map(|i| (0.7 * number(i) + shift).sin()).collect()
    };
    let (a, b) = (wave(0.0), wave(1.0));
    let [mut of_a, mut of_b] = [vec![0.0; a.len()], vec![0.0; b.len()]];
    cycle.apply(&a, &mut of_a).expect("a correction");
    cycle.apply(&b, &mut of_b).expect("a correction");
    let sizes = (dot(comm, &a, &of_a) * dot(comm, &b, &of_b)).sqrt();
    let skew = dot(comm, &a, &of_b) - dot(comm, &b, &of_a);
    assert!(skew.abs() < 1e-5 * sizes, "skew {skew} of {sizes}");
    // A force across the free end, which bends the beam.
    let end = |i: usize| Bars::place(bars.first + i / 3)[2] == NODES[2] - 1 && i.is_multiple_of(3);
    let force: Vec<f64> = (0..a.len()).map(|i| f64::from(u8::from(end(i)))).collect();
    let count = iterations(comm, &matrix, &cycle, &force);
    assert!((8..=26).contains(&count), "{count} iterations on {} ranks", comm.size());
}

/// Nodes that nothing holds but their own stiffness, and ranks without any.
pub fn without_couplings(runtime: &Runtime) {
    let comm = &runtime.comm;
    let owned = if comm.rank() == 0 { 80 } else { 0 };
    let rows: Vec<[i32; 1]> = (0..owned).map(|i| [i]).collect();
    let mut matrix =
        BlockMatrix::new(comm, 2, owned as usize, |i| rows[i].as_slice()).expect("a matrix");
    for [i] in &rows {
        matrix.add_blocked(&[*i], &[*i], &[2.0, 1.0, 1.0, 3.0]).expect("a block");
    }
    comm.agree(matrix.assemble(comm)).expect("an exchange");
    let values = vec![1.0; owned as usize * 6];
    let motions = Motions { height: 2, count: 3, values };
    let cycle = Aggregation::new(comm, &matrix, motions).expect("levels");
    let b: Vec<f64> = (0..2 * owned).map(|i| f64::from(i) - 7.0).collect();
    let (mut x, mut product) = (vec![0.0; b.len()], vec![0.0; b.len()]);
    cycle.apply(&b, &mut x).expect("a correction");
    matrix.multiply(&x, &mut product);
    for (product, b) in product.iter().zip(&b) {
        assert!((product - b).abs() < 1e-3, "{product} for {b}");
    }
}
