//! Linear Lagrange elements on [-1, 1]^dim.

/// The largest number of nodes of any [`Shape`]: the length of a buffer that serves them all.
pub const MAX_NODES: usize = 8;

/// A reference element with one basis function per vertex, linear along each edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Shape {
    /// Two nodes: -1, then +1.
    Line2,
    /// Four nodes, counter-clockwise from (-1, -1).
    Quad4,
    /// Eight nodes: the bottom face (third coordinate -1) as `Quad4`, then the top face.
    Hex8,
}

#[rustfmt::skip]
const VERTICES: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0], [1.0, -1.0, -1.0], [1.0, 1.0, -1.0], [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0],
];

impl Shape {
    /// The number of nodes.
    pub const fn nodes(self) -> usize {
        match self {
            Shape::Line2 => 2,
            Shape::Quad4 => 4,
            Shape::Hex8 => 8,
        }
    }

    /// The number of reference coordinates.
    pub const fn dim(self) -> usize {
        match self {
            Shape::Line2 => 1,
            Shape::Quad4 => 2,
            Shape::Hex8 => 3,
        }
    }

    /// Reference coordinates of the nodes, shape (`nodes()`, 3); those beyond `dim()` mean nothing.
    pub fn vertices(self) -> &'static [[f64; 3]] {
        &VERTICES[..self.nodes()]
    }

    /// Local nodes of each facet (codimension 1), so ordered that its normal points outwards.
    ///
    /// `Hex8`: the right-hand rule over the listed nodes gives the outward normal; order: bottom,
    /// top, front (second coordinate -1), right, back, left. `Quad4`: an edge from a to b has the
    /// outward normal (b - a) turned clockwise. `Line2`: its two ends.
    pub fn facets(self) -> &'static [&'static [usize]] {
        match self {
            Shape::Line2 => &[&[0], &[1]],
            Shape::Quad4 => &[&[0, 1], &[1, 2], &[2, 3], &[3, 0]],
            Shape::Hex8 => &[
                &[0, 3, 2, 1],
                &[4, 5, 6, 7],
                &[0, 1, 5, 4],
                &[1, 2, 6, 5],
                &[2, 3, 7, 6],
                &[3, 0, 4, 7],
            ],
        }
    }

    /// The shape of the facets; none for a line, whose facets are points.
    pub const fn facet(self) -> Option<Shape> {
        match self {
            Shape::Line2 => None,
            Shape::Quad4 => Some(Shape::Line2),
            Shape::Hex8 => Some(Shape::Quad4),
        }
    }

    /// The nodal basis at a reference point: `out[a]` = N_a(xi), for the first `nodes()` entries.
    ///
    /// # Panics
    /// If `out` is shorter than `nodes()`.
    pub fn values(self, xi: [f64; 3], out: &mut [f64]) {
        let dim = self.dim();
        for (value, vertex) in out[..self.nodes()].iter_mut().zip(&VERTICES) {
            *value = (0..dim).map(|d| 0.5 * (1.0 + vertex[d] * xi[d])).product();
        }
    }

    /// Derivatives with respect to the reference coordinates: `out[a][d]` = dN_a/dxi_d; zero for
    /// d >= `dim()`.
    ///
    /// # Panics
    /// If `out` is shorter than `nodes()`.
    pub fn gradients(self, xi: [f64; 3], out: &mut [[f64; 3]]) {
        let dim = self.dim();
        for (gradient, vertex) in out[..self.nodes()].iter_mut().zip(&VERTICES) {
            *gradient = [0.0; 3];
            for (d, component) in gradient.iter_mut().enumerate().take(dim) {
                *component = (0..dim)
                    .map(|e| if e == d { 0.5 * vertex[e] } else { 0.5 * (1.0 + vertex[e] * xi[e]) })
                    .product();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPES: [Shape; 3] = [Shape::Line2, Shape::Quad4, Shape::Hex8];
    const POINTS: [[f64; 3]; 3] = [[0.0; 3], [0.3, -0.7, 0.9], [-1.0, 1.0, 0.25]];

    #[test]
    fn values_sum_to_one_and_interpolate_the_vertices() {
        for shape in SHAPES {
            for xi in POINTS {
                let mut values = [0.0; MAX_NODES];
                shape.values(xi, &mut values);
                assert!((values[..shape.nodes()].iter().sum::<f64>() - 1.0).abs() < 1e-15);
            }
            for (a, &vertex) in shape.vertices().iter().enumerate() {
                let mut values = [0.0; MAX_NODES];
                shape.values(vertex, &mut values);
                for (b, &value) in values[..shape.nodes()].iter().enumerate() {
                    assert_eq!(value, if a == b { 1.0 } else { 0.0 });
                }
            }
        }
    }

    #[test]
    fn gradients_are_the_differences_of_the_values() {
        let step = 1e-3;
        for shape in SHAPES {
            for xi in POINTS {
                let mut gradients = [[9.0; 3]; MAX_NODES];
                shape.gradients(xi, &mut gradients);
                for d in 0..3 {
                    let (mut ahead, mut behind) = (xi, xi);
                    ahead[d] += step;
                    behind[d] -= step;
                    let (mut plus, mut minus) = ([0.0; MAX_NODES], [0.0; MAX_NODES]);
                    shape.values(ahead, &mut plus);
                    shape.values(behind, &mut minus);
                    for a in 0..shape.nodes() {
                        // Linear in each coordinate: the central difference is exact.
                        let difference = (plus[a] - minus[a]) / (2.0 * step);
                        assert!((gradients[a][d] - difference).abs() < 1e-12);
                    }
                }
            }
        }
    }

    #[test]
    fn facets_of_the_quad_look_outwards() {
        for facet in Shape::Quad4.facets() {
            let [a, b] = [VERTICES[facet[0]], VERTICES[facet[1]]];
            let normal = [b[1] - a[1], a[0] - b[0]];
            assert!(normal[0] * (a[0] + b[0]) + normal[1] * (a[1] + b[1]) > 0.0);
        }
    }

    #[test]
    fn facets_of_the_hexahedron_look_outwards_and_hold_each_node_three_times() {
        let mut seen = [0; 8];
        for facet in Shape::Hex8.facets() {
            let p: Vec<[f64; 3]> = facet.iter().map(|&a| VERTICES[a]).collect();
            let u: [f64; 3] = std::array::from_fn(|d| p[1][d] - p[0][d]);
            let v: [f64; 3] = std::array::from_fn(|d| p[3][d] - p[0][d]);
            let normal =
                [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let centre: [f64; 3] = std::array::from_fn(|d| p.iter().map(|x| x[d]).sum::<f64>());
            let outward: f64 = (0..3).map(|d| normal[d] * centre[d]).sum();
            assert_eq!(outward, 16.0);
            facet.iter().for_each(|&a| seen[a] += 1);
        }
        assert_eq!(seen, [3; 8]);
    }
}
