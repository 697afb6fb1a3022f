//! The skin of a mesh: the facets that belong to one cell only, of cells of any kinds.

use crate::element::Shape;
use crate::results::FieldGrid;

use super::vector::{Vector, bounds, cross, minus, plus};

/// What is seen of a mesh. Of a plane mesh, and of an interface, these are the cells themselves.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Skin {
    /// Dimensions of the cells of the mesh.
    pub dim: usize,
    /// Of a plane mesh and its interfaces, the axis (0, 1, 2) along which nothing extends.
    pub depth: usize,
    /// The points of the facets (m).
    pub points: Vec<Vector>,
    /// The row of each point in the field files.
    pub rows: Vec<u32>,
    pub facets: Vec<Facet>,
    /// The points of all facets, facet by facet.
    pub nodes: Vec<u32>,
}

/// One facet, whose normal points outwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Facet {
    pub shape: Shape,
    /// Where its points begin.
    pub start: u32,
    /// The cell to which it belongs.
    pub cell: u32,
}

/// The corners of a facet, sorted; a triangle has one that is no point.
type Key = [u32; 4];

impl Skin {
    /// The skin of a mesh. Cells of fewer dimensions than the most are left out.
    pub fn of(grid: &FieldGrid) -> Self {
        let dim = grid.shapes.iter().map(|shape| shape.dim()).max().unwrap_or_default();
        let mut skin = Self { dim, ..Self::default() };
        if dim == 3 {
            for (cell, facet) in outer(grid) {
                let shape = grid.shapes[cell as usize];
                let nodes = grid.cell(cell as usize);
                let nodes = shape.facets()[facet].iter().map(|i| nodes[*i]);
                if let Some(shape) = shape.facet_shape(facet) {
                    skin.push(shape, cell, nodes);
                }
            }
        } else {
            let cells = grid.shapes.iter().enumerate().filter(|(_, shape)| shape.dim() == dim);
            for (cell, shape) in cells {
                skin.push(*shape, cell as u32, grid.cell(cell).iter().copied());
            }
        }
        skin.number(grid);
        let [low, high] = bounds(skin.points.iter().copied());
        let least = |a: usize, b: usize| if high[b] - low[b] < high[a] - low[a] { b } else { a };
        skin.depth = [2, 0].into_iter().fold(1, least);
        skin
    }

    fn push(&mut self, shape: Shape, cell: u32, nodes: impl Iterator<Item = u32>) {
        self.facets.push(Facet { shape, start: self.nodes.len() as u32, cell });
        self.nodes.extend(nodes);
    }

    /// Takes the points that are used, in the order of their rows.
    fn number(&mut self, grid: &FieldGrid) {
        self.rows = self.nodes.clone();
        self.rows.sort_unstable();
        self.rows.dedup();
        let mut place = vec![0; grid.points.len()];
        for (number, row) in self.rows.iter().enumerate() {
            place[*row as usize] = number as u32;
        }
        self.nodes.iter_mut().for_each(|node| *node = place[*node as usize]);
        self.points = self.rows.iter().map(|row| grid.points[*row as usize]).collect();
    }

    /// The points of a facet in the order of its shape.
    pub fn of_facet(&self, facet: &Facet) -> &[u32] {
        &self.nodes[facet.start as usize..][..facet.shape.nodes()]
    }

    /// The points around a facet, those in the middle of its edges with them.
    pub fn ring(&self, facet: &Facet) -> impl Iterator<Item = u32> + Clone {
        let nodes = self.of_facet(facet);
        ring(facet.shape).iter().map(|i| nodes[*i])
    }

    /// The corners of a facet.
    pub fn corners(&self, facet: &Facet) -> &[u32] {
        &self.of_facet(facet)[..facet.shape.corners().nodes()]
    }

    /// The edges of a facet by their ends, in the order of the ring.
    pub fn edges(&self, facet: &Facet) -> impl Iterator<Item = [u32; 2]> {
        let corners = self.corners(facet);
        (0..corners.len()).map(|i| [corners[i], corners[(i + 1) % corners.len()]])
    }

    /// The normal of a facet times its area (m2) with the given points.
    pub fn area(&self, facet: &Facet, points: &[Vector]) -> Vector {
        let ring: Vec<Vector> = self.ring(facet).map(|i| points[i as usize]).collect();
        let mut sum = [0.0; 3];
        for i in 1..ring.len().max(2) - 1 {
            let sides = [minus(ring[i], ring[0]), minus(ring[i + 1], ring[0])];
            sum = plus(sum, 0.5, cross(sides[0], sides[1]));
        }
        sum
    }

    /// The middle of a facet with the given points.
    pub fn middle(&self, facet: &Facet, points: &[Vector]) -> Vector {
        let corners = self.corners(facet);
        let share = 1.0 / corners.len() as f64;
        corners.iter().fold([0.0; 3], |sum, i| plus(sum, share, points[*i as usize]))
    }
}

/// Cells and facets that no other cell shares, cell by cell.
fn outer(grid: &FieldGrid) -> Vec<(u32, usize)> {
    let mut keys: Vec<(Key, u32, u8)> = Vec::new();
    for (cell, shape) in grid.shapes.iter().enumerate().filter(|(_, shape)| shape.dim() == 3) {
        let nodes = grid.cell(cell);
        for (facet, local) in shape.facets().iter().enumerate() {
            let corners = shape.facet_shape(facet).map_or(0, |shape| shape.corners().nodes());
            let mut key = [u32::MAX; 4];
            key.iter_mut().zip(&local[..corners]).for_each(|(k, i)| *k = nodes[*i]);
            key.sort_unstable();
            keys.push((key, cell as u32, facet as u8));
        }
    }
    keys.sort_unstable();
    let alone = keys.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1);
    let mut found: Vec<(u32, usize)> =
        alone.map(|same| (same[0].1, usize::from(same[0].2))).collect();
    found.sort_unstable();
    found
}

