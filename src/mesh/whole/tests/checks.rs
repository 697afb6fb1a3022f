//! What is wrong with a mesh is said with its number, its place and a remedy.

use proptest::prelude::*;

use super::blocks::{
    add, block, group, group_cells, group_facets, made, refused, request, request_between,
    request_on, two,
};
use crate::mesh::import::{FileMesh, Kind};
use crate::mesh::whole::{MaterialGroups, Request, build, dual_graph};

fn said(file: &FileMesh, request: &Request) -> String {
    refused(build(file, request, "block.msh"))
}

/// Checks that all of these are in the text.
fn assert_says(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "no `{part}` in: {text}");
    }
}

fn materials(list: &[(&str, &[&str])]) -> Request {
    let of = |(name, groups): &(&str, &[&str])| MaterialGroups {
        name: (*name).into(),
        groups: groups.iter().map(|group| (*group).into()).collect(),
    };
    Request { materials: list.iter().map(of).collect(), ..request() }
}

#[test]
fn every_cell_is_in_one_material() {
    let mut file = block(Kind::Hex8, [2, 2, 2]);
    group_cells(&mut file, "dam", |p| p[2] > 1.0);
    group_cells(&mut file, "base", |p| p[2] < 1.0 && p[0] < 1.0);
    group_cells(&mut file, "flank", |p| p[2] < 1.0 && p[0] > 1.0);
    group_facets(&mut file, "foot", [0.0, 0.0, 1.0], |p| p[2] == 0.0);
    group(&mut file, "void", 3);
    let mesh = made(&file, &materials(&[("concrete", &["dam"]), ("rock", &["base", "flank"])]));
    assert_eq!(mesh.materials, [1, 1, 1, 1, 0, 0, 0, 0]);
    assert_eq!(mesh.numbers, (1..=8).collect::<Vec<u64>>());

    let text = said(&file, &materials(&[("concrete", &["dam"]), ("rock", &["flank"])]));
    assert_says(&text, &["in no material: 2 cells", "number 1 at (0.5, 0.5, 0.5) m", "`on`"]);
    let text = said(&file, &materials(&[("a", &["dam", "base", "flank"]), ("b", &["base"])]));
    assert_says(&text, &["in the materials `a` and `b` at once: 2 cells", "number 1 at"]);
    let text = said(&file, &materials(&[("a", &["dam"]), ("b", &["walls"])]));
    let list = "cells dam (4), base (2), flank (2), void (0); facets foot (4)";
    assert_says(&text, &["material `b`: there is no group `walls`", list]);
    let text = said(&file, &materials(&[("a", &["foot"])]));
    assert_says(&text, &["the group `foot` has facets, not cells"]);
    let text = said(&file, &materials(&[("a", &["void"])]));
    assert_says(&text, &["the group `void` has no elements"]);
    let text = said(&file, &materials(&[("a", &["dam"]), ("b", &[])]));
    assert_says(&text, &["the material `b` names no group"]);
}

