//! Normals at the nodes of a surface.

use std::collections::BTreeMap;

use super::facet::SpaceFacet;
use super::vector::{Vector, unit};
use crate::error::{Error, Result};

/// The unit normal at each node of a set of facets, by rising node: the mean of the normals that
/// the facets have at that node, each weighted with the area of its facet.
///
/// Local: a node whose facets are on several ranks needs all of them here.
///
/// # Errors
/// `Input` where a facet has no area, or the facets about a node are folded onto each other, so
/// that the mean has no direction.
pub fn nodal_normals(facets: &[SpaceFacet]) -> Result<Vec<(u64, [f64; 3])>> {
    let mut sums: BTreeMap<u64, (Vector, f64)> = BTreeMap::new();
    for facet in facets {
        let area = facet.area();
        for (node, xi) in facet.nodes().iter().zip(facet.shape().node_points()) {
            let Some(normal) = unit(facet.normal(*xi)) else { return Err(no_normal(facet, *xi)) };
            let (sum, weight) = sums.entry(*node).or_default();
            (0..3).for_each(|d| sum[d] += area * normal[d]);
            *weight += area;
        }
    }
    let mean = |(node, (sum, weight)): (u64, (Vector, f64))| {
        let mean = sum.map(|x| x / weight);
        // Facets at right angles all around still add up to more than half of their area.
        match unit(mean).filter(|_| super::vector::norm(mean) > FOLDED) {
            Some(normal) => Ok((node, normal)),
            None => Err(Error::Input(format!(
                "the facets of an interface about node {node} are folded onto each other: they \
                 have no common normal there; split the interface where it folds"
            ))),
        }
    };
    sums.into_iter().map(mean).collect()
}

/// Means shorter than this come of a fold.
const FOLDED: f64 = 0.1;

fn no_normal(facet: &SpaceFacet, xi: [f64; 3]) -> Error {
    let [x, y, z] = facet.point(xi);
    Error::Input(format!(
        "a facet of an interface has no normal at ({x:.6}, {y:.6}, {z:.6}) m: check the shape of \
         the cells there"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Shape;

    const AXES: [usize; 3] = [0, 1, 2];

    #[test]
    fn all_nodes_of_a_plane_have_its_normal() {
        // Unequal facets in the plane with the normal (1, 2, 2) / 3.
        let (u, v) = ([2.0, 1.0, -2.0], [2.0, -2.0, 1.0]);
        let at = |a: f64, b: f64| std::array::from_fn(|d| 7.0 + a * u[d] + b * v[d]);
        let places = [at(0.0, 0.0), at(0.3, 0.1), at(0.4, 0.9), at(-0.2, 0.5), at(1.5, 0.3)];
        let facet = |shape: Shape, nodes: &[u64]| {
            let points: Vec<[f64; 3]> = nodes.iter().map(|n| places[*n as usize]).collect();
            SpaceFacet::new(shape, nodes, &points, &AXES)
        };
        let facets = [facet(Shape::Quad4, &[0, 3, 2, 1]), facet(Shape::Tri3, &[2, 4, 1])];
        let normals = nodal_normals(&facets).unwrap();
        assert_eq!(normals.iter().map(|n| n.0).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
        for (node, normal) in normals {
            for (found, exact) in normal.iter().zip([1.0, 2.0, 2.0]) {
                assert!((found - exact / 3.0).abs() < 1e-15, "{node} {normal:?}");
            }
        }
    }

    #[test]
    fn curved_facets_give_the_normal_at_the_node_and_areas_weigh() {
        let parabola = [[0.0, 0.0, 0.0], [2.0, 0.0, 4.0], [1.0, 0.0, 1.0]];
        let line = SpaceFacet::new(Shape::Line3, &[5, 6, 7], &parabola, &[0, 2]);
        let normals = nodal_normals(&[line]).unwrap();
        for ((node, normal), slope) in normals.into_iter().zip([0.0, 4.0, 2.0]) {
            let exact: [f64; 3] = [slope, 0.0, -1.0].map(|x: f64| x / slope.hypot(1.0));
            assert!((0..3).all(|d| (normal[d] - exact[d]).abs() < 1e-15), "{node} {normal:?}");
        }
        let corner = [([0.0, 0.0, 0.0], [3.0, 0.0, 0.0]), ([3.0, 0.0, 0.0], [3.0, 1.0, 0.0])];
        let lines: Vec<SpaceFacet> = corner
            .iter()
            .zip([[0, 1], [1, 2]])
            .map(|((a, b), nodes)| SpaceFacet::new(Shape::Line2, &nodes, &[*a, *b], &[0, 1]))
            .collect();
        let (_, normal) = nodal_normals(&lines).unwrap()[1];
        assert!((normal[1] / normal[0] + 3.0).abs() < 1e-14, "{normal:?}");
    }

    #[test]
    fn folds_and_facets_without_area_are_refused() {
        let [a, b] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        let line = |nodes: [u64; 2], points: [[f64; 3]; 2]| {
            SpaceFacet::new(Shape::Line2, &nodes, &points, &[0, 1])
        };
        let Err(Error::Input(message)) =
            nodal_normals(&[line([0, 1], [a, b]), line([1, 2], [b, a])])
        else {
            panic!("accepted");
        };
        assert!(message.contains("about node 1 are folded"), "{message}");
        assert!(matches!(nodal_normals(&[line([0, 1], [a, a])]), Err(Error::Input(_))));
    }
}
