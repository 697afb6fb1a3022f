//! Small meshes of every kind of cell for the tests of the sweeps.

use std::collections::BTreeMap;

use crate::assembly::{CellSet, Cells};
use crate::bulk::{CellStiffness, Elastic, General};
use crate::element::Shape;

/// A mesh of the unit square or cube of cells of one shape.
pub struct Grid {
    pub shape: Shape,
    pub points: Vec<[f64; 3]>,
    pub cells: Vec<Vec<u32>>,
}

/// How the nodes inside move from their places: parts of the edge of a box.
#[derive(Clone, Copy)]
pub struct Shaken {
    /// The corners of the cells.
    pub corners: f64,
    /// The other nodes, from the middles of the corners.
    pub middles: f64,
}

pub const REGULAR: Shaken = Shaken { corners: 0.0, middles: 0.0 };

impl Grid {
    /// Of `n` boxes along each axis, each cut into cells.
    pub fn new(shape: Shape, n: usize, shaken: Shaken) -> Self {
        let mut points = Vec::new();
        let [nx, ny, nz] = if shape.dim() == 2 { [n, n, 0] } else { [n; 3] };
        for (k, j, i) in triples([nz + 1, ny + 1, nx + 1]) {
            points.push([i, j, k].map(|i| i as f64 / n as f64));
        }
        let node = |i: usize, j: usize, k: usize| (i + (n + 1) * (j + (n + 1) * k)) as u32;
        let mut corners: Vec<Vec<u32>> = Vec::new();
        for (k, j, i) in triples([nz.max(1), ny, nx]) {
            let quad =
                |k| [node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k)];
            let mut cube = quad(k).to_vec();
            if shape.dim() == 3 {
                cube.extend(quad(k + 1));
            }
            if shape == Shape::Pyramid5 {
                let middle =
                    |c: usize| 0.5 * (points[cube[0] as usize][c] + points[cube[6] as usize][c]);
                let middle = [0, 1, 2].map(middle);
                cube.push(points.len() as u32);
                points.push(middle);
            }
            let cut = pieces(shape).into_iter();
            corners.extend(cut.map(|piece| piece.into_iter().map(|c| cube[c]).collect()));
        }
        let mut grid = Self { shape, points, cells: Vec::new() };
        grid.shake(0, shaken.corners / n as f64);
        let first = grid.points.len();
        grid.add_middles(corners);
        grid.shake(first, shaken.middles / n as f64);
        grid
    }

    fn shake(&mut self, first: usize, by: f64) {
        let dim = self.shape.dim();
        for (a, x) in self.points.iter_mut().enumerate().skip(first) {
            if x[..dim].iter().all(|x| *x > 0.0 && *x < 1.0) {
                (0..dim).for_each(|c| x[c] += by * ((a * 7 + c * 3) as f64).sin());
            }
        }
    }

    fn add_middles(&mut self, corners: Vec<Vec<u32>>) {
        let (mut known, shape) = (BTreeMap::new(), self.shape);
        for mut cell in corners {
            for xi in &shape.node_points()[shape.corners().nodes()..] {
                let mut values = [0.0; 8];
                shape.corners().values(*xi, &mut values);
                let between = cell.iter().zip(values).filter(|(_, n)| *n > 0.0);
                let mut between: Vec<u32> = between.map(|(node, _)| *node).collect();
                between.sort_unstable();
                let mut middle = [0.0; 3];
                for node in &between {
                    let x = self.points[*node as usize];
                    (0..3).for_each(|i| middle[i] += x[i] / between.len() as f64);
                }
                let points = &mut self.points;
                cell.push(*known.entry(between).or_insert_with(|| {
                    points.push(middle);
                    points.len() as u32 - 1
                }));
            }
            self.cells.push(cell);
        }
    }

    pub fn axes(&self) -> &'static [usize] {
        if self.shape.dim() == 2 { &[0, 1] } else { &[0, 1, 2] }
    }

    /// Its cells, of one material.
    pub fn with(&self, elastic: Elastic, b_bar: bool) -> Cells {
        let general = General::new(self.shape, elastic, self.axes(), b_bar);
        let stiffness = CellStiffness::General(general);
        let nodes = self.cells.iter().cloned();
        let prototypes = vec![0; self.cells.len()];
        Cells::new(self.axes(), nodes, prototypes, vec![stiffness], &self.points)
    }

    /// Nodal values of a field of the position.
    pub fn values(&self, of: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<f64> {
        let dim = self.shape.dim();
        self.points.iter().flat_map(|x| of(*x).into_iter().take(dim)).collect()
    }

    /// Whether a node lies inside.
    pub fn is_inside(&self, node: usize) -> bool {
        self.points[node][..self.shape.dim()].iter().all(|x| *x > 1e-9 && *x < 1.0 - 1e-9)
    }
}

/// Forces of all cells.
pub fn forces(cells: &Cells, u: &[f64]) -> Vec<f64> {
    let mut force = vec![0.0; u.len()];
    cells.add_forces(CellSet::All, u, &mut force, None);
    force
}

/// All triples below the ends, the last index running fastest.
fn triples(ends: [usize; 3]) -> Vec<(usize, usize, usize)> {
    let of = |a| (0..ends[1]).flat_map(move |b| (0..ends[2]).map(move |c| (a, b, c)));
    (0..ends[0]).flat_map(of).collect()
}

/// The corners of the cells into which a box is cut; its own are numbered as in `Quad4` or `Hex8`,
/// then the middle.
fn pieces(shape: Shape) -> Vec<Vec<usize>> {
    match shape.corners() {
        Shape::Tri3 => vec![vec![0, 1, 2], vec![0, 2, 3]],
        Shape::Tet4 => {
            let paths = [[1, 2], [2, 3], [3, 7], [7, 4], [4, 5], [5, 1]];
            paths.iter().map(|[a, b]| vec![0, *a, *b, 6]).collect()
        }
        Shape::Prism6 => vec![vec![0, 1, 2, 4, 5, 6], vec![0, 2, 3, 4, 6, 7]],
        Shape::Pyramid5 => {
            let base = |facet: &&[usize]| facet.iter().rev().copied().chain([8]).collect();
            Shape::Hex8.facets().iter().map(base).collect()
        }
        corners => vec![(0..corners.nodes()).collect()],
    }
}
