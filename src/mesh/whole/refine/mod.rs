//! Uniform refinement of a mesh from a file, before it is cut.
//!
//! Every edge is halved. New nodes lie where the parent's isoparametric map has them, so that a
//! curved side stays the same curve, and all parts of a boundary stay where they are. Groups keep
//! their elements: each element becomes its parts.

mod below;
mod children;
mod size;

pub use children::points as reference_points;
pub use size::check;

use below::{Edges, Halves};
use children::{Children, Order, PYRAMID_EDGES, second_order, second_order_nodes};

use super::cells::{Cells, NONE};
use super::named::Named;
use super::raise::{Middles, fill_centres, fill_edges, fill_faces, make_room, mean, middles};
use crate::element::{MAX_NODES, Shape};
use crate::mesh::import::{FileMesh, Kind};

/// Where a cell lies in the coarser one that it is a part of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parent {
    /// The coarser cell.
    pub cell: u32,
    /// Where its corners are: places of [`reference_points`] of the coarser cell.
    pub corners: [u8; 8],
}

/// A mesh that is made finer step by step, with its groups.
pub struct Refiner {
    cells: Cells,
    /// In which order each cell is refined if it is a tetrahedron.
    orders: Vec<Order>,
    /// What there is beside the cells.
    named: Named,
}

impl Refiner {
    /// Of a file and the cells that were taken out of it.
    pub fn new(file: &FileMesh, cells: Cells) -> Self {
        let named = Named::new(file, &cells);
        Self { orders: vec![Order::Free; cells.shapes.len()], named, cells }
    }

    /// Halves every edge. Takes linear time and memory, up to a logarithm. The place of every new
    /// cell in the old ones.
    pub fn refine(&mut self) -> Vec<Parent> {
        let halves = halve(&mut self.cells);
        let (mut fine, parents, orders) = split(&mut self.cells, &self.orders);
        fine.edges = raise(&mut fine, &self.cells, &parents);
        fine.names = (0..fine.points.len() as u32).collect();
        self.named.below = below::refine(&self.named.below, &halves, &fine.edges);
        (self.cells, self.orders) = (fine, orders);
        parents
    }

    /// The mesh as it is now: a file with the elements that are no cells, all of whose points are
    /// nodes of the cells, and the cells. Positions are in metres. The last one leaves nothing.
    pub fn mesh(&mut self, is_last: bool) -> (FileMesh, Cells) {
        let file = self.named.file(&self.cells);
        let cells = &mut self.cells;
        (file, if is_last { std::mem::take(cells) } else { cells.clone() })
    }
}

/// Gives every cell of first order the nodes of second order, in the middle of its edges and sides.
fn halve(cells: &mut Cells) -> Halves {
    let of_shape = |shape: &Shape| match shape {
        Shape::Pyramid5 => Middles {
            edges: (5..).zip(PYRAMID_EDGES).collect(),
            faces: vec![(13, [0, 1, 2, 3])],
            centre: None,
        },
        _ => middles(second_order(*shape)),
    };
    let middles: Vec<Middles> = Shape::ALL.iter().map(of_shape).collect();
    make_room(cells, second_order_nodes);
    let edges = fill_edges(cells, &middles, &mean);
    let faces = fill_faces(cells, &middles, &mean);
    fill_centres(cells, &middles, &mean);
    Halves { edges, faces }
}

/// The children of cells with nodes of second order; those of second order have their corners only.
/// The parent of each, and its order. The points go over to the children.
fn split(cells: &mut Cells, orders: &[Order]) -> (Cells, Vec<Parent>, Vec<Order>) {
    let children = Children::new();
    let mut fine = Cells { start: vec![0], ..Cells::default() };
    fine.group_sets = std::mem::take(&mut cells.group_sets);
    let (mut parents, mut new_orders) = (Vec::new(), Vec::new());
    for (cell, shape) in cells.shapes.iter().enumerate() {
        let nodes = cells.view().cell_nodes(cell);
        let point = |node: usize| cells.points[nodes[node] as usize];
        for child in children.of(*shape, orders[cell], point) {
            let corners = &child.corners[..child.shape.nodes()];
            let is_second = shape.order() == 2;
            let of_child = if is_second { second_order(child.shape) } else { child.shape };
            let end = fine.nodes.len() + of_child.nodes();
            fine.nodes.extend(corners.iter().map(|corner| nodes[*corner as usize]));
            fine.nodes.resize(end, NONE);
            fine.start.push(end as u32);
            fine.shapes.push(of_child);
            fine.kinds.push(kind_of(of_child));
            fine.numbers.push(cells.numbers[cell]);
            fine.sets.push(cells.sets[cell]);
            parents.push(Parent { cell: cell as u32, corners: child.corners });
            new_orders.push(child.order);
        }
    }
    fine.points = std::mem::take(&mut cells.points);
    (fine, parents, new_orders)
}

/// Gives children of second order their middle nodes, where the map of the parent has them; all of
/// those on edges by the ends of the edges, rising.
fn raise(fine: &mut Cells, coarse: &Cells, parents: &[Parent]) -> Edges {
    if fine.shapes.iter().all(|shape| shape.order() == 1) {
        return Vec::new();
    }
    let middles: Vec<Middles> = Shape::ALL.iter().map(|shape| middles(*shape)).collect();
    let place = |fine: &Cells, cell: usize, corners: &[usize]| {
        let parent = &parents[cell];
        let shape = coarse.shapes[parent.cell as usize];
        let from = coarse.start[parent.cell as usize] as usize;
        let mut xi = [0.0; 3];
        for corner in corners {
            let point = shape.node_points()[parent.corners[*corner] as usize];
            xi.iter_mut().zip(point).for_each(|(sum, x)| *sum += x / corners.len() as f64);
        }
        let mut values = [0.0; MAX_NODES];
        shape.values(xi, &mut values);
        let mut sum = [0.0; 3];
        for (node, value) in coarse.nodes[from..from + shape.nodes()].iter().zip(values) {
            let point = fine.points[*node as usize];
            sum.iter_mut().zip(point).for_each(|(sum, x)| *sum += value * x);
        }
        sum
    };
    let edges = fill_edges(fine, &middles, &place);
    fill_faces(fine, &middles, &place);
    fill_centres(fine, &middles, &place);
    edges
}

/// The kind of element that a shape of cells is.
pub fn kind_of(shape: Shape) -> Kind {
    match shape {
        Shape::Line2 => Kind::Line2,
        Shape::Line3 => Kind::Line3,
        Shape::Quad4 => Kind::Quad4,
        Shape::Quad9 => Kind::Quad9,
        Shape::Hex8 => Kind::Hex8,
        Shape::Hex27 => Kind::Hex27,
        Shape::Tri3 => Kind::Tri3,
        Shape::Tri6 => Kind::Tri6,
        Shape::Tet4 => Kind::Tet4,
        Shape::Tet10 => Kind::Tet10,
        Shape::Prism6 => Kind::Prism6,
        Shape::Prism18 => Kind::Prism18,
        Shape::Pyramid5 => Kind::Pyramid5,
    }
}
