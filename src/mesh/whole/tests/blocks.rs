//! Blocks of unit cells as a file would hold them, with groups where a test wants them.

use std::collections::BTreeSet;

use crate::element::Shape;
use crate::error::Result;
use crate::mesh::import::{Block, FileMesh, Group, Kind};
use crate::mesh::whole::{
    InterfacePlace, InterfaceRequest, MaterialGroups, Request, WholeMesh, build,
};

pub const X: [f64; 3] = [1.0, 0.0, 0.0];
pub const Y: [f64; 3] = [0.0, 1.0, 0.0];
pub const VOLUMES: [Kind; 3] = [Kind::Hex8, Kind::Tet4, Kind::Prism6];
pub const PLANES: [Kind; 2] = [Kind::Quad4, Kind::Tri3];

/// Whether a facet with this middle is one.
pub type Is = fn([f64; 3]) -> bool;

/// The six tetrahedra of a unit cube, by its corners in the order of a hexahedron.
const TETS: [[usize; 4]; 6] =
    [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]];

/// A block of unit cells from the origin on, of `Quad4`, `Tri3`, `Hex8`, `Tet4` or `Prism6`.
pub fn block(kind: Kind, n: [usize; 3]) -> FileMesh {
    let n = if kind.dim() == 2 { [n[0], n[1], 0] } else { n };
    let node = |i: usize, j: usize, k: usize| (i + (n[0] + 1) * (j + (n[1] + 1) * k)) as u32;
    let mut file = FileMesh { group_sets: vec![vec![]], ..FileMesh::default() };
    for k in 0..=n[2] {
        for j in 0..=n[1] {
            for i in 0..=n[0] {
                file.points.push([i, j, k].map(|x| x as f64));
            }
        }
    }
    file.node_numbers = (0..file.points.len() as u64).map(|number| number + 1).collect();
    let rows: Vec<&[usize]> = match kind {
        Kind::Quad4 => vec![&[0, 1, 2, 3]],
        Kind::Tri3 => vec![&[0, 1, 2], &[0, 2, 3]],
        Kind::Hex8 => vec![&[0, 1, 2, 3, 4, 5, 6, 7]],
        Kind::Tet4 => TETS.iter().map(|row| &row[..]).collect(),
        Kind::Prism6 => vec![&[0, 1, 2, 4, 5, 6], &[0, 2, 3, 4, 6, 7]],
        _ => panic!("no block of {}", kind.name()),
    };
    for k in 0..n[2].max(1) {
        for j in 0..n[1] {
            for i in 0..n[0] {
                let square = |k| {
                    [node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k)]
                };
                let top = if n[2] > 0 { square(k + 1) } else { [0; 4] };
                let corners = [square(k), top].concat();
                for row in &rows {
                    add(&mut file, kind, row.iter().map(|a| corners[*a]).collect(), None);
                }
            }
        }
    }
    file
}

/// The group of this name and dimension, made if it is not there.
pub fn group(file: &mut FileMesh, name: &str, dim: usize) -> u32 {
    let group = Group { name: name.into(), dim };
    let place = file.groups.iter().position(|other| *other == group).unwrap_or_else(|| {
        file.groups.push(group);
        file.groups.len() - 1
    });
    place as u32
}

/// Adds one element, which gets the next number.
pub fn add(file: &mut FileMesh, kind: Kind, nodes: Vec<u32>, of: Option<u32>) {
    let set = of.map_or(0, |group| set(file, vec![group]));
    let number = file.blocks.iter().map(|block| block.numbers.len() as u64).sum::<u64>() + 1;
    if !file.blocks.iter().any(|block| block.kind == kind) {
        let (nodes, numbers, groups) = Default::default();
        file.blocks.push(Block { kind, nodes, numbers, groups });
    }
    let block = file.blocks.iter_mut().find(|block| block.kind == kind).expect("it is there now");
    block.nodes.extend(nodes);
    block.numbers.push(number);
    block.groups.push(set);
}

/// The number of a set of groups.
pub fn set(file: &mut FileMesh, groups: Vec<u32>) -> u32 {
    let place = file.group_sets.iter().position(|other| *other == groups);
    place.unwrap_or_else(|| {
        file.group_sets.push(groups);
        file.group_sets.len() - 1
    }) as u32
}

/// Puts the cells whose middle is such into a group.
pub fn group_cells(file: &mut FileMesh, name: &str, is: impl Fn([f64; 3]) -> bool) {
    let dim = file.blocks[0].kind.dim();
    let group = group(file, name, dim);
    for index in 0..file.blocks.len() {
        let count = file.blocks[index].kind.nodes();
        for cell in 0..file.blocks[index].numbers.len() {
            let nodes = &file.blocks[index].nodes[cell * count..][..count];
            if file.blocks[index].kind.dim() != dim || !is(middle(file, nodes)) {
                continue;
            }
            let mut groups = file.group_sets[file.blocks[index].groups[cell] as usize].clone();
            groups.push(group);
            file.blocks[index].groups[cell] = set(file, groups);
        }
    }
}

