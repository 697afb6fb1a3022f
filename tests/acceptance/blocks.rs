//! Meshes of mapped blocks as files of Gmsh (MSH 2.2).

use std::fmt::Write;
use std::fs;

use crate::scene::fresh;

/// A mesh file in the making.
#[derive(Default)]
pub struct Blocks {
    nodes: Vec<[f64; 3]>,
    names: Vec<(usize, String)>,
    elements: Vec<String>,
    /// Whether hexahedra become two prisms each, with triangles across the third axis.
    of_prisms: bool,
}

/// A block of quadrilaterals or hexahedra: where its lattice has its planes, and where its points
/// come to lie.
pub struct Block<'a> {
    /// The group of its cells.
    pub name: &'a str,
    /// Coordinates of the planes along each axis; two axes, or three.
    pub planes: &'a [Vec<f64>],
    /// 1, or in the plane 2.
    pub order: usize,
    /// From the lattice into space.
    pub place: &'a dyn Fn([f64; 3]) -> [f64; 3],
    /// Groups of facets: axis, whether it is the far end of it, name.
    pub sides: &'a [(usize, bool, &'a str)],
}

/// So many equal cells over a length from 0.
pub fn even(cells: usize, length: f64) -> Vec<f64> {
    (0..=cells).map(|i| length * i as f64 / cells as f64).collect()
}

/// Planes from 0 to `end`: equal cells of `size` up to `fine`, then growing ones.
pub fn graded(size: f64, fine: f64, end: f64) -> Vec<f64> {
    const GROWTH: f64 = 1.4;
    let mut planes = even((fine / size).round() as usize, fine);
    let (mut last, mut step) = (fine, size * GROWTH);
    while last + 1.5 * step < end {
        last += step;
        planes.push(last);
        step *= GROWTH;
    }
    planes.push(end);
    planes
}

impl Blocks {
    /// None yet; of hexahedra, or of prisms in their place.
    pub fn of_prisms(of_prisms: bool) -> Self {
        Self { of_prisms, ..Self::default() }
    }

    /// Adds a block, with nodes of its own.
    pub fn add(&mut self, block: &Block<'_>) {
        let (o, dim) = (block.order, block.planes.len());
        let fine: Vec<Vec<f64>> = block.planes.iter().map(|planes| halved(planes, o)).collect();
        let count = |axis: usize| fine.get(axis).map_or(1, Vec::len);
        let first = self.nodes.len() + 1;
        let at = |axis: usize, i: usize| fine.get(axis).map_or(0.0, |planes| planes[i]);
        for k in 0..count(2) {
            for j in 0..count(1) {
                for i in 0..count(0) {
                    self.nodes.push((block.place)([at(0, i), at(1, j), at(2, k)]));
                }
            }
        }
        let node = |[i, j, k]: [usize; 3]| first + i + count(0) * (j + count(1) * k);
        let cells = |axis: usize| if axis < dim { (count(axis) - 1) / o } else { 1 };
        for k in 0..cells(2) {
            for j in 0..cells(1) {
                for i in 0..cells(0) {
                    let from = [o * i, o * j, if dim == 3 { k } else { 0 }];
                    let all = |offsets: &[[usize; 3]]| -> Vec<usize> {
                        let to = |by: &[usize; 3]| node(std::array::from_fn(|d| from[d] + by[d]));
                        offsets.iter().map(to).collect()
                    };
                    let (kind, nodes) = match (dim, o) {
                        (2, 1) => (3, all(&square(1)[..4])),
                        (2, _) => (10, all(&square(2))),
                        _ => (5, [all(&square(1)[..4]), all(&lifted(&square(1)[..4]))].concat()),
                    };
                    if kind == 5 && self.of_prisms {
                        for [a, b] in [[1, 2], [2, 3]] {
                            let halves = [0, a, b, 4, 4 + a, 4 + b].map(|corner| nodes[corner]);
                            self.element(6, dim, block.name, &halves);
                        }
                    } else {
                        self.element(kind, dim, block.name, &nodes);
                    }
                    for (axis, is_far, name) in block.sides {
                        let index = [i, j, k][*axis];
                        if index != if *is_far { cells(*axis) - 1 } else { 0 } {
                            continue;
                        }
                        let (kind, offsets) = facet(dim, o, *axis, *is_far);
                        let mut nodes = all(&offsets);
                        if self.of_prisms && *axis == 2 {
                            nodes.rotate_left(usize::from(!is_far));
                            let [a, b, c, d] = nodes[..] else { unreachable!("four corners") };
                            self.element(2, 2, name, &[a, b, c]);
                            self.element(2, 2, name, &[a, c, d]);
                        } else {
                            self.element(kind, dim - 1, name, &nodes);
                        }
                    }
                }
            }
        }
    }

