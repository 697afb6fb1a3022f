//! The dual graph.

use super::blocks::{block, group_facets, made, request, request_between, request_on, two};
use crate::mesh::import::Kind;
use crate::mesh::whole::{InterfacePlace, WholeMesh, dual_graph, facing};

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

/// Pairs of cells, each with one facet on its lip, of a row of so many unit squares and one above
/// it of squares of half the size, whose columns begin `rise` above the row.
fn seen(has_gap: bool, rise: impl Fn(f64) -> f64) -> Vec<[u32; 2]> {
    let mut lower = block(Kind::Quad4, [4, 1, 0]);
    group_facets(&mut lower, "top", [0.0, 1.0, 0.0], |p| p[1] == 1.0);
    let mut upper = block(Kind::Quad4, [8, 1, 0]);
    group_facets(&mut upper, "bottom", [0.0, 1.0, 0.0], |p| p[1] == 0.0);
    for point in &mut upper.points {
        point[0] *= 0.5;
        point[1] += rise(point[0]);
    }
    let mut request = request_between("top", "bottom");
    if let InterfacePlace::Between { has_gap: has, .. } = &mut request.interfaces[0].place {
        *has = has_gap;
    }
    let mesh = made(&two(&lower, &upper, [0.0, 1.0, 0.0]), &request);
    facing(&mesh, &mesh.interfaces[0]).iter().map(|pair| pair.map(|facet| facet.cell)).collect()
}

#[test]
fn facets_see_each_other_across_a_gap() {
    let over = |pairs: &[[u32; 2]]| {
        (0..8).all(|i| pairs.contains(&[i / 2, 4 + i])) && pairs.windows(2).all(|p| p[0] < p[1])
    };
    // Up to half the length of the row, whichever side looks.
    for rise in [0.0, 0.2, 0.9, 1.9] {
        let pairs = seen(true, |_| rise);
        assert!(over(&pairs), "{rise}: {pairs:?}");
    }
    assert!(over(&seen(true, |x| 0.1 * x * x)));
    assert!(seen(true, |_| 4.0).is_empty());
    // What lies on each other has no reach.
    assert!(over(&seen(false, |_| 0.0)));
    assert!(seen(false, |_| 0.2).is_empty());
}
