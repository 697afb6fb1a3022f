//! What must hold for every mesh that was cut, and a look at it that knows no numbers.

use std::collections::{BTreeMap, BTreeSet};

use super::blocks::{dot, minus};
use crate::element::{Shape, map_point, mapping, stiffness_rule};
use crate::mesh::whole::{WholeFacet, WholeMesh};

/// A place, so that equal ones are found.
pub fn key(point: [f64; 3]) -> [i64; 3] {
    point.map(|x| (x * 1024.0).round() as i64)
}

pub fn centre(points: impl Iterator<Item = [f64; 3]>) -> [f64; 3] {
    let all: Vec<_> = points.collect();
    [0, 1, 2].map(|i| all.iter().map(|p| p[i]).sum::<f64>() / all.len() as f64)
}

pub fn cell_centre(mesh: &WholeMesh, cell: usize) -> [f64; 3] {
    centre(mesh.cell_nodes(cell).iter().map(|node| mesh.points[*node as usize]))
}

pub fn facet_centre(mesh: &WholeMesh, facet: WholeFacet) -> [f64; 3] {
    let corners = mesh.facet_shape(facet).corners().nodes();
    centre(mesh.facet_nodes(facet).take(corners).map(|node| mesh.points[node as usize]))
}

/// Area and outward normal of a plane facet.
pub fn area(mesh: &WholeMesh, facet: WholeFacet) -> (f64, [f64; 3]) {
    let p: Vec<[f64; 3]> = mesh.facet_nodes(facet).map(|n| mesh.points[n as usize]).collect();
    let sum = match mesh.facet_shape(facet).corners() {
        Shape::Line2 => super::blocks::cross(minus(p[1], p[0]), [0.0, 0.0, 1.0]),
        Shape::Tri3 => super::blocks::cross(minus(p[1], p[0]), minus(p[2], p[0])).map(|x| x / 2.0),
        _ => super::blocks::cross(minus(p[2], p[0]), minus(p[3], p[1])).map(|x| x / 2.0),
    };
    let area = dot(sum, sum).sqrt();
    (area, sum.map(|x| x / area))
}

pub fn volume(mesh: &WholeMesh) -> f64 {
    let of = |cell: usize| {
        let shape = mesh.shapes[cell];
        let nodes = mesh.cell_nodes(cell).iter().map(|node| mesh.points[*node as usize]);
        let points: Vec<[f64; 3]> = nodes.collect();
        let plane: Vec<[f64; 2]> = points.iter().map(|p| [p[0], p[1]]).collect();
        let at = |xi| match mesh.dim() {
            2 => mapping(shape, &plane, xi).determinant,
            _ => mapping(shape, &points, xi).determinant,
        };
        stiffness_rule(shape).iter().map(|p| p.weight * at(p.xi)).sum::<f64>()
    };
    (0..mesh.cells()).map(of).sum()
}

/// Checks that lips face each other, normals point from the lower to the upper one, tips are shut,
/// and every place has a copy for each sector, as seen from positions alone; `is_open` tells where
/// interfaces are.
pub fn check(mesh: &WholeMesh, areas: &[f64], is_open: impl Fn([f64; 3]) -> bool) {
    assert_eq!(mesh.interfaces.len(), areas.len());
    for (interface, expected) in mesh.interfaces.iter().zip(areas) {
        let [lower, upper] = &interface.lips;
        assert_eq!((lower.len(), upper.len()), (interface.faces.len(), interface.faces.len()));
        let mut sums = [0.0; 2];
        for ((one, other), facing) in lower.iter().zip(upper).zip(&interface.faces) {
            let rows = [one, other].map(|facet| mesh.facet_nodes(*facet).collect::<Vec<u32>>());
            for (node, to) in rows[0].iter().zip(facing.order) {
                let facing = rows[1][to as usize];
                assert_eq!(mesh.points[*node as usize], mesh.points[facing as usize]);
                if *node == facing {
                    assert!(interface.tips.binary_search(node).is_ok());
                }
            }
            let [low, high] = [one, other].map(|facet| area(mesh, *facet));
            let [from, to] = [one, other].map(|facet| cell_centre(mesh, facet.cell as usize));
            assert!(dot(low.1, minus(to, from)) > 0.0, "the normal points to the upper cell");
            (sums[0], sums[1]) = (sums[0] + low.0, sums[1] + high.0);
        }
        assert!(sums.iter().all(|sum| (sum - expected).abs() < 1e-12), "{sums:?} {expected}");
        check_normals(mesh, interface);
        check_partners(mesh, interface);
    }
    for (place, [nodes, sectors]) in sectors(mesh, is_open) {
        assert_eq!(nodes, sectors, "copies and sectors at {place:?}/1024");
    }
}

fn check_normals(mesh: &WholeMesh, interface: &crate::mesh::whole::WholeInterface) {
    let facets = interface.lips.iter().flatten();
    let mut nodes: Vec<u32> = facets.flat_map(|facet| mesh.facet_nodes(*facet)).collect();
    nodes.sort_unstable();
    nodes.dedup();
    assert_eq!(nodes, interface.normals.iter().map(|(node, _)| *node).collect::<Vec<_>>());
    let mut at = BTreeMap::new();
    for (node, normal) in &interface.normals {
        assert!((dot(*normal, *normal) - 1.0).abs() < 1e-12);
        let known = at.entry(key(mesh.points[*node as usize])).or_insert(*normal);
        assert_eq!(known, normal, "one normal for all copies");
    }
}

