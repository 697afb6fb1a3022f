//! Sides that do not cover each other, thin bodies, and what is refused.

use std::collections::BTreeMap;

use super::surfaces::*;
use crate::element::Shape;
use crate::error::Error;
use crate::interface::mortar::{Partners, Share, SpaceFacet, facet_rows_in_space};

/// Only what lies across from the primary side has rows, with the weights of that part; what both
/// sides can represent makes no jump.
#[test]
fn rows_cover_what_the_other_side_covers() {
    for (i, one) in KINDS.into_iter().enumerate() {
        for (j, other) in KINDS.into_iter().enumerate() {
            let seed = (6 * i + j) as u64;
            let secondary = rectangle([5, 3], one, seed, true, 2.0);
            let primary = rectangle([4, 3], other, seed + 1000, false, 1.3);
            let to = Motion::random(seed);
            let (here, there) = (lay(&secondary, &to), lay(&primary, &to));
            let transformed = one.order() == 2;
            let sums = rows(&here, &there, transformed, |_| false);
            assert!((sums.covered - 1.3).abs() < 1e-9, "{}", sums.covered);
            assert!((sums.area - 2.0).abs() < 1e-9);
            let weights: f64 = sums.rows.values().map(|row| row.weight).sum();
            assert!((weights - 1.3).abs() < 1e-9, "{weights}");
            let field = values([&secondary, &primary], |x| x[0] - 2.0 * x[1]);
            for (node, row) in &sums.rows {
                let sum =
                    |side: &BTreeMap<u64, f64>| side.iter().map(|(k, c)| c * field[k]).sum::<f64>();
                let size: f64 = row.there.values().map(|c| c.abs()).sum();
                assert!((sum(&row.here) - sum(&row.there)).abs() < 1e-10 * size, "{node}");
            }
            for facet in secondary.iter().filter(|f| f.points.iter().all(|x| x[0] > 1.3)) {
                let inside = |node: &&u64| {
                    secondary
                        .iter()
                        .all(|f| !f.nodes.contains(node) || f.points.iter().all(|x| x[0] > 1.3))
                };
                assert!(facet.nodes.iter().filter(inside).all(|n| !sums.rows.contains_key(n)));
            }
        }
    }
}

/// The nodes of one side whose functions are hardly covered.
fn too_small(here: &[SpaceFacet], there: &[SpaceFacet], order: usize) -> Vec<u64> {
    let near: Vec<&SpaceFacet> = there.iter().collect();
    let mut sums: BTreeMap<u64, Share> = BTreeMap::new();
    for facet in here {
        let found = facet_rows_in_space(facet, Partners::Near(&near), &[], order == 2).unwrap();
        assert!(found.contributions.is_empty());
        for share in found.shares {
            let none = Share { covered: 0.0, whole: 0.0, ..share };
            let sum = sums.entry(share.node).or_insert(none);
            sum.covered += share.covered;
            sum.whole += share.whole;
        }
    }
    sums.into_values().filter(|s| s.is_too_small(order)).map(|s| s.node).collect()
}

/// With the nodes dropped that are hardly covered, all others have weights, whatever part of the
/// facets at the border is covered.
#[test]
fn two_passes_give_rows_with_weights() {
    for (i, one) in KINDS.into_iter().enumerate() {
        for (j, right) in [0.61, 1.001, 1.3, 1.27, 1.43, 0.9].into_iter().enumerate() {
            let seed = (4 * i + j) as u64;
            let secondary = rectangle([4, 2], one, seed, true, 2.0);
            let primary = rectangle([2, 3], KINDS[(i + j) % 6], seed + 1000, false, right);
            let to = Motion::random(seed);
            let (here, there) = (lay(&secondary, &to), lay(&primary, &to));
            let transformed = one.order() == 2;
            let small = too_small(&here, &there, one.order());
            let sums = rows(&here, &there, transformed, |node| small.contains(&node));
            assert!((sums.covered - right).abs() < 1e-2, "{}", sums.covered);
            let smallest = sums.rows.values().map(|row| row.weight).fold(1.0, f64::min);
            assert!(smallest > 1e-4, "{one:?} {right}: {smallest:e}");
            let jump = sums.largest_jump(&values([&secondary, &primary], |x| x[0] - 2.0 * x[1]));
            assert!(jump < 1e-9, "{one:?} {right}: {jump:e}");
        }
    }
}

