//! The part of the mesh that one rank holds, as arrays.

use serde::{Deserialize, Serialize};

use super::directions::Directions;
use super::lattice::Column;
use super::marks::{Lip, Marks};
use super::{Geometry, MeshFacts, Prototype};
use crate::case::SurfaceBit;
use crate::element::Shape;

/// Nodes by number: their names, positions and marks.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Places {
    /// Names.
    pub names: Vec<u64>,
    /// Positions (m).
    pub points: Vec<[f64; 3]>,
    /// Bodies, surfaces and lips.
    pub marks: Vec<Marks>,
}

/// A facet of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Facet {
    /// The cell, by its number on this rank.
    pub cell: u32,
    /// Which of `Shape::facets` it is.
    pub facet: u8,
}

/// A facet of a cell of any rank.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FarFacet {
    /// Name of the cell.
    pub cell: u64,
    /// Shape of the facet.
    pub shape: Shape,
    /// Names of the nodes, in the order of the shape.
    pub nodes: Vec<u64>,
    /// Their positions (m).
    pub points: Vec<[f64; 3]>,
}

/// How nodes of a mesh depend on those of a coarser one.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Interpolation {
    /// First entry of each fine node, and the end.
    pub start: Vec<u32>,
    /// Names of coarse nodes.
    pub names: Vec<u64>,
    /// Their parts.
    pub weights: Vec<f64>,
    /// Whether it is that of a mesh from a file, whose nodes may have frames and whose lips may
    /// have common nodes.
    pub is_of_file: bool,
}

impl Interpolation {
    /// That of nodes with these names of coarse nodes and parts.
    pub(super) fn from_rows(rows: &[Vec<(u64, f64)>]) -> Self {
        let mut all = Self { start: vec![0], ..Self::default() };
        for row in rows {
            all.names.extend(row.iter().map(|(name, _)| *name));
            all.weights.extend(row.iter().map(|(_, part)| *part));
            all.start.push(all.names.len() as u32);
        }
        all
    }

    /// That of nodes by number; a node without a number depends on none.
    pub(super) fn of(&self, numbers: impl Iterator<Item = Option<usize>>) -> Self {
        let mut all = Self { start: vec![0], is_of_file: true, ..Self::default() };
        for number in numbers {
            if let Some(number) = number {
                let range = self.start[number] as usize..self.start[number + 1] as usize;
                all.names.extend_from_slice(&self.names[range.clone()]);
                all.weights.extend_from_slice(&self.weights[range]);
            }
            all.start.push(all.names.len() as u32);
        }
        all
    }
}

/// The cells of one rank, with their nodes by number.
///
/// Nodes are numbered by rising name; the numbering of the unknowns reorders them later.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct LocalMesh {
    /// What is known of the whole mesh; known beforehand where a mesh is sent.
    #[serde(skip)]
    pub facts: MeshFacts,
    /// Cell names, rising.
    pub cells: Vec<u64>,
    /// Index into `prototypes` of each cell.
    pub cell_prototype: Vec<u32>,
    /// The prototypes that occur on this rank.
    pub prototypes: Vec<Prototype>,
    /// First entry of each cell in `connectivity`, and the end.
    pub(super) start: Vec<u32>,
    /// Nodes of the cells in the order of their shapes.
    pub(super) connectivity: Vec<u32>,
    /// The nodes of the cells, by rising name.
    pub nodes: Places,
    /// The facets on each surface of the case, by rising cell.
    pub(super) surfaces: Vec<Vec<Facet>>,
    /// The facets on both lips of each interface, by rising cell.
    pub(super) lips: Vec<[Vec<Facet>; 2]>,
    /// For each facet of `lips` the facets of any rank that may face it; none in lattices, where
    /// they are found when they are asked for.
    pub(super) facing: Vec<[Vec<Vec<FarFacet>>; 2]>,
    /// Directions at the nodes that are not those of the axes; none in lattices.
    pub directions: Directions,
    /// Cells that the largest mesh held by any rank before the distribution had.
    pub coarse_cells: u64,
    /// Whether the nodes are the corners of the cells only.
    pub(super) is_of_corners: bool,
    /// How the nodes depend on those of the next coarser mesh of a file, by number; nothing where
    /// there is none, and in lattices, where it is found when it is asked for.
    pub(super) parents: Interpolation,
    /// What the arrays were made of, where that was a lattice.
    #[serde(skip)]
    pub(super) lattice: Option<Column>,
}

impl LocalMesh {
    /// Displacement components per node.
    pub fn dim(&self) -> usize {
        self.facts.dim
    }

    /// The lattice of these cells, where there is one.
    pub fn lattice(&self) -> Option<&Column> {
        self.lattice.as_ref()
    }

    /// Highest order of the cells of any rank, as far as they have nodes here.
    pub fn order(&self) -> usize {
        if self.is_of_corners { 1 } else { self.facts.order }
    }

    /// Whether it is the mesh of a file.
    pub fn is_of_file(&self) -> bool {
        self.lattice.is_none()
    }

    /// The prototype of a cell.
    pub fn prototype(&self, cell: usize) -> &Prototype {
        &self.prototypes[self.cell_prototype[cell] as usize]
    }

    /// The shape of a cell, as far as it has nodes here.
    pub fn shape(&self, cell: usize) -> Shape {
        let shape = self.prototype(cell).shape;
        if self.is_of_corners { shape.corners() } else { shape }
    }

    /// Edge lengths along x, y, z of the smallest box around a cell (m; y is 1 in 2D boxes).
    pub fn extent(&self, cell: usize) -> [f64; 3] {
        if let Geometry::Box(size) = self.prototype(cell).geometry {
            return size;
        }
        let points = || self.cell_nodes(cell).iter().map(|n| self.nodes.points[*n as usize]);
        std::array::from_fn(|i| {
            let along = || points().map(|x| x[i]);
            along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
        })
    }

