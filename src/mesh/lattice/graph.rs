//! The dual graph of a lattice.

use super::column::{CellPlace, Column, Facets};
use crate::error::{Error, Result};
use crate::mesh::DualGraph;

/// Weight of the edge between two facing cells of an interface, against 1 within a body.
const PAIR_WEIGHT: i32 = 8;

/// Work of the largest cell; small enough for the 32-bit sums of METIS.
const MOST_WORK: f64 = 64.0;

impl Column {
    /// The graph of all cells. The work of a cell is that of the cells of the finest lattice in it,
    /// the most being `MOST_WORK`. Facing cells of an interface are joined by heavy edges, so
    /// that pairs stay together where the balance allows it.
    ///
    /// # Errors
    /// `Input` when there are too many cells.
    pub fn dual_graph(&self) -> Result<DualGraph> {
        let cells = self.cells();
        if i32::try_from(cells * 8).is_err() {
            return Err(Error::Input(format!(
                "{cells} cells are too many for the 32-bit METIS that cuts the coarse mesh; \
                 give a coarser mesh and refine it with mesh.refine"
            )));
        }
        let sizes: Vec<u64> = (0..cells).map(|c| self.finest_cells(self.cell_place(c))).collect();
        let largest = sizes.iter().copied().max().unwrap_or(1) as f64;
        let work = |size: &u64| (MOST_WORK * *size as f64 / largest).round().max(1.0) as i32;
        let work = sizes.iter().map(work).collect();
        let (neighbours, weights) = (Vec::new(), Vec::new());
        let mut graph = DualGraph { start: vec![0], neighbours, weights, work };
        for cell in 0..cells {
            let place = self.cell_place(cell);
            self.add_neighbours_within_body(place, &mut graph);
            self.add_facing_cells(place, &mut graph);
            graph.start.push(graph.neighbours.len() as i32);
        }
        Ok(graph)
    }

    fn push(&self, place: CellPlace, weight: i32, graph: &mut DualGraph) {
        graph.neighbours.push(self.cell(place) as i32);
        graph.weights.push(weight);
    }

    fn add_neighbours_within_body(&self, place: CellPlace, graph: &mut DualGraph) {
        let n = self.extent(place.body);
        for (axis, extent) in n.into_iter().enumerate() {
            let mut neighbour = place;
            if place.at[axis] > 0 {
                neighbour.at[axis] = place.at[axis] - 1;
                self.push(neighbour, 1, graph);
            }
            if place.at[axis] + 1 < extent {
                neighbour.at[axis] = place.at[axis] + 1;
                self.push(neighbour, 1, graph);
            }
        }
    }

    /// The cells across the interfaces below and above.
    fn add_facing_cells(&self, place: CellPlace, graph: &mut DualGraph) {
        let top = self.extent(place.body)[2] - 1;
        let below = (place.at[2] == 0 && place.body > 0)
            .then(|| Facets { body: place.body - 1, upper: true });
        let above = (place.at[2] == top && place.body + 1 < self.bodies())
            .then(|| Facets { body: place.body + 1, upper: false });
        let (low, high) = self.footprint(place);
        for face in [below, above].into_iter().flatten() {
            for at in self.facets_over(face, low, high) {
                self.push(self.facet_cell(face, at), PAIR_WEIGHT, graph);
            }
        }
    }
}
