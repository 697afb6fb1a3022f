//! A facet of one side, seen in the plane of the interface.

use super::MOST_NODES;
use crate::element::{QuadraturePoint, Shape, gauss};

/// A facet in the plane of the interface: a convex quadrilateral (3D) or a segment (2D), of first
/// or second order. Its edges are straight: the nodes beyond the corners lie where the corners put
/// them.
///
/// Quadrilaterals may run either way round: the two sides look at each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneFacet {
    shape: Shape,
    nodes: [u64; MOST_NODES],
    corners: [[f64; 2]; 4],
}

impl PlaneFacet {
    /// A facet of a 2D (line) or 3D (quadrilateral) mesh: global node identities in the order of
    /// the shape, and the positions of its corners in the plane of the interface, metres; the
    /// second coordinate of a line is zero.
    ///
    /// # Panics
    /// If the shape is no line or quadrilateral (triangles are [`super::SpaceFacet`]s), or there
    /// are not as many nodes and corners as it has.
    pub fn new(shape: Shape, nodes: &[u64], corners: &[[f64; 2]]) -> Self {
        assert!(matches!(shape.corners(), Shape::Line2 | Shape::Quad4), "a {shape:?} of a box");
        assert_eq!(nodes.len(), shape.nodes(), "nodes of a {shape:?}");
        let mut facet = Self { shape, nodes: [0; MOST_NODES], corners: [[0.0; 2]; 4] };
        facet.nodes[..nodes.len()].copy_from_slice(nodes);
        facet.corners[..shape.corners().nodes()].copy_from_slice(corners);
        facet
    }

    /// The facet of first order of a 2D mesh.
    #[cfg(test)]
    pub fn line(nodes: [u64; 2], along: [f64; 2]) -> Self {
        Self::new(Shape::Line2, &nodes, &along.map(|x| [x, 0.0]))
    }

    /// The facet of first order of a 3D mesh; nodes around it either way.
    #[cfg(test)]
    pub fn quad(nodes: [u64; 4], corners: [[f64; 2]; 4]) -> Self {
        Self::new(Shape::Quad4, &nodes, &corners)
    }

    /// A line or a quadrilateral.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// Global identities of the nodes, in the order of the shape.
    pub fn nodes(&self) -> &[u64] {
        &self.nodes[..self.shape.nodes()]
    }

    /// Positions of the corners in the plane, metres; the second coordinate is zero for a line.
    pub fn corners(&self) -> &[[f64; 2]] {
        &self.corners[..self.shape.corners().nodes()]
    }

    /// Positions of all nodes in the plane, metres.
    pub fn positions(&self) -> Vec<[f64; 2]> {
        self.shape.node_points().iter().map(|xi| self.point(*xi)).collect()
    }

    /// The point of the plane at reference coordinates.
    fn point(&self, xi: [f64; 3]) -> [f64; 2] {
        let mut values = [0.0; 4];
        self.shape.corners().values(xi, &mut values);
        let mut x = [0.0; 2];
        for (corner, value) in self.corners().iter().zip(values) {
            x[0] += value * corner[0];
            x[1] += value * corner[1];
        }
        x
    }

    /// Area, m2 (length, m, for a line); never negative.
    pub fn area(&self) -> f64 {
        self.signed_area().abs()
    }

    /// Positive if the nodes run counter-clockwise (for a line: rightwards).
    pub(super) fn signed_area(&self) -> f64 {
        let [a, b, c, d] = self.corners;
        match self.shape {
            Shape::Line2 | Shape::Line3 => b[0] - a[0],
            _ => 0.5 * ((c[0] - a[0]) * (d[1] - b[1]) - (c[1] - a[1]) * (d[0] - b[0])),
        }
    }

    /// Mean of the corners, metres.
    pub fn centre(&self) -> [f64; 2] {
        let count = self.corners().len() as f64;
        std::array::from_fn(|d| self.corners().iter().map(|x| x[d]).sum::<f64>() / count)
    }

    /// Lower and upper corner of the bounding box, metres.
    pub fn bounds(&self) -> [[f64; 2]; 2] {
        let mut out = [self.corners[0]; 2];
        for x in self.corners() {
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
        gauss(self.shape, self.shape.order() + 1)
            .into_iter()
            .map(|p| QuadraturePoint { weight: p.weight * self.jacobian(p.xi).1.abs(), ..p })
            .collect()
    }

    /// The same facet with `origin` moved to zero: differences of nearby coordinates lose nothing.
    pub(super) fn relative_to(&self, origin: [f64; 2]) -> Self {
        let shift = |x: [f64; 2]| [x[0] - origin[0], x[1] - origin[1]];
        PlaneFacet { corners: self.corners.map(shift), ..*self }
    }

    /// Reference coordinates of a point of the plane: exact after one correction for segments and
    /// parallelograms, by Newton's method for other convex quadrilaterals.
    pub(super) fn locate(&self, point: [f64; 2]) -> [f64; 3] {
        let mut xi = [0.0; 3];
        for _ in 0..30 {
            let there = self.point(xi);
            let miss = [point[0] - there[0], point[1] - there[1]];
            let ([[a, b], [c, d]], determinant) = self.jacobian(xi);
            let step = match self.shape {
                Shape::Line2 | Shape::Line3 => [miss[0] / determinant, 0.0],
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
        let mut gradients = [[0.0; 3]; 4];
        self.shape.corners().gradients(xi, &mut gradients);
        let mut j = [[0.0; 2]; 2];
        for (x, gradient) in self.corners().iter().zip(gradients) {
            for i in 0..2 {
                for d in 0..2 {
                    j[i][d] += x[i] * gradient[d];
                }
            }
        }
        match self.shape {
            Shape::Line2 | Shape::Line3 => (j, j[0][0]),
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

    #[test]
    #[should_panic(expected = "a Tri3 of a box")]
    fn triangles_are_refused() {
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        PlaneFacet::new(Shape::Tri3, &[0, 1, 2], &corners);
    }
}
