//! The column generator: bodies stacked along z, each a lattice of boxes.

use super::grading::graded;
use crate::case::{CLOSEST_PLANES, Case, Cells, ColumnSpec, InterfaceSpec};
use crate::error::{Error, Result};
use crate::mesh::axes;

/// One layer of cells of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Lower and upper height (m).
    pub z: [f64; 2],
    /// Index of the material.
    pub material: usize,
}

/// One body: the cells between two neighbouring interfaces.
#[derive(Debug, Clone)]
pub(super) struct Body {
    /// Cells of the finest lattice along x, y, z (y: 1 in 2D).
    pub(super) finest: [usize; 3],
    /// As the case describes them, before any refinement.
    pub(super) layers: Vec<Layer>,
    /// The planes along x and y (m) as the case describes them; none where they are uniform.
    pub(super) across: [Vec<f64>; 2],
    /// Planes of the finest lattice, along x, y, z, that bound the cells of this column.
    pub(super) planes: [Vec<u32>; 3],
    /// Order of the cells, 1 or 2.
    pub(super) order: usize,
    pub(super) first_node: u64,
    first_cell: u64,
}

/// A column, or a coarser lattice nested in it. Small: of the size of one line of cells, the same
/// on every rank; everything of the size of the mesh is computed from it for the cells a rank owns.
///
/// Every lattice of a family keeps a choice of the planes of the finest one, so that the nodes of
/// a coarse lattice are nodes of the finer ones, to the last bit of their coordinates.
#[derive(Debug, Clone)]
pub struct Column {
    /// 2 (x, z; plane strain) or 3.
    pub dim: usize,
    /// Extent along x, y, z (m); y is 0 in 2D.
    pub size: [f64; 3],
    /// Uniform refinements from the mesh that the case describes to the finest lattice.
    pub(super) refinements: u32,
    pub(super) bodies: Vec<Body>,
}

/// A cell by its place: body, and position along x, y, z in the body's lattice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellPlace {
    /// Body, counted from the bottom.
    pub body: usize,
    /// Position along x, y, z.
    pub at: [usize; 3],
}

/// The facets of one horizontal face of a body.
#[derive(Debug, Clone, Copy)]
pub struct Facets {
    /// The body whose face it is.
    pub body: usize,
    /// Whether it is the body's upper face.
    pub upper: bool,
}

impl Column {
    /// The column of a case, refined as the case says.
    ///
    /// # Errors
    /// `Input` when a material's height range leaves a layer without a material; `Bug` when the
    /// mesh comes from a file.
    pub fn new(case: &Case) -> Result<Self> {
        let column = case
            .mesh
            .column()
            .ok_or_else(|| Error::Bug("a column is made of the mesh of a file".to_owned()))?;
        let (dim, size) = (case.dim, column.lengths());
        let planes: Vec<f64> = std::iter::once(0.0)
            .chain(case.interfaces.iter().filter_map(InterfaceSpec::height))
            .chain(std::iter::once(size[2]))
            .collect();
        let changes: Vec<f64> = case.materials.iter().flat_map(|m| m.z).flatten().collect();
        let refinements = case.mesh.refine;
        let grading = along_axes(case, column);
        let mut bodies = Vec::new();
        for (index, ends) in planes.windows(2).enumerate() {
            let (cells, stops) = match &column.cells {
                Cells::Uniform(n) => (*n, [planes.clone(), changes.clone()].concat()),
                Cells::Bodies(list) => (list[index], with_ends(&changes, [ends[0], ends[1]])),
            };
            let mut levels = match (&grading[2], &column.cells) {
                (Some(growth), _) => growth.planes(&stops, cells[2]),
                (None, Cells::Uniform(_)) => uniform([0.0, size[2]], cells[2]),
                (None, Cells::Bodies(_)) => uniform([ends[0], ends[1]], cells[2]),
            };
            levels.extend(changes.iter().chain(ends));
            let levels = between(levels, [ends[0], ends[1]], CLOSEST_PLANES * size[2]);
            let layers = levels
                .windows(2)
                .map(|z| {
                    let z = [z[0], z[1]];
                    Ok(Layer { z, material: material_at(case, 0.5 * (z[0] + z[1]))? })
                })
                .collect::<Result<Vec<_>>>()?;
            let y = if dim == 2 { 1 } else { cells[1] << refinements };
            let finest = [cells[0] << refinements, y, layers.len() << refinements];
            let planes = finest.map(|n| (0..=n as u32).collect());
            let order = column.orders[index.min(column.orders.len() - 1)];
            let across = [0, 1].map(|axis| {
                let graded = |growth: &Growth| growth.planes(&[0.0, size[axis]], cells[axis]);
                grading[axis].as_ref().map_or_else(Vec::new, graded)
            });
            let (first_node, first_cell) = (0, 0);
            bodies.push(Body { finest, layers, across, planes, order, first_node, first_cell });
        }
        let mut column = Self { dim, size, refinements, bodies };
        column.number();
        Ok(column)
    }

