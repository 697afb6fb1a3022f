//! What a rank gets of a mesh that was read in slabs.

use super::skeleton::Star;
use crate::element::Shape;
use crate::mesh::parts::BarePart;
use crate::mesh::whole::WholeFacet;
use crate::mesh::{Directions, Facet, FarFacet, LocalMesh, Marks, MeshFacts, Places};

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
    /// The part of a rank of a mesh of which these things are known.
    pub fn of_part(part: Part, facts: MeshFacts, star: &Star) -> Self {
        let Part { cells, shapes, materials, mut nodes, start, connectivity, bodies } = part;
        // What takes memory for a moment comes before what stays.
        let (of_star, far) = (star.mesh.marks(), star.mesh.far_facets());
        let directions = star.directions(&nodes.names);
        let marks = |body: &u32| Marks::new(*body as usize, star.surfaces_of_all(), None);
        nodes.marks = bodies.iter().map(marks).collect();
        for (name, marks) in star.nodes.iter().zip(of_star) {
            if let Some(place) = nodes.number(u64::from(*name)) {
                nodes.marks[place] = marks;
                nodes.marks[place].body = bodies[place];
            }
        }
        drop(bodies);
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
        mesh
    }
}

/// The shape of each cell.
fn each(shapes: &[(Shape, usize)]) -> impl Iterator<Item = Shape> {
    shapes.iter().flat_map(|(shape, count)| std::iter::repeat_n(*shape, *count))
}

impl Star {
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

    /// Those at nodes of these rising names, by place.
    fn directions(&self, names: &[u64]) -> Directions {
        self.mesh.directions().named(&self.nodes).of_nodes(names)
    }
}
