//! Cells raised to full kinds and to second order.

use super::blocks::{add, block, group, group_facets, made, refused, request, request_on};
use super::looks::{check, key, volume};
use crate::element::Shape;
use crate::mesh::import::{Block, FileMesh, Kind};
use crate::mesh::whole::{Request, WholeMesh, build};

fn raised() -> Request {
    Request { raise_order: Some(2), ..request() }
}

#[test]
fn raised_cells_share_their_middle_nodes() {
    let cases = [
        (Kind::Quad4, Shape::Quad9, 7 * 5),
        (Kind::Tri3, Shape::Tri6, 7 * 5),
        (Kind::Hex8, Shape::Hex27, 7 * 5 * 3),
        (Kind::Tet4, Shape::Tet10, 7 * 5 * 3),
        (Kind::Prism6, Shape::Prism18, 7 * 5 * 3),
    ];
    for (kind, shape, nodes) in cases {
        let mut file = block(kind, [3, 2, 1]);
        group_facets(&mut file, "side", [1.0, 0.0, 0.0], |p| p[0] == 3.0);
        let mesh = made(&file, &Request { surfaces: vec!["side".into()], ..raised() });
        assert!(mesh.shapes.iter().all(|other| *other == shape));
        // Each node stands on a lattice of half the distance, once.
        assert_eq!(mesh.points.len(), nodes, "{shape:?}");
        let mut places: Vec<_> = mesh.points.iter().map(|point| key(*point)).collect();
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), nodes);
        assert!((volume(&mesh) - 6.0).abs() < 1e-13);
        let of_side = if kind.dim() == 2 { 5 } else { 15 };
        assert_eq!(mesh.surfaces[0].nodes.len(), of_side);
    }
}

/// The file of a raised mesh, with each cell's first nodes only and its points bent.
pub fn lowered(mesh: &WholeMesh, kind: Kind, bend: impl Fn([f64; 3]) -> [f64; 3]) -> FileMesh {
    let cells = 0..mesh.cells();
    let nodes: Vec<u32> =
        cells.clone().flat_map(|c| mesh.cell_nodes(c)[..kind.nodes()].to_vec()).collect();
    let numbers = cells.clone().map(|cell| cell as u64 + 1).collect();
    FileMesh {
        points: mesh.points.iter().map(|point| bend(*point)).collect(),
        node_numbers: (1..=mesh.points.len() as u64).collect(),
        blocks: vec![Block { kind, nodes, numbers, groups: vec![0; mesh.cells()] }],
        group_sets: vec![vec![]],
        ..FileMesh::default()
    }
}

#[test]
fn serendipity_kinds_get_the_nodes_that_they_lack_where_their_interpolation_has_them() {
    let cases = [
        (Kind::Quad4, Kind::Quad8, Shape::Quad9),
        (Kind::Hex8, Kind::Hex20, Shape::Hex27),
        (Kind::Prism6, Kind::Prism15, Shape::Prism18),
    ];
    // Of second degree in each coordinate, but within what serendipity kinds hold exactly.
    let bend = |[x, y, z]: [f64; 3]| [x + 0.1 * y * y, y + 0.05 * x * z, z + 0.1 * x * y];
    let flat = |[x, y, _]: [f64; 3]| [x + 0.1 * y * y, y + 0.05 * x * y, 0.0];
    for (kind, serendipity, shape) in cases {
        let full = made(&block(kind, [2, 2, 2]), &raised());
        let is_flat = kind.dim() == 2;
        let bent = |p| if is_flat { flat(p) } else { bend(p) };
        let mesh = made(&lowered(&full, serendipity, bent), &request());
        assert!(mesh.shapes.iter().all(|other| *other == shape));
        assert_eq!(mesh.points.len(), full.points.len(), "{shape:?}");
        for cell in 0..mesh.cells() {
            for (node, old) in mesh.cell_nodes(cell).iter().zip(full.cell_nodes(cell)) {
                let expected = bent(full.points[*old as usize]);
                let found = mesh.points[*node as usize];
                assert!((0..3).all(|i| (found[i] - expected[i]).abs() < 1e-13), "{shape:?}");
            }
        }
        let kinds = format!("({}) raised to {} nodes", serendipity.name(), shape.nodes());
        assert!(mesh.remarks.iter().any(|remark| remark.contains(&kinds)), "{:?}", mesh.remarks);
        assert!(mesh.remarks.iter().any(|remark| remark.starts_with("nodes of no cell")));
    }
}

