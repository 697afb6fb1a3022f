//! Interpolation between lattices, line by line.
//!
//! Nodes of a fine line depend on the nodes of one, two or four coarse lines, with the same weights
//! all along, and there on one node or two neighbours. So the coarse lines are added up first.

use std::collections::BTreeMap;

use crate::mesh::Interpolation;
use crate::simd::{Kernel, widest};
use crate::sparse::Real;

/// Fine nodes that follow one another.
struct Segment {
    /// Its first fine node.
    first: u32,
    /// Its first coarse line in `Lines::coarse`, and their number.
    lines: [u32; 2],
    /// How its nodes lie between those of the coarse lines.
    pattern: u32,
}

/// Along a line: of each fine node the place of a coarse one, and the part of the next one.
struct Pattern {
    places: Vec<(u32, f64)>,
    /// Coarse nodes of a line.
    coarse: usize,
}

/// How the nodes of a lattice depend on those of a coarser one.
#[derive(Default)]
pub struct Lines {
    segments: Vec<Segment>,
    /// First local coarse node and weight of each coarse line of a segment.
    coarse: Vec<(u32, f64)>,
    patterns: Vec<Pattern>,
}

/// What a node depends on: lines with their weights, and the part of the next node on each.
struct OfNode {
    lines: Vec<(u32, f64)>,
    part: f64,
}

impl OfNode {
    /// From its parents, which stand in pairs of neighbours where it lies between two.
    fn new(parents: &[(u32, f64)]) -> Self {
        let sum = |pair: &[(u32, f64)]| pair[0].1 + pair[1].1;
        if let (pairs, []) = parents.as_chunks::<2>()
            && !pairs.is_empty()
        {
            let part = pairs[0][1].1 / sum(&pairs[0]);
            let is_pair = |pair: &[(u32, f64); 2]| {
                pair[1].0 == pair[0].0 + 1 && alike(pair[1].1 / sum(pair), part)
            };
            if pairs.iter().all(is_pair) {
                let line = |pair: &[(u32, f64); 2]| (pair[0].0, sum(pair));
                return Self { lines: pairs.iter().map(line).collect(), part };
            }
        }
        Self { lines: parents.to_vec(), part: 0.0 }
    }

    /// The place of the node on the lines that begin with `first`, if it lies on those.
    fn place_on(&self, first: &[(u32, f64)]) -> Option<u32> {
        let place = self.lines.first()?.0.checked_sub(first.first()?.0)?;
        let fits = |((node, weight), (first, of_first)): (&(u32, f64), &(u32, f64))| {
            node.checked_sub(*first) == Some(place) && alike(*weight, *of_first)
        };
        let is_same = self.lines.len() == first.len();
        (is_same && self.lines.iter().zip(first).all(fits)).then_some(place)
    }
}

/// Whether weights differ by rounding.
fn alike(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-12
}

impl Lines {
    /// From the lists of an interpolation; `local` gives the local number of a coarse node. Local.
    pub fn new(interpolation: &Interpolation, local: impl Fn(u64) -> u32) -> Self {
        let Interpolation { start, names, weights, .. } = interpolation;
        let (mut lines, mut known) = (Self::default(), BTreeMap::new());
        let mut places: Vec<(u32, f64)> = Vec::new();
        for (node, range) in start.windows(2).enumerate() {
            let range = range[0] as usize..range[1] as usize;
            let parents = names[range.clone()].iter().map(|name| local(*name));
            let parents: Vec<(u32, f64)> = parents.zip(weights[range].iter().copied()).collect();
            let of = OfNode::new(&parents);
            let place = lines.segments.last().and_then(|last| of.place_on(lines.coarse_of(last)));
            // A place behind the last one, so that a segment needs no more than its coarse nodes.
            let last = places.last().map_or(0, |last| last.0);
            match place.filter(|place| !places.is_empty() && (last..=last + 1).contains(place)) {
                Some(place) => places.push((place, of.part)),
                None => {
                    lines.close(&mut places, &mut known);
                    let first = lines.coarse.len() as u32;
                    lines.coarse.extend_from_slice(&of.lines);
                    let count = of.lines.len() as u32;
                    let lines_of = [first, count];
                    let first = node as u32;
                    lines.segments.push(Segment { first, lines: lines_of, pattern: 0 });
                    places.push((0, of.part));
                }
            }
        }
        lines.close(&mut places, &mut known);
        lines
    }

    fn coarse_of(&self, segment: &Segment) -> &[(u32, f64)] {
        let [first, count] = segment.lines.map(|n| n as usize);
        &self.coarse[first..first + count]
    }

