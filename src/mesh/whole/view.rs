//! Cells with their nodes, whoever owns them.

use super::facet::WholeFacet;
use crate::element::{MAX_NODES, Shape};

/// Points, shapes and connectivity of cells.
#[derive(Debug, Clone, Copy)]
pub struct View<'m> {
    pub points: &'m [[f64; 3]],
    pub shapes: &'m [Shape],
    pub start: &'m [u32],
    pub nodes: &'m [u32],
}

impl<'m> View<'m> {
    /// Nodes of a cell.
    pub fn cell_nodes(self, cell: usize) -> &'m [u32] {
        &self.nodes[self.start[cell] as usize..self.start[cell + 1] as usize]
    }

    /// The facets of a cell.
    pub fn facets(self, cell: usize) -> impl Iterator<Item = WholeFacet> {
        (0..self.shapes[cell].facets().len())
            .map(move |facet| WholeFacet { cell: cell as u32, facet: facet as u8 })
    }

    /// The shape of a facet.
    pub fn facet_shape(self, facet: WholeFacet) -> Shape {
        let shape = self.shapes[facet.cell as usize].facet_shape(facet.facet as usize);
        shape.expect("cells have two or three dimensions")
    }

    /// Nodes of a facet in the order of its shape.
    pub fn facet_nodes(self, facet: WholeFacet) -> impl Iterator<Item = u32> + 'm {
        let nodes = self.cell_nodes(facet.cell as usize);
        let order = self.shapes[facet.cell as usize].facets()[facet.facet as usize];
        order.iter().map(move |local| nodes[*local])
    }

    /// Its corners, in a row that [`View::corner_count`] tells the length of.
    pub fn facet_corners(self, facet: WholeFacet) -> [u32; 4] {
        let mut corners = [u32::MAX; 4];
        let nodes = self.facet_nodes(facet).take(self.corner_count(facet));
        corners.iter_mut().zip(nodes).for_each(|(corner, node)| *corner = node);
        corners
    }

    /// The number of its corners.
    pub fn corner_count(self, facet: WholeFacet) -> usize {
        self.facet_shape(facet).corners().nodes()
    }

    /// The mean of the nodes of a cell (m).
    pub fn cell_centre(self, cell: usize) -> [f64; 3] {
        self.mean(self.cell_nodes(cell).iter().copied())
    }

    /// The mean of the nodes of a facet (m).
    pub fn facet_centre(self, facet: WholeFacet) -> [f64; 3] {
        self.mean(self.facet_nodes(facet))
    }

    /// Positions of the nodes of a facet.
    pub fn facet_points(self, facet: WholeFacet) -> ([[f64; 3]; MAX_NODES], Shape) {
        let mut points = [[0.0; 3]; MAX_NODES];
        for (point, node) in points.iter_mut().zip(self.facet_nodes(facet)) {
            *point = self.points[node as usize];
        }
        (points, self.facet_shape(facet))
    }

    fn mean(self, nodes: impl Iterator<Item = u32>) -> [f64; 3] {
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        for node in nodes {
            for (sum, x) in sum.iter_mut().zip(self.points[node as usize]) {
                *sum += x;
            }
            count += 1.0;
        }
        sum.map(|x| x / count)
    }
}
