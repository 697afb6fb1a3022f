//! Which rank owns which cell.
//!
//! Rank 0 builds the dual graph of the coarse mesh, METIS cuts it, and every rank receives the
//! names of its own cells. Facing cells of an interface are joined by heavy edges, so that pairs
//! stay together where the balance allows it; a pair that is cut all the same costs communication
//! and nothing else.

mod metis;

use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::hash::mix;
use crate::mesh::{CellPlace, Column, Facets};

/// Weight of the edge between two facing cells of an interface, against 1 within a body.
const PAIR_WEIGHT: i32 = 8;

/// Work of the largest cell; small enough for the 32-bit sums of METIS.
const MOST_WORK: f64 = 64.0;

/// How the cells are shared out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// By METIS, least surface between the ranks.
    Metis,
    /// Every cell to the rank that a hash of its name gives: the worst that can happen to the
    /// parallel code, for tests.
    Scattered,
}

impl Method {
    /// The method asked for by the environment: tests set `COLUMN_HPC_PARTITION=scattered`.
    pub fn from_environment() -> Self {
        match std::env::var("COLUMN_HPC_PARTITION").as_deref() {
            Ok("scattered") => Self::Scattered,
            _ => Self::Metis,
        }
    }
}

/// The coarse cells of this rank, rising, and the size of the mesh that was cut.
///
/// Collective; rank 0 does the work.
///
/// # Errors
/// `System` when METIS fails.
pub fn distribute(comm: &Comm, column: &Column, method: Method) -> Result<(Vec<u64>, u64)> {
    let parts = comm.size() as usize;
    let local = if comm.is_root() { lists(column, parts, method) } else { Ok(Vec::new()) };
    let mut lists = comm.agree(local)?;
    lists.resize(parts, Vec::new());
    let mut received = comm.exchange(&lists);
    let held = if comm.is_root() { column.cells() } else { 0 };
    Ok((std::mem::take(&mut received[0]), comm.max_u64(held)))
}

/// The cells of every rank.
fn lists(column: &Column, parts: usize, method: Method) -> Result<Vec<Vec<u64>>> {
    let cells = column.cells();
    let mut lists = vec![Vec::new(); parts];
    if parts == 1 {
        lists[0] = (0..cells).collect();
        return Ok(lists);
    }
    let rank_of: Vec<i32> = match method {
        Method::Scattered => (0..cells).map(|c| (mix(c) % parts as u64) as i32).collect(),
        Method::Metis => {
            let graph = Graph::new(column)?;
            metis::cut(&graph.start, &graph.neighbours, &graph.weights, &graph.work, parts)?
        }
    };
    for (cell, rank) in rank_of.iter().enumerate() {
        lists[*rank as usize].push(cell as u64);
    }
    Ok(lists)
}

/// The dual graph of the column in compressed form.
struct Graph {
    start: Vec<i32>,
    neighbours: Vec<i32>,
    weights: Vec<i32>,
    /// Work of each cell: the cells of the finest lattice in it, the most being [`MOST_WORK`].
    work: Vec<i32>,
}

impl Graph {
    fn new(column: &Column) -> Result<Self> {
        let cells = column.cells();
        if i32::try_from(cells * 8).is_err() {
            return Err(Error::Input(format!(
                "{cells} cells are too many for the 32-bit METIS that cuts the coarse mesh; \
                 give a coarser mesh and refine it with mesh.refine"
            )));
        }
        let sizes: Vec<u64> =
            (0..cells).map(|c| column.finest_cells(column.cell_place(c))).collect();
        let largest = sizes.iter().copied().max().unwrap_or(1) as f64;
        let work = |size: &u64| (MOST_WORK * *size as f64 / largest).round().max(1.0) as i32;
        let work = sizes.iter().map(work).collect();
        let (neighbours, weights) = (Vec::new(), Vec::new());
        let mut graph = Self { start: vec![0], neighbours, weights, work };
        for cell in 0..cells {
            let place = column.cell_place(cell);
            graph.add_neighbours_within_body(column, place);
            graph.add_facing_cells(column, place);
            graph.start.push(graph.neighbours.len() as i32);
        }
        Ok(graph)
    }

    fn push(&mut self, column: &Column, place: CellPlace, weight: i32) {
        self.neighbours.push(column.cell(place) as i32);
        self.weights.push(weight);
    }

    fn add_neighbours_within_body(&mut self, column: &Column, place: CellPlace) {
        let n = column.extent(place.body);
        for (axis, extent) in n.into_iter().enumerate() {
            let mut neighbour = place;
            if place.at[axis] > 0 {
                neighbour.at[axis] = place.at[axis] - 1;
                self.push(column, neighbour, 1);
            }
            if place.at[axis] + 1 < extent {
                neighbour.at[axis] = place.at[axis] + 1;
                self.push(column, neighbour, 1);
            }
        }
    }

    /// The cells across the interfaces below and above.
    fn add_facing_cells(&mut self, column: &Column, place: CellPlace) {
        let top = column.extent(place.body)[2] - 1;
        let below = (place.at[2] == 0 && place.body > 0)
            .then(|| Facets { body: place.body - 1, upper: true });
        let above = (place.at[2] == top && place.body + 1 < column.bodies())
            .then(|| Facets { body: place.body + 1, upper: false });
        let (low, high) = column.footprint(place);
        for face in [below, above].into_iter().flatten() {
            for at in column.facets_over(face, low, high) {
                self.push(column, column.facet_cell(face, at), PAIR_WEIGHT);
            }
        }
    }
}