    fn element(&mut self, kind: usize, dim: usize, name: &str, nodes: &[usize]) {
        let group = (dim, name.to_owned());
        let place = self.names.iter().position(|other| *other == group).unwrap_or_else(|| {
            self.names.push(group);
            self.names.len() - 1
        });
        let nodes: Vec<String> = nodes.iter().map(usize::to_string).collect();
        self.elements.push(format!("{kind} 2 {0} {0} {1}", place + 1, nodes.join(" ")));
    }

    /// Writes it; the path of the file.
    pub fn write(&self) -> String {
        let mut text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n".to_owned();
        let mut line = |words: String| writeln!(text, "{words}").expect("memory");
        line(self.names.len().to_string());
        for (place, (dim, name)) in self.names.iter().enumerate() {
            line(format!("{dim} {} \"{name}\"", place + 1));
        }
        line(format!("$EndPhysicalNames\n$Nodes\n{}", self.nodes.len()));
        for (place, [x, y, z]) in self.nodes.iter().enumerate() {
            line(format!("{} {x:?} {y:?} {z:?}", place + 1));
        }
        line(format!("$EndNodes\n$Elements\n{}", self.elements.len()));
        for (place, element) in self.elements.iter().enumerate() {
            line(format!("{} {element}", place + 1));
        }
        line("$EndElements".into());
        let path = fresh().join("blocks.msh");
        fs::write(&path, text).expect("the build directory is writable");
        path.to_string_lossy().into_owned()
    }
}

/// The planes, with one in the middle of each cell for the second order.
fn halved(planes: &[f64], order: usize) -> Vec<f64> {
    let mut all = vec![planes[0]];
    for pair in planes.windows(2) {
        all.extend((order == 2).then(|| 0.5 * (pair[0] + pair[1])));
        all.push(pair[1]);
    }
    all
}

/// Corners, middles of edges and middle of a square of this size.
fn square(o: usize) -> [[usize; 3]; 9] {
    let h = o / 2;
    [[0, 0], [o, 0], [o, o], [0, o], [h, 0], [o, h], [h, o], [0, h], [h, h]].map(|[i, j]| [i, j, 0])
}

fn lifted(offsets: &[[usize; 3]]) -> Vec<[usize; 3]> {
    offsets.iter().map(|[i, j, k]| [*i, *j, k + 1]).collect()
}

/// Kind and nodes of a facet of a cell, its normal out of the cell.
fn facet(dim: usize, o: usize, axis: usize, is_far: bool) -> (usize, Vec<[usize; 3]>) {
    let end = if is_far { o } else { 0 };
    let (b, c) = ((axis + 1) % dim, (axis + 2) % dim);
    let at = |u: usize, v: usize| {
        let mut offset = [0; 3];
        if dim == 3 {
            offset[c] = v;
        }
        offset[b] = u;
        offset[axis] = end;
        offset
    };
    if dim == 2 {
        // Out of the cell is to the right of the way.
        let mut ends = [at(0, 0), at(o, 0)];
        if is_far != (axis == 0) {
            ends.reverse();
        }
        let middle = at(o / 2, 0);
        return if o == 1 { (1, ends.to_vec()) } else { (8, [ends[0], ends[1], middle].to_vec()) };
    }
    let mut corners = vec![at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
    if !is_far {
        corners.reverse();
    }
    (3, corners)
}
