//! What holds for every reference cell.

use super::*;

/// Points inside every reference cell of the dimension, and some elsewhere.
const POINTS: [[f64; 3]; 4] =
    [[0.1, 0.2, 0.3], [0.3, -0.7, 0.9], [-1.0, 1.0, 0.25], [0.25, 0.125, 0.0625]];

fn values(shape: Shape, xi: [f64; 3]) -> Vec<f64> {
    let mut out = [9.0; MAX_NODES];
    shape.values(xi, &mut out);
    assert!(out[shape.nodes()..].iter().all(|value| *value == 9.0));
    out[..shape.nodes()].to_vec()
}

fn gradients(shape: Shape, xi: [f64; 3]) -> Vec<[f64; 3]> {
    let mut out = [[9.0; 3]; MAX_NODES];
    shape.gradients(xi, &mut out);
    out[..shape.nodes()].to_vec()
}

fn minus<const N: usize>(a: [f64; N], b: [f64; N]) -> [f64; N] {
    std::array::from_fn(|d| a[d] - b[d])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|d| a[d] * b[d]).sum()
}

fn cross(u: [f64; 3], v: [f64; 3]) -> [f64; 3] {
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// Sum of the values times those at the nodes.
fn combine(values: &[f64], nodes: impl Iterator<Item = [f64; 3]>) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (value, x) in values.iter().zip(nodes) {
        (0..3).for_each(|d| sum[d] += value * x[d]);
    }
    sum
}

/// Derivatives of the position with respect to each reference coordinate.
fn tangents(shape: Shape, nodes: &[[f64; 3]], xi: [f64; 3]) -> [[f64; 3]; 3] {
    let gradients = gradients(shape, xi);
    std::array::from_fn(|d| {
        let slopes: Vec<f64> = gradients.iter().map(|g| g[d]).collect();
        combine(&slopes, nodes.iter().copied())
    })
}

#[test]
fn values_sum_to_one_and_gradients_to_zero() {
    for shape in Shape::ALL {
        for xi in POINTS {
            assert!((values(shape, xi).iter().sum::<f64>() - 1.0).abs() < 1e-14, "{shape:?}");
            for d in 0..3 {
                let sum: f64 = gradients(shape, xi).iter().map(|g| g[d]).sum();
                assert!(sum.abs() < 1e-14, "{shape:?} {d}");
                let is_zero = gradients(shape, xi).iter().all(|g| g[d] == 0.0);
                assert_eq!(is_zero, d >= shape.dim());
            }
        }
    }
}

#[test]
fn each_function_is_one_at_its_node_and_zero_at_the_others() {
    for shape in Shape::ALL {
        assert_eq!(shape.node_points().len(), shape.nodes());
        for (a, &node) in shape.node_points().iter().enumerate() {
            for (b, &value) in values(shape, node).iter().enumerate() {
                assert_eq!(value, if a == b { 1.0 } else { 0.0 }, "{shape:?} {a} {b}");
            }
        }
    }
}

#[test]
fn gradients_are_the_differences_of_the_values() {
    for shape in Shape::ALL {
        // At most quadratic in each coordinate: the central difference is exact; not in a pyramid.
        let (step, near) =
            if shape.family() == Family::Pyramid { (1e-4, 1e-5) } else { (1e-3, 1e-12) };
        for xi in POINTS {
            let gradients = gradients(shape, xi);
            for d in 0..shape.dim() {
                let (mut ahead, mut behind) = (xi, xi);
                ahead[d] += step;
                behind[d] -= step;
                let (plus, minus) = (values(shape, ahead), values(shape, behind));
                for a in 0..shape.nodes() {
                    let difference = (plus[a] - minus[a]) / (2.0 * step);
                    let error = gradients[a][d] - difference;
                    assert!(error.abs() < near, "{shape:?} {xi:?} {a} {d}: {error:e}");
                }
            }
        }
    }
}

#[test]
fn the_basis_holds_the_polynomials_of_its_order() {
    for shape in Shape::ALL {
        let powers = (0..27).map(|i| [i % 3, i / 3 % 3, i / 9]);
        let fits = |p: &[i32; 3]| p.iter().sum::<i32>() <= shape.order() as i32;
        for powers in powers.filter(fits) {
            let of =
                |x: [f64; 3]| -> f64 { (0..shape.dim()).map(|d| x[d].powi(powers[d])).product() };
            for xi in POINTS {
                let nodes = shape.node_points().iter();
                let sum: f64 = nodes.zip(values(shape, xi)).map(|(x, value)| value * of(*x)).sum();
                assert!((sum - of(xi)).abs() < 1e-14, "{shape:?} {powers:?}");
            }
        }
        for xi in POINTS {
            let tangents = tangents(shape, shape.node_points(), xi);
            for (d, tangent) in tangents.iter().enumerate().take(shape.dim()) {
                for (e, found) in tangent.iter().enumerate() {
                    assert!((found - f64::from(u8::from(d == e))).abs() < 1e-14, "{shape:?}");
                }
            }
        }
    }
}

