//! Which facets of the two sides may overlap.

use super::PlaneFacet;

/// The pairs (index of a secondary facet, index of a primary facet) whose bounding boxes touch,
/// sorted, each once.
///
/// A uniform grid of about as many bins as primary facets: O(n log n) for facets of similar size.
/// Boxes are widened by 1e-9 of their size, so that rounding loses no pair.
pub fn candidates(secondary: &[PlaneFacet], primary: &[PlaneFacet]) -> Vec<(usize, usize)> {
    if primary.is_empty() {
        return Vec::new();
    }
    let boxes: Vec<_> = primary.iter().map(widened).collect();
    let grid = Grid::around(&boxes);
    let mut bins: Vec<(usize, usize)> = Vec::new();
    for (l, bounds) in boxes.iter().enumerate() {
        grid.for_each_bin(*bounds, |bin| bins.push((bin, l)));
    }
    bins.sort_unstable();

    let mut pairs = Vec::new();
    let mut found = Vec::new();
    for (s, facet) in secondary.iter().enumerate() {
        let bounds = widened(facet);
        found.clear();
        grid.for_each_bin(bounds, |bin| {
            let first = bins.partition_point(|&(b, _)| b < bin);
            found.extend(bins[first..].iter().take_while(|&&(b, _)| b == bin).map(|&(_, l)| l));
        });
        found.sort_unstable();
        found.dedup();
        pairs.extend(found.iter().filter(|&&l| touch(bounds, boxes[l])).map(|&l| (s, l)));
    }
    pairs
}

type Bounds = [[f64; 2]; 2];

fn widened(facet: &PlaneFacet) -> Bounds {
    let [low, high] = facet.bounds();
    let margin = 1e-9 * facet.size();
    [low.map(|x| x - margin), high.map(|x| x + margin)]
}

fn touch(a: Bounds, b: Bounds) -> bool {
    (0..2).all(|d| a[0][d] <= b[1][d] && b[0][d] <= a[1][d])
}

struct Grid {
    low: [f64; 2],
    width: [f64; 2],
    count: [usize; 2],
}

impl Grid {
    /// Bins as wide as the mean box, at most four per box.
    fn around(boxes: &[Bounds]) -> Self {
        let mut all = boxes[0];
        let mut mean = [0.0; 2];
        for bounds in boxes {
            for d in 0..2 {
                all[0][d] = all[0][d].min(bounds[0][d]);
                all[1][d] = all[1][d].max(bounds[1][d]);
                mean[d] += (bounds[1][d] - bounds[0][d]) / boxes.len() as f64;
            }
        }
        let limit = ((4 * boxes.len()) as f64).sqrt();
        let extent = [all[1][0] - all[0][0], all[1][1] - all[0][1]];
        // In a line of facets one direction may take all the bins.
        let wanted: [f64; 2] = std::array::from_fn(|d| (extent[d] / mean[d]).max(1.0));
        let shrink = (wanted[0] * wanted[1] / (limit * limit)).max(1.0).sqrt();
        let count: [usize; 2] = std::array::from_fn(|d| {
            let number = (wanted[d] / shrink).clamp(1.0, limit * limit);
            if number.is_finite() { number as usize } else { 1 }
        });
        let width = std::array::from_fn(|d| extent[d] / count[d] as f64);
        Grid { low: all[0], width, count }
    }

    fn for_each_bin(&self, bounds: Bounds, mut visit: impl FnMut(usize)) {
        let bin = |x: f64, d: usize| {
            let index = ((x - self.low[d]) / self.width[d]).floor();
            // Outside goes to the border bins; a grid without width has one bin.
            (index.max(0.0) as usize).min(self.count[d] - 1)
        };
        for j in bin(bounds[0][1], 1)..=bin(bounds[1][1], 1) {
            for i in bin(bounds[0][0], 0)..=bin(bounds[1][0], 0) {
                visit(j * self.count[0] + i);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interface::mortar::patch_tests::{grid, lines};

    fn brute(secondary: &[PlaneFacet], primary: &[PlaneFacet]) -> Vec<(usize, usize)> {
        let mut out = Vec::new();
        for (s, a) in secondary.iter().enumerate() {
            for (l, b) in primary.iter().enumerate() {
                if touch(widened(a), widened(b)) {
                    out.push((s, l));
                }
            }
        }
        out
    }

    #[test]
    fn the_grid_finds_what_comparing_all_pairs_finds() {
        for (a, b) in [([2, 3], [3, 2]), ([1, 1], [7, 5]), ([12, 1], [1, 11]), ([9, 8], [40, 3])] {
            let (secondary, primary) = (grid(a, 3, 0), grid(b, 5, 1000));
            assert_eq!(candidates(&secondary, &primary), brute(&secondary, &primary));
        }
        let (secondary, primary) = (lines(11, 1, 0), lines(30, 2, 100));
        assert_eq!(candidates(&secondary, &primary), brute(&secondary, &primary));
    }

    #[test]
    fn facets_far_apart_and_empty_sides_give_no_pair() {
        let here = [PlaneFacet::line([0, 1], [0.0, 1.0])];
        let there = [PlaneFacet::line([2, 3], [5.0, 6.0])];
        assert!(candidates(&here, &there).is_empty());
        assert!(candidates(&here, &[]).is_empty());
        assert!(candidates(&[], &there).is_empty());
    }
}
