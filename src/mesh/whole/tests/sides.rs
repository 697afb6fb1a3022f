//! Normals of surfaces.

use super::blocks::{block, dot, group_facets, made, request};
use crate::mesh::import::Kind;
use crate::mesh::whole::{Request, surface_normals};

#[test]
fn a_node_at_a_kink_has_the_normals_of_both_sides() {
    for kind in [Kind::Hex8, Kind::Tet4, Kind::Prism6, Kind::Quad4, Kind::Tri3] {
        let mut file = block(kind, [2, 2, 2]);
        // The groups' own orientation plays no part.
        group_facets(&mut file, "corner", [1.0, -1.0, 0.0], |p| p[0] == 2.0 || p[1] == 2.0);
        for order in [1, 2] {
            let surfaces = vec!["corner".into()];
            let mesh = made(&file, &Request { surfaces, raise_order: Some(order), ..request() });
            let normals = surface_normals(&mesh, 0);
            let nodes: Vec<u32> = normals.iter().map(|(node, _)| *node).collect();
            assert_eq!(nodes, mesh.surfaces[0].nodes);
            for (node, mut found) in normals {
                found.sort_by(|a, b| b[0].total_cmp(&a[0]));
                let [x, y, _] = mesh.points[node as usize];
                let mut expected = Vec::new();
                expected.extend((x == 2.0).then_some([1.0, 0.0, 0.0]));
                expected.extend((y == 2.0).then_some([0.0, 1.0, 0.0]));
                assert_eq!(found, expected, "{kind:?} of order {order} at {x}, {y}");
            }
        }
    }
}

#[test]
fn flat_bends_are_averaged_by_area() {
    // A roof that falls by 0.2 to both sides, one of them twice as long as the other.
    let mut file = block(Kind::Quad4, [2, 1, 0]);
    group_facets(&mut file, "roof", [0.0, 1.0, 0.0], |p| p[1] == 1.0);
    for point in &mut file.points {
        point[1] -= if point[1] == 1.0 { 0.2 * (point[0] - 1.0).abs() } else { 0.0 };
        point[0] += (point[0] - 1.0).max(0.0);
    }
    let mesh = made(&file, &Request { surfaces: vec!["roof".into()], ..request() });
    let normals = surface_normals(&mesh, 0);
    let ridge = normals.iter().find(|(node, _)| mesh.points[*node as usize] == [1.0, 1.0, 0.0]);
    let found = &ridge.expect("the ridge is on the roof").1;
    assert_eq!(found.len(), 1);
    // The sum of the normals times the lengths: (-0.2, 1) and (0.2, 2).
    assert!((found[0][0]).abs() < 1e-15 && (dot(found[0], [0.0, 1.0, 0.0]) - 1.0).abs() < 1e-15);
}