/// Checks that each node of a lip that is neither tip nor junction has one partner, on the other
/// lip, and lies on no other interface.
fn check_partners(mesh: &WholeMesh, interface: &crate::mesh::whole::WholeInterface) {
    let mut partners: BTreeMap<u32, Vec<(usize, u32)>> = BTreeMap::new();
    let [lower, upper] = &interface.lips;
    for ((one, other), facing) in lower.iter().zip(upper).zip(&interface.faces) {
        let upper: Vec<u32> = mesh.facet_nodes(*other).collect();
        for (node, to) in mesh.facet_nodes(*one).zip(facing.order) {
            partners.entry(node).or_default().push((0, upper[to as usize]));
            partners.entry(upper[to as usize]).or_default().push((1, node));
        }
    }
    let others = mesh.interfaces.iter().filter(|other| !std::ptr::eq(*other, interface));
    let elsewhere: BTreeSet<u32> =
        others.flat_map(|other| other.normals.iter().map(|(node, _)| *node)).collect();
    for (node, found) in partners {
        let is_told = [&interface.tips, &interface.junctions]
            .iter()
            .any(|list| list.binary_search(&node).is_ok());
        if !is_told {
            assert!(found.iter().all(|partner| *partner == found[0]), "{found:?}");
            assert!(found[0].1 != node && !elsewhere.contains(&node));
        }
    }
}

/// For each place the number of nodes there and the number of sectors of cells around it.
fn sectors(mesh: &WholeMesh, is_open: impl Fn([f64; 3]) -> bool) -> BTreeMap<[i64; 3], [usize; 2]> {
    let mut around: BTreeMap<[i64; 3], Vec<(usize, u32)>> = BTreeMap::new();
    for cell in 0..mesh.cells() {
        for node in mesh.cell_nodes(cell) {
            around.entry(key(mesh.points[*node as usize])).or_default().push((cell, *node));
        }
    }
    let facets = |cell: usize| {
        let count = mesh.shapes[cell].facets().len() as u8;
        (0..count).map(move |facet| WholeFacet { cell: cell as u32, facet })
    };
    let of_place = |(place, list): ([i64; 3], Vec<(usize, u32)>)| {
        let mut class: Vec<usize> = (0..list.len()).collect();
        let mut owner = BTreeMap::new();
        for (index, (cell, _)) in list.iter().enumerate() {
            for facet in facets(*cell) {
                let middle = facet_centre(mesh, facet);
                let has = mesh.facet_nodes(facet).any(|n| key(mesh.points[n as usize]) == place);
                if !has || is_open(middle) {
                    continue;
                }
                let other = *owner.entry(key(middle)).or_insert(index);
                let (from, to) = (class[index], class[other]);
                class.iter_mut().filter(|c| **c == from).for_each(|c| *c = to);
            }
        }
        let distinct = |mut list: Vec<usize>| {
            list.sort_unstable();
            list.dedup();
            list.len()
        };
        let nodes = list.iter().map(|(_, node)| *node as usize).collect();
        (place, [distinct(nodes), distinct(class)])
    };
    around.into_iter().map(of_place).collect()
}

/// The places of nodes, rising, each as often as there are nodes.
pub fn places(mesh: &WholeMesh, nodes: &[u32]) -> Vec<[i64; 3]> {
    let mut found: Vec<_> = nodes.iter().map(|node| key(mesh.points[*node as usize])).collect();
    found.sort_unstable();
    found
}

/// All that does not depend on the order of nodes and cells in the file.
pub fn look(mesh: &WholeMesh) -> Vec<String> {
    let mut found = vec![format!("{} {} {}", mesh.points.len(), mesh.cells(), mesh.body_count)];
    for interface in &mesh.interfaces {
        let [lower, upper] = &interface.lips;
        let pair = |(one, other): (&WholeFacet, &WholeFacet)| {
            let cells = [one, other].map(|f| key(cell_centre(mesh, f.cell as usize)));
            format!("pair {cells:?} {:?}", key(facet_centre(mesh, *one)))
        };
        let mut pairs: Vec<String> = lower.iter().zip(upper).map(pair).collect();
        pairs.sort();
        found.append(&mut pairs);
        found.push(format!("tips {:?}", places(mesh, &interface.tips)));
        found.push(format!("junctions {:?}", places(mesh, &interface.junctions)));
        let normal = |(node, normal): &(u32, [f64; 3])| {
            format!("normal {:?} {:?}", key(mesh.points[*node as usize]), key(*normal))
        };
        let mut normals: Vec<String> = interface.normals.iter().map(normal).collect();
        normals.sort();
        found.append(&mut normals);
    }
    for surface in &mesh.surfaces {
        found.push(format!("surface {} {:?}", surface.facets.len(), places(mesh, &surface.nodes)));
    }
    found
}

#[test]
fn a_point_is_mapped_where_the_volume_says() {
    let mesh = super::blocks::made(
        &super::blocks::block(crate::mesh::import::Kind::Hex8, [2, 1, 1]),
        &super::blocks::request(),
    );
    assert!((volume(&mesh) - 2.0).abs() < 1e-14);
    let nodes = mesh.cell_nodes(1).iter().map(|node| mesh.points[*node as usize]);
    let points: Vec<[f64; 3]> = nodes.collect();
    assert_eq!(map_point(Shape::Hex8, &points, [0.0; 3]), cell_centre(&mesh, 1));
}
