//! What a rank gets of a mesh that was read in slabs.

use super::skeleton::Star;
use crate::element::Shape;
use crate::mesh::parts::BarePart;
use crate::mesh::whole::{WholeFacet, WholeMesh};
use crate::mesh::{Directions, Facet, FarFacet, LocalMesh, Marks, MeshFacts, Places};

/// Nodes whose bodies are given back together once they are told.
const AT_ONCE: usize = 1 << 16;

/// The cells of a rank.
pub struct Part {
    /// Their names, rising.
    pub cells: Vec<u64>,
    /// Their shapes, each with the number of cells beside each other that have it.
    pub shapes: Vec<(Shape, usize)>,
    /// Their materials.
    pub materials: Vec<u32>,
    /// Names of nodes, rising, with positions (m); marks are still to come.
    pub nodes: Places,
    /// First node of each cell, and the end.
    pub start: Vec<u32>,
    /// Nodes of the cells by place.
    pub connectivity: Vec<u32>,
    /// The body of each node.
    pub bodies: Vec<u32>,
}

impl Part {
    /// The shape of each cell.
    pub fn shapes(&self) -> impl Iterator<Item = Shape> {
        each(&self.shapes)
    }
}

impl LocalMesh {
    /// The part of a rank of a mesh of which these things are known, without marks, which are still
    /// to be put in; and the cells behind surfaces and interfaces, where there are interfaces.
    pub fn of_part(
        part: Part,
        facts: MeshFacts,
        star: Star,
        directions: Directions,
    ) -> (Self, Marking, Option<WholeMesh>) {
        let Part { cells, shapes, materials, nodes, start, connectivity, bodies } = part;
        // What takes memory for a moment comes before what stays.
        let marking = Marking {
            bodies: bodies.chunks(AT_ONCE).map(<[u32]>::to_vec).collect(),
            on_all: star.surfaces_of_all(),
            told: star.marks_at(&nodes),
        };
        drop(bodies);
        let far = star.mesh.far_facets();
        let bare = BarePart { cells, materials, start, connectivity, nodes };
        let mut mesh = Self::bare(facts, bare, each(&shapes));
        let cells = std::mem::take(&mut mesh.cells);
        let own = |facet: &WholeFacet| {
            let name = u64::from(star.cells[facet.cell as usize]);
            let cell = cells.binary_search(&name).ok()?;
            Some(Facet { cell: cell as u32, facet: facet.facet })
        };
        mesh.add_groups(&star.mesh, &far, &own, &|far| star.far_facet(far));
        mesh.cells = cells;
        mesh.directions = directions;
        let behind = Some(star.mesh).filter(|mesh| !mesh.interfaces.is_empty());
        (mesh, marking, behind)
    }
}

/// The marks of the nodes of a part, before they take the memory that they take in the end.
pub struct Marking {
    /// The bodies of the nodes.
    bodies: Vec<Vec<u32>>,
    /// The bits of the surfaces that are every node.
    on_all: u128,
    /// The marks of nodes that have others, with their places.
    told: Vec<(u32, Marks)>,
}

impl Marking {
    /// Puts the marks into the part.
    pub fn mark(self, mesh: &mut LocalMesh) {
        let marks = &mut mesh.nodes.marks;
        marks.reserve_exact(mesh.nodes.names.len());
        let plain = |body: u32| Marks::new(body as usize, self.on_all, None);
        marks.extend(self.bodies.into_iter().flatten().map(plain));
        for (place, told) in self.told {
            let known = &mut marks[place as usize];
            *known = told.in_body(known.body);
        }
    }
}

/// The shape of each cell.
fn each(shapes: &[(Shape, usize)]) -> impl Iterator<Item = Shape> {
    shapes.iter().flat_map(|(shape, count)| std::iter::repeat_n(*shape, *count))
}

impl Star {
    /// The marks, but for the body, of its nodes that are among others and lie on something that
    /// not all do, with the places there.
    fn marks_at(&self, nodes: &Places) -> Vec<(u32, Marks)> {
        let plain = Marks::new(0, self.surfaces_of_all(), None);
        let of_all = self.nodes.iter().zip(self.mesh.marks());
        let told = of_all.filter(|(_, marks)| marks.in_body(0) != plain);
        let here = told.filter_map(|(name, marks)| {
            nodes.number(u64::from(*name)).map(|place| (place as u32, marks))
        });
        here.collect()
    }

    /// The bits of the surfaces that are every node.
    fn surfaces_of_all(&self) -> u128 {
        let all = self.is_all.iter().enumerate().filter(|(_, is_all)| **is_all);
        all.fold(0, |bits, (place, _)| bits | 1 << place)
    }

    fn far_facet(&self, facet: WholeFacet) -> FarFacet {
        let mut far = self.mesh.far_facet(facet);
        far.cell = u64::from(self.cells[far.cell as usize]);
        for node in &mut far.nodes {
            *node = u64::from(self.nodes[*node as usize]);
        }
        far
    }

    /// Normals and middles of edges at nodes of these rising names, by place.
    pub fn directions(&self, names: &[u64]) -> Directions {
        self.mesh.directions().named(&self.nodes).of_nodes(names)
    }
}
