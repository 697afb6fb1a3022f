//! Bodies that touch where their meshes do not match, looked for among the cells at the boundary.

use super::head::Head;
use crate::error::Result;
use crate::mesh::whole::{Cells, NO_MATE, WholeFacet, check_bodies, slot};

/// The cells at the boundary of a mesh before cutting.
#[derive(Debug, Default)]
pub struct Skin {
    /// Their names, rising, and their bodies.
    pub cells: Vec<(u32, u32)>,
    /// Names of the nodes of one cell after the other.
    pub nodes: Vec<u32>,
    /// Their positions (m).
    pub points: Vec<[f64; 3]>,
    /// The facets on the boundary.
    pub facets: Vec<(u32, u8)>,
}

impl Skin {
    /// Refuses nodes that lie on facets of other bodies; `between` are facets of interfaces between
    /// two groups.
    ///
    /// # Errors
    /// `Input` with their number and the first place.
    pub fn check(&self, head: &Head, is_raised: bool, between: &[(u32, u8)]) -> Result<()> {
        let shapes = head.shapes(is_raised)?;
        let mut names = self.nodes.clone();
        names.sort_unstable();
        names.dedup();
        let place = |name: &u32| names.binary_search(name).unwrap_or_default();
        let mut cells = Cells { start: vec![0], ..Cells::default() };
        cells.points = vec![[0.0; 3]; names.len()];
        for (name, point) in self.nodes.iter().zip(&self.points) {
            cells.points[place(name)] = *point;
        }
        cells.nodes = self.nodes.iter().map(|name| place(name) as u32).collect();
        for (name, _) in &self.cells {
            let shape = shapes[head.kind_place(*name)];
            cells.kinds.push(head.kind(*name));
            cells.shapes.push(shape);
            cells.numbers.push(u64::from(*name));
            cells.start.push(cells.start[cells.start.len() - 1] + shape.nodes() as u32);
        }
        let facet = |(name, facet): &(u32, u8)| {
            let cell = self.cells.binary_search_by_key(name, |(name, _)| *name).ok()?;
            Some(WholeFacet { cell: cell as u32, facet: *facet })
        };
        let mut mates = vec![0; slot(WholeFacet { cell: self.cells.len() as u32, facet: 0 })];
        for facet in self.facets.iter().filter_map(facet) {
            mates[slot(facet)] = NO_MATE;
        }
        let bodies: Vec<u32> = self.cells.iter().map(|(_, body)| *body).collect();
        check_bodies(&cells, &mates, between.iter().filter_map(facet).collect(), &bodies)
    }
}