#[test]
fn cells_that_are_turned_over_or_degenerate_are_not_repaired() {
    for kind in [Kind::Hex8, Kind::Tet4, Kind::Prism6, Kind::Quad4, Kind::Tri3] {
        let mut file = block(kind, [2, 1, 1]);
        let count = kind.nodes();
        let last = file.blocks[0].numbers.len();
        let nodes = &mut file.blocks[0].nodes[(last - 1) * count..];
        match kind {
            Kind::Hex8 | Kind::Prism6 => nodes.rotate_left(count / 2),
            _ => nodes.swap(0, count - 2),
        }
        let text = said(&file, &request());
        assert_says(&text, &["turned over", &format!("number {last} at (")]);

        let mut file = block(kind, [2, 1, 1]);
        file.points.iter_mut().for_each(|point| point[0] = point[0].min(1.0));
        let text = said(&file, &request());
        assert_says(&text, &["degenerate or folded"]);
        file.points[0][0] = f64::NAN;
        assert_says(&said(&file, &request()), &["degenerate or folded"]);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn spoilt_meshes_are_refused_in_words(
        which in 0..5_usize,
        spoilt in prop::collection::vec((0..3_usize, 0..10_000_usize, 0..27_usize), 1..4),
        raise in prop::bool::ANY,
    ) {
        let kind = [Kind::Hex8, Kind::Tet4, Kind::Prism6, Kind::Quad4, Kind::Tri3][which];
        let mut file = block(kind, [2, 2, 2]);
        group_facets(&mut file, "a", [1.0, 0.0, 0.0], |p| p[0] == 1.0);
        group_facets(&mut file, "b", [0.0, 1.0, 0.0], |p| p[1] == 2.0);
        let nodes = file.points.len();
        for (block, place, value) in spoilt {
            let count = file.blocks.len();
            let list = &mut file.blocks[block % count].nodes;
            let length = list.len();
            list[place % length] = (value % nodes) as u32;
        }
        let mut asked = request_on(&["a"]);
        asked.surfaces = vec!["a".into(), "b".into()];
        asked.raise_order = raise.then_some(2);
        match build(&file, &asked, "spoilt.msh") {
            // A facet may have been made another one, or a node may be what it was.
            Ok(mesh) => prop_assert!(mesh.cells() > 0 && !dual_graph(&mesh).work.is_empty()),
            Err(error) => prop_assert_eq!(error.exit_status(), 2),
        }
    }
}

#[test]
fn thin_cells_are_cells() {
    let mut file = block(Kind::Hex8, [2, 2, 2]);
    file.points.iter_mut().for_each(|point| point[2] *= 1e-7);
    made(&file, &Request { scale: 1e-3, ..request() });
    for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_says(&said(&file, &Request { scale, ..request() }), &["`scale` is"]);
    }
}

#[test]
fn copies_of_cells_are_one_cell_in_several_groups_or_wrong() {
    let mut file = block(Kind::Hex8, [2, 1, 1]);
    group_cells(&mut file, "a", |p| p[0] < 1.0);
    group_cells(&mut file, "b", |p| p[0] > 1.0);
    let nodes = file.blocks[0].nodes[..8].to_vec();
    let c = group(&mut file, "c", 3);
    let mut twice = file.clone();
    add(&mut twice, Kind::Hex8, nodes.clone(), Some(c));
    let mesh = made(&twice, &materials(&[("one", &["c"]), ("other", &["b"])]));
    assert_eq!(mesh.materials, [0, 1]);
    assert_says(
        &said(&twice, &materials(&[("one", &["c"]), ("other", &["a", "b"])])),
        &["in the materials `one` and `other` at once: the hexahedron of 8 nodes number 1 at"],
    );
    for (of, order) in [(None, 0), (Some(0), 0), (Some(c), 4)] {
        let mut twice = file.clone();
        let mut nodes = nodes.clone();
        nodes.rotate_left(order);
        add(&mut twice, Kind::Hex8, nodes, of);
        let what = if order == 0 { "are the same cell" } else { "have the same corners" };
        assert_says(&said(&twice, &request()), &["elements 1 and 3", what]);
    }
    let mut file = block(Kind::Quad4, [2, 1, 0]);
    file.blocks[0].nodes[1] = 0;
    assert_says(&said(&file, &request()), &["number 1 at", "has a node twice"]);
}

#[test]
fn cells_that_overlap_are_refused() {
    let mut file = block(Kind::Tri3, [2, 1, 0]);
    file.points.push([1.2, 0.6, 0.0]);
    file.node_numbers.push(7);
    let last = file.points.len() as u32 - 1;
    // A third triangle on the side from (1, 0) to (1, 1), to its right.
    add(&mut file, Kind::Tri3, vec![1, last, 4], None);
    let text = said(&file, &request());
    assert_says(&text, &["3 cells (elements 1, 4, 5) share one facet", "(1, 0.5, 0) m"]);
    let mut file = block(Kind::Tri3, [1, 1, 0]);
    file.points.push([0.5, 1.0, 0.0]);
    file.node_numbers.push(5);
    add(&mut file, Kind::Tri3, vec![0, 1, 4], None);
    let text = said(&file, &request());
    assert_says(&text, &["elements 1 and 3 meet", "lie on the same side"]);
}

