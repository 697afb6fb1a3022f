//! The nodes of the lattices: at the planes between the cells and, in cells of second order,
//! half-way.

use super::CellPlace;
use super::column::{Column, Facets, flatten, product, unflatten};
use crate::element::Shape;
use crate::mesh::axes;

/// A node by its place: body, and position along x, y, z in the body's lattice of nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NodePlace {
    /// Body, counted from the bottom.
    pub body: usize,
    /// Position along x, y, z.
    pub at: [usize; 3],
}

impl Column {
    /// Number of nodes.
    pub fn nodes(&self) -> u64 {
        let last = self.bodies() - 1;
        self.bodies[last].first_node + product(self.node_extent(last))
    }

    /// Nodes of a body along x, y, z.
    pub fn node_extent(&self, body: usize) -> [usize; 3] {
        let (cells, order) = (self.extent(body), self.order(body));
        let along = |axis: usize| order * cells[axis] + 1;
        [along(0), if self.dim == 2 { 1 } else { along(1) }, along(2)]
    }

    /// The shape of the cells of a body.
    pub fn shape(&self, body: usize) -> Shape {
        Shape::of(self.dim, self.order(body))
    }

    /// The place of a node.
    pub fn node_place(&self, node: u64) -> NodePlace {
        let body = self.bodies.partition_point(|b| b.first_node <= node) - 1;
        let at = unflatten(node - self.bodies[body].first_node, self.node_extent(body));
        NodePlace { body, at }
    }

    /// The number of a node.
    pub fn node(&self, place: NodePlace) -> u64 {
        self.bodies[place.body].first_node + flatten(place.at, self.node_extent(place.body))
    }

    /// The nodes of a cell in the order of its shape, in 2D in the plane of x and z.
    pub fn cell_nodes(&self, place: CellPlace) -> Vec<u64> {
        let order = self.order(place.body);
        let first = place.at.map(|at| at * order);
        let first = if self.dim == 2 { [first[0], 0, first[2]] } else { first };
        self.lattice_nodes(place.body, first, axes(self.dim), self.shape(place.body))
    }

    /// The nodes of a facet in the order of its shape, x before y.
    pub fn facet_nodes(&self, face: Facets, at: [usize; 2]) -> Vec<u64> {
        let order = self.order(face.body);
        let k = if face.upper { self.node_extent(face.body)[2] - 1 } else { 0 };
        let first = [order * at[0], if self.dim == 2 { 0 } else { order * at[1] }, k];
        self.lattice_nodes(face.body, first, &[0, 1], Shape::of(self.dim - 1, order))
    }

    /// The nodes of a shape that lies along `axes` from the node `first` on.
    fn lattice_nodes(
        &self,
        body: usize,
        first: [usize; 3],
        axes: &[usize],
        shape: Shape,
    ) -> Vec<u64> {
        let order = shape.order();
        let node = |point: &[f64; 3]| {
            let mut at = first;
            for (axis, x) in axes.iter().zip(&point[..shape.dim()]) {
                // From -1, (0,) 1 to 0, (1,) order.
                at[*axis] += ((x + 1.0) as usize * order) / 2;
            }
            self.node(NodePlace { body, at })
        };
        shape.node_points().iter().map(node).collect()
    }

    /// Position of a node (m).
    pub fn point(&self, node: u64) -> [f64; 3] {
        let NodePlace { body, at } = self.node_place(node);
        let y = if self.dim == 2 { 0.0 } else { self.node_plane(body, 1, at[1]) };
        [self.node_plane(body, 0, at[0]), y, self.node_plane(body, 2, at[2])]
    }

    /// Coordinate of a plane of nodes of a body along an axis (m).
    pub fn node_plane(&self, body: usize, axis: usize, index: usize) -> f64 {
        let order = self.order(body);
        let low = self.plane(body, axis, index / order);
        if index.is_multiple_of(order) {
            low
        } else {
            0.5 * (low + self.plane(body, axis, index / order + 1))
        }
    }
}
