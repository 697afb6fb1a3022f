//! Refined meshes.

use super::blocks::{
    PLANES, VOLUMES, X, Y, add, block, group, group_cells, group_facets, made, refused, request,
    request_between, request_on, set, two,
};
use super::looks::{area, check, key, look, places, volume};
use super::raising::lowered;
use crate::element::{MAX_NODES, Shape, map_point};
use crate::mesh::import::{FileMesh, Kind};
use crate::mesh::whole::{MaterialGroups, Request, WholeMesh, build};

fn refined(times: u32, request: Request) -> Request {
    Request { refine: times, ..request }
}

/// A block of 4 x 4 x 2 in cells of this size, with a crossing, one of whose arms ends inside, and
/// surfaces of every dimension.
pub fn scene(kind: Kind, size: usize) -> FileMesh {
    let mut file = block(kind, [4 / size, 4 / size, 2 / size]);
    file.points.iter_mut().flatten().for_each(|x| *x *= size as f64);
    group_facets(&mut file, "a", X, |p| p[0] == 2.0);
    group_facets(&mut file, "b", Y, |p| p[1] == 2.0 && p[0] > 2.0);
    group_facets(&mut file, "side", X, |p| p[0] == 0.0);
    group_cells(&mut file, "left", |p| p[0] < 2.0);
    group_cells(&mut file, "right", |p| p[0] > 2.0);
    let at = |p: [f64; 3]| file.points.iter().position(|q| *q == p).map(|node| node as u32);
    let line: Vec<u32> = (0..=4 / size).filter_map(|i| at([4.0, (i * size) as f64, 0.0])).collect();
    let corner = at([4.0, 4.0, 0.0]).expect("a corner");
    if kind.dim() == 3 {
        let edge = group(&mut file, "edge", 1);
        line.windows(2).for_each(|ends| add(&mut file, Kind::Line2, ends.to_vec(), Some(edge)));
    }
    let point = group(&mut file, "point", 0);
    add(&mut file, Kind::Point1, vec![corner], Some(point));
    let nodes = group(&mut file, "nodes", 0);
    file.node_groups.push((nodes, vec![0, corner]));
    file
}

pub fn asked(kind: Kind, order: u32) -> Request {
    let material = |name: &str| MaterialGroups { name: name.into(), groups: vec![name.to_owned()] };
    let names = ["a", "b", "side", "edge", "point", "nodes", "all"];
    let surfaces = names.iter().filter(|name| kind.dim() == 3 || **name != "edge");
    Request {
        raise_order: Some(order),
        materials: vec![material("left"), material("right")],
        surfaces: surfaces.map(|name| (*name).into()).collect(),
        ..request_on(&["a", "b"])
    }
}

fn depth(kind: Kind) -> f64 {
    if kind.dim() == 2 { 1.0 } else { 2.0 }
}

/// Volume of each material.
fn shares(mesh: &WholeMesh) -> [f64; 2] {
    [0, 1].map(|material| {
        let mut part = mesh.clone();
        let cells: Vec<usize> =
            (0..mesh.cells()).filter(|cell| mesh.materials[*cell] == material).collect();
        part.shapes = cells.iter().map(|cell| mesh.shapes[*cell]).collect();
        part.nodes = cells.iter().flat_map(|cell| mesh.cell_nodes(*cell).to_vec()).collect();
        part.start = vec![0];
        for shape in &part.shapes {
            part.start.push(part.start[part.start.len() - 1] + shape.nodes() as u32);
        }
        volume(&part)
    })
}

#[test]
fn a_coarse_block_refined_is_the_fine_block() {
    for kind in [Kind::Hex8, Kind::Prism6, Kind::Quad4, Kind::Tri3] {
        for order in [1, 2] {
            let fine = made(&scene(kind, 1), &asked(kind, order));
            let mesh = made(&scene(kind, 2), &refined(1, asked(kind, order)));
            assert_eq!(look(&mesh), look(&fine), "{kind:?} of order {order}");
            assert!(shares(&mesh).iter().all(|part| (part - 8.0 * depth(kind)).abs() < 1e-12));
            let from = fine.cells() >> kind.dim();
            let remark = format!("{from} cells refined once to {}", fine.cells());
            assert!(mesh.remarks.contains(&remark), "{:?}", mesh.remarks);
            let of_nodes: Vec<&String> =
                mesh.remarks.iter().filter(|remark| remark.contains("of nodes keeps")).collect();
            assert!(of_nodes.len() == 1 && of_nodes[0].starts_with("surface `nodes`"));
        }
        let mut wide = scene(kind, 2);
        wide.points.iter_mut().flatten().for_each(|x| *x *= 2.0);
        let mut asked = asked(kind, 1);
        asked.scale = 0.5;
        let finest = made(&wide, &refined(2, asked));
        let depth = depth(kind);
        check(&finest, &[4.0 * depth, 2.0 * depth], |p| p[0] == 2.0 || (p[1] == 2.0 && p[0] > 2.0));
    }
}

