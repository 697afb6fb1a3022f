//! Boxes that meet a given one, found without looking at all.

/// A box with its walls along the axes (m).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    pub low: [f64; 3],
    pub high: [f64; 3],
}

/// Boxes in a binary tree.
pub struct BoxTree {
    boxes: Vec<Extent>,
    /// Numbers of the boxes, so that those of each node of the tree stand together.
    order: Vec<u32>,
    nodes: Vec<Node>,
}

/// A node of the tree: the boxes from one place to another, all inside its extent.
struct Node {
    extent: Extent,
    from: usize,
    to: usize,
    /// The nodes of both halves, unless there are only few boxes.
    halves: Option<[usize; 2]>,
}

/// Boxes of a node that is not halved.
const FEW: usize = 4;

impl Extent {
    /// That of some points.
    pub fn of(points: impl Iterator<Item = [f64; 3]>) -> Self {
        let none = Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };
        points.fold(none, |sum, point| sum.with(&Self { low: point, high: point }))
    }

    /// The same with all walls moved outwards.
    pub fn grown(self, by: f64) -> Self {
        Self { low: self.low.map(|x| x - by), high: self.high.map(|x| x + by) }
    }

    /// The same so far (m) in the direction of a unit vector.
    pub fn moved(self, by: f64, along: [f64; 3]) -> Self {
        let moved = |x: [f64; 3]| std::array::from_fn(|i| x[i] + by * along[i]);
        Self { low: moved(self.low), high: moved(self.high) }
    }

    /// That of some extents.
    pub fn around(parts: &[Self]) -> Self {
        Self::of(parts.iter().flat_map(|part| [part.low, part.high]))
    }

    /// Length of the diagonal.
    pub fn diagonal(&self) -> f64 {
        (0..3).map(|i| (self.high[i] - self.low[i]).powi(2)).sum::<f64>().sqrt()
    }

    fn with(self, other: &Self) -> Self {
        Self {
            low: [0, 1, 2].map(|i| self.low[i].min(other.low[i])),
            high: [0, 1, 2].map(|i| self.high[i].max(other.high[i])),
        }
    }

    fn meets(&self, other: &Self) -> bool {
        (0..3).all(|i| self.low[i] <= other.high[i] && other.low[i] <= self.high[i])
    }

    /// Twice the middle along an axis.
    fn middle(&self, axis: usize) -> f64 {
        self.low[axis] + self.high[axis]
    }
}

impl BoxTree {
    pub fn new(boxes: Vec<Extent>) -> Self {
        let order = (0..boxes.len() as u32).collect();
        let mut tree = Self { boxes, order, nodes: Vec::new() };
        let all = tree.boxes.len();
        if all > 0 {
            tree.grow(0, all);
        }
        tree
    }

    /// Adds the node of the boxes from one place to another, and all below it.
    fn grow(&mut self, from: usize, to: usize) -> usize {
        let none = Extent::of(std::iter::empty());
        let boxes = self.order[from..to].iter().map(|number| &self.boxes[*number as usize]);
        let extent = boxes.fold(none, Extent::with);
        let number = self.nodes.len();
        self.nodes.push(Node { extent, from, to, halves: None });
        if to - from <= FEW {
            return number;
        }
        let size = |axis: &usize| extent.high[*axis] - extent.low[*axis];
        let axis = (0..3).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(0);
        let (boxes, half) = (&self.boxes, (to - from) / 2);
        self.order[from..to].select_nth_unstable_by(half, |a, b| {
            let middle = |number: &u32| boxes[*number as usize].middle(axis);
            middle(a).total_cmp(&middle(b)).then(a.cmp(b))
        });
        let halves = [self.grow(from, from + half), self.grow(from + half, to)];
        self.nodes[number].halves = Some(halves);
        number
    }

    /// The numbers of the boxes that meet this one, rising.
    pub fn meeting(&self, extent: &Extent) -> Vec<u32> {
        let mut found = Vec::new();
        let mut open: Vec<usize> = (0..self.nodes.len().min(1)).collect();
        while let Some(number) = open.pop() {
            let node = &self.nodes[number];
            if !node.extent.meets(extent) {
                continue;
            }
            match node.halves {
                Some(halves) => open.extend(halves),
                None => {
                    let numbers = self.order[node.from..node.to].iter().copied();
                    found.extend(numbers.filter(|n| self.boxes[*n as usize].meets(extent)));
                }
            }
        }
        found.sort_unstable();
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_tree_finds_what_a_look_at_all_finds(
            lows in prop::collection::vec(prop::array::uniform3(0.0..10.0_f64), 0..60),
            size in 0.0..3.0_f64,
            asked in prop::array::uniform3(0.0..10.0_f64),
        ) {
            let of = |low: [f64; 3]| Extent { low, high: low.map(|x| x + size) };
            let boxes: Vec<Extent> = lows.into_iter().map(of).collect();
            let all = (0..).zip(&boxes).filter(|(_, b)| b.meets(&of(asked))).map(|(i, _)| i);
            let all: Vec<u32> = all.collect();
            prop_assert_eq!(BoxTree::new(boxes.clone()).meeting(&of(asked)), all);
        }
    }
}
