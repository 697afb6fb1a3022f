//! Biorthogonality, sums and signs of the multiplier basis.

#![allow(clippy::needless_range_loop)] // index notation, as in the formulas

use super::*;
use crate::element::{QuadraturePoint, Shape, quadrature};
use crate::interface::mortar::PlaneFacet;

fn facets() -> [PlaneFacet; 7] {
    let quad9 =
        |corners: &[[f64; 2]]| PlaneFacet::new(Shape::Quad9, &[0, 1, 2, 3, 4, 5, 6, 7, 8], corners);
    [
        PlaneFacet::line([0, 1], [0.2, 0.7]),
        PlaneFacet::quad([0, 1, 2, 3], [[0.0, 0.0], [2.0, 0.0], [2.0, 0.5], [0.0, 0.5]]),
        PlaneFacet::quad([0, 1, 2, 3], [[0.0, 0.0], [2.0, 0.3], [2.4, 1.5], [0.1, 1.0]]),
        PlaneFacet::quad([0, 1, 2, 3], [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]]),
        PlaneFacet::new(Shape::Line3, &[0, 1, 2], &[[0.2, 0.0], [0.7, 0.0]]),
        quad9(&[[0.0, 0.0], [2.0, 0.0], [2.0, 0.5], [0.0, 0.5]]),
        quad9(&[[0.0, 0.0], [2.0, 0.3], [2.4, 1.5], [0.1, 1.0]]),
    ]
}

#[test]
fn the_basis_is_biorthogonal_and_sums_to_one_whatever_is_dropped() {
    for facet in facets() {
        let n = facet.shape().nodes();
        // Of 511 choices of 9 nodes every seventh.
        for dropped in (0..(1_u16 << n) - 1).step_by(if n > 4 { 7 } else { 1 }) {
            let basis = DualBasis::new(facet.shape(), &facet.points(), dropped).unwrap();
            let mut found = [[0.0; MOST_NODES]; MOST_NODES];
            let mut nodal = [0.0; MOST_NODES];
            for p in facet.points() {
                let (mut phi, mut values) = ([0.0; MOST_NODES], [0.0; MOST_NODES]);
                basis.values(p.xi, &mut phi);
                facet.shape().values(p.xi, &mut values);
                assert!((phi.iter().sum::<f64>() - 1.0).abs() < 1e-13, "{dropped:b}");
                for k in 0..n {
                    nodal[k] += p.weight * values[k];
                    for i in 0..n {
                        found[i][k] += p.weight * phi[i] * values[k];
                    }
                }
            }
            let area = facet.area();
            for &i in basis.kept() {
                for k in 0..n {
                    assert!((found[i][k] - basis.integrals(i)[k]).abs() < 1e-13 * area);
                    if basis.kept().contains(&k) {
                        let exact = if i == k { nodal[k] } else { 0.0 };
                        assert!((basis.integrals(i)[k] - exact).abs() < 1e-15 * area);
                    }
                }
            }
            let weights: f64 = basis.kept().iter().map(|&i| basis.weight(i)).sum();
            assert!((weights - area).abs() < 1e-13 * area);
        }
    }
}

#[test]
fn the_plain_basis_of_a_segment_is_the_known_one() {
    let facet = PlaneFacet::line([0, 1], [0.0, 1.0]);
    let basis = DualBasis::new(Shape::Line2, &facet.points(), 0).unwrap();
    let mut phi = [0.0; MOST_NODES];
    basis.values([-1.0, 0.0, 0.0], &mut phi);
    assert!((phi[0] - 2.0).abs() < 1e-14 && (phi[1] + 1.0).abs() < 1e-14);
}