#[test]
fn bodies_that_touch_share_nodes_or_an_interface() {
    let mut lower = block(Kind::Tet4, [2, 2, 1]);
    group_facets(&mut lower, "top", [0.0, 0.0, 1.0], |p| p[2] == 1.0);
    let mut upper = lower.clone();
    upper.groups[0].name = "roof".into();
    group_facets(&mut upper, "bottom", [0.0, 0.0, 1.0], |p| p[2] == 0.0);
    for by in [[0.0, 0.0, 1.0], [1e-11, 0.0, 1.0]] {
        let file = two(&lower, &upper, by);
        let text = said(&file, &request());
        let parts = [
            "9 nodes lie at the place of another node, the first at (0, 0, 1) m (nodes 10 and 19)",
            "8 pairs of facets lie on each other",
            "`between`",
            "hinged",
        ];
        assert_says(&text, &parts);
        made(&file, &request_between("top", "bottom"));
    }
    made(&two(&lower, &upper, [0.0, 0.0, 1.0 + 1e-6]), &request());
    // A single node at one place with another one, without common facets.
    let text = said(&two(&lower, &upper, [2.0, 2.0, 1.0]), &request());
    assert_says(&text, &["1 node lies at the place", "(2, 2, 1) m", "Merge nodes"]);
}

#[test]
fn bodies_whose_meshes_do_not_match_touch_by_an_interface() {
    for kind in [Kind::Hex8, Kind::Tet4, Kind::Prism6, Kind::Quad4, Kind::Tri3] {
        // The upper body is of half the size and moved, so that no nodes are at one place.
        let up = if kind.dim() == 2 { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] };
        let axis = kind.dim() - 1;
        let mut lower = block(kind, [2, 2, 2]);
        group_facets(&mut lower, "top", up, |p| p[axis] == 2.0);
        let mut upper = block(kind, [2, 2, 2]);
        upper.points.iter_mut().for_each(|point| *point = point.map(|x| 0.5 * x));
        group_facets(&mut upper, "bottom", up, |p| p[axis] == 0.0);
        let mut by = if kind.dim() == 2 { [0.3, 2.0, 0.0] } else { [0.3, 0.4, 2.0] };
        let file = two(&lower, &upper, by);
        let text = said(&file, &request());
        let nodes = if kind.dim() == 2 { "4 nodes lie on" } else { "lie on a facet" };
        assert_says(&text, &[nodes, "of another body", "`between`"]);
        made(&file, &request_between("top", "bottom"));
        by[axis] += 1e-4;
        made(&two(&lower, &upper, by), &request());
    }
    // Sides that bend, flush at the rim, where the finer one bulges into the other body.
    let mut lower = block(Kind::Hex8, [1, 1, 1]);
    group_facets(&mut lower, "top", [0.0, 0.0, 1.0], |p| p[2] == 1.0);
    let mut upper = block(Kind::Hex8, [2, 1, 1]);
    group_facets(&mut upper, "bottom", [0.0, 0.0, 1.0], |p| p[2] == 0.0);
    upper.points.iter_mut().for_each(|p| p[0] *= 0.5);
    upper.points.iter_mut().filter(|p| p[0] == 0.5 && p[2] == 0.0).for_each(|p| p[2] -= 0.02);
    let file = two(&lower, &upper, [0.0, 0.0, 1.0]);
    made(&file, &request_between("top", "bottom"));
    let text = said(&file, &request());
    assert_says(&text, &["at the place of another node"]);
    // A node in the middle of a square, which is on the diagonal of its halves.
    let mut upper = block(Kind::Hex8, [1, 1, 1]);
    upper.points.iter_mut().for_each(|point| point[2] += 1.0);
    upper.points.iter_mut().for_each(|p| (p[0], p[1]) = (0.5 + p[0] - p[1], 0.5 + p[0] + p[1]));
    let text = said(&two(&block(Kind::Hex8, [1, 1, 1]), &upper, [0.0; 3]), &request());
    assert_says(&text, &["1 node lies on a facet of another body", "first at (0.5, 0.5, 1) m"]);
}

