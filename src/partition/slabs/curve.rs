//! Cells along a curve that fills space, and its pieces of equal length.

use super::cells::Cells;
use super::homes::Homes;
use crate::comm::Comm;

/// Bits of a coordinate on the curve.
const BITS: u32 = 21;

/// The places of nodes on the way along the curve.
pub struct Curve {
    /// Of each node of this rank, its coordinates as whole numbers side by side.
    packed: Vec<[u64; 1]>,
}

impl Curve {
    /// Collective.
    ///
    /// # Arguments
    /// * `points` that this rank keeps (m), and the least and the largest coordinates of all
    pub fn new(
        comm: &Comm,
        homes: &Homes,
        cells: &Cells,
        points: &[[f64; 3]],
        [low, high]: [[f64; 3]; 2],
    ) -> Self {
        let size = (0..3).map(|i| high[i] - low[i]).fold(f64::MIN_POSITIVE, f64::max);
        let most = ((1_u64 << BITS) - 1) as f64;
        let packed = |place: usize| {
            let at = |i: usize| ((points[place][i] - low[i]) / size * most) as u64;
            [at(0) | at(1) << BITS | at(2) << (2 * BITS)]
        };
        Self { packed: homes.fetch(comm, cells.names.iter(), packed) }
    }

    /// The place of the middle of a cell with these nodes.
    pub fn key(&self, cells: &Cells, nodes: &[u32]) -> u64 {
        let mask = (1_u64 << BITS) - 1;
        let mut sums = [0; 3];
        for node in nodes {
            let [place] = self.packed[cells.names.place(*node).unwrap_or_default()];
            (0..3).for_each(|i| sums[i] += place >> (i as u32 * BITS) & mask);
        }
        let spread = sums.map(|sum| spread(sum / nodes.len() as u64));
        spread[0] | spread[1] << 1 | spread[2] << 2
    }
}

/// A coordinate with two zeros between its bits.
fn spread(x: u64) -> u64 {
    (0..BITS).fold(0, |all, bit| all | (x >> bit & 1) << (3 * bit))
}

/// The beginnings, after the first one, of pieces of the curve with about as many cells each, from
/// the places of the cells of each rank. They do not depend on how the cells are shared out.
/// Collective.
pub fn cuts(comm: &Comm, mut sorted: Vec<u64>, pieces: u64) -> Vec<u64> {
    sorted.sort_unstable();
    let total = comm.sum_u64(sorted.len() as u64);
    let wanted: Vec<f64> = (1..pieces)
        .map(|i| (u128::from(i) * u128::from(total) / u128::from(pieces)) as f64)
        .collect();
    // The least key with so many below it.
    let (mut low, mut high) = (vec![0_u64; wanted.len()], vec![1_u64 << (3 * BITS); wanted.len()]);
    for _ in 0..=3 * BITS {
        let middle: Vec<u64> =
            low.iter().zip(&high).map(|(low, high)| low + (high - low) / 2).collect();
        let below = |key: &u64| sorted.partition_point(|other| other < key) as f64;
        let mut counts: Vec<f64> = middle.iter().map(below).collect();
        comm.sum(&mut counts);
        for (i, middle) in middle.into_iter().enumerate() {
            if counts[i] >= wanted[i] {
                high[i] = middle
            } else {
                low[i] = (middle + 1).min(high[i])
            }
        }
    }
    high.dedup();
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_spread() {
        assert_eq!(spread(0b101), 0b1000001);
        assert_eq!(spread((1 << BITS) - 1).count_ones(), BITS);
    }
}
