//! The matrix of a coarser level: that of the finer one between the functions of its basis.

use std::collections::HashMap;

use super::prolongation::Prolongation;
use crate::comm::Comm;
use crate::error::Result;
use crate::simd::{self, Kernel};
use crate::sparse::{BlockRows, Halo, with_sizes};

/// A block row that grows.
#[derive(Default, Clone)]
struct Growing {
    columns: Vec<u32>,
    /// Block after block.
    values: Vec<f64>,
}

/// Where the columns of a row stand, without a search.
struct Places {
    /// Row for which an entry was written last, and the place.
    of: Vec<(u32, u32)>,
    row: u32,
}

impl Places {
    #[inline(always)]
    fn start(&mut self, columns: &[u32], most: usize) {
        self.row += 1;
        self.of.resize(most, (0, 0));
        for (place, column) in (0..).zip(columns) {
            self.of[*column as usize] = (self.row, place);
        }
    }

    /// The place of a column, behind the others where it is new.
    #[inline(always)]
    fn of(&mut self, column: u32, columns: &mut Vec<u32>) -> usize {
        let entry = &mut self.of[column as usize];
        if entry.0 != self.row {
            *entry = (self.row, columns.len() as u32);
            columns.push(column);
        }
        entry.1 as usize
    }
}

/// Rows of the basis at ghosts.
fn rows_of_ghosts(comm: &Comm, halo: &Halo, basis: &mut Prolongation) -> BlockRows<f64> {
    let [height, width] = [basis.rows.height, basis.rows.width];
    let mut rows = BlockRows { height, width, start: vec![0], ..BlockRows::default() };
    if comm.size() == 1 {
        return rows;
    }
    let pack = |nodes: &[u32]| {
        let mut packed = Vec::new();
        for node in nodes {
            let row = basis.rows.row(*node as usize);
            packed.push(row.columns.len() as f64);
            packed.extend(row.columns.iter().map(|c| basis.numbers[*c as usize] as f64));
            packed.extend_from_slice(row.values);
        }
        packed
    };
    let outgoing: Vec<Vec<f64>> = halo.shared().map(pack).collect();
    // Ghosts stand in the order of their owners.
    for list in comm.exchange(&outgoing) {
        let mut rest = list.as_slice();
        while let [count, tail @ ..] = rest {
            let count = *count as usize;
            let (columns, tail) = tail.split_at(count);
            let (values, tail) = tail.split_at(count * height * width);
            rows.columns.extend(columns.iter().map(|number| basis.place(*number as u64)));
            rows.values.extend_from_slice(values);
            rows.start.push(rows.columns.len());
            rest = tail;
        }
    }
    rows
}

/// Sums over the owned rows of the matrix, for every aggregate that they know.
struct Sums<'a> {
    matrix: &'a BlockRows<f64>,
    owned: usize,
    basis: &'a Prolongation,
    ghosts: &'a BlockRows<f64>,
    sums: &'a mut [Growing],
}

impl Kernel for Sums<'_> {
    #[inline(always)]
    fn run(self) {
        with_sizes!(self.basis.rows, sums, self)
    }
}

#[inline(always)]
fn sums<const H: usize, const W: usize>(of: Sums<'_>) {
    let Sums { matrix, owned, basis, ghosts, sums } = of;
    let most = basis.numbers.len();
    let mut places = Places { of: Vec::new(), row: 0 };
    let (mut columns, mut products): (Vec<u32>, Vec<[[f64; W]; H]>) = (Vec::new(), Vec::new());
    for i in 0..matrix.len() {
        let own = basis.rows.row(i);
        if own.columns.is_empty() {
            continue;
        }
        // Matrix times basis.
        let row = matrix.row(i);
        let length = row.columns.len() * H;
        columns.clear();
        products.clear();
        places.start(&[], most);
        for (k, j) in row.columns.iter().enumerate() {
            let a = block::<H, H>(row.values, length, k);
            let j = *j as usize;
            let of_j = if j < owned { basis.rows.row(j) } else { ghosts.row(j - owned) };
            let length_j = of_j.columns.len() * W;
            for (l, column) in of_j.columns.iter().enumerate() {
                let at = places.of(*column, &mut columns);
                if at == products.len() {
                    products.push([[0.0; W]; H]);
                }
                let p = block::<H, W>(of_j.values, length_j, l);
                let to = &mut products[at];
                for h in 0..H {
                    for g in 0..H {
                        for w in 0..W {
                            to[h][w] += a[h][g] * p[g][w];
                        }
                    }
                }
            }
        }
        // Basis transposed times that.
        let length = own.columns.len() * W;
        for (k, aggregate) in own.columns.iter().enumerate() {
            let left = block::<H, W>(own.values, length, k);
            let sum = &mut sums[*aggregate as usize];
            places.start(&sum.columns, most);
            for (column, product) in columns.iter().zip(&products) {
                let at = places.of(*column, &mut sum.columns);
                if at * W * W == sum.values.len() {
                    sum.values.resize((at + 1) * W * W, 0.0);
                }
                let (to, _) = sum.values[at * W * W..][..W * W].as_chunks_mut::<W>();
                for h in 0..H {
                    for v in 0..W {
                        for w in 0..W {
                            to[v][w] += left[h][v] * product[h][w];
                        }
                    }
                }
            }
        }
    }
}

