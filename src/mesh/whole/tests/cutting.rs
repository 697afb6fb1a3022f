//! Meshes cut along interfaces that cross, branch and end inside.

use proptest::prelude::*;

use super::blocks::{
    Is, PLANES, VOLUMES, X, Y, add, block, group, group_facets, made, refused, request,
    request_between, request_on, two,
};
use super::looks::{area, check, key, look, places, volume};
use crate::mesh::import::{FileMesh, Kind};
use crate::mesh::whole::{Request, build};

/// A block of 4 x 4 x depth cells with facets on x = 2 and y = 2 where they are asked for.
fn crossed(kind: Kind, names: [&str; 2], on_x: Is, on_y: Is) -> FileMesh {
    let mut file = block(kind, [4, 4, 2]);
    group_facets(&mut file, names[0], X, |p| p[0] == 2.0 && on_x(p));
    group_facets(&mut file, names[1], Y, |p| p[1] == 2.0 && on_y(p));
    file
}

fn depth(kind: Kind) -> f64 {
    if kind.dim() == 2 { 1.0 } else { 2.0 }
}

/// How many nodes a line along z has.
fn along_z(kind: Kind, order: u32) -> usize {
    if kind.dim() == 2 { 1 } else { 2 * order as usize + 1 }
}

fn raised(request: Request, order: u32) -> Request {
    Request { raise_order: Some(order), ..request }
}

#[test]
fn a_crossing_of_one_or_two_groups_has_four_sectors() {
    for kind in [&VOLUMES[..], &PLANES[..]].concat() {
        for (names, order) in [(["a", "b"], 1), (["a", "a"], 1), (["a", "b"], 2)] {
            let file = crossed(kind, names, |_| true, |_| true);
            let count = if names[0] == names[1] { 1 } else { 2 };
            let mesh = made(&file, &raised(request_on(&names[..count]), order));
            let one = 4.0 * depth(kind);
            let areas = if count == 1 { vec![2.0 * one] } else { vec![one, one] };
            check(&mesh, &areas, |p| p[0] == 2.0 || p[1] == 2.0);
            assert_eq!(mesh.body_count, 4);
            let mut expected = Vec::new();
            for node in 0..along_z(kind, order) {
                let z = node as f64 / f64::from(order);
                expected.extend([key([2.0, 2.0, z]); 4]);
            }
            for interface in &mesh.interfaces {
                assert!(interface.tips.is_empty());
                assert_eq!(places(&mesh, &interface.junctions), expected);
            }
            assert!((volume(&mesh) - 16.0 * depth(kind)).abs() < 1e-12);
        }
    }
}

#[test]
fn a_branch_has_three_sectors() {
    for kind in [&VOLUMES[..], &PLANES[..]].concat() {
        for names in [["a", "b"], ["a", "a"]] {
            let file = crossed(kind, names, |p| p[1] < 2.0, |_| true);
            let count = if names[0] == names[1] { 1 } else { 2 };
            let mesh = made(&file, &request_on(&names[..count]));
            let one = 2.0 * depth(kind);
            let areas = if count == 1 { vec![3.0 * one] } else { vec![one, 2.0 * one] };
            check(&mesh, &areas, |p| p[1] == 2.0 || (p[0] == 2.0 && p[1] < 2.0));
            assert_eq!(mesh.body_count, 3);
            // The branch's own lips have two of the three copies.
            let copies: Vec<usize> = mesh
                .interfaces
                .iter()
                .map(|interface| interface.junctions.len() / along_z(kind, 1))
                .collect();
            assert_eq!(copies, if count == 1 { vec![3] } else { vec![2, 3] });
        }
    }
}

#[test]
fn an_interface_that_ends_inside_stays_shut_there() {
    for kind in [&VOLUMES[..], &PLANES[..]].concat() {
        for order in [1, 2] {
            let mut file = block(kind, [4, 4, 2]);
            group_facets(&mut file, "a", X, |p| p[0] == 2.0 && p[1] < 3.0);
            let mesh = made(&file, &raised(request_on(&["a"]), order));
            check(&mesh, &[3.0 * depth(kind)], |p| p[0] == 2.0 && p[1] < 3.0);
            assert_eq!(mesh.body_count, 1);
            let interface = &mesh.interfaces[0];
            assert!(interface.junctions.is_empty());
            let expected: Vec<_> = (0..along_z(kind, order))
                .map(|node| key([2.0, 3.0, node as f64 / f64::from(order)]))
                .collect();
            assert_eq!(places(&mesh, &interface.tips), expected);
        }
    }
}