#[test]
fn tetrahedra_keep_their_interfaces_tips_and_branches() {
    let kind = Kind::Tet4;
    for order in [1, 2] {
        let mesh = made(&scene(kind, 1), &refined(1, asked(kind, order)));
        check(&mesh, &[8.0, 4.0], |p| p[0] == 2.0 || (p[1] == 2.0 && p[0] > 2.0));
        assert_eq!((mesh.cells(), mesh.body_count), (32 * 6 * 8, 3));
        assert!(shares(&mesh).iter().all(|part| (part - 16.0).abs() < 1e-12));
        let along = |name: usize| mesh.surfaces[name].nodes.len();
        let (line, per_cell) = (4 * 2 * order as usize + 1, 2 * order as usize);
        assert_eq!(along(2), line * (2 * per_cell + 1));
        // The edge and the nodes of the file, of which those on an interface have copies.
        assert_eq!((along(3), along(4), along(5)), (line + 1, 1, 2));
    }
    // A crack inside, of which only one node opened before.
    let mut file = block(kind, [4, 4, 4]);
    let inside =
        |p: [f64; 3]| p[0] == 2.0 && (1.0..3.0).contains(&p[1]) && (1.0..3.0).contains(&p[2]);
    group_facets(&mut file, "a", X, inside);
    let mesh = made(&file, &refined(1, request_on(&["a"])));
    check(&mesh, &[4.0], inside);
    assert_eq!((mesh.interfaces[0].tips.len(), mesh.points.len()), (16, 9 * 9 * 9 + 9));
    // One that cut nothing before.
    let mut file = block(Kind::Hex8, [2, 3, 3]);
    let small = |p: [f64; 3]| p[0] == 1.0 && [p[1], p[2]].iter().all(|x| (1.0..2.0).contains(x));
    group_facets(&mut file, "a", X, small);
    let text = refused(build(&file, &request_on(&["a"]), "block.msh"));
    assert!(text.contains("cuts nothing"), "{text}");
    check(&made(&file, &refined(1, request_on(&["a"]))), &[1.0], small);
}

#[test]
fn sides_between_two_bodies_follow() {
    for kind in [&VOLUMES[..], &PLANES[..]].concat() {
        let mut one = block(kind, [2, 2, 1]);
        group_facets(&mut one, "lower", X, |p| p[0] == 2.0);
        let mut other = block(kind, [1, 2, 1]);
        group_facets(&mut other, "upper", [-1.0, 0.0, 0.0], |p| p[0] == 0.0);
        let file = two(&one, &other, [2.0, 0.0, 0.0]);
        let mesh = made(&file, &refined(1, request_between("lower", "upper")));
        assert_eq!(mesh.body_count, 2);
        for (lip, way) in mesh.interfaces[0].lips.iter().zip([1.0, -1.0]) {
            let parts = lip.iter().map(|facet| area(&mesh, *facet));
            let sum: f64 = parts.clone().map(|(area, _)| area).sum();
            assert!((sum - 2.0).abs() < 1e-14 && parts.clone().all(|(_, n)| n[0] == way));
        }
    }
}

/// Cells of all kinds: a hexahedron, a prism beside it, and on top pyramids and tetrahedra.
fn mixed() -> FileMesh {
    let mut file = block(Kind::Hex8, [1, 1, 1]);
    let mut point = |p: [f64; 3]| {
        file.points.push(p);
        file.node_numbers.push(file.points.len() as u64);
        file.points.len() as u32 - 1
    };
    let [a, b] = [point([1.6, 0.1, 0.0]), point([1.6, 0.1, 1.0])];
    let apex = point([0.4, 0.55, 1.7]);
    let beside = point([1.2, 0.3, 1.9]);
    add(&mut file, Kind::Prism6, vec![1, a, 3, 5, b, 7], None);
    add(&mut file, Kind::Pyramid5, vec![4, 5, 7, 6, apex], None);
    add(&mut file, Kind::Tet4, vec![5, 7, apex, beside], None);
    add(&mut file, Kind::Tet4, vec![5, b, 7, beside], None);
    file
}

