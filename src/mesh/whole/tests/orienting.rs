//! The sides of interfaces.

use super::blocks::{Is, PLANES, VOLUMES, block, group_facets, made, request_on};
use super::looks::check;
use crate::mesh::import::Kind;
use crate::mesh::whole::{InterfacePlace, WholeMesh};

/// Normals of the first interface along an axis: all of them, if they are one.
fn normal(mesh: &WholeMesh) -> [f64; 3] {
    let normals = &mesh.interfaces[0].normals;
    assert!(normals.iter().all(|(_, normal)| *normal == normals[0].1));
    normals[0].1
}

#[test]
fn normals_are_those_of_the_first_facet_unless_flipped() {
    for (kind, along) in [(Kind::Hex8, 1.0), (Kind::Tet4, -1.0), (Kind::Tri3, -1.0)] {
        let mut file = block(kind, [2, 4, 3]);
        group_facets(&mut file, "a", [along, 0.0, 0.0], |p| p[0] == 1.0 && p[1] < 2.0);
        group_facets(&mut file, "a", [-along, 0.0, 0.0], |p| p[0] == 1.0 && p[1] > 2.0);
        let mut request = request_on(&["a"]);
        let mesh = made(&file, &request);
        let area = if kind.dim() == 2 { 4.0 } else { 12.0 };
        check(&mesh, &[area], |p| p[0] == 1.0);
        assert_eq!(normal(&mesh), [along, 0.0, 0.0]);
        assert!(mesh.remarks.iter().any(|remark| remark.contains("were turned")));
        request.interfaces[0].place = InterfacePlace::On { group: "a".into(), flip: true };
        let mesh = made(&file, &request);
        check(&mesh, &[area], |p| p[0] == 1.0);
        assert_eq!(normal(&mesh), [-along, 0.0, 0.0]);
    }
}

#[test]
fn normals_go_straight_on_over_a_crossing() {
    for kind in [&VOLUMES[..], &PLANES[..]].concat() {
        for has_fourth in [false, true] {
            let mut file = block(kind, [4, 4, 2]);
            let arms: [([f64; 3], Is); 4] = [
                ([-1.0, 0.0, 0.0], |p| p[0] == 2.0 && p[1] < 2.0),
                ([0.0, -1.0, 0.0], |p| p[1] == 2.0 && p[0] > 2.0),
                ([1.0, 0.0, 0.0], |p| p[0] == 2.0 && p[1] > 2.0),
                ([0.0, 1.0, 0.0], |p| p[1] == 2.0 && p[0] < 2.0),
            ];
            for (along, is) in arms.iter().take(if has_fourth { 4 } else { 3 }) {
                group_facets(&mut file, "a", *along, is);
            }
            let mesh = made(&file, &request_on(&["a"]));
            let interface = &mesh.interfaces[0];
            for (node, normal) in &interface.normals {
                if interface.junctions.binary_search(node).is_err() {
                    let is_upright = mesh.points[*node as usize][0] == 2.0;
                    let expected = if is_upright { [-1.0, 0.0, 0.0] } else { [0.0, -1.0, 0.0] };
                    assert_eq!(*normal, expected, "{kind:?}");
                }
            }
        }
    }
}

#[test]
fn a_closed_interface_has_normals_on_one_side() {
    for kind in [Kind::Quad4, Kind::Hex8, Kind::Prism6] {
        let mut file = block(kind, [5, 5, 5]);
        let of = |p: f64| (2.0..=3.0).contains(&p);
        let flat = kind.dim() == 2;
        // The sides of the cell in the middle; the first has its normal along +x, or inwards.
        let on = move |p: [f64; 3]| {
            let is_wall = |x: f64| x == 2.0 || x == 3.0;
            (0..3 - usize::from(flat)).any(|i| is_wall(p[i]))
                && (0..3 - usize::from(flat)).all(|i| of(p[i]))
        };
        let all = [1.0, 0.3, 0.2];
        group_facets(&mut file, "a", all, on);
        let mesh = made(&file, &request_on(&["a"]));
        check(&mesh, &[if flat { 4.0 } else { 6.0 }], on);
        assert_eq!((mesh.body_count, mesh.interfaces[0].tips.len()), (2, 0));
        let mut outer = [0, 0];
        for (lower, upper) in mesh.interfaces[0].lips[0].iter().zip(&mesh.interfaces[0].lips[1]) {
            let bodies = [lower, upper].map(|facet| mesh.bodies[facet.cell as usize]);
            outer[usize::from(bodies[0] < bodies[1])] += 1;
        }
        assert!(outer.contains(&0), "{outer:?}");
    }
}
