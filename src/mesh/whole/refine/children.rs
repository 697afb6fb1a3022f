//! Which children cells have.
//!
//! A child at each corner is its parent at half the size. What they leave free in the middle is one
//! triangle, two prisms, a pyramid turned over with four tetrahedra around it, or the octahedron of
//! a tetrahedron, which one of its three diagonals cuts into four.
//!
//! In a tetrahedron that nobody refined before, the shortest diagonal is taken. Its descendants
//! follow the order of Bey, which begins with that diagonal: however often one refines, they have
//! at most three shapes, while the longest diagonals would make them ever flatter.
//!
//! # Source
//! Bey (1995), Computing 55, 355-378; for the other kinds the parts are congruent to the parent or
//! are tetrahedra.

use crate::element::Shape;

/// In which order the corners of a tetrahedron are refined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// None yet: the shortest diagonal says.
    Free,
    /// As its nodes stand.
    Kept,
    /// With the first two nodes exchanged.
    Swapped,
}

/// A child of first order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Child {
    pub shape: Shape,
    /// Its corners among the nodes of the parent of second order (of a pyramid: corners, middles of
    /// the edges, middle of the base).
    pub corners: [u8; 8],
    /// That of a tetrahedron.
    pub order: Order,
}

/// The number of nodes of the cell of second order with the same corners.
pub const fn second_order_nodes(shape: Shape) -> usize {
    match shape {
        Shape::Pyramid5 => 14,
        _ => second_order(shape).nodes(),
    }
}

/// The shape of second order with the same corners. There is none of pyramids, which stay.
pub const fn second_order(shape: Shape) -> Shape {
    match shape.corners() {
        Shape::Line2 => Shape::Line3,
        Shape::Tri3 => Shape::Tri6,
        Shape::Quad4 => Shape::Quad9,
        Shape::Tet4 => Shape::Tet10,
        Shape::Prism6 => Shape::Prism18,
        Shape::Hex8 => Shape::Hex27,
        _ => Shape::Pyramid5,
    }
}

/// Middles of the edges of a pyramid: of the base, then those to its apex.
pub const PYRAMID_EDGES: [[usize; 2]; 8] =
    [[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [1, 4], [2, 4], [3, 4]];

/// The corners of a tetrahedron so that the diagonal between the middles of 0, 2 and of 1, 3 is
/// each of the three, and so that the first two are exchanged.
const ORDERS: [[usize; 4]; 4] = [[0, 1, 2, 3], [0, 2, 1, 3], [0, 1, 3, 2], [1, 0, 2, 3]];

/// The children of the tetrahedron 0, 1, 2, 3 in the order of Bey, each corner as the middle of
/// two: at the corners, then around the diagonal.
const BEY: [[[usize; 2]; 4]; 8] = [
    [[0, 0], [0, 1], [0, 2], [0, 3]],
    [[0, 1], [1, 1], [1, 2], [1, 3]],
    [[0, 2], [1, 2], [2, 2], [2, 3]],
    [[0, 3], [1, 3], [2, 3], [3, 3]],
    [[0, 1], [0, 2], [0, 3], [1, 3]],
    [[0, 1], [0, 2], [1, 2], [1, 3]],
    [[0, 2], [0, 3], [1, 3], [2, 3]],
    [[0, 2], [1, 2], [1, 3], [2, 3]],
];

/// The children of all shapes.
pub struct Children {
    /// By the number of the shape of first order; none of tetrahedra.
    of_shapes: Vec<Vec<Child>>,
    /// Those of tetrahedra for each of [`ORDERS`].
    of_tetrahedra: [Vec<Child>; 4],
}

impl Children {
    pub fn new() -> Self {
        let of_shapes = Shape::ALL.iter().map(|shape| of_shape(*shape)).collect();
        Self { of_shapes, of_tetrahedra: ORDERS.map(of_tetrahedron) }
    }

    /// The children of a cell.
    ///
    /// # Arguments
    /// * `order` of a tetrahedron
    /// * `point` gives the positions (m) of its nodes of second order
    pub fn of(&self, shape: Shape, order: Order, point: impl Fn(usize) -> [f64; 3]) -> &[Child] {
        if shape.corners() != Shape::Tet4 {
            return &self.of_shapes[shape.corners() as usize];
        }
        match order {
            Order::Free => &self.of_tetrahedra[shortest(point)],
            Order::Kept => &self.of_tetrahedra[0],
            Order::Swapped => &self.of_tetrahedra[3],
        }
    }
}

/// Which of [`ORDERS`] has the shortest diagonal. Of those that differ by rounding only the first
/// is taken, so that it does not matter where the cell lies.
fn shortest(point: impl Fn(usize) -> [f64; 3]) -> usize {
    const ALIKE: f64 = 1.0 - 1e-9;
    let square = |order: [usize; 4]| {
        let [p, q] = [[0, 2], [1, 3]].map(|[a, b]| point(middle_of(order[a], order[b])));
        (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>()
    };
    (1..3).fold(
        0,
        |best, next| {
            if square(ORDERS[next]) < ALIKE * square(ORDERS[best]) { next } else { best }
        },
    )
}

/// The node of a tetrahedron of second order in the middle of two corners, or the corner.
fn middle_of(a: usize, b: usize) -> usize {
    match (a.min(b), a.max(b)) {
        (a, b) if a == b => a,
        (0, 1) => 4,
        (1, 2) => 5,
        (0, 2) => 6,
        (a, _) => 7 + a,
    }
}

/// Those of a tetrahedron with its corners in this order.
fn of_tetrahedron(order: [usize; 4]) -> Vec<Child> {
    let child = |row: [[usize; 2]; 4]| {
        let nodes = row.map(|[a, b]| middle_of(order[a], order[b]));
        tetrahedron(nodes, &points(Shape::Tet4), [Order::Kept, Order::Swapped])
    };
    BEY.map(child).into()
}

/// A tetrahedron, with its first two nodes exchanged where it would be turned over; which order it
/// has then.
fn tetrahedron(nodes: [usize; 4], points: &[[f64; 3]], orders: [Order; 2]) -> Child {
    let [o, a, b, c] = nodes.map(|node| points[node]);
    let [a, b, c] = [a, b, c].map(|p| [0, 1, 2].map(|i| p[i] - o[i]));
    let volume = a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0]);
    let [p, q, r, s] = nodes;
    if volume > 0.0 {
        child(Shape::Tet4, &nodes, orders[0])
    } else {
        child(Shape::Tet4, &[q, p, r, s], orders[1])
    }
}

