//! The overlap of a secondary and a primary facet, as integration points on both.

use super::PlaneFacet;
use super::polygon::{clip, cross};
use crate::element::{Shape, gauss, triangle};

/// An integration point of the overlap of two facets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SegmentPoint {
    /// Reference coordinates on the secondary facet.
    pub xi: [f64; 3],
    /// Reference coordinates on the primary facet.
    pub eta: [f64; 3],
    /// Weight times area, m2 (times length, m, for lines).
    pub weight: f64,
}

/// What lies this close to a line, relative to the size of the secondary facet, lies on it. The
/// neighbours beyond the line decide alike, so nothing is lost or counted twice.
const ON_LINE: f64 = 1e-10;

/// Overlaps smaller than this fraction of the secondary facet are rounding.
const NO_AREA: f64 = 1e-14;

/// Facets match when their nodes are this close, relative to the size of the facet.
const MATCH: f64 = 1e-9;

/// Appends the integration points of the overlap to `points`; returns its area, m2 (length, m).
///
/// Lines: 3 Gauss points on the common interval. Quadrilaterals: the common polygon
/// (Sutherland-Hodgman), fanned into triangles with a rule of degree 4 each, or of degree 8 if one
/// facet is of second order: products of basis functions on parallelograms are integrated exactly.
pub fn overlap(
    secondary: &PlaneFacet,
    primary: &PlaneFacet,
    points: &mut Vec<SegmentPoint>,
) -> f64 {
    let origin = secondary.corners()[0];
    let (secondary, primary) = (secondary.relative_to(origin), primary.relative_to(origin));
    let mut push = |point: [f64; 2], weight: f64| {
        let (xi, eta) = (secondary.locate(point), primary.locate(point));
        points.push(SegmentPoint { xi, eta, weight });
    };
    match secondary.shape() {
        Shape::Line2 | Shape::Line3 => {
            let Some([low, high]) = common_interval(&secondary, &primary) else { return 0.0 };
            let length = high - low;
            for p in gauss(Shape::Line2, 3) {
                push([low + 0.5 * (1.0 + p.xi[0]) * length, 0.0], 0.5 * p.weight * length);
            }
            length
        }
        _ => {
            let polygon = common_polygon(&secondary, &primary);
            let fan: Vec<([[f64; 2]; 3], f64)> = (2..polygon.len())
                .map(|i| [polygon[0], polygon[i - 1], polygon[i]])
                .map(|t| (t, 0.5 * cross(t[0], t[1], t[2]).abs()))
                .collect();
            let area: f64 = fan.iter().map(|(_, area)| area).sum();
            if area <= NO_AREA * secondary.area() {
                return 0.0;
            }
            let degree = 4 * secondary.shape().order().max(primary.shape().order());
            for (t, area) in fan {
                for p in triangle(degree) {
                    let [a, b, c] = p.barycentric;
                    let x = std::array::from_fn(|d| a * t[0][d] + b * t[1][d] + c * t[2][d]);
                    push(x, p.weight * area);
                }
            }
            area
        }
    }
}

/// If the facets coincide node by node: for each local secondary node the local primary node at
/// the same place.
pub fn matching_nodes(secondary: &PlaneFacet, primary: &PlaneFacet) -> Option<Vec<usize>> {
    if secondary.shape() != primary.shape() {
        return None;
    }
    let near = MATCH * secondary.size();
    let there = primary.positions();
    let twin = |x: &[f64; 2]| {
        there.iter().position(|y| (x[0] - y[0]).abs() <= near && (x[1] - y[1]).abs() <= near)
    };
    secondary.positions().iter().map(twin).collect()
}

fn common_interval(secondary: &PlaneFacet, primary: &PlaneFacet) -> Option<[f64; 2]> {
    let [[a, _], [b, _]] = secondary.bounds();
    let near = ON_LINE * (b - a);
    let snap = |x: f64| {
        if x <= a + near {
            a
        } else if x >= b - near {
            b
        } else {
            x
        }
    };
    let [[c, _], [d, _]] = primary.bounds();
    let (low, high) = (snap(c), snap(d));
    (high > low).then_some([low, high])
}

