//! What a case asks of a mesh from a file.

use super::facet::WholeFacet;

/// What is to be made of a mesh from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// Metres per unit of length of the file; positive.
    pub scale: f64,
    /// The order to which cells of first order are raised: 2, or none to leave them as they are.
    pub raise_order: Option<u32>,
    /// How often every edge is halved after that.
    pub refine: u32,
    /// The groups of cells of each material. A single material without groups has all cells.
    pub materials: Vec<MaterialGroups>,
    /// Names of groups of facets, edges, points or nodes; `all`, where the file has no such group
    /// with elements, is every node.
    pub surfaces: Vec<String>,
    /// The interfaces.
    pub interfaces: Vec<InterfaceRequest>,
    /// Facets to be divided before anything else, of the mesh as it is made without that and
    /// without refinement; those that cannot be stay.
    pub divided: Vec<WholeFacet>,
}

/// A material and its cells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MaterialGroups {
    /// Name of the material, for messages.
    pub name: String,
    /// The groups of its cells.
    pub groups: Vec<String>,
}

/// An interface and its facets.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InterfaceRequest {
    /// Name of the interface, for messages.
    pub name: String,
    /// Where it is.
    pub place: InterfacePlace,
}

/// Where an interface is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum InterfacePlace {
    /// On facets inside a conforming mesh, which is cut there.
    On {
        /// The group of the facets. Their normals, made one over each piece and over pieces that
        /// go straight on at a crossing, are those of the first facet of the file, and point from
        /// the lower to the upper side.
        group: String,
        /// Whether all normals are turned round.
        flip: bool,
    },
    /// Between the boundaries of bodies that share no nodes there.
    Between {
        /// The group of the facets of the lower side.
        lower: String,
        /// The group of the facets of the upper side.
        upper: String,
        /// Whether the sides may lie apart.
        has_gap: bool,
    },
}
