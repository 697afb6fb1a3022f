//! Where in a cell a point lies.

#![allow(clippy::needless_range_loop)] // index notation over several arrays at once

use super::LocalMesh;
use crate::element::{MAX_NODES, Shape, map_point, mapping};

/// Points this far outside of the reference cell are inside.
const OUTSIDE: f64 = 1e-9;
/// Newton's method needs fewer steps, or does not converge since the point is far away.
const MOST_STEPS: usize = 30;

impl LocalMesh {
    /// The reference coordinates of a point in a cell; none where it lies outside.
    pub(super) fn coordinates_in(&self, cell: usize, point: [f64; 3]) -> Option<[f64; 3]> {
        let nodes = self.cell_nodes(cell);
        let mut points = [[0.0; 3]; MAX_NODES];
        for (at, node) in points.iter_mut().zip(nodes) {
            *at = self.nodes.points[*node as usize];
        }
        let (points, axes) = (&points[..nodes.len()], self.facts.axes);
        for axis in 0..3 {
            let low = points.iter().fold(f64::INFINITY, |m, x| m.min(x[axis]));
            let high = points.iter().fold(f64::NEG_INFINITY, |m, x| m.max(x[axis]));
            // Curved cells reach beyond their nodes.
            let margin = 0.1 * (high - low) + OUTSIDE * high.abs().max(low.abs());
            if point[axis] < low - margin || point[axis] > high + margin {
                return None;
            }
        }
        let along = |x: &[f64; 3], c: usize| axes.get(c).map_or(0.0, |axis| x[*axis]);
        match axes.len() {
            2 => {
                let plane: Vec<[f64; 2]> =
                    points.iter().map(|x| [0, 1].map(|c| along(x, c))).collect();
                inverse(self.shape(cell), &plane, [0, 1].map(|c| along(&point, c)))
            }
            _ => inverse(self.shape(cell), points, point),
        }
    }
}

/// Steps of Newton's method below this may be rounding, where coordinates are large.
const SMALL: f64 = 1e-6;

/// The reference coordinates of a point, if it lies in the cell.
fn inverse<const DIM: usize>(
    shape: Shape,
    points: &[[f64; DIM]],
    point: [f64; DIM],
) -> Option<[f64; 3]> {
    // In a distorted cell the way from the middle may lead astray: then from the nodes.
    let starts = std::iter::once(shape.centroid()).chain(shape.node_points().iter().copied());
    let found = starts.filter_map(|start| root(shape, points, point, start)).next();
    found.filter(|xi| shape.contains(*xi, OUTSIDE))
}

/// Newton's method from a start; none where it does not converge.
fn root<const DIM: usize>(
    shape: Shape,
    points: &[[f64; DIM]],
    point: [f64; DIM],
    start: [f64; 3],
) -> Option<[f64; 3]> {
    let (mut xi, mut largest) = (start, f64::INFINITY);
    for _ in 0..MOST_STEPS {
        let (there, map) = (map_point(shape, points, xi), mapping(shape, points, xi));
        largest = 0.0_f64;
        for d in 0..DIM {
            let step: f64 = (0..DIM).map(|i| map.inverse[d][i] * (point[i] - there[i])).sum();
            xi[d] += step;
            largest = largest.max(step.abs());
        }
        if !largest.is_finite() {
            return None;
        }
        if largest < 1e-13 {
            break;
        }
    }
    (largest < SMALL).then_some(xi)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cells with corners moved about: a point that is found in one lies there, and those inside
    /// are found. Where Newton's method ends short of a root there is none.
    #[test]
    fn points_are_found_where_they_are() {
        let mut number = 1_u64;
        let mut any = || {
            number = number
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (number >> 33) as f64 / (1_u64 << 31) as f64 * 2.0 - 1.0
        };
        for _ in 0..300 {
            let shape = Shape::Hex8;
            let points: Vec<[f64; 3]> =
                shape.node_points().iter().map(|p| p.map(|x| x + 0.35 * any())).collect();
            let inside = [0.9 * any(), 0.9 * any(), 0.9 * any()];
            let at = map_point(shape, &points, inside);
            let valid = shape
                .node_points()
                .iter()
                .all(|xi| mapping(shape, &points, *xi).determinant > 0.05);
            if valid {
                let xi = inverse(shape, &points, at).expect("it is inside");
                let there = map_point(shape, &points, xi);
                assert!((0..3).all(|i| (there[i] - at[i]).abs() < 1e-12), "{there:?} {at:?}");
            }
            for _ in 0..20 {
                let far = [2.0 * any(), 2.0 * any(), 2.0 * any()];
                if let Some(xi) = inverse(shape, &points, far) {
                    let there = map_point(shape, &points, xi);
                    assert!((0..3).all(|i| (there[i] - far[i]).abs() < 1e-9), "{there:?} {far:?}");
                }
            }
        }
    }
}
