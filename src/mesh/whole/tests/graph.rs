//! The dual graph.

use super::blocks::{block, group_facets, made, request, request_between, request_on, two};
use crate::mesh::import::Kind;
use crate::mesh::whole::{WholeMesh, dual_graph};

/// The edges (from, to, weight), after a look at the form.
fn edges(mesh: &WholeMesh) -> Vec<[i32; 3]> {
    let graph = dual_graph(mesh);
    assert_eq!(graph.start.len(), mesh.cells() + 1);
    assert_eq!(*graph.start.last().expect("it begins with 0"), graph.neighbours.len() as i32);
    let nodes = mesh.shapes.iter().map(|shape| shape.nodes() as i32);
    assert_eq!(graph.work, nodes.collect::<Vec<_>>());
    let mut all = Vec::new();
    for cell in 0..mesh.cells() {
        for place in graph.start[cell] as usize..graph.start[cell + 1] as usize {
            all.push([cell as i32, graph.neighbours[place], graph.weights[place]]);
        }
    }
    for [from, to, weight] in &all {
        assert!(all.contains(&[*to, *from, *weight]), "both ends tell of an edge");
    }
    all
}

#[test]
fn cells_that_share_a_facet_or_face_each_other_are_joined() {
    let mut file = block(Kind::Hex8, [2, 2, 1]);
    group_facets(&mut file, "a", [1.0, 0.0, 0.0], |p| p[0] == 1.0);
    let whole = edges(&made(&file, &request()));
    assert_eq!(whole.len(), 8);
    assert!(whole.iter().all(|edge| edge[2] == 1));
    let cut = edges(&made(&file, &request_on(&["a"])));
    let expected = [[0, 1, 4], [0, 2, 1], [1, 0, 4], [1, 3, 1], [2, 0, 1], [2, 3, 4]];
    assert_eq!(cut[..6], expected);
    assert_eq!(cut[6..], [[3, 1, 1], [3, 2, 4]]);
}

#[test]
fn facets_that_do_not_match_face_all_that_they_touch() {
    let mut lower = block(Kind::Quad4, [1, 1, 0]);
    group_facets(&mut lower, "top", [0.0, 1.0, 0.0], |p| p[1] == 1.0);
    let mut upper = block(Kind::Quad4, [2, 1, 0]);
    upper.points.iter_mut().for_each(|point| point[0] *= 0.5);
    group_facets(&mut upper, "bottom", [0.0, 1.0, 0.0], |p| p[1] == 0.0);
    let mesh = made(&two(&lower, &upper, [0.0, 1.0, 0.0]), &request_between("top", "bottom"));
    let expected = [[0, 1, 4], [0, 2, 4], [1, 0, 4], [1, 2, 1], [2, 0, 4], [2, 1, 1]];
    assert_eq!(edges(&mesh), expected);
}