    /// Gives the last segment the pattern of its places.
    fn close(&mut self, places: &mut Vec<(u32, f64)>, known: &mut BTreeMap<Vec<[u64; 2]>, u32>) {
        let Some(segment) = self.segments.last_mut() else { return };
        let key = places.iter().map(|(place, part)| [u64::from(*place), part.to_bits()]).collect();
        let places = std::mem::take(places);
        segment.pattern = *known.entry(key).or_insert_with(|| {
            let end = |(place, part): &(u32, f64)| *place as usize + 1 + usize::from(*part != 0.0);
            let coarse = places.iter().map(end).max().unwrap_or(0);
            self.patterns.push(Pattern { places, coarse });
            self.patterns.len() as u32 - 1
        });
    }

    /// The coarse nodes that a fine node depends on, with their parts.
    pub fn parents(&self, fine_node: usize) -> impl Iterator<Item = (usize, f64)> {
        let number = self.segments.partition_point(|s| s.first as usize <= fine_node) - 1;
        let segment = &self.segments[number];
        let place = fine_node - segment.first as usize;
        let (place, part) = self.patterns[segment.pattern as usize].places[place];
        self.coarse_of(segment).iter().flat_map(move |(first, weight)| {
            let node = (first + place) as usize;
            let both = [(node, weight * (1.0 - part)), (node + 1, weight * part)];
            both.into_iter().take(if part == 0.0 { 1 } else { 2 })
        })
    }

    /// Fine values from those at all local coarse nodes, `dim` of each. Local.
    pub fn interpolate<T: Real>(&self, dim: usize, coarse: &[T], fine: &mut [T]) {
        match dim {
            2 => widest(Interpolate::<T, 2> { lines: self, coarse, fine }),
            _ => widest(Interpolate::<T, 3> { lines: self, coarse, fine }),
        }
    }

    /// The transpose, added to the values at all local coarse nodes. Local.
    pub fn add_transposed<T: Real>(&self, dim: usize, fine: &[T], coarse: &mut [T]) {
        match dim {
            2 => widest(Transposed::<T, 2> { lines: self, coarse, fine }),
            _ => widest(Transposed::<T, 3> { lines: self, coarse, fine }),
        }
    }
}

struct Interpolate<'a, T, const DIM: usize> {
    lines: &'a Lines,
    coarse: &'a [T],
    fine: &'a mut [T],
}

impl<T: Real, const DIM: usize> Kernel for Interpolate<'_, T, DIM> {
    #[inline(always)]
    fn run(self) {
        let Self { lines, coarse, fine } = self;
        let fine = fine.as_chunks_mut::<DIM>().0;
        let mut sums: Vec<T> = Vec::new();
        for segment in &lines.segments {
            let pattern = &lines.patterns[segment.pattern as usize];
            let length = DIM * pattern.coarse;
            sums.clear();
            sums.resize(length + DIM, T::ZERO);
            for (first, weight) in lines.coarse_of(segment) {
                let weight = T::from_double(*weight);
                let from = &coarse[*first as usize * DIM..][..length];
                for (sum, value) in sums.iter_mut().zip(from) {
                    *sum += weight * *value;
                }
            }
            let sums = sums.as_chunks::<DIM>().0;
            let to = &mut fine[segment.first as usize..][..pattern.places.len()];
            for (to, (place, part)) in to.iter_mut().zip(&pattern.places) {
                let (low, high) = (&sums[*place as usize], &sums[*place as usize + 1]);
                let part = T::from_double(*part);
                for c in 0..DIM {
                    to[c] = low[c] + part * (high[c] - low[c]);
                }
            }
        }
    }
}

struct Transposed<'a, T, const DIM: usize> {
    lines: &'a Lines,
    fine: &'a [T],
    coarse: &'a mut [T],
}