#[test]
fn shares_tell_which_nodes_carry_nothing() {
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let facet = SpaceFacet::new(Shape::Quad4, &[0, 1, 2, 3], &square, &[0, 1, 2]);
    // Its image seen from above, a part of which is left of x = 0.01.
    let strip = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.01, 1.0, 0.0], [0.01, 0.0, 0.0]];
    let other = SpaceFacet::new(Shape::Quad4, &[4, 5, 6, 7], &strip, &[0, 1, 2]);
    let found = facet_rows_in_space(&facet, Partners::Near(&[&other]), &[0; 3], false).unwrap();
    assert!((found.covered - 0.01).abs() < 1e-15 && (found.area - 1.0).abs() < 1e-15);
    let small: Vec<bool> = found.shares.iter().map(|s| s.is_too_small(1)).collect();
    assert_eq!(small, [false, true, true, false]);
    let nothing = facet_rows_in_space(&facet, Partners::Near(&[]), &[0; 3], false).unwrap();
    assert!(nothing.contributions.is_empty() && nothing.covered == 0.0);
    assert!(nothing.shares.iter().all(|s| s.is_too_small(1)));
}

fn layer(z: f64, up: bool, first: u64) -> SpaceFacet {
    let mut points = [[-1.0, -1.0, z], [2.0, -1.0, z], [2.0, 2.0, z], [-1.0, 2.0, z]];
    if !up {
        points.reverse();
    }
    SpaceFacet::new(Shape::Quad4, &[first, first + 1, first + 2, first + 3], &points, &[0, 1, 2])
}

/// A stack of thin layers: each sees the one next to it and none of the sides turned away.
#[test]
fn thin_bodies_hide_what_is_behind_them() {
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let facet = SpaceFacet::new(Shape::Quad4, &[0, 1, 2, 3], &square, &[0, 1, 2]);
    let [bottom, top] = [layer(0.0, false, 10), layer(0.2, true, 20)];
    let [next, away] = [layer(0.2, false, 30), layer(9.0, false, 40)];
    for near in [vec![&bottom, &top, &next, &away], vec![&away, &next, &top, &bottom]] {
        let found = facet_rows_in_space(&facet, Partners::Near(&near), &[0; 3], false).unwrap();
        assert!((found.covered - 1.0).abs() < 1e-14);
        for row in &found.contributions {
            assert!(row.primary.iter().all(|(node, _)| (10..14).contains(node)), "{row:?}");
        }
    }
    let found = facet_rows_in_space(&facet, Partners::Near(&[&top, &away]), &[0; 3], false);
    assert_eq!(found.unwrap().covered, 0.0);
}

#[test]
fn what_cannot_be_is_refused_with_its_place() {
    let facet = layer(0.0, true, 0);
    let (one, two) = (layer(0.0, false, 10), layer(1e-3, false, 20));
    // The first would be a twin if it had the same corners.
    let wide = |facet: &SpaceFacet, first: u64| {
        let points: Vec<[f64; 3]> =
            facet.points().iter().map(|[x, y, z]| [x + 0.5, y + 0.5, *z]).collect();
        let nodes = [first, first + 1, first + 2, first + 3];
        SpaceFacet::new(Shape::Quad4, &nodes, &points, &[0, 1, 2])
    };
    let (one, two) = (wide(&one, 10), wide(&two, 20));
    let small = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let small = SpaceFacet::new(Shape::Tri3, &[0, 1, 2], &small, &[0, 1, 2]);
    let Err(Error::Input(message)) =
        facet_rows_in_space(&small, Partners::Near(&[&one, &two]), &[0; 3], false)
    else {
        panic!("accepted");
    };
    assert!(message.contains("overlaps itself"), "{message}");
    assert!(message.contains("(0.333333, 0.333333, 0.000000) m"), "{message}");
    assert!(message.contains("200.000000 %"), "{message}");
    let point = SpaceFacet::new(Shape::Line2, &[0, 1], &[[1.0; 3]; 2], &[0, 1]);
    let refused = facet_rows_in_space(&point, Partners::Near(&[]), &[0; 2], false);
    assert!(matches!(refused, Err(Error::Input(_))));
    let points: Vec<[f64; 3]> = Shape::Tri6.node_points().to_vec();
    let curved = SpaceFacet::new(Shape::Tri6, &[0, 1, 2, 3, 4, 5], &points, &[0, 1, 2]);
    let refused = facet_rows_in_space(&curved, Partners::Near(&[&facet]), &[0; 3], false);
    assert!(matches!(refused, Err(Error::Bug(_))));
}
