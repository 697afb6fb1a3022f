//! What all know of the mesh, found from the parts of all ranks.

use super::bodies::{count, even_homes};
use super::digest::digest;
use super::naming::Naming;
use super::placed::Placed;
use crate::case::Case;
use crate::comm::Comm;
use crate::element::Shape;
use crate::error::Result;
use crate::mesh::MeshFacts;
use crate::mesh::slabs::{Cut, Head, Part, Skin, Star};
use crate::partition::journey::{joined, on_root};

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
}

impl Finish<'_> {
    /// The cells of a skeleton after cutting. Collective.
    ///
    /// # Errors
    /// `Bug` only.
    pub fn cut(&self, placed: &Placed, names: &[u32]) -> Result<Cut> {
        let (mut own, mut fresh) = (Vec::new(), Vec::new());
        for name in names {
            let Ok(cell) = placed.cells.binary_search(name) else { continue };
            own.extend([*name, placed.materials[cell]]);
            for node in placed.cell(cell) {
                let name = placed.nodes.names[*node as usize] as u32;
                own.push(name);
                if name >= self.head.nodes {
                    fresh.push((name, placed.nodes.points[*node as usize]));
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

    /// Refuses bodies that touch where their meshes do not match; `between` are facets of
    /// interfaces between two groups. Collective.
    ///
    /// # Errors
    /// `Input` on all ranks.
    pub fn touching(&self, placed: &Placed, between: &[(u32, u8)], is_raised: bool) -> Result<()> {
        let mut cells: Vec<u32> = placed.boundary.iter().map(|facet| facet.0).collect();
        cells.sort_unstable();
        cells.dedup();
        let mut own = Vec::new();
        for name in cells {
            let Ok(cell) = placed.cells.binary_search(&name) else { continue };
            let nodes = placed.cell(cell).iter().map(|node| {
                let name = placed.nodes.names[*node as usize] as u32;
                (self.naming.before(name), placed.nodes.points[*node as usize])
            });
            let body = placed.body_before(self.naming, cell);
            own.push((name, body, nodes.collect::<Vec<(u32, [f64; 3])>>()));
        }
        let all = on_root(self.comm, &own)?;
        let facets = on_root(self.comm, &placed.boundary)?;
        let check = |mut all: Vec<Sent>, facets| {
            all.sort_unstable_by_key(|cell: &Sent| cell.0);
            let skin = Skin {
                cells: all.iter().map(|cell| (cell.0, cell.1)).collect(),
                nodes: all.iter().flat_map(|cell| &cell.2).map(|node| node.0).collect(),
                points: all.iter().flat_map(|cell| &cell.2).map(|node| node.1).collect(),
                facets,
            };
            skin.check(self.head, is_raised, between)
        };
        let local = all.zip(facets).map_or(Ok(()), |(all, facets)| check(all, facets));
        self.comm.agree(local)
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
        for (cell, shape) in part.shapes().enumerate() {
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
        star.mesh.bodies = all.iter().map(|(_, body)| *body).collect();
        Ok(())
    }
}