    /// The lattice as the case describes it, before any refinement.
    pub fn described(&self) -> Self {
        let mut column = self.clone();
        for body in &mut column.bodies {
            for (axis, planes) in body.planes.iter_mut().enumerate() {
                let step = if axis == 1 && self.dim == 2 { 1 } else { 1u32 << self.refinements };
                *planes = (0..=body.finest[axis] as u32).step_by(step as usize).collect();
            }
        }
        column.number();
        column
    }

    /// Gives nodes and cells their numbers.
    pub(super) fn number(&mut self) {
        let (mut first_node, mut first_cell) = (0, 0);
        for index in 0..self.bodies.len() {
            let nodes = product(self.node_extent(index));
            let body = &mut self.bodies[index];
            (body.first_node, body.first_cell) = (first_node, first_cell);
            first_node += nodes;
            first_cell += product(body.extent());
        }
    }

    /// Number of bodies.
    pub fn bodies(&self) -> usize {
        self.bodies.len()
    }

    /// Number of cells.
    pub fn cells(&self) -> u64 {
        let last = self.bodies.len() - 1;
        self.bodies[last].first_cell + product(self.extent(last))
    }

    /// Order of the cells of a body: 1 or 2.
    pub fn order(&self, body: usize) -> usize {
        self.bodies[body].order
    }

    /// The highest order of the cells of any body.
    pub fn highest_order(&self) -> usize {
        self.bodies.iter().map(|b| b.order).max().unwrap_or(1)
    }

    /// Cells of a body along x, y, z.
    pub fn extent(&self, body: usize) -> [usize; 3] {
        self.bodies[body].extent()
    }

    /// The place of a cell.
    pub fn cell_place(&self, cell: u64) -> CellPlace {
        let body = self.bodies.partition_point(|b| b.first_cell <= cell) - 1;
        let at = unflatten(cell - self.bodies[body].first_cell, self.extent(body));
        CellPlace { body, at }
    }

    /// The number of a cell.
    pub fn cell(&self, place: CellPlace) -> u64 {
        self.bodies[place.body].first_cell + flatten(place.at, self.extent(place.body))
    }

    /// Coordinate of a plane between cells of a body along an axis (m).
    pub fn plane(&self, body: usize, axis: usize, index: usize) -> f64 {
        let Body { finest, layers, across, planes, .. } = &self.bodies[body];
        let plane = planes[axis][index] as usize;
        if axis < 2 && across[axis].is_empty() {
            return self.size[axis] * (plane as f64 / finest[axis] as f64);
        }
        let parts = 1usize << self.refinements;
        let described = if axis < 2 { across[axis].len() - 1 } else { layers.len() };
        let layer = (plane / parts).min(described - 1);
        let [low, high] = match axis {
            2 => layers[layer].z,
            _ => [across[axis][layer], across[axis][layer + 1]],
        };
        let fraction = (plane - layer * parts) as f64 / parts as f64;
        if fraction == 1.0 { high } else { low + (high - low) * fraction }
    }

