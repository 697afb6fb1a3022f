//! Lagrange elements of first and second order on [-1, 1]^dim: products of polynomials of one
//! coordinate each.

/// The largest number of nodes of any [`Shape`]: the length of a buffer that serves them all.
pub const MAX_NODES: usize = 27;

/// A reference element. Nodes are numbered as VTK does: the corners first, then the middles of
/// edges, of faces, of the cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Shape {
    /// Two nodes: -1, then +1.
    Line2,
    /// As `Line2`, then the middle.
    Line3,
    /// Four nodes, counter-clockwise from (-1, -1).
    Quad4,
    /// As `Quad4`, then the middle of each edge to the next corner, then the centre.
    Quad9,
    /// Eight nodes: the bottom face (third coordinate -1) as `Quad4`, then the top face.
    Hex8,
    /// As `Hex8`, then the middles of the edges (bottom, top, upright), of the faces (left, right,
    /// front, back, bottom, top), and the centre.
    Hex27,
}

#[rustfmt::skip]
const LINE: [[f64; 3]; 3] = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]];

#[rustfmt::skip]
const QUAD: [[f64; 3]; 9] = [
    [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0],
    [0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0],
    [0.0, 0.0, 0.0],
];

#[rustfmt::skip]
const HEX: [[f64; 3]; 27] = [
    [-1.0, -1.0, -1.0], [1.0, -1.0, -1.0], [1.0, 1.0, -1.0], [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0],
    [0.0, -1.0, -1.0], [1.0, 0.0, -1.0], [0.0, 1.0, -1.0], [-1.0, 0.0, -1.0],
    [0.0, -1.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [-1.0, 0.0, 1.0],
    [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0],
    [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0],
    [0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0],
];

impl Shape {
    /// The cell of `dim` (1, 2 or 3) dimensions and of first or second `order`.
    ///
    /// # Panics
    /// If there is no such shape.
    pub const fn of(dim: usize, order: usize) -> Self {
        match (dim, order) {
            (1, 1) => Shape::Line2,
            (1, 2) => Shape::Line3,
            (2, 1) => Shape::Quad4,
            (2, 2) => Shape::Quad9,
            (3, 1) => Shape::Hex8,
            (3, 2) => Shape::Hex27,
            _ => panic!("cells have 1 to 3 dimensions and first or second order"),
        }
    }

    /// The number of nodes.
    pub const fn nodes(self) -> usize {
        (self.order() + 1).pow(self.dim() as u32)
    }

    /// The degree of the polynomials in each coordinate.
    pub const fn order(self) -> usize {
        match self {
            Shape::Line2 | Shape::Quad4 | Shape::Hex8 => 1,
            Shape::Line3 | Shape::Quad9 | Shape::Hex27 => 2,
        }
    }

    /// The number of reference coordinates.
    pub const fn dim(self) -> usize {
        match self {
            Shape::Line2 | Shape::Line3 => 1,
            Shape::Quad4 | Shape::Quad9 => 2,
            Shape::Hex8 | Shape::Hex27 => 3,
        }
    }

    /// The shape of first order with the same corners, which are the first nodes.
    pub const fn corners(self) -> Self {
        Self::of(self.dim(), 1)
    }

    /// Reference coordinates of the nodes, shape (`nodes()`, 3); those beyond `dim()` are zero.
    pub fn node_points(self) -> &'static [[f64; 3]] {
        let all: &[[f64; 3]] = match self.dim() {
            1 => &LINE,
            2 => &QUAD,
            _ => &HEX,
        };
        &all[..self.nodes()]
    }

    /// Local nodes of each facet (codimension 1) in the order of [`Shape::facet`], so that its
    /// normal points outwards.
    ///
    /// Hexahedra: the right-hand rule over the corners gives the outward normal; order: bottom,
    /// top, front (second coordinate -1), right, back, left. Quadrilaterals: an edge from a to b
    /// has the outward normal (b - a) turned clockwise. Lines: the two ends.
    pub fn facets(self) -> &'static [&'static [usize]] {
        match self {
            Shape::Line2 | Shape::Line3 => &[&[0], &[1]],
            Shape::Quad4 => &[&[0, 1], &[1, 2], &[2, 3], &[3, 0]],
            Shape::Quad9 => &[&[0, 1, 4], &[1, 2, 5], &[2, 3, 6], &[3, 0, 7]],
            Shape::Hex8 => &[
                &[0, 3, 2, 1],
                &[4, 5, 6, 7],
                &[0, 1, 5, 4],
                &[1, 2, 6, 5],
                &[2, 3, 7, 6],
                &[3, 0, 4, 7],
            ],
            Shape::Hex27 => &[
                &[0, 3, 2, 1, 11, 10, 9, 8, 24],
                &[4, 5, 6, 7, 12, 13, 14, 15, 25],
                &[0, 1, 5, 4, 8, 17, 12, 16, 22],
                &[1, 2, 6, 5, 9, 18, 13, 17, 21],
                &[2, 3, 7, 6, 10, 19, 14, 18, 23],
                &[3, 0, 4, 7, 11, 16, 15, 19, 20],
            ],
        }
    }

    /// The shape of the facets; none for a line, whose facets are points.
    pub const fn facet(self) -> Option<Shape> {
        if self.dim() == 1 { None } else { Some(Self::of(self.dim() - 1, self.order())) }
    }

    /// The nodes of a facet's shape in the order in which it runs the other way round from the same
    /// first corner (a line: from the other end).
    ///
    /// # Panics
    /// For shapes of three dimensions.
    pub const fn mirrored(self) -> &'static [usize] {
        match self {
            Shape::Line2 => &[1, 0],
            Shape::Line3 => &[1, 0, 2],
            Shape::Quad4 => &[0, 3, 2, 1],
            Shape::Quad9 => &[0, 3, 2, 1, 7, 6, 5, 4, 8],
            Shape::Hex8 | Shape::Hex27 => panic!("facets have at most two dimensions"),
        }
    }

    /// The nodal basis at a reference point: `out[a]` = N_a(xi), for the first `nodes()` entries.
    ///
    /// # Panics
    /// If `out` is shorter than `nodes()`.
    pub fn values(self, xi: [f64; 3], out: &mut [f64]) {
        let (dim, order) = (self.dim(), self.order());
        for (value, node) in out[..self.nodes()].iter_mut().zip(self.node_points()) {
            *value = (0..dim).map(|d| along(order, node[d], xi[d])).product();
        }
    }

    /// Derivatives with respect to the reference coordinates: `out[a][d]` = dN_a/dxi_d; zero for
    /// d >= `dim()`.
    ///
    /// # Panics
    /// If `out` is shorter than `nodes()`.
    pub fn gradients(self, xi: [f64; 3], out: &mut [[f64; 3]]) {
        let (dim, order) = (self.dim(), self.order());
        for (gradient, node) in out[..self.nodes()].iter_mut().zip(self.node_points()) {
            *gradient = [0.0; 3];
            for (d, component) in gradient.iter_mut().enumerate().take(dim) {
                let factor = |e: usize| {
                    if e == d { slope(order, node[e], xi[e]) } else { along(order, node[e], xi[e]) }
                };
                *component = (0..dim).map(factor).product();
            }
        }
    }
}