#[test]
fn a_crack_inside_a_body_is_shut_all_around() {
    let mut file = block(Kind::Tet4, [4, 4, 4]);
    let inside =
        |p: [f64; 3]| p[0] == 2.0 && (1.0..3.0).contains(&p[1]) && (1.0..3.0).contains(&p[2]);
    group_facets(&mut file, "a", X, inside);
    let mesh = made(&file, &request_on(&["a"]));
    check(&mesh, &[4.0], inside);
    // A square of 3 x 3 nodes, of which only the middle one opens; two triangles do not have it.
    assert_eq!((mesh.interfaces[0].tips.len(), mesh.points.len()), (8, 126));
    assert!(
        mesh.remarks.iter().any(|remark| remark.contains("2 facets with all nodes on its edge"))
    );
    assert_eq!(mesh.body_count, 1);
}

#[test]
fn interfaces_that_meet_at_the_boundary_or_follow_each_other_have_junctions() {
    // Both begin at (2, 0); the diagonal goes from there to (4, 2). Of the three copies each has
    // those that its own facets touch.
    let mut file = block(Kind::Tri3, [4, 4, 0]);
    group_facets(&mut file, "a", X, |p| p[0] == 2.0);
    group_facets(&mut file, "b", Y, |p| p[0] - p[1] == 2.0 && p[0] > 2.0);
    let mesh = made(&file, &request_on(&["a", "b"]));
    let root = 8.0_f64.sqrt();
    check(&mesh, &[4.0, root], |p| p[0] == 2.0 || (p[0] - p[1] == 2.0 && p[0] > 2.0));
    let at = |interface: usize| places(&mesh, &mesh.interfaces[interface].junctions);
    assert_eq!((at(0), at(1)), (vec![key([2.0, 0.0, 0.0]); 2], vec![key([2.0, 0.0, 0.0]); 2]));
    assert_eq!(mesh.body_count, 3);

    let mut file = block(Kind::Quad4, [4, 4, 0]);
    group_facets(&mut file, "a", X, |p| p[0] == 2.0 && p[1] < 2.0);
    group_facets(&mut file, "b", X, |p| p[0] == 2.0 && p[1] > 2.0);
    let mesh = made(&file, &request_on(&["a", "b"]));
    check(&mesh, &[2.0, 2.0], |p| p[0] == 2.0);
    for interface in &mesh.interfaces {
        assert_eq!(places(&mesh, &interface.junctions), [key([2.0, 2.0, 0.0]); 2]);
    }
    // With one of them alone, the node between them is its tip.
    let mesh = made(&file, &request_on(&["b"]));
    assert_eq!(places(&mesh, &mesh.interfaces[0].tips), [key([2.0, 2.0, 0.0])]);
}

#[test]
fn what_cannot_be_an_interface_is_refused() {
    let mut file = block(Kind::Hex8, [2, 2, 2]);
    group_facets(&mut file, "side", X, |p| p[0] == 0.0);
    group_facets(&mut file, "one", X, |p| p == [1.0, 0.5, 0.5]);
    group_facets(&mut file, "inside", X, |p| p[0] == 1.0);
    let said = |request: &Request| refused(build(&file, request, "block.msh"));
    let text = said(&request_on(&["side"]));
    assert!(
        text.starts_with("block.msh: interface `side`: 4 facets lie on the boundary"),
        "{text}"
    );
    let text = said(&request_on(&["one", "inside"]));
    assert!(text.contains("interfaces `one` and `inside` have a facet in common"), "{text}");
    let text = said(&request_between("inside", "side"));
    assert!(text.contains("make the interface `on: inside`"), "{text}");

    let mut file = block(Kind::Hex8, [4, 4, 4]);
    group_facets(&mut file, "one", X, |p| p == [2.0, 1.5, 1.5]);
    let text = refused(build(&file, &request_on(&["one"]), "block.msh"));
    assert!(text.contains("cuts nothing"), "{text}");
}