/// Local points around a facet; of a line, along it.
fn ring(shape: Shape) -> &'static [usize] {
    match shape {
        Shape::Line3 => &[0, 2, 1],
        Shape::Tri6 => &[0, 3, 1, 4, 2, 5],
        Shape::Quad9 => &[0, 4, 1, 5, 2, 6, 3, 7],
        Shape::Tri3 => &[0, 1, 2],
        Shape::Quad4 => &[0, 1, 2, 3],
        _ => &[0, 1],
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// One cell of a shape, where its reference cell is.
    fn one(shape: Shape) -> FieldGrid {
        FieldGrid {
            points: shape.node_points().to_vec(),
            shapes: vec![shape],
            starts: vec![0, shape.nodes()],
            nodes: (0..shape.nodes() as u32).collect(),
        }
    }

    /// A block of hexahedra with edges of length 1 m.
    pub(in crate::scene) fn block(counts: [usize; 3]) -> FieldGrid {
        let along = counts.map(|count| count + 1);
        let name = |at: [usize; 3]| (at[0] + along[0] * (at[1] + along[1] * at[2])) as u32;
        let mut grid = FieldGrid { starts: vec![0], ..FieldGrid::default() };
        for (z, y, x) in triples(along) {
            grid.points.push([x as f64, y as f64, z as f64]);
        }
        for (z, y, x) in triples(counts) {
            let plane = [[0, 0], [1, 0], [1, 1], [0, 1]];
            for (up, [right, back]) in (0..2).flat_map(|up| plane.map(|step| (up, step))) {
                grid.nodes.push(name([x + right, y + back, z + up]));
            }
            grid.shapes.push(Shape::Hex8);
            grid.starts.push(grid.nodes.len());
        }
        grid
    }

    fn triples(counts: [usize; 3]) -> impl Iterator<Item = (usize, usize, usize)> {
        let [x, y, z] = counts;
        (0..z).flat_map(move |k| (0..y).flat_map(move |j| (0..x).map(move |i| (k, j, i))))
    }

    /// How often each edge is run along one way less the other, and how often in all.
    fn uses(skin: &Skin) -> BTreeMap<[u32; 2], [i32; 2]> {
        let mut found: BTreeMap<[u32; 2], [i32; 2]> = BTreeMap::new();
        for [a, b] in skin.facets.iter().flat_map(|facet| skin.edges(facet)) {
            let [balance, count] = found.entry([a.min(b), a.max(b)]).or_default();
            *balance += if a < b { 1 } else { -1 };
            *count += 1;
        }
        found
    }

    #[test]
    fn a_block_shows_its_six_sides() {
        for counts in [[1, 1, 1], [1, 1, 5], [3, 4, 5], [10, 2, 1]] {
            let skin = Skin::of(&block(counts));
            let [x, y, z] = counts;
            assert_eq!(skin.facets.len(), 2 * (x * y + y * z + z * x), "{counts:?}");
            let area: f64 = skin.facets.iter().map(|f| skin.area(f, &skin.points)[2].abs()).sum();
            assert_eq!(area, 2.0 * (x * y) as f64);
            // Every edge twice, once each way: it is closed, and its normals agree.
            assert!(uses(&skin).values().all(|use_| *use_ == [0, 2]), "{counts:?}");
        }
    }

    #[test]
    fn the_skin_of_any_cell_is_closed_and_looks_outwards() {
        for shape in Shape::ALL.into_iter().filter(|shape| shape.dim() == 3) {
            let skin = Skin::of(&one(shape));
            assert_eq!(skin.facets.len(), shape.facets().len());
            assert!(uses(&skin).values().all(|use_| *use_ == [0, 2]), "{shape:?}");
            let centre = shape.centroid();
            for facet in &skin.facets {
                let away = minus(skin.middle(facet, &skin.points), centre);
                let out = super::super::vector::dot(skin.area(facet, &skin.points), away);
                assert!(out > 0.0, "{shape:?}");
            }
        }
    }

    #[test]
    fn cells_of_different_kinds_hide_what_they_share() {
        // A pyramid on a hexahedron, a tetrahedron on one of its triangles.
        let mut grid = block([1, 1, 1]);
        grid.points.extend([[0.5, 0.5, 2.0], [2.0, 0.5, 2.0]]);
        grid.nodes.extend([4, 5, 7, 6, 8]);
        // The square runs around: 4, 5, 7, 6 of the block's numbering.
        grid.shapes.push(Shape::Pyramid5);
        grid.starts.push(grid.nodes.len());
        grid.nodes.extend([5, 7, 8, 9]);
        grid.shapes.push(Shape::Tet4);
        grid.starts.push(grid.nodes.len());
        let skin = Skin::of(&grid);
        assert_eq!(skin.facets.len(), 6 + 5 + 4 - 4);
        assert!(uses(&skin).values().all(|[_, count]| *count == 2));
    }

    #[test]
    fn a_plane_mesh_is_its_own_skin() {
        for shape in [Shape::Tri3, Shape::Tri6, Shape::Quad4, Shape::Quad9] {
            let skin = Skin::of(&one(shape));
            assert_eq!((skin.dim, skin.facets.len()), (2, 1));
            assert_eq!(skin.points.len(), shape.nodes());
            let area = skin.area(&skin.facets[0], &skin.points)[2];
            assert!((area - shape.volume()).abs() < 1e-12, "{shape:?}");
        }
        assert_eq!(Skin::of(&FieldGrid::default()), Skin { depth: 1, ..Skin::default() });
    }
}
