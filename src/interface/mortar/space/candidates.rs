//! Which facets of two sides in space may touch.

use super::facet::SpaceFacet;

/// The pairs (index of a secondary facet, index of a primary facet) whose bounding boxes touch when
/// those of the primary side are widened by `margin` (m) in all directions; sorted, each once.
///
/// Every box is also widened by a quarter of its own size: curved facets bulge out of theirs, and
/// curved sides with meshes of their own do not meet exactly. A tree of boxes: O(n log n), also if
/// the sizes of the facets differ greatly. Local.
pub fn candidates_in_space(
    secondary: &[SpaceFacet],
    primary: &[SpaceFacet],
    margin: f64,
) -> Vec<(usize, usize)> {
    let boxes: Vec<Bounds> = primary.iter().map(|f| widened(f, margin)).collect();
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    let tree = Tree::over(&boxes, &mut order);
    let mut pairs = Vec::new();
    for (s, facet) in secondary.iter().enumerate() {
        let first = pairs.len();
        if let Some(tree) = &tree {
            tree.visit(widened(facet, 0.0), &boxes, &order, &mut |l| pairs.push((s, l)));
        }
        pairs[first..].sort_unstable();
    }
    pairs
}

/// Lower and upper corner.
type Bounds = [[f64; 3]; 2];

/// Part of its size by which each box is widened.
const BULGE: f64 = 0.25;

fn widened(facet: &SpaceFacet, margin: f64) -> Bounds {
    let [low, high] = facet.bounds();
    let margin = margin + BULGE * facet.size();
    [low.map(|x| x - margin), high.map(|x| x + margin)]
}

fn touch(a: Bounds, b: Bounds) -> bool {
    (0..3).all(|d| a[0][d] <= b[1][d] && b[0][d] <= a[1][d])
}

/// A box around a stretch of the boxes in their order, and its halves.
struct Tree {
    bounds: Bounds,
    first: usize,
    count: usize,
    halves: Option<Box<[Tree; 2]>>,
}

/// Boxes that are compared one by one.
const LEAF: usize = 4;

impl Tree {
    /// The tree over all boxes, which brings their `order` into its own; none without boxes.
    fn over(boxes: &[Bounds], order: &mut [usize]) -> Option<Tree> {
        (!order.is_empty()).then(|| Tree::of(boxes, order, 0))
    }

    /// Halves by the middles of the boxes along the longest side.
    fn of(boxes: &[Bounds], order: &mut [usize], first: usize) -> Tree {
        let mut bounds = boxes[order[0]];
        for l in order.iter() {
            for d in 0..3 {
                bounds[0][d] = bounds[0][d].min(boxes[*l][0][d]);
                bounds[1][d] = bounds[1][d].max(boxes[*l][1][d]);
            }
        }
        let count = order.len();
        if count <= LEAF {
            return Tree { bounds, first, count, halves: None };
        }
        let extent = |d: usize| bounds[1][d] - bounds[0][d];
        let longest = (1..3).fold(0, |a, d| if extent(d) > extent(a) { d } else { a });
        let middle = |l: usize| boxes[l][0][longest] + boxes[l][1][longest];
        order.sort_unstable_by(|a, b| middle(*a).total_cmp(&middle(*b)).then(a.cmp(b)));
        let (left, right) = order.split_at_mut(count / 2);
        let halves = [Tree::of(boxes, left, first), Tree::of(boxes, right, first + count / 2)];
        Tree { bounds, first, count, halves: Some(Box::new(halves)) }
    }

    /// Calls `found` with each box that touches `bounds`.
    fn visit(
        &self,
        bounds: Bounds,
        boxes: &[Bounds],
        order: &[usize],
        found: &mut impl FnMut(usize),
    ) {
        if !touch(bounds, self.bounds) {
            return;
        }
        match &self.halves {
            Some(halves) => halves.iter().for_each(|h| h.visit(bounds, boxes, order, found)),
            None => order[self.first..self.first + self.count]
                .iter()
                .filter(|l| touch(bounds, boxes[**l]))
                .for_each(|l| found(*l)),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::element::Shape;

    fn triangle() -> impl Strategy<Value = SpaceFacet> {
        let corner = prop::array::uniform3(-1.0..1.0_f64);
        let size = prop_oneof![Just(0.02), Just(0.2), Just(2.0)];
        (prop::array::uniform3(-1.0..1.0_f64), prop::array::uniform3(corner), size).prop_map(
            |(centre, corners, size)| {
                let at = |x: [f64; 3]| std::array::from_fn(|d| centre[d] + size * x[d]);
                SpaceFacet::new(Shape::Tri3, &[0, 1, 2], &corners.map(at), &[0, 1, 2])
            },
        )
    }

    proptest! {
        #[test]
        fn the_tree_finds_what_comparing_all_pairs_finds(
            secondary in prop::collection::vec(triangle(), 0..20),
            primary in prop::collection::vec(triangle(), 0..60),
            margin in 0.0..0.3_f64,
        ) {
            let mut brute = Vec::new();
            for (s, a) in secondary.iter().enumerate() {
                for (l, b) in primary.iter().enumerate() {
                    if touch(widened(a, 0.0), widened(b, margin)) {
                        brute.push((s, l));
                    }
                }
            }
            prop_assert_eq!(candidates_in_space(&secondary, &primary, margin), brute);
        }
    }

    #[test]
    fn facets_at_one_place_are_all_found() {
        let points = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let facet = SpaceFacet::new(Shape::Tri3, &[0, 1, 2], &points, &[0, 1, 2]);
        assert_eq!(candidates_in_space(&[facet], &[facet; 33], 0.0).len(), 33);
        let away = points.map(|x| x.map(|x| x + 3.5));
        let other = SpaceFacet::new(Shape::Tri3, &[0, 1, 2], &away, &[0, 1, 2]);
        assert!(candidates_in_space(&[facet], &[other; 33], 1.0).is_empty());
        assert_eq!(candidates_in_space(&[facet], &[other; 33], 2.0).len(), 33);
    }
}
