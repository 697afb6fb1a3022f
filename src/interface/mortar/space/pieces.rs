//! The flat pieces of a facet.

use super::facet::SpaceFacet;
use super::plane::Plane;
use super::vector::{Vector, cross, difference, unit};
use crate::element::Shape;

/// A piece of a facet, of first order: a line, a triangle or a quadrilateral that is nearly flat.
#[derive(Debug, Clone, Copy)]
pub struct Piece {
    shape: Shape,
    /// Where its corners are on the reference facet.
    reference: [[f64; 3]; 4],
    corners: [Vector; 4],
    normal: Vector,
}

impl Piece {
    /// The pieces of a facet: itself, or of curved ones of second order those between neighbouring
    /// nodes (two of a line, four of a triangle or quadrilateral). None of a facet without area.
    pub fn of(facet: &SpaceFacet) -> Option<Vec<Piece>> {
        let whole: &[&[usize]] = match facet.shape().corners() {
            Shape::Line2 => &[&[0, 1]],
            Shape::Tri3 => &[&[0, 1, 2]],
            _ => &[&[0, 1, 2, 3]],
        };
        let parts: &[&[usize]] = match facet.shape() {
            Shape::Line3 => &[&[0, 2], &[2, 1]],
            Shape::Tri6 => &[&[0, 3, 5], &[3, 1, 4], &[5, 4, 2], &[3, 4, 5]],
            Shape::Quad9 => &[&[0, 4, 8, 7], &[4, 1, 5, 8], &[8, 5, 2, 6], &[7, 8, 6, 3]],
            _ => whole,
        };
        let chosen = if facet.is_straight() { whole } else { parts };
        chosen.iter().map(|nodes| Piece::between(facet, nodes)).collect()
    }

    fn between(facet: &SpaceFacet, nodes: &[usize]) -> Option<Piece> {
        let (mut reference, mut corners) = ([[0.0; 3]; 4], [[0.0; 3]; 4]);
        for (i, node) in nodes.iter().enumerate() {
            reference[i] = facet.shape().node_points()[*node];
            corners[i] = facet.points()[*node];
        }
        let [a, b, c, d] = corners;
        let (shape, normal) = match nodes.len() {
            2 => (Shape::Line2, facet.turned(difference(b, a))),
            3 => (Shape::Tri3, cross(difference(b, a), difference(c, a))),
            _ => (Shape::Quad4, cross(difference(c, a), difference(d, b))),
        };
        Some(Piece { shape, reference, corners, normal: unit(normal)? })
    }

    /// The shape of first order.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// The corners, metres.
    pub fn corners(&self) -> &[Vector] {
        &self.corners[..self.shape.nodes()]
    }

    /// The unit normal: of a quadrilateral that is not flat, normal to both diagonals.
    pub fn normal(&self) -> Vector {
        self.normal
    }

    /// Its plane, through the mean of the corners.
    pub fn plane(&self) -> Option<Plane> {
        let corners = self.corners();
        let count = corners.len() as f64;
        let centre = std::array::from_fn(|d| corners.iter().map(|x| x[d]).sum::<f64>() / count);
        Plane::new(centre, self.normal, difference(corners[1], corners[0]))
    }

    /// Where the point at reference coordinates `s` of the piece is on the reference facet.
    pub fn on_facet(&self, s: [f64; 3]) -> [f64; 3] {
        let mut values = [0.0; 4];
        self.shape.values(s, &mut values);
        std::array::from_fn(|d| {
            self.reference.iter().zip(values).map(|(corner, value)| value * corner[d]).sum()
        })
    }

    /// Area of the reference facet per unit of the reference piece. Pieces and facets have the same
    /// reference triangle or square, and the pieces are parallel to it.
    pub fn reference_measure(&self) -> f64 {
        let [a, b, c, d] = self.reference;
        match self.shape {
            Shape::Line2 => 0.5 * (b[0] - a[0]).abs(),
            Shape::Tri3 => ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs(),
            _ => 0.125 * ((c[0] - a[0]) * (d[1] - b[1]) - (c[1] - a[1]) * (d[0] - b[0])).abs(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::map_point;

    fn curved(shape: Shape) -> SpaceFacet {
        let bent = |x: &[f64; 3]| [x[0], x[1], 0.3 * x[0] * x[0] + 0.1 * x[1] * x[1]];
        let points: Vec<Vector> = shape.node_points().iter().map(bent).collect();
        let nodes: Vec<u64> = (0..shape.nodes() as u64).collect();
        let axes: &[usize] = if shape.dim() == 1 { &[0, 2] } else { &[0, 1, 2] };
        SpaceFacet::new(shape, &nodes, &points, axes)
    }

    #[test]
    fn pieces_fill_the_reference_facet_and_run_its_way() {
        for (shape, count) in [(Shape::Line3, 2), (Shape::Tri6, 4), (Shape::Quad9, 4)] {
            let facet = curved(shape);
            let pieces = Piece::of(&facet).unwrap();
            assert_eq!(pieces.len(), count);
            let sum: f64 = pieces.iter().map(|p| p.reference_measure() * p.shape().volume()).sum();
            assert!((sum - shape.volume()).abs() < 1e-15, "{shape:?} {sum}");
            for piece in pieces {
                for (a, x) in piece.corners().iter().enumerate() {
                    let xi = piece.on_facet(piece.shape().node_points()[a]);
                    let there = facet.point(xi);
                    assert!((0..3).all(|d| (there[d] - x[d]).abs() < 1e-15));
                }
                let along = facet.normal(piece.on_facet(piece.shape().centroid()));
                let cosine = super::super::vector::dot(along, piece.normal());
                assert!(cosine > 0.9 * super::super::vector::norm(along), "{shape:?}");
            }
        }
    }

    #[test]
    fn straight_facets_are_one_piece() {
        for shape in [Shape::Line2, Shape::Tri3, Shape::Quad4] {
            assert_eq!(Piece::of(&curved(shape)).unwrap().len(), 1);
        }
        let corners = [[0.0, 0.0, 1.0], [1.0, 0.0, 2.0], [0.0, 3.0, 0.0]];
        let points: Vec<Vector> = Shape::Tri6
            .node_points()
            .iter()
            .map(|x| map_point(Shape::Tri3, &corners, *x))
            .collect();
        let facet = SpaceFacet::new(Shape::Tri6, &[0, 1, 2, 3, 4, 5], &points, &[0, 1, 2]);
        assert_eq!(Piece::of(&facet).unwrap().len(), 1);
        let flat = SpaceFacet::new(Shape::Line2, &[0, 1], &[[1.0; 3]; 2], &[0, 1]);
        assert!(Piece::of(&flat).is_none());
    }
}
