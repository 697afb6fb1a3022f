//! Polynomials of both sides' order make no jump across plane interfaces.

use super::surfaces::*;
use crate::element::Shape;
use crate::interface::mortar::patch_tests::{grid, second_order};
use crate::interface::mortar::{
    Partners, PlaneFacet, SpaceFacet, candidates, facet_rows, facet_rows_in_space,
};

const RATIOS: [([usize; 2], [usize; 2]); 4] =
    [([2, 2], [3, 3]), ([3, 2], [2, 4]), ([1, 1], [4, 3]), ([4, 3], [1, 1])];

type Field = fn([f64; 2]) -> f64;

/// With their degrees.
const FIELDS: [(usize, Field); 5] = [
    (0, |_| 1.0),
    (1, |x| x[0] - 0.3),
    (1, |x| 2.0 * x[1] - x[0]),
    (2, |x| x[0] * x[0] - 3.0 * x[0] * x[1]),
    (2, |x| 0.5 * x[1] * x[1] + x[0] * x[1] - 0.2),
];

/// No jumps of what both sides can represent; the area is covered; uniform tractions give
/// consistent forces on both sides.
fn check(flat: [&[Flat]; 2], orders: [usize; 2], transformed: bool, dropped: &[u64], to: &Motion) {
    let [secondary, primary] = flat.map(|side| lay(side, to));
    let sums = rows(&secondary, &primary, transformed, |node| dropped.contains(&node));
    let order = orders[0].min(orders[1]);
    for (_, field) in FIELDS.iter().filter(|f| f.0 <= order) {
        let jump = sums.largest_jump(&values(flat, field));
        assert!(jump < 1e-12, "{orders:?} {transformed} {dropped:?}: {jump:e}");
    }
    assert!((sums.covered - sums.area).abs() < 1e-12 * sums.area);
    let has_multiplier = |f: &&SpaceFacet| f.nodes().iter().any(|node| !dropped.contains(node));
    let area: f64 = secondary.iter().filter(has_multiplier).map(SpaceFacet::area).sum();
    let weights: f64 = sums.rows.values().map(|row| row.weight).sum();
    assert!((weights - area).abs() < 1e-12 * sums.area);
    for row in sums.rows.values() {
        assert!(row.weight > 1e-4 * sums.area / sums.rows.len() as f64, "{orders:?} {dropped:?}");
        for side in [&row.here, &row.there] {
            assert!((side.values().sum::<f64>() - row.weight).abs() < 1e-12 * row.weight);
        }
    }
    if secondary.iter().all(|f| has_multiplier(&f)) {
        forces_are_consistent(&sums, [&secondary, &primary]);
    }
}

/// To rounding where the rules are exact; on quadrilaterals that are no parallelograms they take so
/// many terms of a series.
fn forces_are_consistent(sums: &Sums, sides: [&[SpaceFacet]; 2]) {
    for (side, facets) in sides.into_iter().enumerate() {
        let mut forces = std::collections::BTreeMap::<u64, f64>::new();
        for row in sums.rows.values() {
            let coefficients = if side == 0 { &row.here } else { &row.there };
            coefficients.iter().for_each(|(k, c)| *forces.entry(*k).or_default() += c);
        }
        for facet in facets {
            for p in facet.rule() {
                let mut values = [0.0; 9];
                facet.shape().values(p.xi, &mut values);
                for (node, value) in facet.nodes().iter().zip(values) {
                    *forces.entry(*node).or_default() -= p.weight * value;
                }
            }
        }
        let exact = sides.concat().iter().all(|f| f.shape().corners() != Shape::Quad4);
        let tolerance = if exact { 1e-13 } else { 1e-11 };
        assert!(forces.values().all(|f| f.abs() < tolerance * sums.area), "{forces:?}");
    }
}

#[test]
fn polynomials_and_uniform_tractions_pass_any_pair_of_surfaces() {
    let mut seed = 0;
    for one in KINDS {
        for other in KINDS {
            for i in 0..2 {
                seed += 1;
                let (a, b) = RATIOS[(seed as usize / 2 + 2 * i) % 4];
                let secondary = rectangle(a, one, seed, true, 2.0);
                let primary = rectangle(b, other, seed + 1000, false, 2.0);
                let orders = [one.order(), other.order()];
                for transformed in [true, false] {
                    if transformed || !one.transformed() {
                        let to = Motion::random(seed);
                        check([&secondary, &primary], orders, transformed, &[], &to);
                    }
                }
            }
        }
    }
}

