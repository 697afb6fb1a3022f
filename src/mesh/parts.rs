//! What each rank gets of a whole mesh.

use std::collections::BTreeMap;

use super::prototype::Prototypes;
use super::whole::{WholeFacet, WholeInterface, WholeMesh, area, digest, facing, surface_normals};
use super::{
    Directions, Facet, FarFacet, Geometry, Interpolation, Joint, Lip, LipFacts, LipNormal,
    LocalMesh, Marks, MeshFacts, MidNode, Places, Prototype, SurfaceNormal,
};
use crate::element::{Shape, mapping, stiffness_rule};

/// Of a node whose surface has no place in a rank's part.
const NOT_HERE: u32 = u32::MAX;

impl WholeMesh {
    /// What is known of the mesh.
    pub fn facts(&self) -> MeshFacts {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for point in &self.points {
            for i in 0..3 {
                low[i] = low[i].min(point[i]);
                high[i] = high[i].max(point[i]);
            }
        }
        let mut is_corner = vec![false; self.points.len()];
        for cell in 0..self.cells() {
            let corners = self.shapes[cell].corners().nodes();
            self.cell_nodes(cell)[..corners].iter().for_each(|n| is_corner[*n as usize] = true);
        }
        let (nodes, dim) = (self.points.len() as u64, self.dim());
        let share = (dim as f64 - 1.0) / dim as f64;
        MeshFacts {
            dim,
            axes: self.axes,
            origin: low,
            size: std::array::from_fn(|i| high[i] - low[i]),
            bodies: self.body_count,
            cells: self.cells() as u64,
            coarser: Vec::new(),
            nodes,
            corners: is_corner.iter().filter(|is| **is).count() as u64,
            order: self.shapes.iter().map(|shape| shape.order()).max().unwrap_or(1),
            nodes_per_cell: self.shapes.iter().map(|shape| shape.nodes()).max().unwrap_or(8),
            section: (nodes as f64).powf(share),
            interfaces: self.interfaces.iter().map(|i| self.lip_facts(i)).collect(),
            digest: digest(self),
            names: Vec::new(),
            joints: self.joints(),
            hinges: self.hinges.clone(),
        }
    }

    /// The pairs of bodies that interfaces join.
    fn joints(&self) -> Vec<Joint> {
        let mut joints = Vec::new();
        let body = |facet: &WholeFacet| self.bodies[facet.cell as usize] as usize;
        for (interface, of) in self.interfaces.iter().enumerate() {
            let mut join = |pair: [WholeFacet; 2]| {
                joints.push(Joint { interface, bodies: pair.each_ref().map(body) });
            };
            if of.faces.is_empty() {
                facing(self, of).into_iter().for_each(&mut join);
            } else {
                of.lips[0].iter().zip(&of.lips[1]).for_each(|(one, other)| join([*one, *other]));
            }
        }
        joints.sort_unstable();
        joints.dedup();
        joints
    }

    /// Both lips in numbers: means over their facets.
    fn lip_facts(&self, interface: &WholeInterface) -> [LipFacts; 2] {
        interface.lips.each_ref().map(|lip| {
            let cell = lip.first().map_or(0, |facet| facet.cell as usize);
            let area = area(self, lip);
            let volume: f64 = lip.iter().map(|facet| self.volume(facet.cell as usize)).sum();
            let edge = (area / lip.len().max(1) as f64).powf(1.0 / (self.dim() as f64 - 1.0));
            let triangles = |facet: &WholeFacet| self.facet_shape(*facet) == Shape::Tri6;
            LipFacts {
                body: self.bodies[cell] as usize,
                cell: [edge, if self.dim() == 3 { edge } else { 1.0 }, volume / area],
                material: self.materials[cell] as usize,
                order: self.shapes[cell].order(),
                area,
                has_shares: lip.iter().any(triangles),
                surfaces: self.surfaces_of(lip),
            }
        })
    }