    /// Nodes of a cell in the order of its shape.
    pub fn cell_nodes(&self, cell: usize) -> &[u32] {
        &self.connectivity[self.start[cell] as usize..self.start[cell + 1] as usize]
    }

    /// The facets of this rank's cells on a surface of the case, by rising cell; none of `all`.
    pub fn on_surface(&self, surface: SurfaceBit) -> &[Facet] {
        match surface {
            SurfaceBit::All => &[],
            SurfaceBit::Place(place) => self.surfaces.get(place).map_or(&[], Vec::as_slice),
        }
    }

    /// The facets of this rank's cells on a lip of an interface, by rising cell.
    pub fn on_lip(&self, interface: usize, lip: Lip) -> &[Facet] {
        &self.lips[interface][lip.index()]
    }

    /// Shape and nodes of a facet, in the order in which its normal points out of the cell.
    pub fn facet_nodes(&self, facet: Facet) -> (Shape, Vec<u32>) {
        let (nodes, shape) =
            (self.cell_nodes(facet.cell as usize), self.shape(facet.cell as usize));
        let local = facet.facet as usize;
        let of_facet = shape.facet_shape(local).expect("cells have two or three dimensions");
        let order = shape.facets()[local].iter();
        (of_facet, order.map(|a| nodes[*a]).collect())
    }

    /// The facets of any rank that face a facet of this rank's cells on a lip of an interface, or
    /// may.
    pub fn across(&self, interface: usize, lip: Lip, facet: Facet) -> Vec<FarFacet> {
        if let Some(column) = &self.lattice {
            return self.across_lattice(column, interface, lip, facet);
        }
        let facets = &self.lips[interface][lip.index()];
        let Ok(place) = facets.binary_search(&facet) else { return Vec::new() };
        let mut facing = self.facing[interface][lip.index()][place].clone();
        if self.is_of_corners {
            for far in &mut facing {
                far.shape = far.shape.corners();
                far.nodes.truncate(far.shape.nodes());
                far.points.truncate(far.shape.nodes());
            }
        }
        facing
    }

    /// The cell of this rank that holds a point, and the reference coordinates there. A point on an
    /// interface of a lattice belongs to the body below, and is found by exactly one rank; in other
    /// meshes every rank that holds such a cell finds the first of its own.
    pub fn locate(&self, point: [f64; 3]) -> Option<(usize, [f64; 3])> {
        if let Some(column) = &self.lattice {
            return self.locate_in_lattice(column, point);
        }
        let cells = 0..self.cells.len();
        cells.into_iter().find_map(|cell| Some((cell, self.coordinates_in(cell, point)?)))
    }

    /// Shape and nodes of a facet of a lip, in an order in which both lips run the same way: x
    /// before y.
    pub fn lip_nodes(&self, lip: Lip, facet: Facet) -> (Shape, Vec<u32>) {
        let (shape, nodes) = self.facet_nodes(facet);
        // Seen from above in 3D; along x in 2D.
        let runs_back = (lip == Lip::Upper) == (self.dim() == 3);
        if !runs_back {
            return (shape, nodes);
        }
        let order = shape.mirrored().iter();
        (shape, order.map(|a| nodes[*a]).collect())
    }

    /// The same cells with their corners as only nodes: those of a field of first order. The names
    /// stay.
    pub fn corners(&self) -> Self {
        let corners = |cell: usize| &self.cell_nodes(cell)[..self.shape(cell).corners().nodes()];
        let cells = 0..self.cells.len();
        let mut is_corner = vec![false; self.nodes.names.len()];
        for node in cells.clone().flat_map(corners) {
            is_corner[*node as usize] = true;
        }
        let kept: Vec<usize> = (0..is_corner.len()).filter(|node| is_corner[*node]).collect();
        let mut new = vec![0; is_corner.len()];
        kept.iter().enumerate().for_each(|(number, node)| new[*node] = number as u32);
        let (mut start, mut connectivity) = (vec![0], Vec::new());
        for cell in cells {
            connectivity.extend(corners(cell).iter().map(|node| new[*node as usize]));
            start.push(connectivity.len() as u32);
        }
        Self {
            facts: self.facts.clone(),
            cells: self.cells.clone(),
            cell_prototype: self.cell_prototype.clone(),
            prototypes: self.prototypes.clone(),
            start,
            connectivity,
            nodes: self.nodes.picked(&kept),
            surfaces: self.surfaces.clone(),
            lips: self.lips.clone(),
            facing: self.facing.clone(),
            directions: self.directions.clone(),
            coarse_cells: self.coarse_cells,
            is_of_corners: true,
            parents: Interpolation::default(),
            lattice: self.lattice.clone(),
        }
    }
}

impl Places {
    /// Those of the given numbers.
    pub fn picked(&self, numbers: &[usize]) -> Self {
        Self {
            names: numbers.iter().map(|n| self.names[*n]).collect(),
            points: numbers.iter().map(|n| self.points[*n]).collect(),
            marks: numbers.iter().map(|n| self.marks[*n]).collect(),
        }
    }

    /// Name, position and marks of every node.
    pub fn iter(&self) -> impl Iterator<Item = (u64, [f64; 3], &Marks)> {
        let places = self.names.iter().zip(&self.points).zip(&self.marks);
        places.map(|((name, point), marks)| (*name, *point, marks))
    }

    /// The number of a node, where names rise.
    pub fn number(&self, name: u64) -> Option<usize> {
        self.names.binary_search(&name).ok()
    }
}