#[test]
fn they_pass_any_pair_of_lines() {
    for seed in 0..20_u64 {
        for (one, other) in [(1, 1), (1, 2), (2, 1), (2, 2)] {
            let [a, b] = [1 + seed as usize % 5, 1 + (7 * seed as usize) % 11];
            let secondary = interval(a, one, seed, true, 1.0);
            let primary = interval(b, other, seed + 1000, false, 1.0);
            let mut to = Motion::random(seed);
            let (sin, cos) = (seed as f64).sin_cos();
            to.axes = [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]];
            for transformed in [true, false] {
                check([&secondary, &primary], [one, other], transformed, &[], &to);
            }
            let ends = [secondary[0].nodes[1]];
            if a > 1 || one > 1 {
                check([&secondary, &primary], [one, other], true, &ends, &to);
            }
        }
    }
}

/// Edges of the rectangle, and the nodes next to a corner, without multipliers.
#[test]
fn they_pass_with_multipliers_dropped_on_edges_and_corners() {
    let left = |x: [f64; 2]| x[0] == 0.0;
    let two = |x: [f64; 2]| x[0] == 0.0 || x[1] == 1.0;
    let corner = |x: [f64; 2]| x == [2.0, 0.0];
    for (i, one) in KINDS.into_iter().enumerate() {
        for (j, other) in KINDS.into_iter().enumerate() {
            let seed = (6 * i + j) as u64;
            let secondary = rectangle([3, 3], one, seed, true, 2.0);
            let primary = rectangle([4, 2], other, seed + 1000, false, 2.0);
            for dropped in [left, two, corner] {
                let nodes: Vec<u64> = secondary
                    .iter()
                    .flat_map(|f| f.nodes.iter().zip(&f.points))
                    .filter(|(_, x)| dropped(**x))
                    .map(|(node, _)| *node)
                    .collect();
                assert!(!nodes.is_empty());
                let orders = [one.order(), other.order()];
                let to = Motion::random(seed);
                check([&secondary, &primary], orders, one.order() == 2, &nodes, &to);
            }
        }
    }
}

/// The rows of transformed edges hold their two corners; those of corners hold themselves only.
#[test]
fn rows_have_two_levels() {
    let secondary = rectangle([2, 2], Kind::Mixed(2), 3, true, 2.0);
    let corners: Vec<u64> =
        secondary.iter().flat_map(|f| &f.nodes[..f.shape.corners().nodes()]).copied().collect();
    let facets = lay(&secondary, &Motion::random(1));
    let primary = lay(&rectangle([3, 3], Kind::Mixed(1), 4, false, 2.0), &Motion::random(1));
    let mut edges = 0;
    for (node, row) in rows(&facets, &primary, true, |_| false).rows {
        let others: Vec<&u64> = row.here.keys().filter(|k| **k != node).collect();
        assert!(others.iter().all(|k| corners.contains(k)), "{node} {others:?}");
        match others.len() {
            0 => {}
            2 => {
                edges += 1;
                assert!((row.here[&node] / row.weight - 5.0 / 3.0).abs() < 1e-12);
            }
            _ => panic!("{node} {others:?}"),
        }
    }
    assert!(edges >= 12, "{edges}");
}

/// Lines that are not straight within the plane, and quadrilaterals that are not parallelograms.
#[test]
fn linear_fields_pass_curved_edges_within_a_plane() {
    let bend = |facets: Vec<Flat>, amount: f64| -> Vec<Flat> {
        let bent = |x: &[f64; 2]| {
            let bump = x[0] * (2.0 - x[0]) * x[1] * (1.0 - x[1]);
            [x[0] + amount * bump, x[1] - amount * bump]
        };
        let moved = |f: Flat| Flat { points: f.points.iter().map(bent).collect(), ..f };
        facets.into_iter().map(moved).collect()
    };
    for (seed, one) in KINDS.into_iter().enumerate() {
        for other in KINDS {
            let to = Motion::random(seed as u64);
            let secondary = bend(rectangle([3, 2], one, 5, true, 2.0), 0.2);
            let primary = bend(rectangle([4, 4], other, 6, false, 2.0), -0.15);
            let transformed = one.transformed();
            let sums = rows(&lay(&secondary, &to), &lay(&primary, &to), transformed, |_| false);
            let field = values([&secondary, &primary], |x| x[0] - 3.0 * x[1]);
            let jump = sums.largest_jump(&field);
            assert!(jump < 1e-12, "{one:?} {other:?} {jump:e}");
            assert!((sums.covered / sums.area - 1.0).abs() < 0.01, "{}", sums.covered);
        }
    }
}