    /// The parts of ranks, each of which gets the cells that `rank_of` gives it.
    pub fn parts(&self, rank_of: &[i32], ranks: usize) -> Vec<LocalMesh> {
        let facts = self.facts();
        let mut places = vec![0; self.cells()];
        let mut cells = vec![Vec::new(); ranks];
        for (cell, rank) in rank_of.iter().enumerate() {
            let of_rank = &mut cells[*rank as usize];
            places[cell] = of_rank.len() as u32;
            of_rank.push(cell as u64);
        }
        let marks = self.marks();
        let far = self.far_facets();
        let directions = self.directions();
        let mut local = vec![NOT_HERE; self.points.len()];
        let of_rank = |(rank, cells): (usize, Vec<u64>)| {
            let mut part = self.cells_of(facts.clone(), cells, &marks, &mut local);
            let own = |facet: &WholeFacet| {
                (rank_of[facet.cell as usize] == rank as i32)
                    .then(|| Facet { cell: places[facet.cell as usize], facet: facet.facet })
            };
            part.add_groups(self, &far, &own, &|facet| self.far_facet(facet));
            part.directions = directions.of_nodes(&part.nodes.names);
            part
        };
        cells.into_iter().enumerate().map(of_rank).collect()
    }

    /// Whether some node of an interface is doubtful.
    pub fn touches_interfaces(&self, is_doubtful: &dyn Fn(&Marks) -> bool) -> bool {
        let marks = self.marks();
        let facets = self.interfaces.iter().flat_map(|interface| interface.lips.iter().flatten());
        facets.flat_map(|f| self.facet_nodes(*f)).any(|node| is_doubtful(&marks[node as usize]))
    }

    /// Cells with their nodes; `local` is scratch.
    fn cells_of(
        &self,
        facts: MeshFacts,
        cells: Vec<u64>,
        marks: &[Marks],
        local: &mut [u32],
    ) -> LocalMesh {
        let mut names: Vec<u64> = Vec::new();
        for cell in &cells {
            for node in self.cell_nodes(*cell as usize) {
                if std::mem::replace(&mut local[*node as usize], 0) == NOT_HERE {
                    names.push(u64::from(*node));
                }
            }
        }
        names.sort_unstable();
        for (number, name) in names.iter().enumerate() {
            local[*name as usize] = number as u32;
        }
        let (mut start, mut connectivity) = (vec![0], Vec::new());
        for cell in cells.iter().map(|cell| *cell as usize) {
            connectivity.extend(self.cell_nodes(cell).iter().map(|n| local[*n as usize]));
            start.push(connectivity.len() as u32);
        }
        let at = |name: &u64| *name as usize;
        let nodes = Places {
            points: names.iter().map(|name| self.points[at(name)]).collect(),
            marks: names.iter().map(|name| marks[at(name)]).collect(),
            names,
        };
        nodes.names.iter().for_each(|name| local[at(name)] = NOT_HERE);
        let shapes: Vec<Shape> = cells.iter().map(|cell| self.shapes[at(cell)]).collect();
        let materials = cells.iter().map(|cell| self.materials[at(cell)]).collect();
        let part = BarePart { cells, materials, start, connectivity, nodes };
        LocalMesh::bare(facts, part, shapes.into_iter())
    }

    /// Body, surfaces and lip of every node.
    pub(super) fn marks(&self) -> Vec<Marks> {
        let mut surfaces = vec![0_u128; self.points.len()];
        for (place, surface) in self.surfaces.iter().enumerate() {
            surface.nodes.iter().for_each(|node| surfaces[*node as usize] |= 1 << place);
        }
        let mut lips = vec![None; self.points.len()];
        let mut junction = vec![false; self.points.len()];
        for (index, interface) in self.interfaces.iter().enumerate() {
            for (lip, facets) in Lip::BOTH.iter().zip(&interface.lips) {
                for node in facets.iter().flat_map(|facet| self.facet_nodes(*facet)) {
                    lips[node as usize].get_or_insert((index, *lip));
                }
            }
            let without = interface.tips.iter().chain(&interface.junctions);
            without.for_each(|node| junction[*node as usize] = true);
        }
        let mut bodies = vec![0; self.points.len()];
        for cell in 0..self.cells() {
            let nodes = self.cell_nodes(cell).iter();
            nodes.for_each(|node| bodies[*node as usize] = self.bodies[cell] as usize);
        }
        let all = surfaces.into_iter().zip(lips).zip(junction).zip(bodies);
        all.map(|(((surfaces, lip), is_junction), body)| {
            let mut marks = Marks::new(body, surfaces, lip);
            marks.is_junction = is_junction;
            marks
        })
        .collect()
    }

