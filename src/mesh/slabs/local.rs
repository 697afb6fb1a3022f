//! What a rank gets of a mesh that was read in slabs.

use super::skeleton::Star;
use crate::element::Shape;
use crate::mesh::parts::prototypes;
use crate::mesh::whole::WholeFacet;
use crate::mesh::{
    Directions, Facet, FarFacet, Interpolation, LocalMesh, Marks, MeshFacts, Places,
};

/// The cells of a rank.
pub struct Part {
    /// Their names, rising.
    pub cells: Vec<u64>,
    /// Their shapes.
    pub shapes: Vec<Shape>,
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

impl LocalMesh {
    /// The part of a rank of a mesh of which these things are known.
    pub fn of_part(part: Part, facts: MeshFacts, star: &Star) -> Self {
        let Part { cells, shapes, materials, mut nodes, start, connectivity, bodies } = part;
        let marks = |body: &u32| Marks::new(*body as usize, star.surfaces_of_all(), None);
        nodes.marks = bodies.iter().map(marks).collect();
        for (name, marks) in star.nodes.iter().zip(star.mesh.marks()) {
            if let Some(place) = nodes.number(u64::from(*name)) {
                nodes.marks[place] = marks;
                nodes.marks[place].body = bodies[place];
            }
        }
        drop(bodies);
        let of_cells = shapes.iter().copied().zip(&materials).map(|(s, m)| (s, *m as usize));
        let points = |cell: usize, points: &mut Vec<[f64; 3]>| {
            let of_cell = &connectivity[start[cell] as usize..start[cell + 1] as usize];
            points.extend(of_cell.iter().map(|node| nodes.points[*node as usize]));
        };
        let (cell_prototype, prototypes) = prototypes(of_cells, facts.axes, points);
        let own = |facet: &WholeFacet| {
            let name = u64::from(star.cells[facet.cell as usize]);
            let cell = cells.binary_search(&name).ok()?;
            Some(Facet { cell: cell as u32, facet: facet.facet })
        };
        let surfaces = star.mesh.surfaces.iter().map(|surface| {
            let mut own: Vec<Facet> = surface.facets.iter().filter_map(own).collect();
            own.sort_unstable();
            own
        });
        let surfaces = surfaces.collect();
        let (lips, facing) = star.lips(&own);
        let directions = star.directions(&nodes.names);
        Self {
            coarse_cells: facts.cells,
            facts,
            cells,
            cell_prototype,
            prototypes,
            start,
            connectivity,
            nodes,
            surfaces,
            lips,
            facing,
            directions,
            is_of_corners: false,
            parents: Interpolation::default(),
            lattice: None,
        }
    }
}

/// The facets of a rank on both lips of each interface, and what may face each.
type Lips = (Vec<[Vec<Facet>; 2]>, Vec<[Vec<Vec<FarFacet>>; 2]>);

impl Star {
    /// The bits of the surfaces that are every node.
    fn surfaces_of_all(&self) -> u128 {
        let all = self.is_all.iter().enumerate().filter(|(_, is_all)| **is_all);
        all.fold(0, |bits, (place, _)| bits | 1 << place)
    }

    fn lips(&self, own: &dyn Fn(&WholeFacet) -> Option<Facet>) -> Lips {
        let mut all = Lips::default();
        for (interface, far) in self.mesh.interfaces.iter().zip(self.mesh.far_facets()) {
            let (mut lips, mut facing) = (<[Vec<Facet>; 2]>::default(), [Vec::new(), Vec::new()]);
            for lip in [0, 1] {
                let of_lip = interface.lips[lip].iter();
                let mut rows: Vec<(Facet, &WholeFacet)> =
                    of_lip.filter_map(|facet| Some((own(facet)?, facet))).collect();
                rows.sort_unstable_by_key(|(facet, _)| *facet);
                for (facet, whole) in rows {
                    let far = far[lip].get(whole).map_or(&[][..], Vec::as_slice);
                    lips[lip].push(facet);
                    facing[lip].push(far.iter().map(|far| self.far_facet(*far)).collect());
                }
            }
            all.0.push(lips);
            all.1.push(facing);
        }
        all
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
