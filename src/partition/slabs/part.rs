//! The part of a rank, and what all know of the mesh.

use super::bodies::{all_bodies, count, even_homes};
use super::digest::digest;
use super::naming::Naming;
use super::pieces::{Work, fresh_place};
use super::spread::Held;
use crate::case::Case;
use crate::comm::Comm;
use crate::element::Shape;
use crate::error::Result;
use crate::mesh::slabs::{Cut, Head, Numbers, Part, Skin, Star};
use crate::mesh::whole::bodies;
use crate::mesh::{MeshFacts, Places};
use crate::partition::journey::joined;

/// A cell on its way: its name, its material or body, and names and positions (m) of its nodes.
type Sent = (u32, u32, Vec<(u32, [f64; 3])>);

/// What is needed to finish.
pub struct Finish<'f> {
    /// All ranks.
    pub comm: &'f Comm,
    /// What all know.
    pub head: &'f Head,
    /// The shapes of the kinds of cells.
    pub shapes: &'f [Shape],
    /// How new nodes are named.
    pub naming: &'f Naming,
    /// Names of the new nodes.
    pub names: &'f [u32],
}

impl Finish<'_> {
    /// The name and the position (m) of a node of an own cell by what stands for it.
    fn node(&self, work: &Work, word: u32) -> (u32, [f64; 3]) {
        match fresh_place(word) {
            Some(place) => (self.names[place], work.fresh[place].point),
            None => (word, work.points[work.names.place(word).unwrap_or_default()]),
        }
    }

    /// What stands for the nodes of an own cell.
    fn words<'w>(&self, held: &'w Held, work: &'w Work, start: &[u32], cell: usize) -> &'w [u32] {
        let range = start[cell] as usize..start[cell + 1] as usize;
        &work.nodes.as_ref().unwrap_or(&held.nodes)[range]
    }

    /// The names of new nodes that were there before cutting.
    pub fn before_cutting(&self, work: &Work) -> Vec<Option<u32>> {
        let fresh = work.fresh.iter().zip(self.names);
        fresh.map(|(fresh, name)| (fresh.key.sector() == 0).then_some(*name)).collect()
    }

    /// The cells of a skeleton after cutting. Collective.
    ///
    /// # Errors
    /// `Bug` only.
    pub fn cut(&self, held: &Held, work: &Work, names: &[u32], start: &[u32]) -> Result<Cut> {
        let (mut own, mut fresh) = (Vec::new(), Vec::new());
        for name in names {
            let Ok(cell) = held.cells.binary_search(&u64::from(*name)) else { continue };
            own.extend([*name, held.sets[cell]]);
            for word in self.words(held, work, start, cell) {
                let (name, point) = self.node(work, *word);
                own.push(name);
                if fresh_place(*word).is_some() {
                    fresh.push((name, point));
                }
            }
        }
        let (words, points) = (joined(self.comm, &own)?, joined(self.comm, &fresh)?);
        let mut all = Vec::with_capacity(names.len());
        let mut rest = &words[..];
        while let [name, material, more @ ..] = rest {
            let (nodes, more) = more.split_at(self.shapes[self.head.kind_place(*name)].nodes());
            all.push((*name, *material, nodes));
            rest = more;
        }
        all.sort_unstable_by_key(|cell| cell.0);
        Ok(Cut {
            dim: self.head.dim,
            nodes: all.iter().flat_map(|cell| cell.2).copied().collect(),
            points,
            first: self.naming.uncut() as u32,
            origins: self.naming.origins.clone(),
            materials: all.iter().map(|cell| cell.1).collect(),
        })
    }

    /// Refuses bodies that touch where their meshes do not match. Collective.
    ///
    /// # Errors
    /// `Input` on all ranks.
    pub fn touching(
        &self,
        held: &Held,
        work: &Work,
        start: &[u32],
        (bodies, between): (&[u32], &[(u32, u8)]),
        is_raised: bool,
    ) -> Result<()> {
        let mut cells: Vec<u32> = work.boundary.iter().map(|facet| facet.0).collect();
        cells.sort_unstable();
        cells.dedup();
        let mut own = Vec::new();
        for name in cells {
            let Ok(cell) = held.cells.binary_search(&u64::from(name)) else { continue };
            let nodes = self.words(held, work, start, cell).iter();
            let nodes = nodes.map(|word| {
                let (name, point) = self.node(work, *word);
                (self.naming.before(name), point)
            });
            let first = held.cell(cell).1[0];
            let body = bodies[work.names.place(first).unwrap_or_default()];
            own.push((name, body, nodes.collect::<Vec<(u32, [f64; 3])>>()));
        }
        let mut all = joined(self.comm, &own)?;
        let facets = joined(self.comm, &work.boundary)?;
        all.sort_unstable_by_key(|cell: &Sent| cell.0);
        let local = if self.comm.is_root() {
            let skin = Skin {
                cells: all.iter().map(|cell| (cell.0, cell.1)).collect(),
                nodes: all.iter().flat_map(|cell| &cell.2).map(|node| node.0).collect(),
                points: all.iter().flat_map(|cell| &cell.2).map(|node| node.1).collect(),
                facets,
            };
            skin.check(self.head, is_raised, between)
        } else {
            Ok(())
        };
        self.comm.agree(local)
    }

    /// The cells of this rank with their nodes by place, and how many bodies there are.
    /// Collective.
    ///
    /// # Arguments
    /// * `bodies` before cutting, by the places of the files' names
    ///
    /// # Errors
    /// `Bug` only.
    pub fn part(
        &self,
        held: Held,
        work: Work,
        raised_start: Option<Vec<u32>>,
        bodies: (Vec<u32>, usize),
    ) -> Result<(Part, usize)> {
        let Held { cells, sets: materials, start: of_file, nodes, pieces, far, beside } = held;
        drop((pieces, far, beside));
        let start = raised_start.unwrap_or(of_file);
        let (nodes, work) = work.without_nodes(nodes);
        let (connectivity, nodes, of_file) = self.placed(nodes, work, bodies.0);
        let (bodies, count) = match of_file {
            Some(of_file) => (of_corners(of_file, &start, &connectivity), bodies.1),
            None => self.bodies_after(&start, &connectivity, &nodes, &cells)?,
        };
        let shape = |cell: &u64| self.shapes[self.head.kind_place(*cell as u32)];
        let shapes = cells.iter().map(shape).collect();
        Ok((Part { cells, shapes, materials, nodes, start, connectivity, bodies }, count))
    }

    /// Nodes of cells by place, the nodes, and where nothing was cut the bodies of those of the
    /// file.
    fn placed(
        &self,
        mut connectivity: Vec<u32>,
        work: Work,
        of_file: Vec<u32>,
    ) -> (Vec<u32>, Places, Option<Vec<u32>>) {
        let name = |word: u32| fresh_place(word).map_or(word, |place| self.names[place]);
        let all = connectivity.iter().map(|word| name(*word));
        let used = Numbers::of(0, self.naming.total(), all);
        let mut nodes = Places {
            names: used.iter().map(u64::from).collect(),
            points: vec![[0.0; 3]; used.len()],
            marks: Vec::new(),
        };
        let mut bodies = vec![u32::MAX; used.len()];
        for (name, (point, body)) in work.names.iter().zip(work.points.iter().zip(of_file)) {
            if let Some(place) = used.place(name) {
                (nodes.points[place], bodies[place]) = (*point, body);
            }
        }
        for (name, fresh) in self.names.iter().zip(&work.fresh) {
            if let Some(place) = used.place(*name) {
                nodes.points[place] = fresh.point;
            }
        }
        for word in &mut connectivity {
            *word = used.place(name(*word)).unwrap_or_default() as u32;
        }
        let is_cut = !self.naming.origins.is_empty();
        (connectivity, nodes, (!is_cut).then_some(bodies))
    }

    /// The bodies of nodes after cutting, and how many there are. Collective.
    fn bodies_after(
        &self,
        start: &[u32],
        connectivity: &[u32],
        nodes: &Places,
        cells: &[u64],
    ) -> Result<(Vec<u32>, usize)> {
        let add = |cell: usize, nodes: &mut Vec<u32>| {
            nodes.extend_from_slice(&connectivity[start[cell] as usize..start[cell + 1] as usize]);
        };
        let of_nodes = bodies(nodes.names.len(), cells.len(), add);
        let homes = even_homes(self.comm, self.naming.total());
        let names = nodes.names.iter().map(|name| *name as u32);
        all_bodies(self.comm, &homes, names, of_nodes, cells)
    }

    /// What is known of the mesh; tells the bodies of the cells behind surfaces. Collective.
    ///
    /// # Errors
    /// `Bug` only.
    pub fn facts(
        &self,
        case: &Case,
        part: &Part,
        star: &mut Star,
        body_count: usize,
    ) -> Result<MeshFacts> {
        self.tell_bodies(part, star)?;
        star.mesh.body_count = body_count;
        let total = self.naming.total();
        let mut is_corner = vec![false; part.nodes.names.len()];
        for (cell, shape) in part.shapes.iter().enumerate() {
            let corners =
                &part.connectivity[part.start[cell] as usize..][..shape.corners().nodes()];
            corners.iter().for_each(|node| is_corner[*node as usize] = true);
        }
        let corners = part.nodes.names.iter().zip(is_corner).filter(|(_, is)| *is);
        let corners = corners.map(|(name, _)| *name as u32);
        let corners = count(self.comm, &even_homes(self.comm, total), corners);
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for point in &part.nodes.points {
            for i in 0..3 {
                (low[i], high[i]) = (low[i].min(point[i]), high[i].max(point[i]));
            }
        }
        self.comm.min(&mut low);
        self.comm.max(&mut high);
        let counts = self.head.kinds.iter().map(|range| u64::from(range.count));
        let shapes: Vec<(Shape, u64)> = self.shapes.iter().copied().zip(counts).collect();
        let digest = digest(self.comm, part, star, total, &shapes);
        let dim = self.head.dim;
        let of_lips = star.mesh.facts();
        Ok(MeshFacts {
            origin: low,
            size: std::array::from_fn(|i| high[i] - low[i]),
            bodies: body_count,
            cells: self.head.cells(),
            coarser: Vec::new(),
            nodes: total,
            corners,
            order: self.shapes.iter().map(|shape| shape.order()).max().unwrap_or(1),
            nodes_per_cell: self.shapes.iter().map(|shape| shape.nodes()).max().unwrap_or(8),
            section: (total as f64).powf((dim as f64 - 1.0) / dim as f64),
            digest,
            names: case.interfaces.iter().map(|interface| interface.name.clone()).collect(),
            ..of_lips
        })
    }

    /// Tells the bodies of the cells behind surfaces and interfaces. Collective.
    fn tell_bodies(&self, part: &Part, star: &mut Star) -> Result<()> {
        let mut own = Vec::new();
        for name in &star.cells {
            if let Ok(cell) = part.cells.binary_search(&u64::from(*name)) {
                let node = part.connectivity[part.start[cell] as usize];
                own.push((*name, part.bodies[node as usize]));
            }
        }
        let mut all: Vec<(u32, u32)> = joined(self.comm, &own)?;
        all.sort_unstable();
        star.mesh.bodies = all.into_iter().map(|(_, body)| body).collect();
        Ok(())
    }
}

/// The bodies of all nodes, from those of the first corners of cells.
fn of_corners(mut of_nodes: Vec<u32>, start: &[u32], connectivity: &[u32]) -> Vec<u32> {
    for ends in start.windows(2) {
        let nodes = &connectivity[ends[0] as usize..ends[1] as usize];
        let body = of_nodes[nodes[0] as usize];
        nodes.iter().for_each(|node| of_nodes[*node as usize] = body);
    }
    of_nodes
}