    /// By interface and lip, the facets of the other lip that may face each facet.
    pub(super) fn far_facets(&self) -> FarFacets {
        let of_interface = |interface: &WholeInterface| {
            let mut far = <[BTreeMap<WholeFacet, Vec<WholeFacet>>; 2]>::default();
            let [lower, upper] = &interface.lips;
            let mut join = |one: WholeFacet, other: WholeFacet| {
                far[0].entry(one).or_default().push(other);
                far[1].entry(other).or_default().push(one);
            };
            if interface.faces.is_empty() {
                facing(self, interface).into_iter().for_each(|[one, other]| join(one, other));
            } else {
                lower.iter().zip(upper).for_each(|(one, other)| join(*one, *other));
            }
            far
        };
        self.interfaces.iter().map(of_interface).collect()
    }

    /// Normals and middles of edges, by names of nodes.
    pub(super) fn directions(&self) -> Directions {
        let mut all = Directions::default();
        for (index, interface) in self.interfaces.iter().enumerate() {
            let normals = interface.normals.iter();
            all.of_lips.extend(normals.map(|(node, normal)| LipNormal {
                node: *node,
                interface: index as u32,
                normal: self.along_axes(*normal),
            }));
            for (lip, facets) in Lip::BOTH.iter().zip(&interface.lips) {
                let has_shares = |facet: &&WholeFacet| self.facet_shape(**facet) == Shape::Tri6;
                if !facets.iter().any(|facet| has_shares(&facet)) {
                    continue;
                }
                for facet in facets {
                    all.middles.extend(self.middles(*facet, index as u32, *lip));
                }
            }
        }
        for surface in 0..self.surfaces.len() {
            for (node, normals) in surface_normals(self, surface) {
                all.of_surfaces.extend(normals.into_iter().map(|normal| SurfaceNormal {
                    node,
                    surface: surface as u32,
                    normal: self.along_axes(normal),
                }));
            }
        }
        all.sort();
        all
    }

    /// The nodes in the middle of the edges of a facet.
    fn middles(&self, facet: WholeFacet, interface: u32, lip: Lip) -> Vec<MidNode> {
        let corners = self.facet_shape(facet).corners().nodes();
        let nodes: Vec<u32> = self.facet_nodes(facet).collect();
        let middle = |edge: usize| MidNode {
            node: nodes[corners + edge],
            interface,
            lip,
            ends: [nodes[edge], nodes[(edge + 1) % corners]],
        };
        (0..corners).filter(|_| nodes.len() >= 2 * corners).map(middle).collect()
    }

    /// A vector by components of the displacement.
    fn along_axes(&self, v: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|c| self.axes.get(c).map_or(0.0, |axis| v[*axis]))
    }

    /// The volume of a cell (m3; in 2D its area).
    fn volume(&self, cell: usize) -> f64 {
        let shape = self.shapes[cell];
        let points: Vec<[f64; 3]> =
            self.cell_nodes(cell).iter().map(|n| self.points[*n as usize]).collect();
        let at = |xi| {
            if shape.dim() == 3 {
                return mapping(shape, &points, xi).determinant;
            }
            let plane: Vec<[f64; 2]> = points.iter().map(|x| [x[0], x[1]]).collect();
            mapping(shape, &plane, xi).determinant
        };
        stiffness_rule(shape).iter().map(|p| p.weight * at(p.xi)).sum()
    }

    pub(super) fn far_facet(&self, facet: WholeFacet) -> FarFacet {
        let nodes: Vec<u64> = self.facet_nodes(facet).map(u64::from).collect();
        FarFacet {
            cell: u64::from(facet.cell),
            shape: self.facet_shape(facet),
            points: nodes.iter().map(|node| self.points[*node as usize]).collect(),
            nodes,
        }
    }
}