/// Adds elements on the facets of first-order cells whose middle is such, with normals along
/// `along`.
pub fn group_facets(
    file: &mut FileMesh,
    name: &str,
    along: [f64; 3],
    is: impl Fn([f64; 3]) -> bool,
) {
    let dim = file.blocks[0].kind.dim();
    let group = group(file, name, dim - 1);
    let mut known = BTreeSet::new();
    for block in file.blocks.clone().iter().filter(|block| block.kind.dim() == dim) {
        let shape = shape(block.kind);
        for cell in block.nodes.chunks(block.kind.nodes()) {
            for facet in shape.facets() {
                let mut nodes: Vec<u32> = facet.iter().map(|a| cell[*a]).collect();
                let mut key = nodes.clone();
                key.sort_unstable();
                if !is(middle(file, &nodes)) || !known.insert(key) {
                    continue;
                }
                if dot(normal(file, &nodes), along) < 0.0 {
                    nodes.reverse();
                }
                let kind = [Kind::Line2, Kind::Tri3, Kind::Quad4][nodes.len() - 2];
                add(file, kind, nodes, Some(group));
            }
        }
    }
}

fn shape(kind: Kind) -> Shape {
    match kind {
        Kind::Quad4 => Shape::Quad4,
        Kind::Tri3 => Shape::Tri3,
        Kind::Hex8 => Shape::Hex8,
        Kind::Tet4 => Shape::Tet4,
        Kind::Prism6 => Shape::Prism6,
        Kind::Pyramid5 => Shape::Pyramid5,
        _ => panic!("no block of {}", kind.name()),
    }
}

pub fn middle(file: &FileMesh, nodes: &[u32]) -> [f64; 3] {
    let sum = |i: usize| nodes.iter().map(|node| file.points[*node as usize][i]).sum::<f64>();
    [0, 1, 2].map(|i| sum(i) / nodes.len() as f64)
}

fn normal(file: &FileMesh, nodes: &[u32]) -> [f64; 3] {
    let edge = |b: usize| {
        let [p, q] = [nodes[0], nodes[b]].map(|node| file.points[node as usize]);
        minus(q, p)
    };
    if nodes.len() == 2 { cross(edge(1), [0.0, 0.0, 1.0]) } else { cross(edge(1), edge(2)) }
}

pub fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] - b[i])
}

pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Everything in one material, and nothing else.
pub fn request() -> Request {
    Request {
        scale: 1.0,
        raise_order: None,
        refine: 0,
        materials: vec![MaterialGroups { name: "rock".into(), groups: vec![] }],
        surfaces: vec![],
        interfaces: vec![],
        divided: vec![],
    }
}

/// The same with interfaces on groups of their names.
pub fn request_on(groups: &[&str]) -> Request {
    let on = |name: &&str| InterfaceRequest {
        name: (*name).into(),
        place: InterfacePlace::On { group: (*name).into(), flip: false },
    };
    Request { interfaces: groups.iter().map(on).collect(), ..request() }
}

/// The same with one interface between two groups.
pub fn request_between(lower: &str, upper: &str) -> Request {
    let place =
        InterfacePlace::Between { lower: lower.into(), upper: upper.into(), has_gap: false };
    let interfaces = vec![InterfaceRequest { name: "bed".into(), place }];
    Request { interfaces, ..request() }
}

pub fn made(file: &FileMesh, request: &Request) -> WholeMesh {
    build(file, request, "block.msh").unwrap_or_else(|error| panic!("{error}"))
}

/// The words of the error that must come.
pub fn refused(result: Result<WholeMesh>) -> String {
    let error = result.map(|_| ()).expect_err("this mesh is wrong");
    assert_eq!(error.exit_status(), 2, "{error}");
    error.to_string()
}

/// Two blocks of the same cells, the second one moved by `by`, sharing no node.
pub fn two(one: &FileMesh, other: &FileMesh, by: [f64; 3]) -> FileMesh {
    let mut file = one.clone();
    let shift = file.points.len() as u32;
    let moved = other.points.iter().map(|p| [0, 1, 2].map(|i| p[i] + by[i]));
    file.points.extend(moved);
    file.node_numbers = (1..=file.points.len() as u64).collect();
    for block in &other.blocks {
        for (cell, set_of) in block.nodes.chunks(block.kind.nodes()).zip(&block.groups) {
            let nodes = cell.iter().map(|node| node + shift).collect();
            let groups = &other.group_sets[*set_of as usize];
            let groups: Vec<_> = groups.iter().map(|g| other.groups[*g as usize].clone()).collect();
            let of = groups.first().map(|g| group(&mut file, &g.name, g.dim));
            add(&mut file, block.kind, nodes, of);
        }
    }
    file
}