/// The secondary polygon cut by the primary one.
fn common_polygon(secondary: &PlaneFacet, primary: &PlaneFacet) -> Vec<[f64; 2]> {
    let turn = primary.signed_area().signum();
    clip(secondary.corners(), primary.corners(), turn, ON_LINE * secondary.size())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::element::map_point;

    fn rectangle(x: [f64; 2], y: [f64; 2]) -> PlaneFacet {
        PlaneFacet::quad([0, 1, 2, 3], [[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]])
    }

    fn area(a: &PlaneFacet, b: &PlaneFacet) -> f64 {
        overlap(a, b, &mut Vec::new())
    }

    #[test]
    fn neighbours_that_share_an_edge_or_a_corner_do_not_overlap() {
        let cell = rectangle([0.1, 0.2], [0.1, 0.2]);
        for other in [
            rectangle([0.2, 0.3], [0.1, 0.2]),
            rectangle([0.2 - 1e-13, 0.3], [0.1, 0.2]),
            rectangle([0.2, 0.3], [0.2, 0.3]),
            rectangle([0.5, 0.6], [0.1, 0.2]),
        ] {
            let mut points = Vec::new();
            assert_eq!(overlap(&cell, &other, &mut points), 0.0);
            assert!(points.is_empty());
        }
        let line = PlaneFacet::line([0, 1], [1.0, 2.0]);
        assert_eq!(area(&line, &PlaneFacet::line([2, 3], [2.0 - 1e-13, 3.0])), 0.0);
        assert_eq!(area(&line, &PlaneFacet::line([2, 3], [3.0, 1.5])), 0.5);
    }

    #[test]
    fn a_turned_square_inside_is_found_whole() {
        let diamond =
            PlaneFacet::quad([0, 1, 2, 3], [[0.5, 0.0], [1.0, 0.5], [0.5, 1.0], [0.0, 0.5]]);
        let square = rectangle([0.0, 1.0], [0.0, 1.0]);
        assert!((area(&diamond, &square) - 0.5).abs() < 1e-15);
        assert!((area(&square, &diamond) - 0.5).abs() < 1e-15);
    }

    #[test]
    fn products_of_bilinear_functions_are_integrated_exactly() {
        let cell = rectangle([0.0, 1.0], [0.0, 1.0]);
        let mut points = Vec::new();
        for x in [[-0.3, 0.4], [0.4, 1.2]] {
            for y in [[-0.1, 0.7], [0.7, 1.0]] {
                overlap(&cell, &rectangle(x, y), &mut points);
            }
        }
        let sum: f64 = points.iter().map(|p| p.weight * (p.xi[0] * p.xi[1]).powi(2)).sum();
        assert!((sum - 1.0 / 9.0).abs() < 1e-15);
    }

    #[test]
    fn coordinates_far_from_the_origin_lose_nothing() {
        let at = |x: f64| rectangle([x, x + 0.125], [x, x + 0.125]);
        let (a, b) = (at(4096.0), at(4096.0625));
        assert_eq!(area(&a, &b), 0.0625 * 0.0625);
    }

    fn convex_quad() -> impl Strategy<Value = PlaneFacet> {
        // A parallelogram with its corners moved by less than would fold it, either way round.
        let shake = prop::array::uniform8(-0.15..0.15_f64);
        ((-1.0..1.0_f64, -1.0..1.0_f64), 0.0..6.3_f64, 0.4..1.6_f64, shake, any::<bool>()).prop_map(
            |(centre, angle, aspect, shake, reverse)| {
                let (sin, cos) = angle.sin_cos();
                let mut positions: [[f64; 2]; 4] = std::array::from_fn(|a| {
                    let v = Shape::Quad4.node_points()[a];
                    let x = [aspect * v[0] + shake[2 * a] * aspect, v[1] + shake[2 * a + 1]];
                    [centre.0 + cos * x[0] - sin * x[1], centre.1 + sin * x[0] + cos * x[1]]
                });
                if reverse {
                    positions.reverse();
                }
                PlaneFacet::quad([0, 1, 2, 3], positions)
            },
        )
    }

    proptest! {
        #[test]
        fn the_overlap_is_the_same_from_both_sides(a in convex_quad(), b in convex_quad()) {
            let one = area(&a, &b);
            prop_assert!((one - area(&b, &a)).abs() < 1e-9);
            prop_assert!(one <= a.area().min(b.area()) * (1.0 + 1e-12));
        }

        #[test]
        fn a_tiling_covers_each_facet_once(
            facet in convex_quad(),
            x in -1.0..1.0_f64,
            y in -1.0..1.0_f64,
        ) {
            let mut points = Vec::new();
            let mut sum = 0.0;
            let origin = [x - 5.0, y - 5.0];
            for i in 0..20 {
                for j in 0..20 {
                    let low = [origin[0] + 0.5 * f64::from(i), origin[1] + 0.5 * f64::from(j)];
                    let cell = rectangle([low[0], origin[0] + 0.5 * f64::from(i + 1)],
                        [low[1], origin[1] + 0.5 * f64::from(j + 1)]);
                    let first = points.len();
                    sum += overlap(&facet, &cell, &mut points);
                    for p in &points[first..] {
                        let here = map_point(Shape::Quad4, facet.corners(), p.xi);
                        let there = map_point(Shape::Quad4, cell.corners(), p.eta);
                        let apart = (here[0] - there[0]).hypot(here[1] - there[1]);
                        prop_assert!(apart < 1e-13);
                        prop_assert!(p.eta.iter().chain(&p.xi).all(|c| c.abs() < 1.0 + 1e-9));
                    }
                }
            }
            prop_assert!((sum - facet.area()).abs() < 1e-12 * facet.area());
            let weights: f64 = points.iter().map(|p| p.weight).sum();
            prop_assert!((weights - sum).abs() < 1e-12 * sum);
        }
    }
}
