//! A mesh as a file holds it: what the readers of all formats fill.

use serde::{Deserialize, Serialize};

/// The kinds of elements that files hold; nodes in the order of VTK.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Kind {
    /// One node.
    Point1,
    /// A line of its two ends.
    Line2,
    /// A line with a node in its middle.
    Line3,
    /// A triangle of three corners.
    Tri3,
    /// A triangle with a node on each side.
    Tri6,
    /// A quadrilateral of four corners.
    Quad4,
    /// A quadrilateral with a node on each side.
    Quad8,
    /// A quadrilateral with a node on each side and one in its middle.
    Quad9,
    /// A tetrahedron of four corners.
    Tet4,
    /// A tetrahedron with a node on each edge.
    Tet10,
    /// A prism of six corners.
    Prism6,
    /// A prism with a node on each edge.
    Prism15,
    /// A prism with a node on each edge and on each quadrilateral.
    Prism18,
    /// A pyramid of five corners.
    Pyramid5,
    /// A pyramid with a node on each edge.
    Pyramid13,
    /// A pyramid with a node on each edge and on its base; VTK has none.
    Pyramid14,
    /// A hexahedron of eight corners.
    Hex8,
    /// A hexahedron with a node on each edge.
    Hex20,
    /// A hexahedron with a node on each edge and face and one in its middle.
    Hex27,
}

impl Kind {
    /// The number of nodes.
    pub fn nodes(self) -> usize {
        match self {
            Kind::Point1 => 1,
            Kind::Line2 => 2,
            Kind::Line3 | Kind::Tri3 => 3,
            Kind::Quad4 | Kind::Tet4 => 4,
            Kind::Pyramid5 => 5,
            Kind::Tri6 | Kind::Prism6 => 6,
            Kind::Quad8 | Kind::Hex8 => 8,
            Kind::Quad9 => 9,
            Kind::Tet10 => 10,
            Kind::Pyramid13 => 13,
            Kind::Pyramid14 => 14,
            Kind::Prism15 => 15,
            Kind::Prism18 => 18,
            Kind::Hex20 => 20,
            Kind::Hex27 => 27,
        }
    }

    /// The dimension, 0 to 3.
    pub fn dim(self) -> usize {
        match self {
            Kind::Point1 => 0,
            Kind::Line2 | Kind::Line3 => 1,
            Kind::Tri3 | Kind::Tri6 | Kind::Quad4 | Kind::Quad8 | Kind::Quad9 => 2,
            _ => 3,
        }
    }

    /// The name for messages.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Point1 => "point",
            Kind::Line2 => "line of 2 nodes",
            Kind::Line3 => "line of 3 nodes",
            Kind::Tri3 => "triangle of 3 nodes",
            Kind::Tri6 => "triangle of 6 nodes",
            Kind::Quad4 => "quadrilateral of 4 nodes",
            Kind::Quad8 => "quadrilateral of 8 nodes",
            Kind::Quad9 => "quadrilateral of 9 nodes",
            Kind::Tet4 => "tetrahedron of 4 nodes",
            Kind::Tet10 => "tetrahedron of 10 nodes",
            Kind::Prism6 => "prism of 6 nodes",
            Kind::Prism15 => "prism of 15 nodes",
            Kind::Prism18 => "prism of 18 nodes",
            Kind::Pyramid5 => "pyramid of 5 nodes",
            Kind::Pyramid13 => "pyramid of 13 nodes",
            Kind::Pyramid14 => "pyramid of 14 nodes",
            Kind::Hex8 => "hexahedron of 8 nodes",
            Kind::Hex20 => "hexahedron of 20 nodes",
            Kind::Hex27 => "hexahedron of 27 nodes",
        }
    }
}

/// Elements of one kind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// What they are.
    pub kind: Kind,
    /// Indices into the points, `kind.nodes()` for each element, in the order of VTK.
    pub nodes: Vec<u32>,
    /// The numbers of the elements in the file, for messages.
    pub numbers: Vec<u64>,
    /// The set of groups of each element, an index into [`FileMesh::group_sets`].
    pub groups: Vec<u32>,
}

/// A named group of elements or nodes of one dimension.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Group {
    /// As in the file; unique among the groups of its dimension.
    pub name: String,
    /// The dimension of its elements, 0 to 3.
    pub dim: usize,
}

/// All that a file says of a mesh, before it is checked and cut.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FileMesh {
    /// Coordinates, in the unit of the file.
    pub points: Vec<[f64; 3]>,
    /// The numbers of the points in the file, for messages.
    pub node_numbers: Vec<u64>,
    /// Elements, at most one block for each kind.
    pub blocks: Vec<Block>,
    /// Distinct sets of groups (indices into `groups`, rising); set 0 is empty.
    pub group_sets: Vec<Vec<u32>>,
    /// The groups, also those without elements.
    pub groups: Vec<Group>,
    /// Groups of nodes: the group, and its nodes, rising.
    pub node_groups: Vec<(u32, Vec<u32>)>,
    /// What is to be said of the file, in words.
    pub remarks: Vec<String>,
}
