//! The reference cells and what each family says of them.

use serde::{Deserialize, Serialize};

use super::{cube, prism, pyramid, simplex};

/// The largest number of nodes of any [`Shape`]: the length of a buffer that serves them all.
pub const MAX_NODES: usize = 27;

/// A reference element. Nodes are numbered as VTK does: the corners first, then the middles of
/// edges, of faces, of the cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
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
    /// Three nodes: the origin, then 1 on each axis.
    Tri3,
    /// As `Tri3`, then the middle of each edge to the next corner.
    Tri6,
    /// Four nodes: the origin, then 1 on each axis.
    Tet4,
    /// As `Tet4`, then the middles of the edges as `Tri6`, then of those to the last corner.
    Tet10,
    /// Six nodes: the triangle at the bottom (third coordinate -1) as `Tri3`, then the top one.
    Prism6,
    /// As `Prism6`, then the middles of the edges (bottom, top, upright) and of the quadrilaterals.
    Prism18,
    /// Five nodes: the square (third coordinate 0) as `Quad4`, then the apex at (0, 0, 1).
    Pyramid5,
}

/// The shapes whose basis is made in the same way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// Lines, quadrilaterals, hexahedra: products over the axes of [-1, 1]^dim.
    Cube,
    /// Triangles and tetrahedra.
    Simplex,
    /// Triangle times line.
    Prism,
    /// Pyramids over a square.
    Pyramid,
}

impl Shape {
    /// Every shape.
    pub const ALL: [Shape; 13] = [
        Shape::Line2,
        Shape::Line3,
        Shape::Quad4,
        Shape::Quad9,
        Shape::Hex8,
        Shape::Hex27,
        Shape::Tri3,
        Shape::Tri6,
        Shape::Tet4,
        Shape::Tet10,
        Shape::Prism6,
        Shape::Prism18,
        Shape::Pyramid5,
    ];

    /// The cube of `dim` (1, 2 or 3) dimensions and of first or second `order`.
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

    /// The shapes that it is made like.
    #[inline]
    pub const fn family(self) -> Family {
        match self {
            Shape::Line2
            | Shape::Line3
            | Shape::Quad4
            | Shape::Quad9
            | Shape::Hex8
            | Shape::Hex27 => Family::Cube,
            Shape::Tri3 | Shape::Tri6 | Shape::Tet4 | Shape::Tet10 => Family::Simplex,
            Shape::Prism6 | Shape::Prism18 => Family::Prism,
            Shape::Pyramid5 => Family::Pyramid,
        }
    }

    /// The number of nodes.
    #[inline]
    pub const fn nodes(self) -> usize {
        match self {
            Shape::Line2 => 2,
            Shape::Line3 | Shape::Tri3 => 3,
            Shape::Quad4 | Shape::Tet4 => 4,
            Shape::Pyramid5 => 5,
            Shape::Tri6 | Shape::Prism6 => 6,
            Shape::Hex8 => 8,
            Shape::Quad9 => 9,
            Shape::Tet10 => 10,
            Shape::Prism18 => 18,
            Shape::Hex27 => 27,
        }
    }

    /// The degree of the polynomials in each coordinate (of a simplex: in all together).
    #[inline]
    pub const fn order(self) -> usize {
        match self {
            Shape::Line2 | Shape::Quad4 | Shape::Hex8 => 1,
            Shape::Tri3 | Shape::Tet4 | Shape::Prism6 | Shape::Pyramid5 => 1,
            Shape::Line3 | Shape::Quad9 | Shape::Hex27 => 2,
            Shape::Tri6 | Shape::Tet10 | Shape::Prism18 => 2,
        }
    }

    /// The number of reference coordinates.
    #[inline]
    pub const fn dim(self) -> usize {
        match self {
            Shape::Line2 | Shape::Line3 => 1,
            Shape::Quad4 | Shape::Quad9 | Shape::Tri3 | Shape::Tri6 => 2,
            Shape::Hex8 | Shape::Hex27 | Shape::Tet4 | Shape::Tet10 => 3,
            Shape::Prism6 | Shape::Prism18 | Shape::Pyramid5 => 3,
        }
    }

    /// The shape of first order with the same corners, which are the first nodes.
    #[inline]
    pub const fn corners(self) -> Self {
        match self {
            Shape::Line2 | Shape::Line3 => Shape::Line2,
            Shape::Quad4 | Shape::Quad9 => Shape::Quad4,
            Shape::Hex8 | Shape::Hex27 => Shape::Hex8,
            Shape::Tri3 | Shape::Tri6 => Shape::Tri3,
            Shape::Tet4 | Shape::Tet10 => Shape::Tet4,
            Shape::Prism6 | Shape::Prism18 => Shape::Prism6,
            Shape::Pyramid5 => Shape::Pyramid5,
        }
    }

    /// Volume of the reference cell (length, area).
    pub const fn volume(self) -> f64 {
        match self.corners() {
            Shape::Line2 => 2.0,
            Shape::Quad4 => 4.0,
            Shape::Hex8 => 8.0,
            Shape::Tri3 => 0.5,
            Shape::Tet4 => 1.0 / 6.0,
            Shape::Prism6 => 1.0,
            _ => 4.0 / 3.0,
        }
    }