    /// The cell that holds a point of the column, and where in it (0 to 1 along x, y, z). A point
    /// on an interface belongs to the body below.
    pub fn locate(&self, point: [f64; 3]) -> (CellPlace, [f64; 3]) {
        let tolerance = 1e-12 * self.size[2];
        let top = |b: usize| self.plane(b, 2, self.extent(b)[2]);
        let body = (0..self.bodies.len() - 1).find(|b| point[2] <= top(*b) + tolerance);
        let body = body.unwrap_or(self.bodies.len() - 1);
        let n = self.extent(body);
        let (mut at, mut fraction) = ([0; 3], [0.0; 3]);
        for axis in axes(self.dim).iter().copied() {
            let upper = |k: usize| self.plane(body, axis, k + 1);
            at[axis] = (0..n[axis] - 1).find(|k| point[axis] <= upper(*k)).unwrap_or(n[axis] - 1);
            let (low, high) = (self.plane(body, axis, at[axis]), upper(at[axis]));
            fraction[axis] = (point[axis] - low) / (high - low);
        }
        (CellPlace { body, at }, fraction)
    }

    /// Edge lengths of a cell along x, y, z (m; y is 1 in 2D, the unit thickness) and its material.
    pub fn cell_size(&self, place: CellPlace) -> ([f64; 3], usize) {
        let body = &self.bodies[place.body];
        let edge = |axis: usize| {
            let cells = &body.planes[axis][place.at[axis]..];
            if !body.across[axis].is_empty() {
                let plane = |k: usize| self.plane(place.body, axis, place.at[axis] + k);
                return plane(1) - plane(0);
            }
            self.size[axis] * (f64::from(cells[1] - cells[0]) / body.finest[axis] as f64)
        };
        let y = if self.dim == 2 { 1.0 } else { edge(1) };
        let layer = &body.layers[body.planes[2][place.at[2]] as usize >> self.refinements];
        let cells = body.planes[2][place.at[2] + 1] - body.planes[2][place.at[2]];
        let z = if cells == 1 {
            (layer.z[1] - layer.z[0]) / (1u64 << self.refinements) as f64
        } else {
            self.plane(place.body, 2, place.at[2] + 1) - self.plane(place.body, 2, place.at[2])
        };
        ([edge(0), y, z], layer.material)
    }

    /// The cell behind a facet of a face; `at` is the facet's position along x, y.
    pub fn facet_cell(&self, face: Facets, at: [usize; 2]) -> CellPlace {
        let k = if face.upper { self.extent(face.body)[2] - 1 } else { 0 };
        CellPlace { body: face.body, at: [at[0], at[1], k] }
    }

    /// The facets of `face` that overlap the box from `low` to `high` in the plane (m).
    pub fn facets_over(&self, face: Facets, low: [f64; 2], high: [f64; 2]) -> Vec<[usize; 2]> {
        let n = self.extent(face.body);
        let range = |axis: usize| {
            if axis == 1 && self.dim == 2 {
                return 0..1;
            }
            // A facet that only touches the box is left out.
            let body = &self.bodies[face.body];
            let uniform = self.size[axis] / body.finest[axis] as f64;
            let narrowest = body.across[axis].windows(2).map(|x| x[1] - x[0]);
            let margin = 1e-9 * narrowest.fold(uniform, f64::min);
            let plane = |k: usize| self.plane(face.body, axis, k);
            let first = (0..n[axis]).find(|k| plane(k + 1) > low[axis] + margin);
            let end = (0..n[axis]).rfind(|k| plane(*k) < high[axis] - margin);
            first.unwrap_or(n[axis])..end.map_or(0, |k| k + 1)
        };
        range(1).flat_map(|j| range(0).map(move |i| [i, j])).collect()
    }
}

impl Body {
    fn extent(&self) -> [usize; 3] {
        [0, 1, 2].map(|axis| self.planes[axis].len() - 1)
    }
}

pub(super) fn product(n: [usize; 3]) -> u64 {
    n.iter().map(|n| *n as u64).product()
}

pub(super) fn flatten(at: [usize; 3], n: [usize; 3]) -> u64 {
    at[0] as u64 + n[0] as u64 * (at[1] as u64 + n[1] as u64 * at[2] as u64)
}

