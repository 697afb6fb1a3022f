//! From a lattice to the arrays of a rank.

use super::column::{Column, Facets};
use super::{CellPlace, NodePlace};
use crate::case::Surface;
use crate::element::Shape;
use crate::mesh::directions::Directions;
use crate::mesh::facts::Hinges;
use crate::mesh::prototype::Prototypes;
use crate::mesh::{
    Facet, FarFacet, Geometry, Interpolation, Joint, Lip, LipFacts, LocalMesh, Marks, MeshFacts,
    Places, Prototype, axes,
};

impl LocalMesh {
    /// The mesh of the given cells of `column`, rising. Local.
    pub fn new(column: &Column, cells: Vec<u64>, coarse_cells: u64) -> Self {
        let mut prototypes = Prototypes::default();
        let mut cell_prototype = Vec::with_capacity(cells.len());
        let (mut start, mut names) = (vec![0], Vec::new());
        let mut surfaces = vec![Vec::new(); Surface::COLUMN.len()];
        let mut lips = vec![<[Vec<Facet>; 2]>::default(); column.bodies() - 1];
        for (index, cell) in cells.iter().enumerate() {
            let place = column.cell_place(*cell);
            let (size, material) = column.cell_size(place);
            let shape = column.shape(place.body);
            let geometry = Geometry::Box(size);
            cell_prototype.push(prototypes.number(Prototype { geometry, material, shape }));
            names.extend(column.cell_nodes(place));
            start.push(names.len() as u32);
            let facet = |facet: usize| Facet { cell: index as u32, facet: facet as u8 };
            for (surface, end) in column.ends(place).into_iter().enumerate() {
                let Some((axis, upper)) = end else { continue };
                surfaces[surface].push(facet(facet_towards(column.dim, axis, upper)));
            }
            for (interface, lip) in column.lips_of(place) {
                let facet = facet(facet_towards(column.dim, 2, lip == Lip::Lower));
                lips[interface][lip.index()].push(facet);
            }
        }
        let mut nodes = names.clone();
        nodes.sort_unstable();
        nodes.dedup();
        let number = |name: &u64| nodes.partition_point(|n| n < name) as u32;
        let connectivity = names.iter().map(number).collect();
        let points = nodes.iter().map(|name| column.point(*name)).collect();
        let marks = nodes.iter().map(|name| column.marks(*name)).collect();
        Self {
            facts: column.facts(),
            cells,
            cell_prototype,
            prototypes: prototypes.list,
            start,
            connectivity,
            nodes: Places { names: nodes, points, marks },
            surfaces,
            lips,
            coarse_cells,
            is_of_corners: false,
            facing: Vec::new(),
            directions: Directions::default(),
            parents: Interpolation::default(),
            lattice: Some(column.clone()),
        }
    }

    /// The cells of the finer lattice `fine` that this rank's cells of `coarse` consist of. Local.
    pub fn refined(&self, coarse: &Column, fine: &Column) -> Self {
        let children = |cell: &u64| coarse.children(coarse.cell_place(*cell), fine);
        let mut cells: Vec<u64> =
            self.cells.iter().flat_map(children).map(|place| fine.cell(place)).collect();
        cells.sort_unstable();
        Self::new(fine, cells, self.coarse_cells)
    }