    /// Centre of gravity of the reference cell.
    pub const fn centroid(self) -> [f64; 3] {
        const THIRD: f64 = 1.0 / 3.0;
        match (self.family(), self.dim()) {
            (Family::Cube, _) => [0.0; 3],
            (Family::Simplex, 2) | (Family::Prism, _) => [THIRD, THIRD, 0.0],
            (Family::Simplex, _) => [0.25; 3],
            (Family::Pyramid, _) => [0.0, 0.0, 0.25],
        }
    }

    /// Reference coordinates of the nodes, shape (`nodes()`, 3); those beyond `dim()` are zero.
    #[inline]
    pub fn node_points(self) -> &'static [[f64; 3]] {
        let all = match self.family() {
            Family::Cube => cube::points(self.dim()),
            Family::Simplex => simplex::points(self.dim()),
            Family::Prism => prism::points(),
            Family::Pyramid => pyramid::points(),
        };
        &all[..self.nodes()]
    }

    /// Local nodes of each facet (codimension 1) in the order of [`Shape::facet_shape`], so that
    /// its normal points outwards.
    ///
    /// Three dimensions: the right-hand rule over the corners gives the outward normal; two: an
    /// edge from a to b has the outward normal (b - a) turned clockwise. Lines: the two ends.
    #[inline]
    pub const fn facets(self) -> &'static [&'static [usize]] {
        match self.family() {
            Family::Cube => cube::facets(self.dim(), self.order()),
            Family::Simplex => simplex::facets(self.dim(), self.order()),
            Family::Prism => prism::facets(self.order()),
            Family::Pyramid => pyramid::facets(),
        }
    }

    /// The shape of a facet of [`Shape::facets`]; none for a line, whose facets are points.
    pub const fn facet_shape(self, facet: usize) -> Option<Shape> {
        Some(match self {
            Shape::Line2 | Shape::Line3 => return None,
            Shape::Quad4 | Shape::Tri3 => Shape::Line2,
            Shape::Quad9 | Shape::Tri6 => Shape::Line3,
            Shape::Hex8 => Shape::Quad4,
            Shape::Hex27 => Shape::Quad9,
            Shape::Tet4 => Shape::Tri3,
            Shape::Tet10 => Shape::Tri6,
            Shape::Prism6 if facet < 2 => Shape::Tri3,
            Shape::Prism6 => Shape::Quad4,
            Shape::Prism18 if facet < 2 => Shape::Tri6,
            Shape::Prism18 => Shape::Quad9,
            Shape::Pyramid5 if facet == 0 => Shape::Quad4,
            Shape::Pyramid5 => Shape::Tri3,
        })
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
            Shape::Tri3 => &[0, 2, 1],
            Shape::Tri6 => &[0, 2, 1, 5, 4, 3],
            _ => panic!("facets have at most two dimensions"),
        }
    }

    /// Whether a point lies in the reference cell, or outside by no more than `margin`.
    pub fn contains(self, [x, y, z]: [f64; 3], margin: f64) -> bool {
        let within = |x: f64| x.abs() <= 1.0 + margin;
        let in_triangle = x >= -margin && y >= -margin && x + y <= 1.0 + margin;
        match (self.family(), self.dim()) {
            (Family::Cube, 1) => within(x),
            (Family::Cube, 2) => within(x) && within(y),
            (Family::Cube, _) => within(x) && within(y) && within(z),
            (Family::Simplex, 2) => in_triangle,
            (Family::Simplex, _) => in_triangle && z >= -margin && x + y + z <= 1.0 + margin,
            (Family::Prism, _) => in_triangle && within(z),
            (Family::Pyramid, _) => {
                let s = 1.0 - z + margin;
                z >= -margin && x.abs() <= s && y.abs() <= s
            }
        }
    }

    /// The nodal basis at a reference point: `out[a]` = N_a(xi), for the first `nodes()` entries.
    ///
    /// # Panics
    /// If `out` is shorter than `nodes()`.
    #[inline]
    pub fn values(self, xi: [f64; 3], out: &mut [f64]) {
        let out = &mut out[..self.nodes()];
        match self.family() {
            Family::Cube => cube::values(self.dim(), self.order(), xi, out),
            Family::Simplex => simplex::values(self.dim(), self.order(), xi, out),
            Family::Prism => prism::values(self.order(), xi, out),
            Family::Pyramid => pyramid::values(xi, out),
        }
    }

    /// Derivatives with respect to the reference coordinates: `out[a][d]` = dN_a/dxi_d; zero for
    /// d >= `dim()`. Those of a pyramid have no limit at its apex: there, those on the axis.
    ///
    /// # Panics
    /// If `out` is shorter than `nodes()`.
    #[inline]
    pub fn gradients(self, xi: [f64; 3], out: &mut [[f64; 3]]) {
        let out = &mut out[..self.nodes()];
        match self.family() {
            Family::Cube => cube::gradients(self.dim(), self.order(), xi, out),
            Family::Simplex => simplex::gradients(self.dim(), self.order(), xi, out),
            Family::Prism => prism::gradients(self.order(), xi, out),
            Family::Pyramid => pyramid::gradients(xi, out),
        }
    }
}
