//! What must not matter: where the scene is, its size, the names and the order of nodes.

use std::collections::BTreeMap;

use super::surfaces::*;
use crate::interface::mortar::SpaceFacet;

/// Both sides have the same coefficients up to `tolerance` times the weights, those of `b` divided
/// by `scale`; `name` gives the nodes of `a` their names in `b`.
fn compare(a: &Sums, b: &Sums, scale: f64, tolerance: f64, name: impl Fn(u64) -> u64) {
    assert_eq!(a.rows.len(), b.rows.len());
    for (node, row) in &a.rows {
        let other = &b.rows[&name(*node)];
        let near = |x: f64, y: f64| (x - y / scale).abs() < tolerance * row.weight;
        assert!(near(row.weight, other.weight), "{} {}", row.weight, other.weight / scale);
        for (here, there) in [(&row.here, &other.here), (&row.there, &other.there)] {
            let value = |side: &BTreeMap<u64, f64>, k: u64| side.get(&k).copied().unwrap_or(0.0);
            for k in here.keys() {
                let [x, y] = [value(here, *k), value(there, name(*k))];
                assert!(near(x, y), "{node} {k}: {x:e} {:e}", y / scale);
            }
            // What touches only may be missing on one side.
            let sum = |side: &BTreeMap<u64, f64>| side.values().map(|c| c.abs()).sum::<f64>();
            assert!(near(sum(here), sum(there)));
        }
    }
}

fn for_each_pair(mut visit: impl FnMut(Vec<Flat>, Vec<Flat>, bool, u64)) {
    for (i, one) in KINDS.into_iter().enumerate() {
        for (j, other) in KINDS.into_iter().enumerate() {
            let seed = (10 * i + j) as u64;
            let secondary = rectangle([3, 2], one, seed, true, 2.0);
            let primary = rectangle([2, 3], other, seed + 1000, false, 2.0);
            visit(secondary, primary, one.transformed(), seed);
        }
    }
}

#[test]
fn the_place_and_the_size_of_the_scene_do_not_matter() {
    for_each_pair(|one, other, transformed, seed| {
        let at = |to: &Motion| rows(&lay(&one, to), &lay(&other, to), transformed, |_| false);
        let plain = at(&Motion::NONE);
        for scale in [1e-6, 1.0, 1e6] {
            let to = Motion { scale, ..Motion::random(seed) };
            compare(&plain, &at(&to), scale * scale, 1e-10, |node| node);
        }
    });
}

#[test]
fn names_do_not_matter() {
    let name = |node: u64| (node * 7_919 + 13) % 1_000_003;
    for_each_pair(|one, other, transformed, seed| {
        let to = Motion::random(seed);
        let renamed = |side: &[Flat]| -> Vec<SpaceFacet> {
            let named =
                |f: &Flat| Flat { nodes: f.nodes.iter().map(|n| name(*n)).collect(), ..f.clone() };
            lay(&side.iter().map(named).collect::<Vec<_>>(), &to)
        };
        let a = rows(&lay(&one, &to), &lay(&other, &to), transformed, |_| false);
        let b = rows(&renamed(&one), &renamed(&other), transformed, |_| false);
        compare(&a, &b, 1.0, 1e-13, name);
    });
}

/// With which corner a facet begins, and in which order the facets come. Inverse bilinear maps are
/// no polynomials: there the rules are exact only to some digits.
#[test]
fn the_first_corner_and_the_order_of_facets_do_not_matter() {
    let turned = |f: &Flat| {
        let corners = f.shape.corners().nodes();
        let mut order: Vec<usize> = (0..f.shape.nodes()).collect();
        order[..corners].rotate_left(1);
        if f.shape.order() == 2 {
            order[corners..2 * corners].rotate_left(1);
        }
        Flat {
            shape: f.shape,
            nodes: order.iter().map(|a| f.nodes[*a]).collect(),
            points: order.iter().map(|a| f.points[*a]).collect(),
        }
    };
    for_each_pair(|one, other, transformed, seed| {
        let to = Motion::random(seed);
        let plain = rows(&lay(&one, &to), &lay(&other, &to), transformed, |_| false);
        let again = |side: &[Flat]| lay(&side.iter().rev().map(turned).collect::<Vec<_>>(), &to);
        let moved = rows(&again(&one), &again(&other), transformed, |_| false);
        let all = || one.iter().chain(&other);
        let only_triangles = all().all(|f| f.shape.corners().nodes() == 3);
        let tolerance = if only_triangles { 1e-12 } else { 1e-4 };
        compare(&plain, &moved, 1.0, tolerance, |node| node);
    });
}