#[test]
fn the_basis_of_second_order_reproduces_linear_functions_with_positive_weights() {
    for facet in &facets()[4..6] {
        let shape = facet.shape();
        let basis = DualBasis::new(shape, &facet.points(), 0).unwrap();
        let mut phi = [0.0; MOST_NODES];
        for xi in [[0.3, -0.7, 0.0], [-1.0, 1.0, 0.0]] {
            basis.values(xi, &mut phi);
            for d in 0..shape.dim() {
                let linear: f64 =
                    phi.iter().zip(shape.node_points()).map(|(phi, x)| phi * x[d]).sum();
                assert!((linear - xi[d]).abs() < 1e-13, "{shape:?}: {linear} {}", xi[d]);
            }
        }
        assert!((0..shape.nodes()).all(|i| basis.weight(i) > 0.02 * facet.area()));
    }
}

#[test]
fn a_dropped_edge_leaves_a_constant_across() {
    let facet = facets()[1];
    // Nodes 0 and 3 (the left edge) are dropped: constant along the first axis.
    let basis = DualBasis::new(Shape::Quad4, &facet.points(), 0b1001).unwrap();
    let (mut left, mut right) = ([0.0; MOST_NODES], [0.0; MOST_NODES]);
    basis.values([-1.0, 0.3, 0.0], &mut left);
    basis.values([1.0, 0.3, 0.0], &mut right);
    for i in 0..4 {
        assert!((left[i] - right[i]).abs() < 1e-14);
    }
    assert!((basis.weight(1) - 0.5).abs() < 1e-14);
    assert!(DualBasis::new(Shape::Quad4, &facet.points(), 0b1111).is_none());
}

/// Points of a facet whose measure is not constant.
fn curved(shape: Shape) -> Vec<QuadraturePoint> {
    let measure = |p: QuadraturePoint| {
        let stretch = 1.0 + 0.3 * p.xi[0] - 0.2 * p.xi[1] * p.xi[1];
        QuadraturePoint { weight: p.weight * stretch, ..p }
    };
    quadrature(shape, 8).into_iter().map(measure).collect()
}

const TRANSFORMED: [Shape; 4] = [Shape::Tri3, Shape::Tri6, Shape::Line3, Shape::Quad9];

