//! A whole mesh on one rank.

use super::facet::WholeFacet;
use super::refine::Parent;
use super::view::View;
use crate::element::Shape;
use crate::mesh::facts::Hinges;

/// The largest number of nodes of a facet.
pub const MAX_FACET_NODES: usize = 9;

/// A whole mesh on one rank: checked, in SI units, and cut along its interfaces.
///
/// Names of nodes and cells are indices. What is told of groups keeps the order of the file; what
/// is told of nodes rises.
#[derive(Debug, Clone, PartialEq)]
pub struct WholeMesh {
    /// Coordinate axes of the components: [0, 1] in the plane z = 0, else [0, 1, 2].
    pub axes: &'static [usize],
    /// Positions of the nodes (m), after cutting: the copies stand at the end.
    pub points: Vec<[f64; 3]>,
    /// The shape of each cell; all have the dimension of the mesh.
    pub shapes: Vec<Shape>,
    /// First entry of each cell in `nodes`, and the end.
    pub start: Vec<u32>,
    /// Nodes of the cells in the order of their shapes.
    pub nodes: Vec<u32>,
    /// Number of each cell in the file, for messages.
    pub numbers: Vec<u64>,
    /// Index of the material of each cell, as asked for.
    pub materials: Vec<u32>,
    /// The body of each cell, numbered by their first cells; cells that share nodes are one body.
    pub bodies: Vec<u32>,
    /// The number of bodies.
    pub body_count: usize,
    /// Parts of bodies that hang on others by nodes alone.
    pub hinges: Hinges,
    /// The surfaces as asked for, in that order.
    pub surfaces: Vec<WholeSurface>,
    /// The interfaces as asked for, in that order.
    pub interfaces: Vec<WholeInterface>,
    /// Where each cell lies in the next coarser mesh; none where there is none.
    pub parents: Vec<Parent>,
    /// What is to be said of the mesh, in words.
    pub remarks: Vec<String>,
}

/// A named surface.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct WholeSurface {
    /// The facets on the boundary of the mesh after cutting: of a group of facets of which an
    /// interface is made, those of both lips. None of groups of edges, points and nodes.
    pub facets: Vec<WholeFacet>,
    /// The nodes, rising: those of the facets, also of facets inside the mesh, with the copies that
    /// belong to their cells; of edges, points and groups of nodes all copies.
    pub nodes: Vec<u32>,
}

/// An interface: two lips that face each other.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WholeInterface {
    /// The facets of the lower and of the upper lip, each with its normal out of its cell. The
    /// normal of the interface points from the lower to the upper one.
    pub lips: [Vec<WholeFacet>; 2],
    /// Of an interface along which the mesh was cut: `lips[0][i]` faces `lips[1][i]` as
    /// `faces[i]` says. Empty for one between two groups.
    pub faces: Vec<Facing>,
    /// Nodes that both facets of a pair share, rising: there the interface is shut.
    pub tips: Vec<u32>,
    /// Copies, on the lips, of nodes where interfaces or branches of one meet or cross, rising.
    pub junctions: Vec<u32>,
    /// Whether the lips may lie apart: sides that face each other across a gap belong together.
    pub has_gap: bool,
    /// Unit normal at each node of both lips, by rising node. It points from the lower lip to the
    /// upper one, and is the same at all copies of a node.
    pub normals: Vec<(u32, [f64; 3])>,
}

/// How the nodes of two facets that were one correspond.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Facing {
    /// Node k of the lower facet, in the order of its shape, faces node `order[k]` of the upper
    /// one; zero beyond the nodes that the facet has.
    pub order: [u8; MAX_FACET_NODES],
}

impl WholeMesh {
    /// The number of components: 2 or 3.
    pub fn dim(&self) -> usize {
        self.axes.len()
    }

    /// The number of cells.
    pub fn cells(&self) -> usize {
        self.shapes.len()
    }

    /// Nodes of a cell in the order of its shape.
    pub fn cell_nodes(&self, cell: usize) -> &[u32] {
        self.view().cell_nodes(cell)
    }

    /// The shape of a facet.
    pub fn facet_shape(&self, facet: WholeFacet) -> Shape {
        self.view().facet_shape(facet)
    }

    /// Nodes of a facet in the order of its shape, whose normal points out of the cell.
    pub fn facet_nodes(&self, facet: WholeFacet) -> impl Iterator<Item = u32> + '_ {
        self.view().facet_nodes(facet)
    }

    /// The nodes of both lips of an interface, without facets.
    pub fn surface_of_lips(&self, interface: usize) -> WholeSurface {
        let facets = self.interfaces[interface].lips.iter().flatten();
        let mut nodes: Vec<u32> = facets.flat_map(|facet| self.facet_nodes(*facet)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        WholeSurface { facets: Vec::new(), nodes }
    }

    /// The cells alone.
    pub(super) fn view(&self) -> View<'_> {
        View { points: &self.points, shapes: &self.shapes, start: &self.start, nodes: &self.nodes }
    }
}
