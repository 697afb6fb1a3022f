//! Measures of elements by plain geometry, with the nodes in the order of VTK.

use column_hpc::mesh::import::{Block, FileMesh, Kind};

type Point = [f64; 3];

/// Right-handed tetrahedra that fill an element of three dimensions.
fn tetrahedra(kind: Kind) -> &'static [[usize; 4]] {
    match kind {
        Kind::Tet4 | Kind::Tet10 => &[[0, 1, 2, 3]],
        Kind::Pyramid5 | Kind::Pyramid13 => &[[0, 1, 2, 4], [0, 2, 3, 4]],
        Kind::Prism6 | Kind::Prism15 | Kind::Prism18 => &[[0, 1, 2, 5], [0, 1, 5, 4], [0, 4, 5, 3]],
        Kind::Hex8 | Kind::Hex20 | Kind::Hex27 => {
            &[[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]
        }
        _ => &[],
    }
}

/// Triangles that fill an element of two dimensions.
fn triangles(kind: Kind) -> &'static [[usize; 3]] {
    match kind {
        Kind::Tri3 | Kind::Tri6 => &[[0, 1, 2]],
        Kind::Quad4 | Kind::Quad8 | Kind::Quad9 => &[[0, 1, 2], [0, 2, 3]],
        _ => &[],
    }
}

/// The corners between which the nodes after the corners lie in the middle.
fn middles(kind: Kind) -> &'static [&'static [usize]] {
    match kind {
        Kind::Line3 => &[&[0, 1]],
        Kind::Tri6 => &[&[0, 1], &[1, 2], &[2, 0]],
        Kind::Quad8 => &[&[0, 1], &[1, 2], &[2, 3], &[3, 0]],
        Kind::Quad9 => &[&[0, 1], &[1, 2], &[2, 3], &[3, 0], &[0, 1, 2, 3]],
        Kind::Tet10 => &[&[0, 1], &[1, 2], &[2, 0], &[0, 3], &[1, 3], &[2, 3]],
        Kind::Pyramid13 => {
            &[&[0, 1], &[1, 2], &[2, 3], &[3, 0], &[0, 4], &[1, 4], &[2, 4], &[3, 4]]
        }
        Kind::Prism15 => &PRISM[..9],
        Kind::Prism18 => &PRISM,
        Kind::Hex20 => &HEX[..12],
        Kind::Hex27 => &HEX,
        _ => &[],
    }
}

const PRISM: [&[usize]; 12] = [
    &[0, 1],
    &[1, 2],
    &[2, 0],
    &[3, 4],
    &[4, 5],
    &[5, 3],
    &[0, 3],
    &[1, 4],
    &[2, 5],
    &[0, 1, 4, 3],
    &[1, 2, 5, 4],
    &[2, 0, 3, 5],
];

const HEX: [&[usize]; 19] = [
    &[0, 1],
    &[1, 2],
    &[2, 3],
    &[3, 0],
    &[4, 5],
    &[5, 6],
    &[6, 7],
    &[7, 4],
    &[0, 4],
    &[1, 5],
    &[2, 6],
    &[3, 7],
    &[0, 4, 7, 3],
    &[1, 2, 6, 5],
    &[0, 1, 5, 4],
    &[3, 7, 6, 2],
    &[0, 1, 2, 3],
    &[4, 5, 6, 7],
    &[0, 1, 2, 3, 4, 5, 6, 7],
];

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The volume, area or length of an element; every part of a volume has to be positive.
fn measure(kind: Kind, nodes: &[Point]) -> f64 {
    let edge = |from: usize, to: usize| minus(nodes[to], nodes[from]);
    match kind.dim() {
        3 => {
            let volume = |[a, b, c, d]: [usize; 4]| {
                let volume = dot(cross(edge(a, b), edge(a, c)), edge(a, d)) / 6.0;
                assert!(volume > 0.0, "{}: {a} {b} {c} {d} turn the wrong way", kind.name());
                volume
            };
            tetrahedra(kind).iter().copied().map(volume).sum()
        }
        2 => {
            let normal = |&[a, b, c]: &[usize; 3]| cross(edge(a, b), edge(a, c));
            triangles(kind).iter().map(|t| dot(normal(t), normal(t)).sqrt() / 2.0).sum()
        }
        1 => dot(edge(0, 1), edge(0, 1)).sqrt(),
        _ => 1.0,
    }
}

fn nodes_of<'m>(mesh: &'m FileMesh, block: &'m Block) -> impl Iterator<Item = Vec<Point>> + 'm {
    let point = |node: &u32| mesh.points[*node as usize];
    block.nodes.chunks(block.kind.nodes()).map(move |cell| cell.iter().map(point).collect())
}

/// The sum of the measures of all elements of a dimension.
pub fn total(mesh: &FileMesh, dim: usize) -> f64 {
    let blocks = mesh.blocks.iter().filter(|block| block.kind.dim() == dim);
    blocks.flat_map(|b| nodes_of(mesh, b).map(|nodes| measure(b.kind, &nodes))).sum()
}

/// Asserts that middle nodes lie in the middle of what VTK says they do.
pub fn assert_middles(mesh: &FileMesh) {
    for block in &mesh.blocks {
        let (kind, middles) = (block.kind, middles(block.kind));
        for nodes in nodes_of(mesh, block) {
            let first = kind.nodes() - middles.len();
            for (node, corners) in (first..).zip(middles) {
                let mean = |axis: usize| {
                    corners.iter().map(|corner| nodes[*corner][axis]).sum::<f64>()
                        / corners.len() as f64
                };
                let apart = minus(nodes[node], [mean(0), mean(1), mean(2)]);
                assert!(dot(apart, apart) < 1e-24, "{}: node {node} by {apart:?}", kind.name());
            }
        }
    }
}