#[test]
fn pyramids_become_pyramids_and_tetrahedra() {
    let coarse = made(&mixed(), &request());
    // A base that is not plane.
    let mut bent = mixed();
    bent.points[5][2] += 0.15;
    for (file, volume_of) in
        [(mixed(), volume(&coarse)), (bent.clone(), volume(&made(&bent, &request())))]
    {
        for times in [1, 2, 3] {
            let mesh = made(&file, &refined(times, request()));
            assert!((volume(&mesh) / volume_of - 1.0).abs() < 1e-12);
            let number = |shape| mesh.shapes.iter().filter(|other| **other == shape).count();
            let pyramids = 6_usize.pow(times);
            let tetrahedra = (0..times).fold(2, |t, time| 8 * t + 4 * 6_usize.pow(time));
            assert_eq!((number(Shape::Pyramid5), number(Shape::Tet4)), (pyramids, tetrahedra));
            assert_eq!(number(Shape::Hex8), 8_usize.pow(times));
            assert_eq!(mesh.body_count, 1);
        }
    }
}

/// Cells of second order that are bent as far as they hold exactly.
fn bent(kind: Kind) -> FileMesh {
    let second = match kind {
        Kind::Quad4 => Kind::Quad9,
        Kind::Tri3 => Kind::Tri6,
        Kind::Tet4 => Kind::Tet10,
        Kind::Prism6 => Kind::Prism18,
        _ => Kind::Hex27,
    };
    let full = made(&block(kind, [2, 2, 1]), &Request { raise_order: Some(2), ..request() });
    let is_flat = kind.dim() == 2;
    lowered(&full, second, |p| bend(p, is_flat))
}

fn bend([x, y, z]: [f64; 3], is_flat: bool) -> [f64; 3] {
    if is_flat {
        [x + 0.1 * y * y - 0.05 * x * y, y + 0.05 * x * x, 0.0]
    } else {
        [x + 0.1 * y * y, y + 0.05 * x * z, z + 0.1 * x * y - 0.05 * z * z]
    }
}

#[test]
fn curved_cells_stay_the_same_curve() {
    for kind in [&VOLUMES[..], &PLANES[..]].concat() {
        let coarse = made(&bent(kind), &request());
        let mesh = made(&bent(kind), &refined(2, request()));
        assert_eq!(mesh.cells(), coarse.cells() << (2 * kind.dim()));
        assert!((volume(&mesh) / volume(&coarse) - 1.0).abs() < 1e-12, "{kind:?}");
        // The straight mesh, refined in the same way, bent afterwards.
        let straight = Request { raise_order: Some(2), ..request() };
        let straight = made(&block(kind, [2, 2, 1]), &refined(2, straight));
        let is_flat = kind.dim() == 2;
        assert_eq!(mesh.points.len(), straight.points.len());
        let mut found: Vec<_> = mesh.points.iter().map(|p| key(*p)).collect();
        let mut exact: Vec<_> = straight.points.iter().map(|p| key(bend(*p, is_flat))).collect();
        found.sort_unstable();
        exact.sort_unstable();
        let apart =
            found.iter().zip(&exact).map(|(p, q)| (0..3).map(|i| (p[i] - q[i]).abs()).max());
        assert!(apart.flatten().all(|apart| apart <= 1), "{kind:?}");
    }
}

/// A quarter of a disk of radius 1: triangles of six nodes with the middles of their sides on it.
fn disk(sectors: usize) -> FileMesh {
    let mut file = FileMesh { group_sets: vec![vec![]], ..FileMesh::default() };
    let at = |turn: f64, radius: f64| {
        let angle = turn * std::f64::consts::FRAC_PI_2 / sectors as f64;
        [radius * angle.cos(), radius * angle.sin(), 0.0]
    };
    file.points.push([0.0; 3]);
    let rim = group(&mut file, "rim", 1);
    for i in 0..=2 * sectors {
        file.points.push(at(i as f64 / 2.0, 1.0));
        file.points.push(at(i as f64 / 2.0, 0.5));
    }
    for i in 0..sectors as u32 {
        let on = |half: u32| 1 + 2 * (2 * i + half);
        add(&mut file, Kind::Tri6, vec![0, on(0), on(2), on(0) + 1, on(1), on(2) + 1], None);
        add(&mut file, Kind::Line3, vec![on(0), on(2), on(1)], Some(rim));
    }
    file.node_numbers = (1..=file.points.len() as u64).collect();
    file
}

