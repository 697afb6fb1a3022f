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

/// Newton's method for the reference coordinates of a point.
fn inverse<const DIM: usize>(
    shape: Shape,
    points: &[[f64; DIM]],
    point: [f64; DIM],
) -> Option<[f64; 3]> {
    let mut xi = shape.centroid();
    for _ in 0..MOST_STEPS {
        let (there, map) = (map_point(shape, points, xi), mapping(shape, points, xi));
        let mut largest = 0.0_f64;
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
    shape.contains(xi, OUTSIDE).then_some(xi)
}
