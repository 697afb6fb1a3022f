//! What is known of a whole mesh, the same on every rank.

use serde::{Deserialize, Serialize};

/// The whole mesh in numbers.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct MeshFacts {
    /// 2 (plane strain) or 3.
    pub dim: usize,
    /// The coordinate axes of the displacement components.
    #[serde(with = "axes")]
    pub axes: &'static [usize],
    /// The least coordinates (m).
    pub origin: [f64; 3],
    /// Extent along x, y, z (m); that across a plane is 0.
    pub size: [f64; 3],
    /// Number of bodies.
    pub bodies: usize,
    /// Number of cells.
    pub cells: u64,
    /// Numbers of cells of the coarser meshes that a file's refined mesh has, coarsest first.
    pub coarser: Vec<u64>,
    /// Number of nodes; all names are below it.
    pub nodes: u64,
    /// Number of nodes that are corners of cells.
    pub corners: u64,
    /// Highest order of any cell.
    pub order: usize,
    /// Most nodes of any cell.
    pub nodes_per_cell: usize,
    /// Nodes of the smallest plane section across an axis, about.
    pub section: f64,
    /// The lips of each interface, the lower one first.
    pub interfaces: Vec<[LipFacts; 2]>,
    /// Of the mesh of a file: what tells it from another one; else 0.
    pub digest: u64,
    /// The names of the interfaces of the mesh of a file, for messages.
    pub names: Vec<String>,
    /// The pairs of bodies that interfaces join, each once.
    pub joints: Vec<Joint>,
    /// Parts of bodies of the mesh of a file that hang on others by nodes alone.
    pub hinges: Hinges,
}

impl MeshFacts {
    /// Whether the mesh of a file has coarser ones: refinement has left them, or cells of second
    /// order have corners.
    pub fn has_coarser(&self) -> bool {
        !self.coarser.is_empty() || self.order > 1
    }
}

/// Two bodies that an interface joins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Joint {
    /// The interface, by its index.
    pub interface: usize,
    /// The body of the lower lip and that of the upper one, which may be the same.
    pub bodies: [usize; 2],
}

/// The parts of bodies that consist of several, and what they hang on.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Hinges {
    /// Cells that share facets, or that an interface joins. None where every body is one part.
    pub parts: Vec<Part>,
    /// The nodes that parts share.
    pub nodes: Vec<HingeNode>,
}

/// Cells that share facets.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// The mean of the nodes of its cells (m).
    pub middle: [f64; 3],
    /// The number of its cells.
    pub cells: u64,
    /// The surfaces, by their index, that nodes of it alone are on.
    pub surfaces: Vec<usize>,
}

/// A node that two parts share.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HingeNode {
    /// Where it is (m).
    pub point: [f64; 3],
    /// Both parts.
    pub parts: [usize; 2],
    /// The surfaces, by their index, that it is on.
    pub surfaces: Vec<usize>,
}

/// One lip of an interface in numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LipFacts {
    /// The body whose face it is, or one of them.
    pub body: usize,
    /// Edge lengths of a cell behind it along x, y, z (m; y is 1 in 2D); where they grow along an
    /// axis across the column, their mean.
    pub cell: [f64; 3],
    /// Index of the material of that cell.
    pub material: usize,
    /// Order of the cells.
    pub order: usize,
    /// Its area (m2; in 2D its length, m).
    pub area: f64,
    /// Whether it has triangles of second order, so that the ends of edges have a share in the
    /// displacement of their middles.
    pub has_shares: bool,
    /// Surfaces of the case, one bit for each by its place in the list: those with all nodes of
    /// some of its facets, and those with all of its nodes.
    pub surfaces: [u128; 2],
}

/// The dual graph of a mesh in compressed form: cells that share a facet or face each other.
#[derive(Debug, Clone, PartialEq)]
pub struct DualGraph {
    /// First neighbour of each cell, and the end.
    pub start: Vec<i32>,
    /// Neighbours, cell by cell.
    pub neighbours: Vec<i32>,
    /// Weight of each of these edges.
    pub weights: Vec<i32>,
    /// Work of each cell.
    pub work: Vec<i32>,
}

/// The axes on their journey between ranks.
mod axes {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    const ALL: [&[usize]; 4] = [&[], &[0, 1], &[0, 2], &[0, 1, 2]];

    pub fn serialize<S: Serializer>(axes: &&'static [usize], to: S) -> Result<S::Ok, S::Error> {
        axes.serialize(to)
    }

    pub fn deserialize<'d, D: Deserializer<'d>>(from: D) -> Result<&'static [usize], D::Error> {
        let sent = Vec::<usize>::deserialize(from)?;
        let known = ALL.into_iter().find(|axes| *axes == sent.as_slice());
        known.ok_or_else(|| D::Error::custom("axes that no mesh has"))
    }
}
