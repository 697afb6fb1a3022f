//! Boxes laid along the axes: their local coordinates become x, y and z.
//!
//! Mesh generators begin a hexahedron at any corner and in any direction. Boxes that begin alike
//! share one stiffness, and their products are those of lattices.

use super::cells::Cells;
use crate::element::{Family, Shape};

/// Edges lean by less than this part of their length where they run along an axis.
const ALONG: f64 = 1e-12;

/// The axis and sense of each local axis.
type Way = [(usize, f64); 3];

/// Turns the local axes of quadrilaterals and hexahedra whose edges at their first node run along
/// the axes; nodes, shape and sense of the cells stay.
pub fn lay_along_axes(cells: &mut Cells) {
    let dim = cells.dim();
    let mut known: Vec<((Shape, Way), Vec<usize>)> = Vec::new();
    let mut before = Vec::new();
    for (cell, shape) in cells.shapes.iter().enumerate() {
        if shape.family() != Family::Cube || shape.dim() != dim {
            continue;
        }
        let nodes = &mut cells.nodes[cells.start[cell] as usize..cells.start[cell + 1] as usize];
        let corner = |local: usize| cells.points[nodes[local] as usize];
        let Some(way) = way(dim, &corner).filter(|way| !is_usual(&way[..dim])) else { continue };
        let place = known.iter().position(|(of, _)| *of == (*shape, way)).unwrap_or_else(|| {
            known.push(((*shape, way), order(*shape, &way)));
            known.len() - 1
        });
        before.clear();
        before.extend_from_slice(nodes);
        for (node, old) in nodes.iter_mut().zip(&known[place].1) {
            *node = before[*old];
        }
    }
}

/// Which way the local axes run, if that is along x, y and z, one each, without a reflection.
fn way(dim: usize, corner: &dyn Fn(usize) -> [f64; 3]) -> Option<Way> {
    let first = corner(0);
    let mut way = [(0, 1.0), (1, 1.0), (2, 1.0)];
    for (local, end) in [1, 3, 4].into_iter().enumerate().take(dim) {
        let end = corner(end);
        let edge: [f64; 3] = std::array::from_fn(|i| end[i] - first[i]);
        let longest = |a: usize, b: usize| if edge[b].abs() > edge[a].abs() { b } else { a };
        let axis = longest(longest(0, 1), 2);
        if (0..3).any(|i| i != axis && edge[i].abs() > ALONG * edge[axis].abs()) {
            return None;
        }
        way[local] = (axis, edge[axis].signum());
    }
    let row =
        |local: usize| std::array::from_fn(|i| if way[local].0 == i { way[local].1 } else { 0.0 });
    let [a, b, c]: [[f64; 3]; 3] = [row(0), row(1), row(2)];
    let determinant = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0]);
    (determinant > 0.0).then_some(way)
}

fn is_usual(way: &[(usize, f64)]) -> bool {
    way.iter().enumerate().all(|(local, (axis, sense))| local == *axis && *sense > 0.0)
}

/// The node that each node of a cell was before its local axes were turned.
fn order(shape: Shape, way: &Way) -> Vec<usize> {
    let points = shape.node_points();
    let before = |xi: &[f64; 3]| {
        let old: [f64; 3] = std::array::from_fn(|local| way[local].1 * xi[way[local].0]);
        let is_there = |other: &[f64; 3]| (0..shape.dim()).all(|i| other[i] == old[i]);
        points.iter().position(is_there).expect("turned by right angles, nodes lie on nodes")
    };
    points.iter().map(before).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::import::Kind;

    /// Turns by a right angle about x, y or z, as (axis, sense) of each local axis.
    const TURNS: [Way; 3] = [
        [(0, 1.0), (2, 1.0), (1, -1.0)],
        [(2, -1.0), (1, 1.0), (0, 1.0)],
        [(1, 1.0), (0, -1.0), (2, 1.0)],
    ];

    #[test]
    fn boxes_begin_at_their_lowest_corner_whatever_their_order_was() {
        let kinds =
            [(Kind::Hex8, Shape::Hex8), (Kind::Hex27, Shape::Hex27), (Kind::Quad9, Shape::Quad9)];
        for (kind, shape) in kinds {
            let points: Vec<[f64; 3]> = shape.node_points().to_vec();
            let usual: Vec<u32> = (0..points.len() as u32).collect();
            let mut nodes = usual.clone();
            let mut seen = Vec::new();
            // Turns one after the other come to all 24 (2D: 4) orders.
            for step in 0..200 {
                let turn = if shape.dim() == 2 { 2 } else { (step + step / 3 + step / 7) % 3 };
                let turned = order(shape, &TURNS[turn]);
                nodes = turned.iter().map(|old| nodes[*old]).collect();
                if !seen.contains(&nodes) {
                    seen.push(nodes.clone());
                }
                let mut cells = Cells {
                    points: points.clone(),
                    kinds: vec![kind],
                    shapes: vec![shape],
                    start: vec![0, nodes.len() as u32],
                    nodes: nodes.clone(),
                    ..Cells::default()
                };
                lay_along_axes(&mut cells);
                assert_eq!(cells.nodes, usual, "{shape:?} {nodes:?}");
            }
            assert_eq!(seen.len(), if shape.dim() == 2 { 4 } else { 24 });
        }
    }

    #[test]
    fn other_cells_and_those_turned_over_stay() {
        let lean: Vec<[f64; 3]> =
            Shape::Hex8.node_points().iter().map(|x| [x[1], x[0] + 1e-9 * x[1], x[2]]).collect();
        let over: Vec<[f64; 3]> =
            Shape::Hex8.node_points().iter().map(|x| [x[1], x[0], x[2]]).collect();
        for points in [lean, over] {
            let nodes: Vec<u32> = (0..8).collect();
            let mut cells = Cells {
                points,
                kinds: vec![Kind::Hex8],
                shapes: vec![Shape::Hex8],
                start: vec![0, 8],
                nodes: nodes.clone(),
                ..Cells::default()
            };
            lay_along_axes(&mut cells);
            assert_eq!(cells.nodes, nodes);
        }
    }
}