/// The block at a place of a row whose rows have `length` numbers.
#[inline(always)]
fn block<const H: usize, const W: usize>(
    values: &[f64],
    length: usize,
    place: usize,
) -> [[f64; W]; H] {
    let mut block = [[0.0; W]; H];
    for h in 0..H {
        block[h].copy_from_slice(&values[h * length + place * W..][..W]);
    }
    block
}

/// Adds the sums for aggregates of other ranks to those of their owners. Collective.
fn to_owners(
    comm: &Comm,
    offsets: &[u64],
    basis: &mut Prolongation,
    mut sums: Vec<Growing>,
) -> Vec<Growing> {
    let square = basis.rows.width * basis.rows.width;
    let mut outgoing = vec![Vec::new(); comm.size() as usize];
    for (number, sum) in basis.numbers.iter().zip(&sums).skip(basis.owned) {
        let owner = offsets.partition_point(|first| first <= number) - 1;
        let packed: &mut Vec<f64> = &mut outgoing[owner];
        packed.extend([*number as f64, sum.columns.len() as f64]);
        packed.extend(sum.columns.iter().map(|c| basis.numbers[*c as usize] as f64));
        packed.extend_from_slice(&sum.values);
    }
    sums.truncate(basis.owned);
    if comm.size() == 1 {
        return sums;
    }
    let first = offsets[comm.rank() as usize];
    for list in comm.exchange(&outgoing) {
        let mut rest = list.as_slice();
        while let [number, count, tail @ ..] = rest {
            let count = *count as usize;
            let (columns, tail) = tail.split_at(count);
            let (values, tail) = tail.split_at(count * square);
            let sum = &mut sums[(*number as u64 - first) as usize];
            for (column, block) in columns.iter().zip(values.chunks_exact(square)) {
                let column = basis.place(*column as u64);
                let at = match sum.columns.iter().position(|c| *c == column) {
                    Some(at) => at,
                    None => {
                        sum.columns.push(column);
                        sum.values.resize(sum.columns.len() * square, 0.0);
                        sum.columns.len() - 1
                    }
                };
                let to = &mut sum.values[at * square..][..square];
                to.iter_mut().zip(block).for_each(|(t, b)| *t += b);
            }
            rest = tail;
        }
    }
    sums
}

/// The coarser matrix with its halo; the columns of the basis become local entries of it.
/// `offsets` are the first aggregates of the ranks. Collective.
///
/// # Errors
/// `Bug` when the exchange does not fit.
pub fn coarser(
    comm: &Comm,
    matrix: &BlockRows<f64>,
    halo: &Halo,
    basis: &mut Prolongation,
    offsets: &[u64],
) -> Result<(BlockRows<f64>, Halo)> {
    let ghosts = rows_of_ghosts(comm, halo, basis);
    let mut sums = vec![Growing::default(); basis.numbers.len()];
    let (owned, ghosts) = (halo.owned, &ghosts);
    simd::widest(Sums { matrix, owned, basis, ghosts, sums: &mut sums });
    let sums = to_owners(comm, offsets, basis, sums);
    let numbers = &basis.numbers;
    let far = |c: &&u32| **c as usize >= basis.owned;
    let columns = sums.iter().flat_map(|sum| &sum.columns).chain(&basis.rows.columns);
    let mut others: Vec<u64> = columns.filter(far).map(|c| numbers[*c as usize]).collect();
    others.sort_unstable();
    others.dedup();
    let coarse = Halo::new(comm, basis.owned, others)?;
    let local: Vec<u32> =
        numbers.iter().map(|number| coarse.local(*number).unwrap_or(u32::MAX)).collect();
    let matrix = gathered(basis.rows.width, &sums, &local);
    renumber(&mut basis.rows, &local);
    (basis.numbers, basis.others) = (Vec::new(), HashMap::new());
    Ok((matrix, coarse))
}

/// The rows with their columns in order.
fn gathered(width: usize, sums: &[Growing], local: &[u32]) -> BlockRows<f64> {
    let in_order = |sum: &Growing| {
        let mut order: Vec<(u32, usize)> =
            sum.columns.iter().map(|c| local[*c as usize]).zip(0..).collect();
        order.sort_unstable();
        order
    };
    let rows = sums.iter().map(|sum| in_order(sum).into_iter().map(|(c, _)| c).collect());
    let mut matrix = BlockRows::with_columns([width, width], rows);
    for (i, sum) in sums.iter().enumerate() {
        for (place, (_, at)) in in_order(sum).into_iter().enumerate() {
            matrix.add(i, place, &sum.values[at * width * width..], width);
        }
    }
    matrix
}

/// Gives the columns of each row other numbers, and puts them in order.
fn renumber(rows: &mut BlockRows<f64>, local: &[u32]) {
    let (height, width) = (rows.height, rows.width);
    for i in 0..rows.len() {
        let range = rows.start[i]..rows.start[i + 1];
        let columns: Vec<u32> =
            rows.columns[range.clone()].iter().map(|c| local[*c as usize]).collect();
        let mut order: Vec<usize> = (0..columns.len()).collect();
        order.sort_unstable_by_key(|place| columns[*place]);
        let old = rows.row(i).values.to_vec();
        let length = columns.len() * width;
        let values = rows.row_mut(i);
        for (to, from) in order.iter().enumerate() {
            for h in 0..height {
                values[h * length + to * width..][..width]
                    .copy_from_slice(&old[h * length + from * width..][..width]);
            }
        }
        for (to, from) in rows.columns[range].iter_mut().zip(order) {
            *to = columns[from];
        }
    }
}