/// The polynomial of one coordinate that is 1 at `node` (-1, 0 or 1) and 0 at the others.
fn along(order: usize, node: f64, x: f64) -> f64 {
    if order == 1 {
        0.5 * (1.0 + node * x)
    } else if node == 0.0 {
        1.0 - x * x
    } else {
        0.5 * x * (x + node)
    }
}

/// The derivative of [`along`].
fn slope(order: usize, node: f64, x: f64) -> f64 {
    if order == 1 {
        0.5 * node
    } else if node == 0.0 {
        -2.0 * x
    } else {
        x + 0.5 * node
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPES: [Shape; 6] =
        [Shape::Line2, Shape::Quad4, Shape::Hex8, Shape::Line3, Shape::Quad9, Shape::Hex27];
    const POINTS: [[f64; 3]; 3] = [[0.0; 3], [0.3, -0.7, 0.9], [-1.0, 1.0, 0.25]];

    #[test]
    fn values_sum_to_one_and_interpolate_the_nodes() {
        for shape in SHAPES {
            for xi in POINTS {
                let mut values = [0.0; MAX_NODES];
                shape.values(xi, &mut values);
                assert!((values[..shape.nodes()].iter().sum::<f64>() - 1.0).abs() < 1e-14);
            }
            for (a, &node) in shape.node_points().iter().enumerate() {
                let mut values = [0.0; MAX_NODES];
                shape.values(node, &mut values);
                for (b, &value) in values[..shape.nodes()].iter().enumerate() {
                    assert_eq!(value, if a == b { 1.0 } else { 0.0 });
                }
            }
        }
    }

    #[test]
    fn a_mirrored_facet_is_the_same_facet() {
        for shape in SHAPES.into_iter().filter(|s| s.dim() < 3) {
            let (points, order) = (shape.node_points(), shape.mirrored());
            let mut same = order.to_vec();
            same.sort_unstable();
            assert_eq!(same, (0..shape.nodes()).collect::<Vec<_>>());
            // Exchanging the axes (2D: turning the axis) takes each node to its mirror image.
            for (point, other) in points.iter().zip(order) {
                let [x, y, z] = points[*other];
                let image = if shape.dim() == 1 { [-x, y, z] } else { [y, x, z] };
                assert_eq!(*point, image, "{shape:?}");
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
                        // At most quadratic in each coordinate: the central difference is exact.
                        let difference = (plus[a] - minus[a]) / (2.0 * step);
                        assert!((gradients[a][d] - difference).abs() < 1e-12);
                    }
                }
            }
        }
    }

    #[test]
    fn facets_are_the_nodes_of_one_side_and_look_outwards() {
        for shape in SHAPES.into_iter().filter(|s| s.dim() > 1) {
            let (nodes, dim) = (shape.node_points(), shape.dim());
            let facet_shape = shape.facet().unwrap();
            let mut axes = Vec::new();
            for facet in shape.facets() {
                let p: Vec<[f64; 3]> = facet.iter().map(|&a| nodes[a]).collect();
                assert_eq!(p.len(), facet_shape.nodes());
                let axis = (0..dim).find(|&d| p.iter().all(|x| x[d] == p[0][d])).unwrap();
                axes.push((axis, p[0][axis] as i32));
                // Each node of the facet stands where the facet's own numbering has it.
                let corners = facet_shape.corners();
                for (x, xi) in p.iter().zip(facet_shape.node_points()) {
                    let mut values = [0.0; MAX_NODES];
                    corners.values(*xi, &mut values);
                    for d in 0..dim {
                        let mapped: f64 = (0..corners.nodes()).map(|a| values[a] * p[a][d]).sum();
                        assert_eq!(x[d], mapped);
                    }
                }
                let u: [f64; 3] = std::array::from_fn(|d| p[1][d] - p[0][d]);
                let normal = if dim == 2 {
                    [u[1], -u[0], 0.0]
                } else {
                    let v: [f64; 3] = std::array::from_fn(|d| p[3][d] - p[0][d]);
                    [
                        u[1] * v[2] - u[2] * v[1],
                        u[2] * v[0] - u[0] * v[2],
                        u[0] * v[1] - u[1] * v[0],
                    ]
                };
                assert!(normal[axis] * p[0][axis] > 0.0, "{shape:?} {facet:?}");
            }
            axes.sort_unstable();
            axes.dedup();
            assert_eq!(axes.len(), 2 * dim);
        }
    }
}
