//! A facet anywhere in space.

use super::vector::{Vector, cross, difference, norm, unit};
use crate::element::{QuadraturePoint, Shape, gauss, map_point, quadrature};
use crate::interface::mortar::MOST_NODES;

/// A facet of one side of an interface: a line in a plane of the axes (2D), a triangle or a
/// quadrilateral in space, of first or second order, plane or curved.
///
/// Its nodes are in the order of [`Shape::facets`] of its cell, so that its normal points out of
/// the body: the right-hand rule over the corners; of a line from a to b, (b - a) turned clockwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpaceFacet {
    shape: Shape,
    nodes: [u64; MOST_NODES],
    points: [Vector; MOST_NODES],
    /// The direction that a line has in the place of a second tangent.
    across: Vector,
}

/// Nodes of a facet of second order this close to where its corners put them, relative to its size,
/// are there.
const STRAIGHT: f64 = 1e-9;

impl SpaceFacet {
    /// A facet: global identities of its nodes and their positions (m), in the order of the shape.
    ///
    /// # Arguments
    /// * `axes` the coordinate axes of the scene: only those of a line matter, which lies in the
    ///   plane of the first two
    ///
    /// # Panics
    /// If the shape is no line, triangle or quadrilateral, or there are not as many nodes, points
    /// or axes as it has.
    pub fn new(shape: Shape, nodes: &[u64], points: &[[f64; 3]], axes: &[usize]) -> Self {
        assert!(shape.dim() <= 2, "a {shape:?} is no facet");
        assert_eq!(nodes.len(), shape.nodes(), "nodes of a {shape:?}");
        assert_eq!(points.len(), shape.nodes(), "points of a {shape:?}");
        let axis = |d: usize| std::array::from_fn(|i| f64::from(u8::from(axes[d] == i)));
        let across = cross(axis(0), axis(1));
        let mut facet =
            Self { shape, nodes: [0; MOST_NODES], points: [[0.0; 3]; MOST_NODES], across };
        facet.nodes[..nodes.len()].copy_from_slice(nodes);
        facet.points[..points.len()].copy_from_slice(points);
        facet
    }

    /// A line, a triangle or a quadrilateral.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// Global identities of the nodes, in the order of the shape.
    pub fn nodes(&self) -> &[u64] {
        &self.nodes[..self.shape.nodes()]
    }

    /// Positions of the nodes, metres.
    pub fn points(&self) -> &[[f64; 3]] {
        &self.points[..self.shape.nodes()]
    }

    /// The point at reference coordinates, metres.
    pub fn point(&self, xi: [f64; 3]) -> [f64; 3] {
        map_point(self.shape, self.points(), xi)
    }

    /// The normal at a reference point, as long as the measure there: area (m2; of a line m) per
    /// unit of the reference facet.
    pub fn normal(&self, xi: [f64; 3]) -> [f64; 3] {
        let mut gradients = [[0.0; 3]; MOST_NODES];
        self.shape.gradients(xi, &mut gradients);
        let mut tangents = [[0.0; 3], self.across];
        for (d, tangent) in tangents.iter_mut().enumerate().take(self.shape.dim()) {
            *tangent = [0.0; 3];
            for (x, gradient) in self.points().iter().zip(gradients) {
                (0..3).for_each(|i| tangent[i] += gradient[d] * x[i]);
            }
        }
        cross(tangents[0], tangents[1])
    }

    /// A direction along a line, turned to its normal side.
    pub(super) fn turned(&self, along: [f64; 3]) -> [f64; 3] {
        cross(along, self.across)
    }

    /// The unit normal in the middle; none of a facet without area.
    pub fn middle_normal(&self) -> Option<[f64; 3]> {
        unit(self.normal(self.shape.centroid()))
    }

    /// Area, m2 (length, m, of a line), as [`SpaceFacet::rule`] integrates it.
    pub fn area(&self) -> f64 {
        self.rule().iter().map(|p| p.weight).sum()
    }

    /// Mean of the corners, metres.
    pub fn centre(&self) -> [f64; 3] {
        let corners = &self.points[..self.shape.corners().nodes()];
        let count = corners.len() as f64;
        std::array::from_fn(|d| corners.iter().map(|x| x[d]).sum::<f64>() / count)
    }

