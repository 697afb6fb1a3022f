//! A facet of one side, seen in the plane of the interface.

use crate::element::{MAX_NODES, QuadraturePoint, Shape, gauss};

/// A facet in the plane of the interface: a convex quadrilateral (3D) or a segment (2D).
///
/// Quadrilaterals may run either way round: the two sides look at each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneFacet {
    shape: Shape,
    nodes: [u64; 4],
    positions: [[f64; 2]; 4],
}

impl PlaneFacet {
    /// The facet of a 2D mesh: global node identities and coordinates along the interface, metres.
    pub fn line(nodes: [u64; 2], along: [f64; 2]) -> Self {
        PlaneFacet {
            shape: Shape::Line2,
            nodes: [nodes[0], nodes[1], 0, 0],
            positions: [[along[0], 0.0], [along[1], 0.0], [0.0; 2], [0.0; 2]],
        }
    }

    /// The facet of a 3D mesh: global node identities and positions in the plane of the interface,
    /// metres, around the facet either way.
    pub fn quad(nodes: [u64; 4], positions: [[f64; 2]; 4]) -> Self {
        PlaneFacet { shape: Shape::Quad4, nodes, positions }
    }

    /// `Line2` or `Quad4`.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// Global identities of the nodes, in the order of the shape.
    pub fn nodes(&self) -> &[u64] {
        &self.nodes[..self.shape.nodes()]
    }

    /// Positions of the nodes in the plane, metres; the second coordinate is zero for a line.
    pub fn positions(&self) -> &[[f64; 2]] {
        &self.positions[..self.shape.nodes()]
    }

    /// Area, m2 (length, m, for a line); never negative.
    pub fn area(&self) -> f64 {
        self.signed_area().abs()
    }

    /// Positive if the nodes run counter-clockwise (for a line: rightwards).
    pub(super) fn signed_area(&self) -> f64 {
        let [a, b, c, d] = self.positions;
        match self.shape {
            Shape::Line2 => b[0] - a[0],
            _ => 0.5 * ((c[0] - a[0]) * (d[1] - b[1]) - (c[1] - a[1]) * (d[0] - b[0])),
        }
    }

    /// Mean of the node positions, metres.
    pub fn centre(&self) -> [f64; 2] {
        let count = self.positions().len() as f64;
        std::array::from_fn(|d| self.positions().iter().map(|x| x[d]).sum::<f64>() / count)
    }

    /// Lower and upper corner of the bounding box, metres.
    pub fn bounds(&self) -> [[f64; 2]; 2] {
        let mut out = [self.positions[0]; 2];
        for x in self.positions() {
            for d in 0..2 {
                out[0][d] = out[0][d].min(x[d]);
                out[1][d] = out[1][d].max(x[d]);
            }
        }
        out
    }

    /// The larger side of the bounding box, metres.
    pub fn size(&self) -> f64 {
        let [low, high] = self.bounds();
        (high[0] - low[0]).max(high[1] - low[1])
    }

    /// The Gauss points of the facet with area weights, m2: products of two basis functions are
    /// integrated exactly.
    pub fn points(&self) -> Vec<QuadraturePoint> {
        gauss(self.shape, 2)
            .into_iter()
            .map(|p| QuadraturePoint { weight: p.weight * self.jacobian(p.xi).1.abs(), ..p })
            .collect()
    }

    /// The same facet with `origin` moved to zero: differences of nearby coordinates lose nothing.
    pub(super) fn relative_to(&self, origin: [f64; 2]) -> Self {
        let shift = |x: [f64; 2]| [x[0] - origin[0], x[1] - origin[1]];
        PlaneFacet { positions: self.positions.map(shift), ..*self }
    }

    /// Reference coordinates of a point of the plane: exact after one correction for segments and
    /// parallelograms, by Newton's method for other convex quadrilaterals.
    pub(super) fn locate(&self, point: [f64; 2]) -> [f64; 3] {
        let mut xi = [0.0; 3];
        let mut values = [0.0; MAX_NODES];
        for _ in 0..30 {
            self.shape.values(xi, &mut values);
            let mut miss = point;
            for (x, value) in self.positions().iter().zip(values) {
                miss[0] -= value * x[0];
                miss[1] -= value * x[1];
            }
            let ([[a, b], [c, d]], determinant) = self.jacobian(xi);
            let step = match self.shape {
                Shape::Line2 => [miss[0] / determinant, 0.0],
                _ => [
                    (d * miss[0] - b * miss[1]) / determinant,
                    (a * miss[1] - c * miss[0]) / determinant,
                ],
            };
            xi[0] += step[0];
            xi[1] += step[1];
            if step[0].abs().max(step[1].abs()) <= 4.0 * f64::EPSILON {
                break;
            }
        }
        xi
    }

    /// Jacobian dx_i/dxi_d and its (signed) determinant.
    fn jacobian(&self, xi: [f64; 3]) -> ([[f64; 2]; 2], f64) {
        let mut gradients = [[0.0; 3]; MAX_NODES];
        self.shape.gradients(xi, &mut gradients);
        let mut j = [[0.0; 2]; 2];
        for (x, gradient) in self.positions().iter().zip(gradients) {
            for i in 0..2 {
                for d in 0..2 {
                    j[i][d] += x[i] * gradient[d];
                }
            }
        }
        match self.shape {
            Shape::Line2 => (j, j[0][0]),
            _ => (j, j[0][0] * j[1][1] - j[0][1] * j[1][0]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::map_point;

    #[test]
    fn points_are_located_in_distorted_and_clockwise_facets() {
        let mut positions = [[0.0, 0.0], [2.0, 0.1], [1.7, 1.4], [-0.2, 1.0]];
        for _ in 0..2 {
            let facet = PlaneFacet::quad([0, 1, 2, 3], positions);
            for xi in [[0.3, -0.8, 0.0], [-1.0, 1.0, 0.0], [0.99, 0.5, 0.0]] {
                let point = map_point(Shape::Quad4, &positions, xi);
                let found = facet.locate(point);
                assert!((found[0] - xi[0]).abs() < 1e-14 && (found[1] - xi[1]).abs() < 1e-14);
            }
            let area: f64 = facet.points().iter().map(|p| p.weight).sum();
            assert!((area - facet.area()).abs() < 1e-15 * 10.0);
            positions.reverse();
        }
        let line = PlaneFacet::line([0, 1], [3.0, 1.0]);
        assert!((line.locate([1.5, 0.0])[0] - 0.5).abs() < 1e-15);
        assert_eq!(line.area(), 2.0);
    }
}