#[test]
fn a_circle_keeps_the_radius_that_its_parabolas_have() {
    for sectors in [2, 4] {
        let asked = Request { surfaces: vec!["rim".into()], ..request() };
        let coarse = made(&disk(sectors), &asked);
        let first: Vec<[f64; 3]> = coarse
            .facet_nodes(coarse.surfaces[0].facets[0])
            .map(|n| coarse.points[n as usize])
            .collect();
        let radius = |s: f64| {
            let [x, y, _] = map_point(Shape::Line3, &first, [s, 0.0, 0.0]);
            x.hypot(y)
        };
        let mesh = made(&disk(sectors), &refined(2, asked));
        assert_eq!(mesh.surfaces[0].facets.len(), 4 * sectors);
        assert_eq!(mesh.surfaces[0].nodes.len(), 8 * sectors + 1);
        let mut found: Vec<f64> = mesh.surfaces[0]
            .nodes
            .iter()
            .map(|node| mesh.points[*node as usize])
            .map(|[x, y, _]| x.hypot(y))
            .collect();
        let steps = [-1.0, -0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75];
        let mut exact: Vec<f64> = (0..sectors).flat_map(|_| steps.map(radius)).collect();
        exact.push(1.0);
        found.sort_by(f64::total_cmp);
        exact.sort_by(f64::total_cmp);
        for (found, exact) in found.iter().zip(&exact) {
            assert!((found - exact).abs() < 1e-14, "{found} {exact}");
        }
        // The parabola leaves the circle by about angle^4 / 512 at a quarter of it.
        let angle = std::f64::consts::FRAC_PI_2 / sectors as f64;
        let most = exact.iter().map(|r| (r - 1.0).abs()).fold(0.0, f64::max);
        assert!(most < angle.powi(4) / 400.0 && most > angle.powi(4) / 700.0, "{most} {angle}");
    }
}

#[test]
fn too_many_cells_are_refused_before_memory_is_asked_for() {
    let file = block(Kind::Hex8, [2, 2, 1]);
    let text = refused(build(&file, &refined(20, request()), "big.msh"));
    for words in ["big.msh: refined 20 times, 4 cells", "2147483647", "`mesh.refine: 8`"] {
        assert!(text.contains(words), "{text}");
    }
    let text = refused(build(&mixed(), &refined(11, request()), "big.msh"));
    assert!(text.contains("5 cells would become more than"), "{text}");
}

#[test]
fn what_is_wrong_is_told_of_the_elements_of_the_file() {
    let mut file = block(Kind::Hex8, [2, 1, 1]);
    let nodes = &mut file.blocks[0].nodes;
    nodes.swap(0, 4);
    let plain = refused(build(&file, &request(), "wrong.msh"));
    assert_eq!(refused(build(&file, &refined(2, request()), "wrong.msh")), plain);
    // An element of two groups is one cell with both.
    let mut file = block(Kind::Hex8, [1, 1, 1]);
    let [a, b] = ["a", "b"].map(|name| group(&mut file, name, 3));
    file.blocks[0].groups[0] = set(&mut file, vec![a]);
    let copy = file.blocks[0].nodes.clone();
    add(&mut file, Kind::Hex8, copy, Some(b));
    for name in ["a", "b"] {
        let groups = vec![name.to_owned()];
        let materials = vec![MaterialGroups { name: "rock".into(), groups }];
        let mesh = made(&file, &refined(1, Request { materials, ..request() }));
        assert_eq!(mesh.cells(), 8);
    }
}

#[test]
fn positions_are_mapped_as_the_cells_say() {
    // Corners of the children of a hexahedron that is no box lie where its map has them.
    let mut file = block(Kind::Hex8, [1, 1, 1]);
    file.points[7] = [1.3, 1.2, 1.4];
    let mesh = made(&file, &refined(1, request()));
    let mut corners = [[0.0; 3]; MAX_NODES];
    let order = &file.blocks[0].nodes;
    corners.iter_mut().zip(order).for_each(|(p, node)| *p = file.points[*node as usize]);
    let all: Vec<u32> = (0..mesh.points.len() as u32).collect();
    let mut exact: Vec<_> = Shape::Hex27
        .node_points()
        .iter()
        .map(|xi| key(map_point(Shape::Hex8, &corners[..8], *xi)))
        .collect();
    exact.sort_unstable();
    assert_eq!(places(&mesh, &all), exact);
}
