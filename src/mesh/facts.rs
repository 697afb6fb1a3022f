//! What is known of a whole mesh, the same on every rank.

/// The whole mesh in numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshFacts {
    /// 2 (x, z; plane strain) or 3.
    pub dim: usize,
    /// Extent along x, y, z (m); y is 0 in 2D.
    pub size: [f64; 3],
    /// Number of bodies.
    pub bodies: usize,
    /// Number of cells.
    pub cells: u64,
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
}

/// One lip of an interface in numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LipFacts {
    /// The body whose face it is.
    pub body: usize,
    /// Edge lengths of a cell behind it along x, y, z (m; y is 1 in 2D).
    pub cell: [f64; 3],
    /// Index of the material of that cell.
    pub material: usize,
    /// Order of the cells.
    pub order: usize,
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