pub(super) fn unflatten(index: u64, n: [usize; 3]) -> [usize; 3] {
    let (x, y) = (n[0] as u64, n[1] as u64);
    [(index % x) as usize, (index / x % y) as usize, (index / (x * y)) as usize]
}

/// How cells grow along an axis.
struct Growth {
    places: Vec<f64>,
    ratio: f64,
}

impl Growth {
    /// The planes of so many cells, with planes at all `stops`, in any order.
    fn planes(&self, stops: &[f64], cells: usize) -> Vec<f64> {
        let mut stops = stops.to_vec();
        stops.sort_by(f64::total_cmp);
        let height = stops[stops.len() - 1] - stops[0];
        stops.dedup_by(|b, a| *b - *a <= CLOSEST_PLANES * height);
        graded(&stops, &self.places, self.ratio, cells)
    }
}

/// How the cells of a column grow along x, y, z.
fn along_axes(case: &Case, column: &ColumnSpec) -> [Option<Growth>; 3] {
    let lengths = column.lengths();
    [0, 1, 2].map(|axis| {
        let grading = column.grading.along(axis)?;
        let of = grading.places(axis, lengths[axis], &case.interfaces, &case.materials);
        of.ok().map(|places| Growth { places, ratio: grading.ratio })
    })
}

/// The planes that divide a range into equal layers.
fn uniform(ends: [f64; 2], layers: usize) -> Vec<f64> {
    let part = |k: usize| ends[0] + (ends[1] - ends[0]) * (k as f64 / layers as f64);
    (0..=layers).map(part).collect()
}

/// The ends and the planes between them.
fn with_ends(planes: &[f64], ends: [f64; 2]) -> Vec<f64> {
    let inside = planes.iter().copied().filter(|z| *z > ends[0] && *z < ends[1]);
    inside.chain(ends).collect()
}

/// Sorted planes within `ends`; of planes closer than `tolerance` an end wins.
fn between(mut planes: Vec<f64>, ends: [f64; 2], tolerance: f64) -> Vec<f64> {
    planes.retain(|z| *z > ends[0] + tolerance && *z < ends[1] - tolerance);
    planes.extend(ends);
    planes.sort_by(f64::total_cmp);
    planes.dedup_by(|b, a| *b - *a <= tolerance);
    planes
}

fn material_at(case: &Case, z: f64) -> Result<usize> {
    let holds = |m: &crate::case::Material| m.z.is_none_or(|[low, high]| low < z && z < high);
    case.materials.iter().position(holds).ok_or_else(|| {
        Error::Input(format!("no material is given at the height z = {z} m; see materials.*.z"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// As thin as the case may say: there are cells between all planes.
    #[test]
    fn thin_layers_have_cells() {
        let elastic = "elastic: {young_modulus: 1, poisson_ratio: 0}";
        let yaml = format!(
            "mesh: {{column: {{size: [1, 1, 5], cells: [1, 1, 5]}}}}\n\
             materials:\n  rock: {{z: [0, 2], {elastic}}}\n  seam: {{z: [2, 2.000000011], {elastic}}}\n  \
             upper: {{z: [2.000000011, 5], {elastic}}}\n\
             interfaces:\n  - {{name: low, z: 5.1e-9, law: {{tied: {{}}}}}}\n  \
             - {{name: high, z: 4.9999999949, law: {{tied: {{}}}}}}\n\
             boundary: [{{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}]\ntime: {{instants: [1]}}\n"
        );
        let case = Case::read(&yaml, Path::new("t.yaml"), &[]).expect("a case");
        let column = Column::new(&case).expect("a column");
        let layers: Vec<usize> = (0..3).map(|body| column.extent(body)[2]).collect();
        assert_eq!(layers, [1, 6, 1]);
        let mut thin = 0;
        for cell in 0..column.cells() {
            let (size, material) = column.cell_size(column.cell_place(cell));
            assert!(size[2] > 5e-9, "{size:?}");
            thin += usize::from(material == 1);
        }
        assert_eq!(thin, 1, "cells of the seam");
    }
}