#[test]
fn triangles_and_transformed_edges_have_their_basis_whatever_is_dropped() {
    for shape in TRANSFORMED {
        let (n, points) = (shape.nodes(), curved(shape));
        let area: f64 = points.iter().map(|p| p.weight).sum();
        for dropped in (0..(1_u16 << n) - 1).step_by(if n > 6 { 7 } else { 1 }) {
            let nodal = EdgeBasis::transformed(shape, dropped);
            let basis = DualBasis::to(nodal, &points, dropped).unwrap();
            let (mut found, mut plain) = ([[0.0; MOST_NODES]; MOST_NODES], [[0.0; 9]; 9]);
            let mut whole = [0.0; MOST_NODES];
            for p in &points {
                let (mut phi, mut values) = ([0.0; MOST_NODES], [0.0; MOST_NODES]);
                basis.values(p.xi, &mut phi);
                shape.values(p.xi, &mut values);
                assert!((phi.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{shape:?} {dropped:b}");
                for k in 0..n {
                    whole[k] += p.weight * nodal.values(p.xi)[k];
                    for i in 0..n {
                        found[i][k] += p.weight * phi[i] * nodal.values(p.xi)[k];
                        plain[i][k] += p.weight * phi[i] * values[k];
                    }
                }
            }
            for &i in basis.kept() {
                for k in 0..n {
                    let exact = if i == k { whole[k] } else { 0.0 };
                    let is_kept = basis.kept().contains(&k);
                    assert!(!is_kept || (found[i][k] - exact).abs() < 1e-13 * area);
                    assert!((plain[i][k] - basis.integrals(i)[k]).abs() < 1e-13 * area);
                }
                let sum: f64 = basis.integrals(i).iter().sum();
                assert!((sum - basis.weight(i)).abs() < 1e-14 * area);
            }
        }
    }
}

/// The nodes of each edge of a facet, one bit each.
fn edges(shape: Shape) -> Vec<u16> {
    let corners = shape.corners().nodes();
    let bits = |e: usize| {
        let middle = if shape.order() == 2 { 1 << (corners + e) } else { 0 };
        1 << e | 1 << ((e + 1) % corners) | middle
    };
    (0..corners).map(bits).collect()
}

/// What happens at the border of an interface: an edge, two edges, a corner without multipliers.
#[test]
fn weights_are_positive_where_edges_or_corners_are_dropped() {
    for shape in [Shape::Tri3, Shape::Tri6, Shape::Quad4, Shape::Quad9] {
        let points = quadrature(shape, 8);
        let area: f64 = points.iter().map(|p| p.weight).sum();
        let (edges, corners) = (edges(shape), shape.corners().nodes());
        let mut masks = vec![0];
        masks.extend((0..corners).map(|c| 1 << c));
        masks.extend(edges.iter().flat_map(|a| edges.iter().map(move |b| a | b)));
        masks.extend(edges.iter().flat_map(|a| (0..corners).map(move |c| a | 1 << c)));
        masks.extend((0..corners).map(|c| 1 << c | 1 << ((c + 1) % corners)));
        for dropped in masks.into_iter().filter(|m| m.count_ones() < shape.nodes() as u32) {
            for nodal in [EdgeBasis::plain(shape), EdgeBasis::transformed(shape, dropped)] {
                if shape == Shape::Tri6 && nodal == EdgeBasis::plain(shape) {
                    continue;
                }
                let basis = DualBasis::to(nodal, &points, dropped).unwrap();
                for &i in basis.kept() {
                    let part = basis.weight(i) / area;
                    assert!(part > 0.005, "{shape:?} {dropped:b} node {i}: {part}");
                }
            }
        }
    }
}

#[test]
fn triangles_of_second_order_share_their_area_as_published() {
    let points = quadrature(Shape::Tri6, 4);
    let basis = DualBasis::to(EdgeBasis::transformed(Shape::Tri6, 0), &points, 0).unwrap();
    for i in 0..6 {
        let exact = 0.5 * if i < 3 { 2.0 / 15.0 } else { 1.0 / 5.0 };
        assert!((basis.weight(i) - exact).abs() < 1e-15);
    }
}

/// Points in a corner only, or in the middle: the functions differ little there.
#[test]
fn bases_over_small_parts_keep_their_digits_or_are_refused() {
    for (shape, corner) in [(Shape::Tri3, 1e-4), (Shape::Quad4, 1e-2), (Shape::Tri6, 0.03)] {
        let within = |size: f64, from: [f64; 2]| -> Vec<QuadraturePoint> {
            let shrink = |p: QuadraturePoint| {
                let [x, y, _] = p.xi;
                let xi = [from[0] + size * x, from[1] + size * y, 0.0];
                QuadraturePoint { xi, weight: size * size * p.weight }
            };
            quadrature(Shape::Tri3, 8).into_iter().map(shrink).collect()
        };
        let nodal = EdgeBasis::transformed(shape, 0);
        let from = [shape.node_points()[0][0], shape.node_points()[0][1]];
        let points = within(corner, from);
        let basis = DualBasis::to(nodal, &points, 0).expect("a basis");
        let mut moments = [[0.0; MOST_NODES]; MOST_NODES];
        let area: f64 = points.iter().map(|p| p.weight).sum();
        for p in &points {
            let mut phi = [0.0; MOST_NODES];
            basis.values(p.xi, &mut phi);
            assert!((phi.iter().sum::<f64>() - 1.0).abs() < 1e-8);
            for i in 0..shape.nodes() {
                for k in 0..shape.nodes() {
                    moments[i][k] += p.weight * phi[i] * nodal.values(p.xi)[k] / area;
                }
                moments[i][i] -= p.weight * nodal.values(p.xi)[i] / area;
            }
        }
        let largest = moments.iter().flatten().fold(0.0_f64, |a, m| a.max(m.abs()));
        assert!(largest < 1e-8, "{shape:?} {largest:e}");
        assert!(DualBasis::to(nodal, &within(1e-9, [0.2, 0.3]), 0).is_none(), "{shape:?}");
    }
}
