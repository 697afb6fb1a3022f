//! A plane in space, and facets seen in it.

use super::facet::SpaceFacet;
use super::vector::{Vector, cross, difference, dot, unit};
use crate::element::Shape;
use crate::interface::mortar::MOST_NODES;

/// A plane with two axes of its own.
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    origin: Vector,
    axes: [Vector; 2],
    normal: Vector,
}

impl Plane {
    /// The plane through `origin` with this unit `normal`, the first axis as near to `along` as can
    /// be; none if that is normal to it.
    pub fn new(origin: Vector, normal: Vector, along: Vector) -> Option<Self> {
        let height = dot(along, normal);
        let first = unit(std::array::from_fn(|d| along[d] - height * normal[d]))?;
        Some(Plane { origin, axes: [first, cross(normal, first)], normal })
    }

    /// The unit normal.
    pub fn normal(&self) -> Vector {
        self.normal
    }

    /// Coordinates of the foot of a point in the plane, metres.
    pub fn foot(&self, x: Vector) -> [f64; 2] {
        self.axes.map(|axis| dot(difference(x, self.origin), axis))
    }

    /// The point of the plane with these coordinates, metres.
    pub fn point(&self, x: [f64; 2]) -> Vector {
        let [u, v] = self.axes;
        std::array::from_fn(|d| self.origin[d] + x[0] * u[d] + x[1] * v[d])
    }

    /// The facet as it is seen along the normal.
    pub fn shadow_of(&self, facet: &SpaceFacet) -> Shadow {
        self.shadow(facet.shape(), facet.points())
    }

    /// The facet of this shape with these nodes as it is seen along the normal.
    pub fn shadow(&self, shape: Shape, points: &[Vector]) -> Shadow {
        let mut shadow = Shadow { shape, points: [[0.0; 2]; MOST_NODES] };
        for (foot, x) in shadow.points.iter_mut().zip(points) {
            *foot = self.foot(*x);
            if shape.dim() == 1 {
                foot[1] = 0.0;
            }
        }
        shadow
    }
}

/// A facet in a plane: its map from reference coordinates there.
#[derive(Debug, Clone, Copy)]
pub struct Shadow {
    shape: Shape,
    points: [[f64; 2]; MOST_NODES],
}

/// Corrections of Newton's method until it is given up.
const MOST_CORRECTIONS: usize = 30;

impl Shadow {
    /// Positions of the nodes in the plane, metres; the second coordinate of a line is zero.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points[..self.shape.nodes()]
    }

    /// The point of the plane at reference coordinates, metres.
    pub fn point(&self, xi: [f64; 3]) -> [f64; 2] {
        let mut values = [0.0; MOST_NODES];
        self.shape.values(xi, &mut values);
        let mut x = [0.0; 2];
        for (node, value) in self.points().iter().zip(values) {
            x[0] += value * node[0];
            x[1] += value * node[1];
        }
        x
    }

    /// Area of the plane per unit of the reference facet, m2 (m); positive if the facet looks to
    /// the side of the normal.
    pub fn determinant(&self, xi: [f64; 3]) -> f64 {
        self.jacobian(xi).1
    }

    /// Reference coordinates of a point of the plane, by Newton's method from `start`: exact after
    /// one correction for lines of first order, triangles of first order and parallelograms. None
    /// if it does not converge, as far outside of a curved facet.
    pub fn locate(&self, point: [f64; 2], start: [f64; 3]) -> Option<[f64; 3]> {
        let mut xi = start;
        let mut last = f64::INFINITY;
        for _ in 0..MOST_CORRECTIONS {
            let there = self.point(xi);
            let miss = [point[0] - there[0], point[1] - there[1]];
            let ([[a, b], [c, d]], determinant) = self.jacobian(xi);
            let step = if self.shape.dim() == 1 {
                [miss[0] / determinant, 0.0]
            } else {
                [
                    (d * miss[0] - b * miss[1]) / determinant,
                    (a * miss[1] - c * miss[0]) / determinant,
                ]
            };
            xi[0] += step[0];
            xi[1] += step[1];
            let size = step[0].abs().max(step[1].abs());
            // Small steps that no longer shrink are rounding.
            if size <= 4.0 * f64::EPSILON || (size <= ROUNDING && size >= last) {
                return Some(xi);
            }
            last = size;
        }
        None
    }

    /// Jacobian dx_i/dxi_d and its determinant.
    fn jacobian(&self, xi: [f64; 3]) -> ([[f64; 2]; 2], f64) {
        let mut gradients = [[0.0; 3]; MOST_NODES];
        self.shape.gradients(xi, &mut gradients);
        let mut j = [[0.0; 2]; 2];
        for (x, gradient) in self.points().iter().zip(gradients) {
            for i in 0..2 {
                for d in 0..2 {
                    j[i][d] += x[i] * gradient[d];
                }
            }
        }
        match self.shape.dim() {
            1 => (j, j[0][0]),
            _ => (j, j[0][0] * j[1][1] - j[0][1] * j[1][0]),
        }
    }
}

/// Steps of Newton's method below this, in reference coordinates, may be rounding: coordinates far
/// from the origin of the scene have lost digits.
const ROUNDING: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    const PLANE: Plane = Plane {
        origin: [1.0, 2.0, 3.0],
        axes: [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        normal: [1.0, 0.0, 0.0],
    };

    #[test]
    fn the_axes_are_right_handed() {
        let normal = unit([1.0, -2.0, 2.0]).unwrap();
        let plane = Plane::new([0.0; 3], normal, [1.0, 0.0, 0.0]).unwrap();
        let third = cross(plane.axes[0], plane.axes[1]);
        assert!((0..3).all(|d| (third[d] - normal[d]).abs() < 1e-15));
        assert!(Plane::new([0.0; 3], [0.0, 0.0, 1.0], [0.0, 0.0, 3.0]).is_none());
    }

    #[test]
    fn points_are_located_in_curved_and_in_distorted_shadows() {
        for shape in [Shape::Line3, Shape::Quad4, Shape::Quad9, Shape::Tri3, Shape::Tri6] {
            // A smooth distortion of the reference facet, seen from the first axis.
            let bent = |x: &[f64; 3]| {
                let [u, v, _] = *x;
                let v = if shape.dim() == 1 { 0.0 } else { v };
                [5.0 * u, 2.0 + 1.5 * u + 0.1 * u * v + 0.1 * v * v, 3.0 + v - 0.2 * u * v]
            };
            let points: Vec<Vector> = shape.node_points().iter().map(bent).collect();
            let shadow = PLANE.shadow(shape, &points);
            for mut xi in [[0.2, 0.3, 0.0], [0.9, 0.05, 0.0], [0.0, 1.05, 0.0]] {
                if shape.dim() == 1 {
                    xi[1] = 0.0;
                }
                let found = shadow.locate(shadow.point(xi), shape.centroid()).unwrap();
                assert!((0..2).all(|d| (found[d] - xi[d]).abs() < 1e-14), "{shape:?} {found:?}");
            }
        }
    }
}
