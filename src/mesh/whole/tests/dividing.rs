//! Facets with nodes inside.

use super::blocks::{block, group_cells, group_facets, made, request_on};
use super::looks::{look, volume};
use crate::element::Shape;
use crate::mesh::import::Kind;
use crate::mesh::whole::{MaterialGroups, Request, WholeFacet, WholeMesh, area};

/// Two cubes with a joint between them; of one of them, cells are in two groups.
fn cubes(kind: Kind) -> crate::mesh::import::FileMesh {
    let mut file = block(kind, [2, 1, 1]);
    group_cells(&mut file, "left", |x| x[0] < 1.0);
    group_cells(&mut file, "right", |x| x[0] > 1.0);
    group_facets(&mut file, "joint", [1.0, 0.0, 0.0], |x| (x[0] - 1.0).abs() < 1e-9);
    file
}

fn asked() -> Request {
    let material = |name: &str| MaterialGroups { name: name.into(), groups: vec![name.into()] };
    Request { materials: vec![material("left"), material("right")], ..request_on(&["joint"]) }
}

fn lower(mesh: &WholeMesh) -> Vec<WholeFacet> {
    mesh.interfaces[0].lips[0].clone()
}

#[test]
fn parts_fill_the_cells_and_the_joint() {
    for kind in [Kind::Quad4, Kind::Tri3, Kind::Hex8, Kind::Tet4, Kind::Prism6] {
        let (file, asked) = (cubes(kind), asked());
        let before = made(&file, &asked);
        let request = Request { divided: lower(&before), ..asked };
        let mesh = made(&file, &request);
        assert!((volume(&mesh) / volume(&before) - 1.0).abs() < 1e-12, "{kind:?}");
        let parts = |facet: &WholeFacet| match before.facet_shape(*facet) {
            Shape::Line2 => 3,
            Shape::Tri3 => 7,
            _ => 5,
        };
        let expected: usize = lower(&before).iter().map(parts).sum();
        for lip in 0..2 {
            let facets = &mesh.interfaces[0].lips[lip];
            assert_eq!(facets.len(), expected, "{kind:?}");
            let areas = [area(&mesh, facets), area(&before, &before.interfaces[0].lips[lip])];
            assert!((areas[0] / areas[1] - 1.0).abs() < 1e-12, "{kind:?}: {areas:?}");
        }
        // Both cubes keep their material, and every facet has a node inside.
        let of = |mesh: &WholeMesh| mesh.materials.iter().filter(|m| **m == 0).count();
        assert!(of(&mesh) > of(&before) && of(&mesh) < mesh.cells());
        let is_inside = |node: u32| {
            let [_, y, z] = mesh.points[node as usize];
            y > 1e-3 && y < 1.0 - 1e-3 && (mesh.dim() == 2 || z > 1e-3 && z < 1.0 - 1e-3)
        };
        assert!(lower(&mesh).iter().all(|f| mesh.facet_nodes(*f).any(is_inside)), "{kind:?}");
        assert!(mesh.remarks.iter().any(|words| words.contains("got nodes inside")));
    }
}

/// The same cells come of a file whose nodes have other numbers.
#[test]
fn numbers_of_nodes_make_no_other_parts() {
    for kind in [Kind::Tri3, Kind::Hex8, Kind::Tet4, Kind::Prism6] {
        let [one, other] = [false, true].map(|is_reversed| {
            let (mut file, asked) = (cubes(kind), asked());
            file.points.iter_mut().for_each(|p| *p = [p[0], p[1] + 0.3 * p[2], p[2]]);
            if is_reversed {
                file.points.reverse();
                let last = file.points.len() as u32 - 1;
                let nodes = file.blocks.iter_mut().flat_map(|block| &mut block.nodes);
                nodes.for_each(|node| *node = last - *node);
            }
            let divided = lower(&made(&file, &asked));
            look(&made(&file, &Request { divided, ..asked }))
        });
        assert_eq!(one, other, "{kind:?}");
    }
}

#[test]
fn simplices_are_raised_afterwards_and_others_stay() {
    for kind in [Kind::Tri3, Kind::Tet4, Kind::Hex8, Kind::Prism6] {
        let (file, asked) = (cubes(kind), Request { raise_order: Some(2), ..asked() });
        let before = made(&file, &asked);
        let mesh = made(&file, &Request { divided: lower(&before), ..asked });
        let is_simplex = matches!(kind, Kind::Tri3 | Kind::Tet4);
        assert_eq!(mesh.cells() > before.cells(), is_simplex, "{kind:?}");
        assert!(mesh.shapes.iter().all(|shape| shape.order() == 2));
        assert!((volume(&mesh) / volume(&before) - 1.0).abs() < 1e-12, "{kind:?}");
    }
}