#[test]
fn two_bodies_are_joined_between_groups() {
    let mut lower = block(Kind::Hex8, [2, 2, 1]);
    group_facets(&mut lower, "top", [0.0, 0.0, 1.0], |p| p[2] == 1.0);
    let mut upper = block(Kind::Tet4, [2, 2, 1]);
    group_facets(&mut upper, "bottom", [0.0, 0.0, 1.0], |p| p[2] == 0.0);
    let file = two(&lower, &upper, [0.0, 0.0, 1.0]);
    let mesh = made(&file, &request_between("top", "bottom"));
    let interface = &mesh.interfaces[0];
    assert_eq!((interface.lips[0].len(), interface.lips[1].len()), (4, 8));
    assert_eq!((mesh.body_count, mesh.points.len(), interface.faces.len()), (2, 36, 0));
    assert_eq!(interface.normals.len(), 18);
    assert!(interface.normals.iter().all(|(_, normal)| *normal == [0.0, 0.0, 1.0]));
    // The group's own orientation plays no part here, and the order of the groups does.
    let mesh = made(&file, &request_between("bottom", "top"));
    assert!(mesh.interfaces[0].normals.iter().all(|(_, normal)| *normal == [0.0, 0.0, -1.0]));

    let mut file = block(Kind::Quad4, [2, 1, 0]);
    group_facets(&mut file, "left", Y, |p| p[1] == 1.0 && p[0] < 1.0);
    group_facets(&mut file, "right", Y, |p| p[1] == 1.0 && p[0] > 1.0);
    let text = refused(build(&file, &request_between("left", "right"), "block.msh"));
    assert!(text.contains("share 1 node, the first at (1, 1, 0) m"), "{text}");
}

/// The same file with points and elements in another order.
fn shuffled(file: &FileMesh, points: &[usize], seed: usize) -> FileMesh {
    let mut new = FileMesh { groups: file.groups.clone(), ..FileMesh::default() };
    new.group_sets.clone_from(&file.group_sets);
    new.points = points.iter().map(|point| file.points[*point]).collect();
    new.node_numbers = points.iter().map(|point| file.node_numbers[*point]).collect();
    let mut place = vec![0; points.len()];
    (0..).zip(points).for_each(|(to, from)| place[*from] = to);
    for block in &file.blocks {
        let count = block.numbers.len();
        for i in 0..count {
            let element = (i * 7 + seed) % count;
            let element = if count % 7 == 0 { (i + seed) % count } else { element };
            let nodes = &block.nodes[element * block.kind.nodes()..][..block.kind.nodes()];
            let nodes = nodes.iter().map(|node| place[*node as usize]).collect();
            let of = file.group_sets[block.groups[element] as usize].first().copied();
            add(&mut new, block.kind, nodes, of);
        }
    }
    new
}