    /// As [`LocalMesh::across`] in a lattice.
    pub(in crate::mesh) fn across_lattice(
        &self,
        column: &Column,
        interface: usize,
        lip: Lip,
        facet: Facet,
    ) -> Vec<FarFacet> {
        let (_, nodes) = self.facet_nodes(facet);
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for node in nodes {
            let point = self.nodes.points[node as usize];
            for axis in 0..2 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        let face = column.lip(interface, lip.other());
        let far = |at: [usize; 2]| {
            let mut shape = Shape::of(column.dim - 1, column.order(face.body));
            let mut nodes = column.facet_nodes(face, at);
            if self.is_of_corners {
                shape = shape.corners();
                nodes.truncate(shape.nodes());
            }
            let points = nodes.iter().map(|name| column.point(*name)).collect();
            FarFacet { cell: column.cell(column.facet_cell(face, at)), shape, nodes, points }
        };
        column.facets_over(face, low, high).into_iter().map(far).collect()
    }

    /// As [`LocalMesh::locate`] in a lattice.
    pub(in crate::mesh) fn locate_in_lattice(
        &self,
        column: &Column,
        point: [f64; 3],
    ) -> Option<(usize, [f64; 3])> {
        let (place, fraction) = column.locate(point);
        let cell = self.cells.binary_search(&column.cell(place)).ok()?;
        let mut xi = [0.0; 3];
        for (component, axis) in axes(self.dim()).iter().enumerate() {
            xi[component] = 2.0 * fraction[*axis] - 1.0;
        }
        Some((cell, xi))
    }

    /// How the nodes of these `names` depend on those of the next coarser level. Every one lies in
    /// a cell of `coarse`; of the mesh of a file those that do not depend on none.
    pub fn interpolation(&self, coarse: &Self, names: &[u64]) -> Interpolation {
        let mut all = Interpolation { start: vec![0], ..Interpolation::default() };
        let (Some(fine), Some(coarse)) = (&self.lattice, &coarse.lattice) else {
            if coarse.is_of_corners {
                return self.by_corners(names);
            }
            return self.parents.of(names.iter().map(|name| self.nodes.number(*name)));
        };
        for name in names {
            for (parent, part) in parents(fine, coarse, *name) {
                all.names.push(parent);
                all.weights.push(part);
            }
            all.start.push(all.names.len() as u32);
        }
        all
    }
}

/// The nodes of the coarse lattice that a fine node depends on, with their weights.
fn parents(fine: &Column, coarse: &Column, name: u64) -> Vec<(u64, f64)> {
    let place = fine.node_place(name);
    let (low, fraction) = coarse.place_in(fine, place);
    let mut list = vec![(low, 1.0)];
    for axis in axes(fine.dim).iter().copied().filter(|axis| fraction[*axis] > 0.0) {
        for i in 0..list.len() {
            let (mut upper, weight) = list[i];
            upper[axis] += 1;
            list.push((upper, weight * fraction[axis]));
            list[i].1 = weight * (1.0 - fraction[axis]);
        }
    }
    let name = |at| coarse.node(NodePlace { body: place.body, at });
    list.into_iter().map(|(at, weight)| (name(at), weight)).collect()
}

impl Column {
    /// What is known of the whole lattice.
    pub fn facts(&self) -> MeshFacts {
        let bodies = || 0..self.bodies();
        let order = self.highest_order();
        let along = |axis: usize| -> f64 {
            let nodes = bodies().map(|b| (self.extent(b)[axis] * self.order(b) + 1) as f64);
            if axis == 2 { nodes.sum() } else { nodes.fold(0.0, f64::max) }
        };
        let [x, y, z] = [0, 1, 2].map(along);
        let section = if self.dim == 2 { x.min(z) } else { (x * y).min(x * z).min(y * z) };
        let lip = |interface: usize, lip: Lip| {
            let face = self.lip(interface, lip);
            let (mut cell, material) = self.cell_size(self.facet_cell(face, [0, 0]));
            let n = self.extent(face.body);
            for axis in (0..self.dim - 1).filter(|axis| self.is_graded(face.body, *axis)) {
                cell[axis] = self.size[axis] / n[axis] as f64;
            }
            let order = self.order(face.body);
            let area = self.size[0] * if self.dim == 3 { self.size[1] } else { 1.0 };
            LipFacts {
                body: face.body,
                cell,
                material,
                order,
                area,
                has_shares: false,
                surfaces: [0; 2],
            }
        };
        MeshFacts {
            dim: self.dim,
            axes: axes(self.dim),
            origin: [0.0; 3],
            size: self.size,
            bodies: self.bodies(),
            cells: self.cells(),
            coarser: Vec::new(),
            nodes: self.nodes(),
            corners: self.of_first_order().nodes(),
            order,
            nodes_per_cell: bodies().map(|b| self.shape(b).nodes()).max().unwrap_or(8),
            section,
            digest: 0,
            hinges: Hinges::default(),
            names: Vec::new(),
            joints: (1..self.bodies())
                .map(|i| Joint { interface: i - 1, bodies: [i - 1, i] })
                .collect(),
            interfaces: (1..self.bodies()).map(|i| Lip::BOTH.map(|l| lip(i - 1, l))).collect(),
        }
    }

