//! The part of the mesh that one rank holds, as arrays.

use std::collections::HashMap;

use super::MeshFacts;
use super::lattice::Column;
use super::marks::{Lip, Marks, SURFACES};
use crate::case::Surface;
use crate::element::Shape;

/// A cell that stands for all its like: cells of one geometry, material and order are identical up
/// to translation, and share one stiffness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prototype {
    /// Edge lengths along x, y, z (m; y is 1 in 2D).
    pub size: [f64; 3],
    /// Index of the material.
    pub material: usize,
    /// The shape of the cell.
    pub shape: Shape,
}

/// Nodes by number: their names, positions and marks.
#[derive(Debug, Clone, Default)]
pub struct Places {
    /// Names.
    pub names: Vec<u64>,
    /// Positions (m).
    pub points: Vec<[f64; 3]>,
    /// Bodies, surfaces and lips.
    pub marks: Vec<Marks>,
}

/// A facet of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Facet {
    /// The cell, by its number on this rank.
    pub cell: u32,
    /// Which of `Shape::facets` it is.
    pub facet: u8,
}

/// A facet of a cell of any rank.
#[derive(Debug, Clone, PartialEq)]
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
#[derive(Debug, Clone, Default)]
pub struct Interpolation {
    /// First entry of each fine node, and the end.
    pub start: Vec<u32>,
    /// Names of coarse nodes.
    pub names: Vec<u64>,
    /// Their parts.
    pub weights: Vec<f64>,
}

/// The cells of one rank, with their nodes by number.
///
/// Nodes are numbered by rising name; the numbering of the unknowns reorders them later.
#[derive(Debug, Clone)]
pub struct LocalMesh {
    /// What is known of the whole mesh.
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
    /// The facets on each named surface, by rising cell.
    pub(super) surfaces: [Vec<Facet>; SURFACES.len()],
    /// The facets on both lips of each interface, by rising cell.
    pub(super) lips: Vec<[Vec<Facet>; 2]>,
    /// Cells that the largest mesh held by any rank before the distribution had.
    pub coarse_cells: u64,
    /// Whether the nodes are the corners of the cells only.
    pub(super) is_of_corners: bool,
    /// What the arrays were made of.
    pub(super) lattice: Column,
}

impl LocalMesh {
    /// Displacement components per node.
    pub fn dim(&self) -> usize {
        self.facts.dim
    }

    /// The lattice of these cells, where there is one.
    pub fn lattice(&self) -> Option<&Column> {
        Some(&self.lattice)
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

    /// Nodes of a cell in the order of its shape.
    pub fn cell_nodes(&self, cell: usize) -> &[u32] {
        &self.connectivity[self.start[cell] as usize..self.start[cell + 1] as usize]
    }

    /// The facets of this rank's cells on a named surface, by rising cell; none of `all`.
    pub fn on_surface(&self, surface: Surface) -> &[Facet] {
        SURFACES.iter().position(|s| *s == surface).map_or(&[], |index| &self.surfaces[index])
    }

    /// The facets of this rank's cells on a lip of an interface, by rising cell.
    pub fn on_lip(&self, interface: usize, lip: Lip) -> &[Facet] {
        &self.lips[interface][lip.index()]
    }

    /// Shape and nodes of a facet, in the order in which its normal points out of the cell.
    pub fn facet_nodes(&self, facet: Facet) -> (Shape, Vec<u32>) {
        let (nodes, shape) =
            (self.cell_nodes(facet.cell as usize), self.shape(facet.cell as usize));
        let of_facet = shape.facet().expect("cells have two or three dimensions");
        let order = shape.facets()[facet.facet as usize].iter();
        (of_facet, order.map(|a| nodes[*a]).collect())
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
            coarse_cells: self.coarse_cells,
            is_of_corners: true,
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

/// Cells whose edges differ by less than this part of them are alike.
const ALIKE: f64 = 1e-12;
/// Bits of a length that are not told apart, so many that alike lengths fall into one class or into
/// neighbouring ones.
const COARSE: u32 = 14;

/// Prototypes by geometry, each found in the same time however many there are.
#[derive(Default)]
pub(super) struct Prototypes {
    pub list: Vec<Prototype>,
    classes: HashMap<(usize, Shape, [u64; 3]), Vec<u32>>,
}

impl Prototypes {
    /// The number of the first prototype that is like `cell`, which becomes one if there is none.
    pub fn number(&mut self, cell: Prototype) -> u32 {
        let alike = |other: &Prototype| {
            (0..3).all(|i| (other.size[i] - cell.size[i]).abs() <= ALIKE * cell.size[i])
        };
        let ends = cell.size.map(|x| [x * (1.0 - ALIKE), x * (1.0 + ALIKE)].map(class));
        let mut first: Option<u32> = None;
        for corner in 0..8 {
            let end = |axis: usize| corner >> axis & 1;
            // Usually both ends are of one class.
            if (0..3).any(|axis| end(axis) == 1 && ends[axis][0] == ends[axis][1]) {
                continue;
            }
            let key = (cell.material, cell.shape, [0, 1, 2].map(|axis| ends[axis][end(axis)]));
            let found = self.classes.get(&key).into_iter().flatten();
            let found = found.copied().filter(|number| alike(&self.list[*number as usize]));
            first = first.into_iter().chain(found).min();
        }
        first.unwrap_or_else(|| {
            let number = self.list.len() as u32;
            let key = (cell.material, cell.shape, cell.size.map(class));
            self.classes.entry(key).or_default().push(number);
            self.list.push(cell);
            number
        })
    }
}

fn class(length: f64) -> u64 {
    length.to_bits() >> COARSE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_alike_whatever_their_number() {
        let cell = |size| Prototype { size, material: 0, shape: Shape::Hex8 };
        let mut prototypes = Prototypes::default();
        let count = 70_000_u32;
        let edge = |i: u32| 1.0 + 1e-9 * f64::from(i);
        for i in 0..count {
            assert_eq!(prototypes.number(cell([edge(i), 1.0, 2.0])), i);
        }
        for i in (0..count).step_by(7) {
            for by in [0.0, 9e-13, -9e-13] {
                assert_eq!(prototypes.number(cell([edge(i) * (1.0 + by), 1.0 + by, 2.0])), i);
            }
        }
        let other = Prototype { material: 1, ..cell([1.0; 3]) };
        assert_eq!(prototypes.number(other), count);
        assert_eq!(prototypes.list.len(), count as usize + 1);
    }
}