/// By interface and lip, the facets of the other lip that may face each facet.
pub(super) type FarFacets = Vec<[BTreeMap<WholeFacet, Vec<WholeFacet>>; 2]>;

/// The cells of a rank with their nodes by number.
pub(super) struct BarePart {
    /// Their names, rising.
    pub cells: Vec<u64>,
    /// Their materials.
    pub materials: Vec<u32>,
    /// First node of each, and the end.
    pub start: Vec<u32>,
    /// Nodes of the cells.
    pub connectivity: Vec<u32>,
    /// The nodes, by rising name.
    pub nodes: Places,
}

impl LocalMesh {
    /// The part of a rank of the mesh of a file, before it is told of surfaces and interfaces.
    pub(super) fn bare(
        facts: MeshFacts,
        part: BarePart,
        shapes: impl Iterator<Item = Shape>,
    ) -> Self {
        let BarePart { cells, materials, start, connectivity, nodes } = part;
        let points = |cell: usize, points: &mut Vec<[f64; 3]>| {
            let of_cell = &connectivity[start[cell] as usize..start[cell + 1] as usize];
            points.extend(of_cell.iter().map(|node| nodes.points[*node as usize]));
        };
        let (cell_prototype, prototypes) = prototypes(shapes, materials, facts.axes, points);
        Self {
            coarse_cells: facts.cells,
            facts,
            cells,
            cell_prototype,
            prototypes,
            start,
            connectivity,
            nodes,
            surfaces: Vec::new(),
            lips: Vec::new(),
            facing: Vec::new(),
            directions: Directions::default(),
            is_of_corners: false,
            parents: Interpolation::default(),
            lattice: None,
        }
    }

    /// Adds the facets on surfaces and on lips, and those that may face the latter.
    ///
    /// # Arguments
    /// * `own` tells a facet of the mesh by the numbers of this rank, if it is one of its cells
    /// * `named` tells a facet by names
    pub(super) fn add_groups(
        &mut self,
        mesh: &WholeMesh,
        far: &FarFacets,
        own: &dyn Fn(&WholeFacet) -> Option<Facet>,
        named: &dyn Fn(WholeFacet) -> FarFacet,
    ) {
        for surface in &mesh.surfaces {
            let mut facets: Vec<Facet> = surface.facets.iter().filter_map(own).collect();
            facets.sort_unstable();
            self.surfaces.push(facets);
        }
        for (interface, far) in mesh.interfaces.iter().zip(far) {
            let (mut lips, mut facing) = (<[Vec<Facet>; 2]>::default(), [Vec::new(), Vec::new()]);
            for lip in [0, 1] {
                let of_lip = interface.lips[lip].iter();
                let mut rows: Vec<(Facet, &WholeFacet)> =
                    of_lip.filter_map(|facet| Some((own(facet)?, facet))).collect();
                rows.sort_unstable_by_key(|(facet, _)| *facet);
                for (facet, whole) in rows {
                    let far = far[lip].get(whole).map_or(&[][..], Vec::as_slice);
                    lips[lip].push(facet);
                    facing[lip].push(far.iter().map(|far| named(*far)).collect());
                }
            }
            self.lips.push(lips);
            self.facing.push(facing);
        }
    }
}

/// The prototypes of some cells, told by shape and material, with the number of each cell's in the
/// place of its material; `points` adds the positions of the nodes (m) of a cell by its place.
fn prototypes(
    shapes: impl Iterator<Item = Shape>,
    mut materials: Vec<u32>,
    axes: &[usize],
    points: impl Fn(usize, &mut Vec<[f64; 3]>),
) -> (Vec<u32>, Vec<Prototype>) {
    let (mut prototypes, mut of_cell) = (Prototypes::default(), Vec::new());
    for ((cell, number), shape) in materials.iter_mut().enumerate().zip(shapes) {
        of_cell.clear();
        points(cell, &mut of_cell);
        let (geometry, material) = (Geometry::of(shape, &of_cell, axes), *number as usize);
        *number = prototypes.number(Prototype { geometry, material, shape });
    }
    (materials, prototypes.list)
}