impl<T: Real, const DIM: usize> Kernel for Transposed<'_, T, DIM> {
    #[inline(always)]
    fn run(self) {
        let Self { lines, fine, coarse } = self;
        let fine = fine.as_chunks::<DIM>().0;
        let mut sums: Vec<T> = Vec::new();
        for segment in &lines.segments {
            let pattern = &lines.patterns[segment.pattern as usize];
            let length = DIM * pattern.coarse;
            sums.clear();
            sums.resize(length + DIM, T::ZERO);
            let of_nodes = sums.as_chunks_mut::<DIM>().0;
            let from = &fine[segment.first as usize..][..pattern.places.len()];
            for (from, (place, part)) in from.iter().zip(&pattern.places) {
                let (place, part) = (*place as usize, T::from_double(*part));
                for c in 0..DIM {
                    let of_next = part * from[c];
                    of_nodes[place][c] += from[c] - of_next;
                    of_nodes[place + 1][c] += of_next;
                }
            }
            for (first, weight) in lines.coarse_of(segment) {
                let weight = T::from_double(*weight);
                let to = &mut coarse[*first as usize * DIM..][..length];
                for (to, sum) in to.iter_mut().zip(&sums) {
                    *to += weight * *sum;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places of the fine nodes of a line between those of a coarse one: every second, one cell
    /// that stays alone, cells of other widths.
    fn line(coarse: usize, kind: usize) -> Vec<(usize, f64)> {
        let last = coarse - 1;
        let mut places = Vec::new();
        for place in 0..last {
            places.push((place, 0.0));
            if kind == 0 || kind == 1 && place != last / 2 {
                places.push((place, if kind == 0 { 0.5 } else { 0.3 }));
            }
        }
        places.push((last, 0.0));
        places
    }

    /// Lists of a lattice of fine nodes, and its coarse nodes.
    fn lists(coarse: [usize; 3], kinds: [usize; 3]) -> (Interpolation, usize) {
        let [x, y, z] = [0, 1, 2].map(|axis| line(coarse[axis], kinds[axis]));
        let mut all = Interpolation { start: vec![0], ..Interpolation::default() };
        for at in z.iter().flat_map(|z| y.iter().flat_map(|y| x.iter().map(|x| [*x, *y, *z]))) {
            for corner in 0..8 {
                let upper = |axis: usize| corner >> axis & 1;
                let part = |axis: usize| match (upper(axis), at[axis].1) {
                    (0, part) => 1.0 - part,
                    (_, part) => part,
                };
                let weight: f64 = [0, 1, 2].into_iter().map(part).product();
                if weight > 0.0 {
                    let [i, j, k] = [0, 1, 2].map(|axis| at[axis].0 + upper(axis));
                    all.names.push((i + coarse[0] * (j + coarse[1] * k)) as u64);
                    all.weights.push(weight);
                }
            }
            all.start.push(all.names.len() as u32);
        }
        (all, coarse.into_iter().product())
    }

    #[test]
    fn lines_give_the_sums_of_the_lists() {
        let scenes = [
            ([5, 4, 3], [0, 0, 0]),
            ([6, 5, 4], [1, 1, 1]),
            ([4, 5, 3], [2, 0, 1]),
            ([3, 4, 5], [0, 2, 2]),
            ([2, 1, 2], [0, 0, 0]),
        ];
        for (coarse, kinds) in scenes {
            let (all, count) = lists(coarse, kinds);
            // Some coarse nodes are ghosts, whose numbers lie behind the others.
            let local = |name: u64| {
                if name % 7 == 3 { count as u32 + name as u32 } else { name as u32 }
            };
            let lines = Lines::new(&all, local);
            let fine = all.start.len() - 1;
            let value = |i: usize| (i as f64 * 1.7).sin();
            let u: Vec<f64> = (0..6 * count).map(value).collect();
            let (mut found, mut back) = (vec![0.0; 3 * fine], vec![0.0; u.len()]);
            lines.interpolate(3, &u, &mut found);
            let r: Vec<f64> = (0..3 * fine).map(|i| value(i + 5)).collect();
            lines.add_transposed(3, &r, &mut back);
            let mut exact_back = vec![0.0; u.len()];
            for node in 0..fine {
                let range = all.start[node] as usize..all.start[node + 1] as usize;
                let parents =
                    || range.clone().map(|i| (local(all.names[i]) as usize, all.weights[i]));
                for c in 0..3 {
                    let exact: f64 = parents().map(|(parent, w)| w * u[3 * parent + c]).sum();
                    assert!((found[3 * node + c] - exact).abs() < 1e-14);
                    parents()
                        .for_each(|(parent, w)| exact_back[3 * parent + c] += w * r[3 * node + c]);
                }
                let mut of_node: Vec<(usize, f64)> = lines.parents(node).collect();
                let mut expected: Vec<(usize, f64)> = parents().collect();
                of_node.sort_by_key(|(parent, _)| *parent);
                expected.sort_by_key(|(parent, _)| *parent);
                assert_eq!(of_node.len(), expected.len());
                let same = |(a, b): (&(usize, f64), &(usize, f64))| a.0 == b.0 && alike(a.1, b.1);
                assert!(of_node.iter().zip(&expected).all(same), "{of_node:?} {expected:?}");
            }
            let close = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-13;
            assert!(back.iter().zip(&exact_back).all(close));
        }
    }
}