#[test]
fn an_interface_is_cut_in_raised_serendipity_cells() {
    let full = made(&block(Kind::Hex8, [2, 2, 2]), &raised());
    let mut file = lowered(&full, Kind::Hex20, |p| p);
    let at = |p: [f64; 3]| file.points.iter().position(|q| *q == p).map(|node| node as u32);
    let mut rows = Vec::new();
    for [y, z] in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
        // A quadrilateral of eight nodes on x = 1.
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let middles = [[0.5, 0.0], [1.0, 0.5], [0.5, 1.0], [0.0, 0.5]];
        let all = corners.iter().chain(&middles);
        let row: Option<Vec<u32>> = all.map(|[a, b]| at([1.0, y + a, z + b])).collect();
        rows.push(row.expect("all nodes are there"));
    }
    let of = group(&mut file, "a", 2);
    rows.into_iter().for_each(|row| add(&mut file, Kind::Quad8, row, Some(of)));
    let mesh = made(&file, &request_on(&["a"]));
    check(&mesh, &[4.0], |p| p[0] == 1.0);
    assert_eq!(mesh.points.len(), 125 + 25);
}

#[test]
fn groups_of_edges_get_the_middle_nodes_of_raised_cells() {
    let mut file = block(Kind::Tet4, [2, 1, 1]);
    let edge = group(&mut file, "edge", 1);
    add(&mut file, Kind::Line2, vec![0, 1], Some(edge));
    add(&mut file, Kind::Line2, vec![2, 1], Some(edge));
    let mesh = made(&file, &Request { surfaces: vec!["edge".into()], ..raised() });
    let points = mesh.surfaces[0].nodes.iter().map(|node| mesh.points[*node as usize]);
    let mut along: Vec<f64> = points.map(|point| point[0] + 10.0 * (point[1] + point[2])).collect();
    along.sort_by(f64::total_cmp);
    assert_eq!(along, [0.0, 0.5, 1.0, 1.5, 2.0]);
}

#[test]
fn pyramids_and_other_orders_are_refused() {
    let mut file = FileMesh { group_sets: vec![vec![]], ..FileMesh::default() };
    for point in crate::element::Shape::Pyramid5.node_points() {
        file.points.push(*point);
        file.node_numbers.push(file.points.len() as u64);
    }
    add(&mut file, Kind::Pyramid5, vec![0, 1, 2, 3, 4], None);
    assert!((volume(&made(&file, &request())) - 4.0 / 3.0).abs() < 1e-13);
    let text = refused(build(&file, &raised(), "p.msh"));
    assert!(text.contains("there are no pyramids of second order"), "{text}");
    let text = refused(build(&file, &Request { raise_order: Some(3), ..request() }, "p.msh"));
    assert!(text.contains("`raise_order` is 3"), "{text}");
    let mut file = block(Kind::Hex8, [3, 3, 3]);
    file.blocks.clear();
    add(&mut file, Kind::Pyramid13, (0..13).collect(), None);
    let text = refused(build(&file, &request(), "p.msh"));
    assert!(text.contains("only pyramids of 5 nodes"), "{text}");
}

#[test]
fn cells_of_two_orders_that_meet_are_refused_unless_raised() {
    let full = made(&block(Kind::Quad4, [2, 1, 0]), &raised());
    let mut file = lowered(&full, Kind::Quad9, |p| p);
    let last = file.blocks[0].nodes.split_off(9);
    file.blocks[0].numbers.pop();
    file.blocks[0].groups.pop();
    add(&mut file, Kind::Quad4, last[..4].to_vec(), None);
    let text = refused(build(&file, &request(), "q.msh"));
    assert!(text.contains("elements 1 and 2 meet") && text.contains("(1, 0.5, 0) m"), "{text}");
    // The middle node between them is the one that is there.
    let mesh = made(&file, &raised());
    assert_eq!((mesh.points.len(), mesh.body_count), (15, 1));
}
