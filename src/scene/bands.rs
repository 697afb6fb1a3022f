//! Facets cut into bands of a quantity.

use crate::element::Shape;

use super::drawing::Place;
use super::levels::Levels;

/// A corner of an area with the value there.
pub(crate) type Corner = (Place, f64);

/// The bands of a facet with these points and values, in the order of its shape: the quantity runs
/// straight in the triangles between them.
pub(crate) fn bands(shape: Shape, nodes: &[Corner], levels: &Levels) -> Vec<(usize, Vec<Place>)> {
    let mut found: Vec<(usize, Vec<Place>)> = Vec::new();
    for triangle in triangles(shape, nodes) {
        let of = |pick: fn(f64, f64) -> f64| triangle.iter().map(|c| c.1).reduce(pick);
        let (Some(low), Some(high)) = (of(f64::min), of(f64::max)) else { continue };
        for band in levels.band(low)..=levels.band(high) {
            let [from, to] = levels.range(band);
            let above = cut(&triangle, |value| value - from);
            let part = cut(&above, |value| to - value);
            if part.len() >= 3 {
                found.push((band, part.into_iter().map(|(place, _)| place).collect()));
            }
        }
    }
    // What has one colour is drawn at once, so that no seam is seen between triangles.
    found.sort_by_key(|(band, _)| *band);
    found
}

/// The part of an area that is nearest to each of its corners, with the value there.
pub(crate) fn shares(ring: &[Corner]) -> Vec<(f64, Vec<Place>)> {
    let share = 1.0 / ring.len().max(1) as f64;
    let middle = [0, 1].map(|c| share * ring.iter().map(|corner| corner.0[c]).sum::<f64>());
    let half = |a: Place, b: Place| [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    let part = |i: usize| {
        let (here, value) = ring[i];
        let [last, next] = [ring.len() - 1, 1].map(|step| ring[(i + step) % ring.len()].0);
        (value, vec![here, half(here, next), middle, half(last, here)])
    };
    (0..ring.len()).map(part).collect()
}

/// The triangles of a facet.
fn triangles(shape: Shape, nodes: &[Corner]) -> Vec<[Corner; 3]> {
    let around = |ring: &[usize], middle: Corner| -> Vec<[Corner; 3]> {
        let next = ring.iter().cycle().skip(1);
        ring.iter().zip(next).map(|(a, b)| [nodes[*a], nodes[*b], middle]).collect()
    };
    match shape {
        Shape::Tri3 => vec![[nodes[0], nodes[1], nodes[2]]],
        Shape::Tri6 => [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]
            .map(|corners| corners.map(|i| nodes[i]))
            .to_vec(),
        Shape::Quad9 => around(&[0, 4, 1, 5, 2, 6, 3, 7], nodes[8]),
        Shape::Quad4 => {
            let mean = |of: &dyn Fn(&Corner) -> f64| 0.25 * nodes.iter().map(of).sum::<f64>();
            let middle = [mean(&|c| c.0[0]), mean(&|c| c.0[1])];
            around(&[0, 1, 2, 3], (middle, mean(&|c| c.1)))
        }
        _ => Vec::new(),
    }
}

/// The part of a convex area in which `inside` is not negative.
fn cut(area: &[Corner], inside: impl Fn(f64) -> f64) -> Vec<Corner> {
    let mut left = Vec::with_capacity(area.len() + 1);
    for (i, to) in area.iter().enumerate() {
        let from = area[(i + area.len() - 1) % area.len()];
        let [a, b] = [inside(from.1), inside(to.1)];
        if (a < 0.0) != (b < 0.0) {
            let share = a / (a - b);
            let mix = |x: f64, y: f64| x + share * (y - x);
            let place = [mix(from.0[0], to.0[0]), mix(from.0[1], to.0[1])];
            left.push((place, mix(from.1, to.1)));
        }
        if b >= 0.0 {
            left.push(*to);
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(points: &[Place]) -> f64 {
        let next = points.iter().cycle().skip(1);
        0.5 * points.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
    }

    #[test]
    fn every_corner_has_its_share() {
        let ring = [([0.0, 0.0], 1.0), ([4.0, 0.0], 2.0), ([4.0, 2.0], 3.0), ([0.0, 2.0], 4.0)];
        let parts = shares(&ring);
        assert!(parts.iter().all(|(_, part)| area(part) == 2.0), "{parts:?}");
        assert_eq!(parts.iter().map(|part| part.0).sum::<f64>(), 10.0);
    }

    #[test]
    fn bands_cover_their_facet_once() {
        for shape in [Shape::Tri3, Shape::Tri6, Shape::Quad4, Shape::Quad9] {
            let value = |p: [f64; 3]| 3.0 * p[0] - p[1];
            let nodes: Vec<Corner> =
                shape.node_points().iter().map(|p| ([p[0], p[1]], value(*p))).collect();
            let levels = Levels::over(nodes.iter().map(|n| n.1), "", false);
            let parts = bands(shape, &nodes, &levels);
            let whole: f64 = parts.iter().map(|(_, part)| area(part)).sum();
            assert!((whole - shape.volume()).abs() < 1e-12, "{shape:?}: {whole}");
            for (band, part) in &parts {
                let [low, high] = levels.range(*band);
                for [x, y] in part {
                    let value = value([*x, *y, 0.0]);
                    assert!(low - 1e-12 <= value && value <= high + 1e-12, "{shape:?}");
                }
            }
            let used: std::collections::BTreeSet<usize> = parts.iter().map(|p| p.0).collect();
            assert_eq!(used.len(), levels.count(), "{shape:?}");
        }
    }
}