#[test]
fn the_corners_are_the_first_nodes_and_the_others_lie_between_them() {
    for shape in Shape::ALL {
        let corners = shape.corners();
        assert_eq!((corners.order(), corners.dim()), (1, shape.dim()));
        assert_eq!(corners.family(), shape.family());
        assert_eq!(shape.node_points()[..corners.nodes()], *corners.node_points());
        if shape.family() == Family::Cube {
            assert_eq!(Shape::of(shape.dim(), shape.order()), shape);
        }
    }
}

#[test]
fn facets_look_outwards_and_are_numbered_as_their_own_shape() {
    for shape in Shape::ALL.into_iter().filter(|s| s.dim() > 1) {
        let nodes = shape.node_points();
        for (i, facet) in shape.facets().iter().enumerate() {
            let of = shape.facet_shape(i).unwrap();
            assert_eq!((of.dim(), of.order()), (shape.dim() - 1, shape.order()));
            let p: Vec<[f64; 3]> = facet.iter().map(|&a| nodes[a]).collect();
            assert_eq!(p.len(), of.nodes(), "{shape:?} {i}");
            // Each node of the facet stands where the facet's own numbering has it.
            for (x, xi) in p.iter().zip(of.node_points()) {
                let at_corners = values(of.corners(), *xi);
                assert_eq!(*x, combine(&at_corners, p.iter().copied()), "{shape:?} {i}");
            }
            let [u, v, _] = tangents(of, &p, of.centroid());
            let normal = if shape.dim() == 2 { [u[1], -u[0], 0.0] } else { cross(u, v) };
            for node in nodes {
                let behind = dot(normal, minus(*node, p[0]));
                let is_there = if p.contains(node) { behind.abs() < 1e-15 } else { behind < -0.1 };
                assert!(is_there, "{shape:?} {i}");
            }
        }
    }
    for i in 0..2 {
        assert_eq!(Shape::Line3.facet_shape(i), None);
    }
}

#[test]
fn on_a_facet_the_basis_is_that_of_the_facet() {
    // So that cells of different families that share a facet fit together.
    for shape in Shape::ALL.into_iter().filter(|s| s.dim() > 1) {
        for (i, facet) in shape.facets().iter().enumerate() {
            let of = shape.facet_shape(i).unwrap();
            let nodes = shape.node_points();
            for p in quadrature(of, 5) {
                let own = values(of, p.xi);
                let there = combine(&own, facet.iter().map(|&a| nodes[a]));
                for (a, value) in values(shape, there).into_iter().enumerate() {
                    let expected = facet.iter().position(|b| *b == a).map_or(0.0, |b| own[b]);
                    assert!((value - expected).abs() < 1e-14, "{shape:?} {i} {a}");
                }
            }
        }
    }
}

#[test]
fn every_edge_belongs_to_two_facets_that_run_along_it_opposite_ways() {
    for shape in Shape::ALL.into_iter().filter(|s| s.dim() == 3) {
        let mut edges = Vec::new();
        for (i, facet) in shape.facets().iter().enumerate() {
            let corners = shape.facet_shape(i).unwrap().corners().nodes();
            edges.extend((0..corners).map(|c| (facet[c], facet[(c + 1) % corners])));
        }
        let opposite = |(a, b): &(usize, usize)| edges.iter().filter(|e| **e == (*b, *a)).count();
        assert!(edges.iter().all(|edge| opposite(edge) == 1), "{shape:?}");
    }
}

/// The cell with its nodes moved, smoothly or not: corners and middles each by their own amount.
fn distorted<const DIM: usize>(shape: Shape) -> Vec<[f64; DIM]> {
    let shift = |a: usize, i: usize| 0.06 * ((7 * a + 3 * i * i + 1) as f64).sin();
    let nodes = shape.node_points().iter().enumerate();
    nodes.map(|(a, x)| std::array::from_fn(|i| x[i] + shift(a, i))).collect()
}