    /// Whether the cells of a body grow along an axis across the column.
    fn is_graded(&self, body: usize, axis: usize) -> bool {
        !self.bodies[body].across[axis].is_empty()
    }

    /// The face of a body that is a lip of an interface.
    pub(super) fn lip(&self, interface: usize, lip: Lip) -> Facets {
        match lip {
            Lip::Lower => Facets { body: interface, upper: true },
            Lip::Upper => Facets { body: interface + 1, upper: false },
        }
    }

    /// Body, surfaces and lip of a node.
    pub fn marks(&self, node: u64) -> Marks {
        let NodePlace { body, at } = self.node_place(node);
        let last = self.node_extent(body).map(|n| n - 1);
        let is_on = self.is_on_surfaces(body, at, last);
        let surfaces = is_on.iter().enumerate().map(|(place, on)| u128::from(*on) << place).sum();
        Marks::new(body, surfaces, self.lip_at(body, at[2], last[2]))
    }

    /// Whether a place in a body, whose last one along each axis is `last`, is on each surface of
    /// [`Surface::COLUMN`].
    fn is_on_surfaces(&self, body: usize, at: [usize; 3], last: [usize; 3]) -> [bool; 6] {
        let flat = self.dim == 2;
        [
            body == 0 && at[2] == 0,
            body + 1 == self.bodies() && at[2] == last[2],
            at[0] == 0,
            at[0] == last[0],
            !flat && at[1] == 0,
            !flat && at[1] == last[1],
        ]
    }

    fn lip_at(&self, body: usize, k: usize, last: usize) -> Option<(usize, Lip)> {
        if k == 0 && body > 0 {
            Some((body - 1, Lip::Upper))
        } else if k == last && body + 1 < self.bodies() {
            Some((body, Lip::Lower))
        } else {
            None
        }
    }

    /// The named surfaces a cell has a facet on, with the axis and the end of that facet.
    fn ends(&self, place: CellPlace) -> [Option<(usize, bool)>; 6] {
        const TOWARDS: [(usize, bool); 6] =
            [(2, false), (2, true), (0, false), (0, true), (1, false), (1, true)];
        let last = self.extent(place.body).map(|n| n - 1);
        let is_on = self.is_on_surfaces(place.body, place.at, last);
        std::array::from_fn(|surface| is_on[surface].then_some(TOWARDS[surface]))
    }

    /// The lips a cell has a facet on: both, in a body of one layer.
    fn lips_of(&self, place: CellPlace) -> Vec<(usize, Lip)> {
        let last = self.extent(place.body)[2] - 1;
        let lower = (place.at[2] == last && place.body + 1 < self.bodies())
            .then_some((place.body, Lip::Lower));
        let upper = (place.at[2] == 0 && place.body > 0).then(|| (place.body - 1, Lip::Upper));
        lower.into_iter().chain(upper).collect()
    }
}

/// Number of the facet in `Shape::facets` that looks along an axis, to its lower or upper end.
fn facet_towards(dim: usize, axis: usize, upper: bool) -> usize {
    match (dim, axis, upper) {
        (2, 2, false) => 0,
        (2, 0, true) => 1,
        (2, 2, true) => 2,
        (2, _, _) => 3,
        (_, 2, low_or_high) => usize::from(low_or_high),
        (_, 1, false) => 2,
        (_, 0, true) => 3,
        (_, 1, true) => 4,
        _ => 5,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facets_look_where_they_should() {
        for (dim, order) in [(2, 1), (3, 1), (2, 2), (3, 2)] {
            let shape = Shape::of(dim, order);
            for axis in axes(dim) {
                for upper in [false, true] {
                    let component = axes(dim).iter().position(|a| a == axis).expect("an axis");
                    let side = if upper { 1.0 } else { -1.0 };
                    let facet = shape.facets()[facet_towards(dim, *axis, upper)];
                    assert!(facet.iter().all(|a| shape.node_points()[*a][component] == side));
                }
            }
        }
    }
}
