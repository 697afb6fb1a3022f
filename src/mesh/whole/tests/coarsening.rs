//! Coarser meshes that are found in one of a file.

use super::blocks::{
    X, add, block, group, group_cells, group_facets, made, request, request_between, request_on,
    two,
};
use super::looks::{check, look, volume};
use super::refining::{asked, scene};
use crate::element::Shape;
use crate::mesh::import::{FileMesh, Kind};
use crate::mesh::whole::{Keep, MaterialGroups, Request, WholeMesh, nested};

/// The meshes of a file, coarsest first.
fn meshes(file: &FileMesh, request: &Request) -> Vec<WholeMesh> {
    nested(file, request, "block.msh", Keep::All).unwrap_or_else(|error| panic!("{error}"))
}

/// The numbers of cells, coarsest first.
fn counts(file: &FileMesh, request: &Request) -> Vec<usize> {
    meshes(file, request).iter().map(WholeMesh::cells).collect()
}

/// The same mesh with nodes in another order, and cells that begin at other corners.
fn scrambled(file: &FileMesh) -> FileMesh {
    let mut file = file.clone();
    let count = file.points.len();
    let step = (count / 2..).find(|step| gcd(*step, count) == 1).expect("some number");
    let new = |node: u32| ((node as usize * step + 3) % count) as u32;
    let points = file.points.clone();
    for (old, point) in points.iter().enumerate() {
        file.points[new(old as u32) as usize] = *point;
    }
    for block in &mut file.blocks {
        block.nodes.iter_mut().for_each(|node| *node = new(*node));
        for (index, cell) in block.nodes.chunks_mut(block.kind.nodes()).enumerate() {
            let before = cell.to_vec();
            // About the third axis, and about the first diagonal.
            let turns: &[&[usize]] = match block.kind {
                Kind::Quad4 if file.points.iter().all(|p| p[2] == 0.0) => &[&[1, 2, 3, 0]],
                Kind::Hex8 => &[&[1, 2, 3, 0, 5, 6, 7, 4], &[0, 3, 7, 4, 1, 2, 6, 5]],
                _ => &[],
            };
            let Some(turn) = turns.get(index % 3) else { continue };
            cell.iter_mut().zip(*turn).for_each(|(node, from)| *node = before[*from]);
        }
    }
    for (_, nodes) in &mut file.node_groups {
        nodes.iter_mut().for_each(|node| *node = new(*node));
        nodes.sort_unstable();
    }
    file
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[test]
fn the_coarser_mesh_of_a_fine_block_is_the_coarse_block() {
    for kind in [Kind::Hex8, Kind::Quad4] {
        let coarse = look(&made(&scene(kind, 2), &asked(kind, 1)));
        for file in [scene(kind, 1), scrambled(&scene(kind, 1))] {
            let all = meshes(&file, &asked(kind, 1));
            assert_eq!(all.len(), 2, "{kind:?}");
            assert_eq!(look(&all[0]), coarse, "{kind:?}");
            assert_eq!(look(&all[1]), look(&made(&scene(kind, 1), &asked(kind, 1))));
            // Cells of second order have their corners as a level between.
            let all = meshes(&file, &asked(kind, 2));
            assert_eq!(all.len(), 3, "{kind:?}");
            assert_eq!(look(&all[0]), coarse, "{kind:?}");
            assert_eq!(look(&all[1]), look(&made(&scene(kind, 1), &asked(kind, 1))));
            assert_eq!(all[1].cells(), all[2].cells());
        }
    }
}

#[test]
fn odd_layers_stay_and_walls_stand() {
    let file = block(Kind::Hex8, [5, 3, 3]);
    assert_eq!(counts(&file, &request()), [1, 2, 12, 45]);
    // The interface ends a layer in the middle.
    for at in [1.0, 2.0, 3.0, 4.0] {
        let mut file = file.clone();
        group_facets(&mut file, "a", X, |p| p[0] == at);
        for file in [file.clone(), scrambled(&file)] {
            let all = meshes(&file, &request_on(&["a"]));
            let along: usize = [at, 5.0 - at].iter().map(|n| (n / 2.0_f64).ceil() as usize).sum();
            assert_eq!(all[all.len() - 2].cells(), along * 4, "at {at}");
            for mesh in &all {
                assert!((volume(mesh) - 45.0).abs() < 1e-12);
                check(mesh, &[9.0], |p| p[0] == at);
            }
        }
    }
    let mut file = block(Kind::Quad4, [6, 4, 0]);
    group_cells(&mut file, "left", |p| p[0] < 3.0);
    group_cells(&mut file, "right", |p| p[0] > 3.0);
    let material = |name: &str| MaterialGroups { name: name.into(), groups: vec![name.to_owned()] };
    let request = Request { materials: vec![material("left"), material("right")], ..request() };
    assert_eq!(counts(&file, &request), [2, 8, 24]);
}

#[test]
fn bodies_are_joined_for_themselves() {
    let mut one = block(Kind::Hex8, [4, 4, 4]);
    group_facets(&mut one, "lower", X, |p| p[0] == 4.0);
    let mut other = block(Kind::Hex8, [5, 4, 2]);
    group_facets(&mut other, "upper", [-1.0, 0.0, 0.0], |p| p[0] == 0.0);
    let file = two(&one, &other, [4.0, 0.0, 0.0]);
    let counts = counts(&file, &request_between("lower", "upper"));
    assert_eq!(counts[counts.len() - 2..], [8 + 6, 64 + 40]);
}

/// Corners of coarser cells stay in a group of points, however many others it has.
#[test]
fn points_beside_the_corners_of_coarser_cells_go() {
    let mut file = block(Kind::Hex8, [4, 2, 2]);
    let pins = group(&mut file, "pins", 0);
    for node in 0..5 {
        add(&mut file, Kind::Point1, vec![node], Some(pins));
    }
    let request = Request { surfaces: vec!["pins".into()], ..request() };
    let all = meshes(&file, &request);
    let pins: Vec<usize> = all.iter().map(|mesh| mesh.surfaces[0].nodes.len()).collect();
    assert_eq!(pins, [2, 3, 5]);
}

#[test]
fn cells_that_no_halving_made_have_no_coarser_mesh() {
    for kind in [Kind::Tet4, Kind::Prism6, Kind::Tri3] {
        assert_eq!(counts(&block(kind, [4, 4, 2]), &request()).len(), 1);
    }
    // Three quadrilaterals around a node, each of them once, and as four and nine.
    let star = |n: usize| {
        let mut file = FileMesh { group_sets: vec![vec![]], ..FileMesh::default() };
        let ring = |k: usize| {
            let angle = std::f64::consts::PI * (k as f64) / 3.0;
            [angle.cos(), angle.sin(), 0.0]
        };
        for third in 0..3 {
            let corners = [[0.0; 3], ring(2 * third), ring(2 * third + 1), ring(2 * third + 2)];
            let at = |u: usize, v: usize| {
                let [u, v] = [u, v].map(|x| 2.0 * x as f64 / n as f64 - 1.0);
                let mut values = [0.0; 4];
                Shape::Quad4.values([u, v, 0.0], &mut values);
                [0, 1, 2].map(|i| corners.iter().zip(values).map(|(p, v)| p[i] * v).sum::<f64>())
            };
            let mut node = |u, v| {
                let point: [f64; 3] = at(u, v);
                let near = |p: &[f64; 3]| (0..3).all(|i| (p[i] - point[i]).abs() < 1e-9);
                file.points.iter().position(near).unwrap_or_else(|| {
                    file.points.push(point);
                    file.points.len() - 1
                }) as u32
            };
            let mut cells = Vec::new();
            for v in 0..n {
                for u in 0..n {
                    cells.push(vec![
                        node(u, v),
                        node(u + 1, v),
                        node(u + 1, v + 1),
                        node(u, v + 1),
                    ]);
                }
            }
            cells
                .into_iter()
                .for_each(|cell| super::blocks::add(&mut file, Kind::Quad4, cell, None));
        }
        file.node_numbers = (1..=file.points.len() as u64).collect();
        file
    };
    assert_eq!(counts(&star(1), &request()), [3]);
    assert_eq!(counts(&star(2), &request()), [3, 12]);
    assert_eq!(counts(&star(3), &request()), [3, 12, 27]);
    assert_eq!(counts(&star(4), &request()), [3, 12, 48]);
}

#[test]
fn layers_are_joined_until_cells_are_as_long_as_wide() {
    let mut file = block(Kind::Hex8, [4, 4, 4]);
    file.points.iter_mut().for_each(|p| p[0] *= 4.0);
    for file in [scrambled(&file), file.clone()] {
        assert_eq!(counts(&file, &request()), [2, 4, 16, 64]);
    }
    // Joined along their short edges only.
    file.points.iter_mut().for_each(|p| p[0] = 0.01 * (p[0] / 4.0).exp2());
    assert_eq!(counts(&file, &request()), [16, 32, 64]);
    // Thin layers at one end, thick ones at the other: joined, a quarter would be longer still.
    let at = [0.0, 0.02, 0.22, 2.22, 22.22];
    file.points.iter_mut().for_each(|p| p[0] = at[(p[0] / 0.01).log2().round() as usize]);
    assert_eq!(counts(&file, &request()), [64]);
}