fn child(shape: Shape, nodes: &[usize], order: Order) -> Child {
    let mut corners = [0; 8];
    corners.iter_mut().zip(nodes).for_each(|(corner, node)| *corner = *node as u8);
    Child { shape, corners, order }
}

/// The reference coordinates of the nodes of second order.
pub fn points(shape: Shape) -> Vec<[f64; 3]> {
    let corners = shape.corners().node_points();
    if shape != Shape::Pyramid5 {
        return second_order(shape).node_points().to_vec();
    }
    let edges = PYRAMID_EDGES.map(|[a, b]| between(corners[a], corners[b]));
    [corners, &edges, &[[0.0; 3]]].concat()
}

fn between(p: [f64; 3], q: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| 0.5 * (p[i] + q[i]))
}

/// Those of a shape of first order that is no tetrahedron.
fn of_shape(shape: Shape) -> Vec<Child> {
    if shape.corners() != shape || shape == Shape::Tet4 {
        return Vec::new();
    }
    let points = points(shape);
    let corners = shape.node_points();
    let node = |point| points.iter().position(|other| *other == point).unwrap_or_default();
    let mut found = Vec::new();
    for to in corners {
        let nodes: Vec<usize> = corners.iter().map(|from| node(between(*from, *to))).collect();
        found.push(child(shape, &nodes, Order::Free));
    }
    match shape {
        Shape::Tri3 => found.push(child(shape, &[3, 4, 5], Order::Free)),
        Shape::Prism6 => {
            found.push(child(shape, &[6, 7, 8, 15, 16, 17], Order::Free));
            found.push(child(shape, &[15, 16, 17, 9, 10, 11], Order::Free));
        }
        Shape::Pyramid5 => {
            found.push(child(shape, &[9, 12, 11, 10, 13], Order::Free));
            for side in 0..4 {
                let nodes = [5 + side, 9 + side, 9 + (side + 1) % 4, 13];
                found.push(tetrahedron(nodes, &points, [Order::Free; 2]));
            }
        }
        _ => {}
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::{MAX_NODES, mapping, quadrature};

    fn volume(shape: Shape, points: &[[f64; 3]]) -> f64 {
        let det = |xi| {
            if shape.dim() == 2 {
                let plane: Vec<[f64; 2]> = points.iter().map(|p| [p[0], p[1]]).collect();
                mapping(shape, &plane, xi).determinant
            } else {
                mapping(shape, points, xi).determinant
            }
        };
        quadrature(shape, 2).iter().map(|p| p.weight * det(p.xi)).sum()
    }

    #[test]
    fn children_fill_their_parent_and_none_is_turned_over() {
        let counts = [(Shape::Tri3, 4), (Shape::Quad4, 4), (Shape::Tet4, 8), (Shape::Prism6, 8)];
        for (shape, count) in [&counts[..], &[(Shape::Pyramid5, 10), (Shape::Hex8, 8)]].concat() {
            let points = points(shape);
            assert!(points.len() == second_order_nodes(shape) && points.len() <= MAX_NODES);
            for order in [Order::Free, Order::Kept, Order::Swapped] {
                let children = Children::new();
                let children = children.of(shape, order, |node| points[node]);
                assert_eq!(children.len(), count);
                let part = |child: &Child| {
                    let nodes = &child.corners[..child.shape.nodes()];
                    let points: Vec<_> = nodes.iter().map(|node| points[*node as usize]).collect();
                    let part = volume(child.shape, &points);
                    let is_tetrahedron = child.shape != shape;
                    let share = if is_tetrahedron { 16.0 } else { f64::from(1 << shape.dim()) };
                    assert!((part * share / shape.volume() - 1.0).abs() < 1e-14, "{child:?}");
                    part
                };
                let sum: f64 = children.iter().map(part).sum();
                assert!((sum / shape.volume() - 1.0).abs() < 1e-14, "{shape:?}");
            }
        }
    }

    /// Six lengths, rising, of a tetrahedron made as large as its first ancestor.
    fn lengths(tetrahedron: &[[f64; 3]; 4], level: u32) -> Vec<i64> {
        let mut all = Vec::new();
        for a in 0..4 {
            for b in a + 1..4 {
                let [p, q] = [tetrahedron[a], tetrahedron[b]];
                let length = (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt();
                all.push((length * f64::from(1 << level) * 1e6).round() as i64);
            }
        }
        all.sort_unstable();
        all
    }

    fn halves([p, q, r, s]: [[f64; 3]; 4]) -> Vec<[f64; 3]> {
        let pairs = [[p, q], [q, r], [p, r], [p, s], [q, s], [r, s]];
        [p, q, r, s].into_iter().chain(pairs.map(|[p, q]| between(p, q))).collect()
    }

    /// The quality of Liu and Joe, 1 for the regular tetrahedron.
    fn quality(t: &[[f64; 3]; 4]) -> f64 {
        let squares: f64 = (0..4)
            .flat_map(|a| (a + 1..4).map(move |b| (a, b)))
            .map(|(a, b)| (0..3).map(|i| (t[a][i] - t[b][i]).powi(2)).sum::<f64>())
            .sum();
        12.0 * (3.0 * volume(Shape::Tet4, t)).powf(2.0 / 3.0) / squares
    }

    #[test]
    fn tetrahedra_keep_to_three_shapes_however_often_they_are_refined() {
        let children = Children::new();
        let sliver = [[0.0; 3], [1.0, 0.0, 0.1], [0.9, 1.1, 0.0], [0.1, 1.0, 0.2]];
        let oblique = [[0.0; 3], [1.0, 0.0, 0.0], [0.7, 0.8, 0.0], [2.3, -0.4, 0.5]];
        for first in [sliver, oblique, [0, 1, 2, 3].map(|i| Shape::Tet4.node_points()[i])] {
            let mut shapes = std::collections::BTreeSet::new();
            let mut cells = vec![(first, Order::Free)];
            for level in 1..=5 {
                let mut next = Vec::new();
                for (cell, order) in &cells {
                    let points = halves(*cell);
                    for child in children.of(Shape::Tet4, *order, |node| points[node]) {
                        let corners = [0, 1, 2, 3].map(|i| points[child.corners[i] as usize]);
                        shapes.insert(lengths(&corners, level));
                        assert!(quality(&corners) > 0.7 * quality(&first), "{first:?} {level}");
                        next.push((corners, child.order));
                    }
                }
                cells = next;
            }
            assert!(shapes.len() <= 3, "{} shapes of {first:?}", shapes.len());
        }
    }

    #[test]
    fn the_shortest_diagonal_is_taken() {
        let children = Children::new();
        // The middles of 0, 1 and of 2, 3 lie nearest to each other.
        let flat = [[0.0, 0.0, 0.0], [2.0, 2.0, 0.2], [2.0, 0.0, 0.1], [0.0, 2.0, 0.3]];
        let flat = if volume(Shape::Tet4, &flat) > 0.0 {
            flat
        } else {
            [flat[1], flat[0], flat[2], flat[3]]
        };
        let points = halves(flat);
        let of_diagonal = |child: &&Child| [4, 9].iter().all(|n| child.corners[..4].contains(n));
        let cut = children.of(Shape::Tet4, Order::Free, |node| points[node]);
        assert_eq!(cut.iter().filter(of_diagonal).count(), 4);
    }
}