    /// Lower and upper corner of the bounding box of the nodes, metres.
    ///
    /// A curved facet may bulge out of it a little.
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        let mut out = [self.points[0]; 2];
        for x in self.points() {
            for d in 0..3 {
                out[0][d] = out[0][d].min(x[d]);
                out[1][d] = out[1][d].max(x[d]);
            }
        }
        out
    }

    /// The diagonal of the bounding box of the nodes, metres.
    pub fn size(&self) -> f64 {
        let [low, high] = self.bounds();
        norm(difference(high, low))
    }

    /// Whether every node beyond the corners lies where the corners put it.
    pub fn is_straight(&self) -> bool {
        let corners = self.shape.corners();
        let near = STRAIGHT * self.size();
        let places = self.shape.node_points().iter().zip(self.points()).skip(corners.nodes());
        places.into_iter().all(|(xi, x)| {
            let there = map_point(corners, &self.points[..corners.nodes()], *xi);
            norm(difference(*x, there)) <= near
        })
    }

    /// Whether all nodes lie in one plane.
    pub fn is_flat(&self) -> bool {
        let Some(normal) = self.middle_normal() else { return false };
        let (centre, near) = (self.centre(), STRAIGHT * self.size());
        let height = |x: &Vector| super::vector::dot(difference(*x, centre), normal).abs();
        self.points().iter().all(|x| height(x) <= near)
    }

    /// Points of integration with area weights, m2 (m). Products of two basis functions are
    /// integrated exactly on plane facets with straight edges (quadrilaterals: parallelograms, and
    /// any of first order); on curved ones nearly so.
    pub fn rule(&self) -> Vec<QuadraturePoint> {
        let order = self.shape.order();
        let more = usize::from(order > 1 && !self.is_straight());
        let rule = match self.shape.corners() {
            Shape::Tri3 => quadrature(self.shape, 2 * order + 4 * more),
            _ => gauss(self.shape, order + 1 + 2 * more),
        };
        let weighed = |p: QuadraturePoint| {
            let measure = norm(self.normal(p.xi));
            QuadraturePoint { weight: p.weight * measure, ..p }
        };
        rule.into_iter().map(weighed).collect()
    }

    /// If the facets coincide node by node: for each local node the local one of `other` at the
    /// same place.
    pub fn matching_nodes(&self, other: &SpaceFacet) -> Option<Vec<usize>> {
        if self.shape != other.shape {
            return None;
        }
        let near = STRAIGHT * self.size();
        let twin =
            |x: &Vector| other.points().iter().position(|y| norm(difference(*x, *y)) <= near);
        self.points().iter().map(twin).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_look_out_of_their_bodies_in_either_plane() {
        // The lower edge of a body in each plane, from left to right.
        for axes in [[0, 1], [0, 2]] {
            let mut points = [[0.0; 3]; 2];
            points[1][axes[0]] = 2.0;
            let normal = SpaceFacet::new(Shape::Line2, &[0, 1], &points, &axes).normal([0.0; 3]);
            let mut expected = [0.0; 3];
            expected[axes[1]] = -1.0;
            assert_eq!(normal, expected);
        }
    }

    #[test]
    fn areas_are_those_of_the_surface() {
        let cylinder = |angle: f64, z: f64| [angle.cos(), angle.sin(), z];
        let points: Vec<[f64; 3]> = Shape::Quad9
            .node_points()
            .iter()
            .map(|xi| cylinder(0.2 * xi[0], 0.5 * xi[1]))
            .collect();
        let facet =
            SpaceFacet::new(Shape::Quad9, &[0, 1, 2, 3, 4, 5, 6, 7, 8], &points, &[0, 1, 2]);
        // A parabola is shorter than its arc.
        assert!((facet.area() - 0.4).abs() < 2e-5, "{}", facet.area());
        assert!(!facet.is_straight() && !facet.is_flat());
        let normal = facet.middle_normal().unwrap();
        assert!((normal[0] - 1.0).abs() < 1e-14, "{normal:?}");
        let triangle = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let facet = SpaceFacet::new(Shape::Tri3, &[0, 1, 2], &triangle, &[0, 1, 2]);
        assert!((facet.area() - 0.75_f64.sqrt()).abs() < 1e-15);
        assert!(facet.is_flat() && facet.is_straight());
    }

    #[test]
    fn a_facet_matches_its_mirror_image_only() {
        let quad = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.2], [1.0, 1.0, 0.0], [0.0, 1.0, 0.1]];
        let facet = SpaceFacet::new(Shape::Quad4, &[0, 1, 2, 3], &quad, &[0, 1, 2]);
        let turned = [2, 1, 0, 3].map(|a| quad[a].map(|x| x + 1e-12));
        let twin = SpaceFacet::new(Shape::Quad4, &[4, 5, 6, 7], &turned, &[0, 1, 2]);
        assert_eq!(facet.matching_nodes(&twin).unwrap(), [2, 1, 0, 3]);
        let away = turned.map(|[x, y, z]| [x, y, z + 1e-6]);
        let other = SpaceFacet::new(Shape::Quad4, &[4, 5, 6, 7], &away, &[0, 1, 2]);
        assert!(facet.matching_nodes(&other).is_none());
    }
}