/// Area of the facets in each direction, and volume by the divergence theorem.
fn by_facets(shape: Shape, nodes: &[[f64; 3]]) -> ([f64; 3], f64) {
    let (mut areas, mut volume) = ([0.0; 3], 0.0);
    for (i, facet) in shape.facets().iter().enumerate() {
        let of = shape.facet_shape(i).unwrap();
        let p: Vec<[f64; 3]> = facet.iter().map(|&a| nodes[a]).collect();
        for point in quadrature(of, 5) {
            let [u, v, _] = tangents(of, &p, point.xi);
            let normal = if shape.dim() == 2 { [u[1], -u[0], 0.0] } else { cross(u, v) };
            let x = combine(&values(of, point.xi), p.iter().copied());
            volume += point.weight * dot(x, normal) / shape.dim() as f64;
            (0..3).for_each(|d| areas[d] += point.weight * normal[d]);
        }
    }
    (areas, volume)
}

fn by_mapping<const DIM: usize>(shape: Shape, nodes: &[[f64; DIM]]) -> f64 {
    let of = |p: &QuadraturePoint| {
        let determinant = mapping(shape, nodes, p.xi).determinant;
        assert!(determinant > 0.0, "{shape:?}");
        p.weight * determinant
    };
    quadrature(shape, 5).iter().map(of).sum()
}

fn volumes<const DIM: usize>(shape: Shape) {
    let lifted = |nodes: &[[f64; DIM]]| -> Vec<[f64; 3]> {
        let of = |x: &[f64; DIM]| std::array::from_fn(|d| if d < DIM { x[d] } else { 0.0 });
        nodes.iter().map(of).collect()
    };
    let (areas, volume) = by_facets(shape, shape.node_points());
    assert!((volume - shape.volume()).abs() < 1e-14, "{shape:?}");
    assert!(areas.iter().all(|area| area.abs() < 1e-14));
    let cell = distorted::<DIM>(shape);
    let (areas, volume) = by_facets(shape, &lifted(&cell));
    assert!(areas.iter().all(|area| area.abs() < 1e-14), "{shape:?}");
    let found = by_mapping(shape, &cell);
    assert!((found - volume).abs() < 1e-14, "{shape:?}: {found} {volume}");
    assert!((found - shape.volume()).abs() > 1e-4, "{shape:?} is not distorted");
}

#[test]
fn a_distorted_cell_has_the_volume_that_its_facets_enclose() {
    for shape in Shape::ALL {
        match shape.dim() {
            2 => volumes::<2>(shape),
            3 => volumes::<3>(shape),
            _ => {}
        }
    }
}

fn linear_gradient<const DIM: usize>(shape: Shape, xi: [f64; 3]) {
    let cell = distorted::<DIM>(shape);
    let map = mapping(shape, &cell, xi);
    let slope = [3.0, -5.0, 7.0];
    let mut gradient = [0.0; 3];
    for (x, reference) in cell.iter().zip(gradients(shape, xi)) {
        let value: f64 = x.iter().zip(slope).map(|(x, s)| x * s).sum();
        let part = map.gradient(reference, DIM);
        (0..3).for_each(|d| gradient[d] += value * part[d]);
    }
    for d in 0..DIM {
        assert!((gradient[d] - slope[d]).abs() < 1e-12, "{shape:?}: {gradient:?}");
    }
}

#[test]
fn the_gradient_of_a_linear_function_is_exact_in_a_distorted_cell() {
    for shape in Shape::ALL {
        for p in stiffness_rule(shape) {
            match shape.dim() {
                2 => linear_gradient::<2>(shape, p.xi),
                3 => linear_gradient::<3>(shape, p.xi),
                _ => {}
            }
        }
    }
}

#[test]
fn a_mirrored_facet_is_the_same_facet() {
    for shape in Shape::ALL.into_iter().filter(|s| s.dim() < 3) {
        let (points, order) = (shape.node_points(), shape.mirrored());
        let mut same = order.to_vec();
        same.sort_unstable();
        assert_eq!(same, (0..shape.nodes()).collect::<Vec<_>>());
        // Exchanging the axes (a line: turning the axis) takes each node to its mirror image.
        for (point, other) in points.iter().zip(order) {
            let [x, y, z] = points[*other];
            let image = if shape.dim() == 1 { [-x, y, z] } else { [y, x, z] };
            assert_eq!(*point, image, "{shape:?}");
        }
    }
}

#[test]
fn at_the_apex_of_a_pyramid_gradients_are_those_on_its_axis() {
    let at = |z: f64| gradients(Shape::Pyramid5, [0.0, 0.0, z]);
    assert_eq!(at(1.0), at(0.5));
}