fn orders() -> impl Strategy<Value = (Vec<usize>, usize)> {
    (Just((0..75).collect::<Vec<usize>>()).prop_shuffle(), 0..1000_usize)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn the_order_of_nodes_and_elements_does_not_matter(order in orders(), which in 0..3_usize) {
        let (points, seed) = order;
        let mut file = block(VOLUMES[which], [4, 4, 2]);
        group_facets(&mut file, "a", X, |p| p[0] == 2.0 && p[1] < 3.0);
        group_facets(&mut file, "b", Y, |p| p[1] == 2.0);
        group_facets(&mut file, "foot", Y, |p| p[1] == 0.0);
        let edge = group(&mut file, "edge", 1);
        add(&mut file, Kind::Line2, vec![2, 27], Some(edge));
        let mut request = request_on(&["a", "b"]);
        request.surfaces = vec!["foot".into(), "edge".into(), "all".into()];
        let mesh = made(&file, &request);
        let other = made(&shuffled(&file, &points, seed), &request);
        prop_assert_eq!(look(&mesh), look(&other));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn any_set_of_facets_cuts_the_cells_into_sectors(
        which in 0..3_usize,
        seeds in prop::collection::vec(0..u64::MAX, 1..4),
        share in 1..8_u64,
        order in 1..3_u32,
    ) {
        let kind = [Kind::Hex8, Kind::Tet4, Kind::Tri3][which];
        let mut file = block(kind, [2, 3, 2]);
        // Facets are drawn by a hash of their middle; none of them lies on the boundary.
        let drawn = |p: [f64; 3], seed: u64| {
            let bits = p.iter().fold(seed, |h, x| (h ^ x.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29));
            bits % 8 < share
        };
        let is_inside = |p: [f64; 3]| {
            let size = [2.0, 3.0, if kind.dim() == 2 { f64::INFINITY } else { 2.0 }];
            (0..3).all(|i| (p[i] > 0.0 || i >= kind.dim()) && p[i] < size[i])
        };
        let mut known: Vec<[i64; 3]> = Vec::new();
        let mut names = Vec::new();
        for (index, seed) in seeds.iter().enumerate() {
            let name = ["a", "b", "c"][index];
            let before = known.clone();
            let is = |p: [f64; 3]| is_inside(p) && drawn(p, *seed) && !before.contains(&key(p));
            let found = std::cell::RefCell::new(Vec::new());
            group_facets(&mut file, name, [0.3, 0.2, 1.0], |p| {
                if is(p) {
                    found.borrow_mut().push(key(p));
                }
                is(p)
            });
            let found = found.into_inner();
            if !found.is_empty() {
                known.extend(found);
                names.push(name);
            }
        }
        prop_assume!(!names.is_empty());
        match build(&file, &raised(request_on(&names), order), "any.msh") {
            Ok(mesh) => {
                let areas: Vec<f64> = mesh.interfaces.iter().map(|interface| {
                    interface.lips[0].iter().map(|facet| area(&mesh, *facet).0).sum()
                }).collect();
                check(&mesh, &areas, |p| known.contains(&key(p)));
            }
            Err(error) => {
                let text = error.to_string();
                prop_assert!(text.contains("cuts nothing") || text.contains("one side only"), "{}", text);
            }
        }
    }
}

#[test]
fn surfaces_get_the_copies_that_touch_them() {
    // An interface on x = 2 for y < 3 cuts the foot y = 0.
    let mut file = block(Kind::Hex8, [4, 4, 1]);
    group_facets(&mut file, "a", X, |p| p[0] == 2.0 && p[1] < 3.0);
    group_facets(&mut file, "left foot", Y, |p| p[1] == 0.0 && p[0] < 2.0);
    group_facets(&mut file, "level", Y, |p| p[1] == 1.0);
    let edge = group(&mut file, "edge", 1);
    add(&mut file, Kind::Line2, vec![2, 27], Some(edge));
    let corner = group(&mut file, "corner", 0);
    add(&mut file, Kind::Point1, vec![2], Some(corner));
    file.node_groups.push((corner, vec![2, 7]));
    let mut asked = request_on(&["a"]);
    let names = ["left foot", "level", "edge", "corner", "a", "all"];
    asked.surfaces = names.iter().map(|name| (*name).into()).collect();
    let mesh = made(&file, &asked);
    let counts: Vec<_> =
        mesh.surfaces.iter().map(|surface| (surface.facets.len(), surface.nodes.len())).collect();
    // Six nodes of two facets; ten of a level inside, of which two have copies; all copies of two
    // nodes; twice; both lips, with two tips; all.
    assert_eq!(counts, [(2, 6), (0, 12), (0, 4), (0, 4), (6, 14), (0, 56)]);
    assert!(mesh.remarks.iter().any(|r| r.contains("surface `level`: 4 facets lie inside")));
    // The foot on the left has the copy of the cells on the left.
    let place =
        mesh.surfaces[0].nodes.iter().find(|n| mesh.points[**n as usize] == [2.0, 0.0, 0.0]);
    let node = place.expect("the foot has a node there");
    let cells = (0..mesh.cells()).filter(|cell| mesh.cell_nodes(*cell).contains(node));
    let cells: Vec<usize> = cells.collect();
    assert_eq!(cells, [1]);
    let plain = made(&file, &Request { surfaces: vec!["a".into()], ..request() });
    assert_eq!((plain.surfaces[0].facets.len(), plain.surfaces[0].nodes.len()), (0, 8));
}