#[test]
fn facets_of_groups_lie_on_cells() {
    let mut file = block(Kind::Hex8, [2, 2, 2]);
    group_facets(&mut file, "side", [1.0, 0.0, 0.0], |p| p[0] == 0.0);
    let side = group(&mut file, "side", 2);
    add(&mut file, Kind::Tri3, vec![0, 1, 2], Some(side));
    let asked = Request { surfaces: vec!["side".into()], ..request() };
    let text = said(&file, &asked);
    assert_says(&text, &["1 facet of the group `side` lies on no cell", "number 13 at (1, 0, 0)"]);
    let text = said(&file, &request_on(&["side"]));
    assert_says(&text, &["lies on no cell"]);
    // Nobody asks for it: nobody is disturbed.
    made(&file, &request());

    file.points.push([9.0; 3]);
    file.node_numbers.push(28);
    let edge = group(&mut file, "edge", 1);
    add(&mut file, Kind::Line2, vec![0, 27], Some(edge));
    let asked = Request { surfaces: vec!["edge".into()], ..request() };
    assert_says(&said(&file, &asked), &["1 edge of the group `edge` lies on no cell"]);
    let lonely = group(&mut file, "lonely", 0);
    file.node_groups.push((lonely, vec![27]));
    let asked = Request { surfaces: vec!["lonely".into()], ..request() };
    assert_says(&said(&file, &asked), &["no node of the group belongs to a cell"]);
    let mesh = made(&file, &request());
    assert_eq!(mesh.points.len(), 27);
    assert!(mesh.remarks.iter().any(|remark| remark == "nodes of no cell, left out: 1"));
}

#[test]
fn groups_of_cells_are_no_surfaces() {
    let mut file = block(Kind::Hex8, [1, 1, 1]);
    group_cells(&mut file, "rock", |_| true);
    let asked = |name: &str| Request { surfaces: vec![name.into()], ..request() };
    let text = said(&file, &asked("rock"));
    assert_says(&text, &["surface `rock`: the group `rock` has cells, not facets, edges"]);
    let text = said(&file, &asked("top"));
    assert_says(&text, &["there is no group `top`", "cells rock (1)"]);
    let text = said(&block(Kind::Hex8, [1, 1, 1]), &asked("top"));
    assert_says(&text, &["the file has no groups"]);
}

#[test]
fn plane_meshes_lie_in_their_plane() {
    let mut file = block(Kind::Quad4, [2, 2, 0]);
    file.points.iter_mut().for_each(|point| point[2] = 1e-12);
    let mesh = made(&file, &request());
    assert_eq!((mesh.axes, mesh.points[3][2]), (&[0, 1][..], 0.0));
    file.points.iter_mut().for_each(|point| point[2] = 3.0);
    assert_says(&said(&file, &request()), &["plane z = 3 m; move them to z = 0"]);
    file.points.iter_mut().for_each(|point| point.swap(1, 2));
    assert_says(&said(&file, &request()), &["z runs from 0 to 2 m"]);
    file.blocks.clear();
    add(&mut file, Kind::Line2, vec![0, 1], None);
    assert_says(&said(&file, &request()), &["there are no cells in it"]);
}

#[test]
fn simplices_of_first_order_are_told_to_lock() {
    let locks = |kind, raise_order| {
        let mesh = made(&block(kind, [1, 1, 1]), &Request { raise_order, ..request() });
        mesh.remarks.iter().any(|remark| remark.contains("`mesh.raise_order: 2`"))
    };
    assert!(locks(Kind::Tet4, None) && locks(Kind::Tri3, None));
    assert!(!locks(Kind::Tet4, Some(2)) && !locks(Kind::Hex8, None) && !locks(Kind::Quad4, None));
}