#[test]
fn matching_facets_give_a_permutation_to_the_last_bit() {
    for (seed, kind) in KINDS.into_iter().enumerate() {
        let secondary = rectangle([4, 3], kind, seed as u64, true, 2.0);
        let mirrored = |f: &Flat| {
            let order = f.shape.mirrored();
            let nodes = order.iter().map(|a| f.nodes[*a] + 1000).collect();
            Flat { shape: f.shape, nodes, points: order.iter().map(|a| f.points[*a]).collect() }
        };
        let primary: Vec<Flat> = secondary.iter().map(mirrored).collect();
        let to = Motion::random(seed as u64);
        // A curved surface: both sides have the same nodes.
        let lift = |facets: &[Flat]| -> Vec<SpaceFacet> {
            let facet = |f: &Flat| {
                let at = |x: &[f64; 2]| to.of([x[0], x[1], 0.3 * x[0] * x[1] + 0.1 * x[1] * x[1]]);
                let points: Vec<[f64; 3]> = f.points.iter().map(at).collect();
                SpaceFacet::new(f.shape, &f.nodes, &points, &[0, 1, 2])
            };
            facets.iter().map(facet).collect()
        };
        let (here, there) = (lift(&secondary), lift(&primary));
        let all: Vec<&SpaceFacet> = there.iter().collect();
        for (facet, twin) in here.iter().zip(&there) {
            for mask in [0, 0b1, 0b11] {
                let masks = [mask; 3];
                let found = facet_rows_in_space(facet, Partners::Near(&all), &masks, true).unwrap();
                let order = facet.matching_nodes(twin).unwrap();
                let partners = Partners::Twin { facet: twin, order: &order };
                assert_eq!(facet_rows_in_space(facet, partners, &masks, true).unwrap(), found);
                assert_eq!(found.covered, found.area);
                for row in found.contributions {
                    let mut moved: Vec<(u64, f64)> =
                        row.secondary.iter().map(|&(k, c)| (k + 1000, c)).collect();
                    moved.sort_unstable_by_key(|&(node, _)| node);
                    assert_eq!(moved, row.primary);
                }
            }
        }
    }
}

/// A facet of a box in the plane z = 1.
fn lifted(f: &PlaneFacet) -> SpaceFacet {
    let points: Vec<[f64; 3]> = f.positions().iter().map(|x| [x[0], x[1], 1.0]).collect();
    SpaceFacet::new(f.shape(), f.nodes(), &points, &[0, 1, 2])
}

/// On rectangles, where both integrate exactly, the way of boxes and this one say the same.
#[test]
fn they_agree_with_the_rows_of_boxes() {
    for seed in 0..6 {
        // Seeds that differ by one run opposite ways round: the sides look at each other.
        let (one, other) = (grid([3, 4], seed, 0), grid([4, 3], seed + 1, 1000));
        agree_with_boxes(&second_order(one.clone(), 0), &second_order(other.clone(), 1000));
        agree_with_boxes(&one, &second_order(other.clone(), 1000));
        agree_with_boxes(&one, &other);
        let shifted = |f: &PlaneFacet| {
            let nodes: Vec<u64> = f.nodes().iter().map(|n| n + 1000).collect();
            PlaneFacet::new(f.shape(), &nodes, f.corners())
        };
        let one = second_order(one, 0);
        agree_with_boxes(&one, &one.iter().map(shifted).collect::<Vec<_>>());
    }
}

fn agree_with_boxes(one: &[PlaneFacet], other: &[PlaneFacet]) {
    let pairs = candidates(one, other);
    for (s, secondary) in one.iter().enumerate() {
        let near: Vec<&PlaneFacet> =
            pairs.iter().filter(|p| p.0 == s).map(|p| &other[p.1]).collect();
        let far: Vec<SpaceFacet> = near.iter().map(|f| lifted(f)).collect();
        let far: Vec<&SpaceFacet> = far.iter().collect();
        for mask in [0, 0b0011] {
            let boxes = facet_rows(secondary, &near, &[mask; 3]).unwrap();
            let partners = Partners::Near(&far);
            let space =
                facet_rows_in_space(&lifted(secondary), partners, &[mask; 3], false).unwrap();
            assert_eq!(boxes.len(), space.contributions.len());
            for (a, b) in boxes.iter().zip(&space.contributions) {
                assert_eq!((a.node, a.components), (b.node, b.components));
                assert!((a.weight - b.weight).abs() < 1e-14);
                // What only touches has coefficients of zero on one of the ways.
                let value = |side: &[(u64, f64)], node: u64| {
                    side.iter().find(|(k, _)| *k == node).map_or(0.0, |(_, c)| *c)
                };
                let sides = [(&a.secondary, &b.secondary), (&a.primary, &b.primary)];
                for (node, x, y) in sides.iter().flat_map(|(x, y)| {
                    x.iter().chain(*y).map(|(node, _)| (*node, value(x, *node), value(y, *node)))
                }) {
                    assert!((x - y).abs() < 1e-14, "{node}: {x:e} {y:e}");
                }
            }
        }
    }
}
