//! A cylinder between two meshes that do not match: the orders with which the jump of a smooth
//! field vanishes.

#![allow(clippy::print_stdout)] // the orders, with --nocapture

use std::collections::BTreeMap;

use super::surfaces::*;
use crate::element::Shape;
use crate::interface::mortar::SpaceFacet;

/// The rectangle wound on a quarter of the cylinder of radius 1, of height 1.
fn wind(x: [f64; 2]) -> [f64; 3] {
    let (sin, cos) = (0.25 * std::f64::consts::PI * x[0]).sin_cos();
    [cos, sin, x[1]]
}

fn wound(flat: &[Flat], to: &Motion, axes: &[usize]) -> Vec<SpaceFacet> {
    let facet = |f: &Flat| {
        let points: Vec<[f64; 3]> = f.points.iter().map(|x| to.of(wind(*x))).collect();
        SpaceFacet::new(f.shape, &f.nodes, &points, axes)
    };
    flat.iter().map(facet).collect()
}

fn smooth(x: [f64; 2]) -> f64 {
    let [x, y, z] = wind(x);
    (1.3 * x - 0.7 * y + 0.4 * z).sin()
}

/// The root of the weighted mean of the squares of the jumps, and the part that is covered.
fn error(flat: [&[Flat]; 2], transformed: bool, axes: &[usize], to: &Motion) -> [f64; 2] {
    let [secondary, primary] = flat.map(|side| wound(side, to, axes));
    let sums = rows(&secondary, &primary, transformed, |_| false);
    let field = values(flat, smooth);
    let sum = |side: &BTreeMap<u64, f64>| side.iter().map(|(k, c)| c * field[k]).sum::<f64>();
    let square = |row: &Row| (sum(&row.here) - sum(&row.there)).powi(2) / row.weight;
    let squares: f64 = sums.rows.values().map(square).sum();
    let weights: f64 = sums.rows.values().map(|row| row.weight).sum();
    [(squares / weights).sqrt(), sums.covered / sums.area]
}

fn order_of(errors: [[f64; 2]; 2]) -> f64 {
    (errors[0][0] / errors[1][0]).log2()
}

#[test]
fn jumps_on_a_cylinder_vanish_with_the_order_of_the_facets() {
    for kind in KINDS.into_iter().filter(|kind| *kind != Kind::Mixed(1)) {
        let at = |n: usize| {
            let secondary = rectangle([2 * n, n], kind, 3, true, 2.0);
            let primary = rectangle([2 * n + 1, n + 1], kind, 4, false, 2.0);
            let to = Motion::random(5);
            error([&secondary, &primary], kind.order() == 2, &[0, 1, 2], &to)
        };
        let errors = [at(3), at(6)];
        let order = order_of(errors);
        println!("{kind:?}: {errors:?}, order {order:.2}");
        assert!(order > kind.order() as f64 + 0.5, "{kind:?}: order {order:.2} {errors:?}");
        for [_, covered] in errors {
            assert!((covered - 1.0).abs() < 1e-2, "{kind:?}: {covered}");
        }
    }
}

#[test]
fn jumps_on_a_circle_vanish_with_the_order_of_the_lines() {
    for shape in [Shape::Line2, Shape::Line3] {
        let at = |n: usize| {
            let secondary = interval(2 * n, shape.order(), 3, true, 2.0);
            let primary = interval(3 * n, shape.order(), 4, false, 2.0);
            error([&secondary, &primary], false, &[0, 1], &Motion::NONE)
        };
        let errors = [at(8), at(16)];
        let order = order_of(errors);
        println!("{shape:?}: {errors:?}, order {order:.2}");
        assert!(order > shape.order() as f64 + 0.5, "{shape:?}: order {order:.2} {errors:?}");
    }
}
