//! The cells of a rank with their nodes by place, once these have their names.

use super::bodies::{all_bodies, even_homes};
use super::naming::Naming;
use super::pieces::{Work, fresh_place};
use super::runs::Runs;
use super::spread::Held;
use crate::comm::Comm;
use crate::element::Shape;
use crate::error::Result;
use crate::mesh::Places;
use crate::mesh::slabs::{Head, Numbers, Part};
use crate::mesh::whole::bodies;
use crate::runtime::give_back_memory;

/// The cells of a rank after raising and cutting.
pub struct Placed {
    /// Their names, rising.
    pub cells: Vec<u32>,
    /// Their materials.
    pub materials: Vec<u32>,
    /// Where the nodes of each stand.
    runs: Runs,
    /// Nodes of the cells by place.
    pub connectivity: Vec<u32>,
    /// The nodes, by rising name, without marks.
    pub nodes: Places,
    /// The shortest edge (m) at each that was there before cutting, or a little more.
    pub shortest: Vec<f32>,
    /// Facets on the boundary before cutting, by names of cells.
    pub boundary: Vec<(u32, u8)>,
    /// The bodies before cutting of nodes of the file.
    bodies: (Numbers, Vec<u32>),
}

impl Placed {
    /// Local. What is not needed any more is given back on the way.
    ///
    /// # Arguments
    /// * `raised`: where the nodes of each cell stand where cells were raised
    /// * `bodies` before cutting, by the places of the files' names
    pub fn new(
        (head, naming): (&Head, &Naming),
        held: Held,
        work: Work,
        raised: Option<Runs>,
        bodies: Vec<u32>,
    ) -> Self {
        let Held { cells, sets: materials, runs, nodes, pieces, far, beside } = held;
        drop((pieces, far, beside));
        let runs = raised.unwrap_or(runs);
        let mut connectivity = work.nodes.unwrap_or(nodes);
        give_back_memory();
        let fresh = work.fresh;
        let names: Vec<u32> = fresh.keys.iter().map(|key| naming.name(head, *key)).collect();
        drop(fresh.keys);
        let name = |word: u32| fresh_place(word).map_or(word, |place| names[place]);
        let used = Numbers::of(0, naming.total(), connectivity.iter().map(|word| name(*word)));
        let mut points = vec![[0.0; 3]; used.len()];
        let mut shortest = vec![f32::INFINITY; used.len()];
        let of_file = work.names.iter().zip(work.points.iter().zip(&work.shortest));
        let of_fresh = names.iter().copied().zip(fresh.points.iter().zip(&fresh.shortest));
        for (name, (point, edge)) in of_file.chain(of_fresh) {
            if let Some(place) = used.place(name) {
                (points[place], shortest[place]) = (*point, *edge);
            }
        }
        drop((work.points, work.shortest, fresh.points, fresh.shortest));
        for word in &mut connectivity {
            *word = used.place(name(*word)).unwrap_or_default() as u32;
        }
        drop(names);
        give_back_memory();
        let names = used.iter().map(u64::from).collect();
        let nodes = Places { names, points, marks: Vec::new() };
        let (boundary, bodies) = (work.boundary, (work.names, bodies));
        Self { cells, materials, runs, connectivity, nodes, shortest, boundary, bodies }
    }

    /// The nodes of a cell.
    pub fn cell(&self, cell: usize) -> &[u32] {
        &self.connectivity[self.runs.of(cell)]
    }

    /// The body of a cell before cutting.
    pub fn body_before(&self, naming: &Naming, cell: usize) -> u32 {
        let corner = naming.before(self.nodes.names[self.cell(cell)[0] as usize] as u32);
        let (names, bodies) = &self.bodies;
        names.place(corner).map_or(u32::MAX, |place| bodies[place])
    }

    /// The part of this rank, and how many bodies there are: `before` of them before cutting.
    /// Collective.
    ///
    /// # Errors
    /// `Bug` only.
    pub fn part(
        mut self,
        comm: &Comm,
        naming: &Naming,
        shapes: &[Shape],
        before: usize,
    ) -> Result<(Part, usize)> {
        self.shortest = Vec::new();
        let (bodies, count) = if naming.origins.is_empty() {
            (self.bodies_of_file(naming), before)
        } else {
            self.bodies_after(comm, naming)?
        };
        self.bodies = Default::default();
        let shapes = shapes.iter().copied().zip(self.runs.counts()).collect();
        let Self { cells, materials, runs, connectivity, nodes, .. } = self;
        let cells = cells.into_iter().map(u64::from).collect();
        let start = runs.starts();
        Ok((Part { cells, shapes, materials, nodes, start, connectivity, bodies }, count))
    }

    /// The bodies of all nodes of a mesh that was not cut.
    fn bodies_of_file(&self, naming: &Naming) -> Vec<u32> {
        let mut of_nodes = vec![u32::MAX; self.nodes.names.len()];
        for cell in 0..self.cells.len() {
            let body = self.body_before(naming, cell);
            self.cell(cell).iter().for_each(|node| of_nodes[*node as usize] = body);
        }
        of_nodes
    }

    /// The bodies of nodes after cutting, and how many there are. Collective.
    fn bodies_after(&self, comm: &Comm, naming: &Naming) -> Result<(Vec<u32>, usize)> {
        let add = |cell: usize, nodes: &mut Vec<u32>| nodes.extend_from_slice(self.cell(cell));
        let of_nodes = bodies(self.nodes.names.len(), self.cells.len(), add);
        let homes = even_homes(comm, naming.total());
        let names = self.nodes.names.iter().map(|name| *name as u32);
        all_bodies(comm, &homes, names, of_nodes, &self.cells)
    }
}
