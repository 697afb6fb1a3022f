use super::*;
use crate::element::{MAX_NODES, mapping};

fn factorial(n: usize) -> f64 {
    (1..=n).map(|i| i as f64).product()
}

/// The integral of x^i over [-1, 1].
fn on_line(i: usize) -> f64 {
    if i % 2 == 1 { 0.0 } else { 2.0 / (i + 1) as f64 }
}

/// The integral of the monomial over the reference cell.
fn exact(shape: Shape, [i, j, k]: [usize; 3]) -> f64 {
    match (shape.family(), shape.dim()) {
        (Family::Cube, dim) => [i, j, k][..dim].iter().map(|i| on_line(*i)).product(),
        (Family::Simplex, dim) => {
            factorial(i) * factorial(j) * factorial(k) / factorial(i + j + k + dim)
        }
        (Family::Prism, _) => factorial(i) * factorial(j) / factorial(i + j + 2) * on_line(k),
        (Family::Pyramid, _) => {
            let upwards = factorial(k) * factorial(i + j + 2) / factorial(i + j + k + 3);
            on_line(i) * on_line(j) * upwards
        }
    }
}

/// The monomials that a rule of this degree integrates.
fn monomials(shape: Shape, degree: usize) -> Vec<[usize; 3]> {
    let most = |d: usize| if d < shape.dim() { degree } else { 0 };
    let all = (0..=most(0))
        .flat_map(|i| (0..=most(1)).flat_map(move |j| (0..=most(2)).map(move |k| [i, j, k])));
    all.filter(|[i, j, k]| match shape.family() {
        Family::Cube => true,
        Family::Prism => i + j <= degree,
        _ => i + j + k <= degree,
    })
    .collect()
}

fn integral(rule: &[QuadraturePoint], f: impl Fn([f64; 3]) -> f64) -> f64 {
    rule.iter().map(|p| p.weight * f(p.xi)).sum()
}

fn monomial(xi: [f64; 3], powers: [usize; 3]) -> f64 {
    (0..3).map(|d| xi[d].powi(powers[d] as i32)).product()
}

/// How far inside the reference cell a point lies: the least of what is positive there.
fn depth(shape: Shape, [x, y, z]: [f64; 3]) -> f64 {
    let all = match (shape.family(), shape.dim()) {
        (Family::Cube, _) => vec![1.0 - x.abs(), 1.0 - y.abs(), 1.0 - z.abs()],
        (Family::Simplex, 2) => vec![x, y, 1.0 - x - y],
        (Family::Simplex, _) => vec![x, y, z, 1.0 - x - y - z],
        (Family::Prism, _) => vec![x, y, 1.0 - x - y, 1.0 - z.abs()],
        (Family::Pyramid, _) => vec![1.0 - z - x.abs(), 1.0 - z - y.abs(), z],
    };
    all.into_iter().fold(f64::INFINITY, f64::min)
}

#[test]
fn rules_on_the_triangle_have_any_degree() {
    for degree in [0, 5, 8, 9, 16, 31] {
        let rule = quadrature_on_triangle(degree);
        assert!(rule.iter().all(|p| p.weight > 0.0 && depth(Shape::Tri3, p.xi) > 0.0));
        for powers in monomials(Shape::Tri3, degree) {
            let found = integral(&rule, |xi| monomial(xi, powers));
            let exact = exact(Shape::Tri3, powers);
            assert!((found - exact).abs() < 1e-13 * exact, "{powers:?} {found} {exact}");
        }
    }
}

#[test]
fn rules_integrate_every_monomial_of_their_degree_with_positive_weights_inside() {
    for shape in Shape::ALL {
        for degree in 0..=MAX_DEGREE {
            let rule = quadrature(shape, degree);
            assert!(rule.iter().all(|p| p.weight > 0.0 && depth(shape, p.xi) > 1e-5));
            let volume: f64 = rule.iter().map(|p| p.weight).sum();
            assert!((volume - shape.volume()).abs() < 1e-15 * shape.volume(), "{shape:?} {degree}");
            for powers in monomials(shape, degree) {
                let error = integral(&rule, |xi| monomial(xi, powers)) - exact(shape, powers);
                assert!(
                    error.abs() < 1e-15 * shape.volume(),
                    "{shape:?} {degree} {powers:?}: {error:e}"
                );
            }
            for d in 0..shape.dim() {
                let centre = integral(&rule, |xi| xi[d]) / shape.volume();
                assert!(degree == 0 || (centre - shape.centroid()[d]).abs() < 1e-15);
            }
        }
    }
}

#[test]
fn rules_have_no_more_points_than_the_degree_needs() {
    let counts = |shape: Shape| [1, 2, 3, 4, 5, 8].map(|degree| quadrature(shape, degree).len());
    assert_eq!(counts(Shape::Line2), [1, 2, 2, 3, 3, 5]);
    assert_eq!(counts(Shape::Tri6), [1, 3, 6, 6, 7, 25]);
    assert_eq!(counts(Shape::Tet4), [1, 4, 8, 14, 14, 125]);
    assert_eq!(counts(Shape::Prism18), [1, 6, 12, 18, 21, 125]);
    assert_eq!(counts(Shape::Pyramid5), [1, 8, 8, 27, 27, 125]);
}

#[test]
fn a_rule_of_too_low_a_degree_is_not_exact() {
    for shape in Shape::ALL {
        for degree in [1, 2, 3, 5] {
            let misses = |of: usize| {
                let rule = quadrature(shape, degree);
                let error = |powers: &[usize; 3]| {
                    (integral(&rule, |xi| monomial(xi, *powers)) - exact(shape, *powers)).abs()
                };
                monomials(shape, of).iter().map(error).fold(0.0, f64::max)
            };
            // Some rules are better than they were asked to be, none by more than two degrees.
            assert!(misses(degree + 2) > 1e-7, "{shape:?} {degree}");
        }
    }
}

#[test]
fn gauss_rules_integrate_monomials_of_degree_2n_minus_1() {
    let exact = |k: u32| if k % 2 == 1 { 0.0 } else { 2.0 / f64::from(k + 1) };
    for shape in [Shape::Line2, Shape::Quad4, Shape::Hex8] {
        for n in 1..=5_u32 {
            let rule = gauss(shape, n as usize);
            assert_eq!(rule.len(), (n as usize).pow(shape.dim() as u32));
            for k in 0..2 * n {
                let product =
                    |xi: [f64; 3]| (0..shape.dim()).map(|d| xi[d].powi(k as i32)).product();
                let sum = integral(&rule, product);
                assert!((sum - exact(k).powi(shape.dim() as i32)).abs() < 1e-14);
            }
            let k = (2 * n) as i32;
            let beyond: f64 = rule.iter().map(|p| p.weight * p.xi[0].powi(k)).sum();
            let volume = 2.0_f64.powi(shape.dim() as i32 - 1);
            assert!((beyond - volume * exact(2 * n)).abs() > 1e-3, "no rule is that good");
        }
    }
}

#[test]
fn triangle_rules_integrate_their_degree_and_no_more() {
    let error = |degree: usize, i: usize, j: usize| {
        let sum: f64 = triangle(degree)
            .iter()
            .map(|p| p.weight * p.barycentric[0].powi(i as i32) * p.barycentric[1].powi(j as i32))
            .sum();
        (sum - 2.0 * factorial(i) * factorial(j) / factorial(i + j + 2)).abs()
    };
    for degree in [1, 2, 4, 5, 8] {
        for i in 0..=degree {
            for j in 0..=degree - i {
                assert!(error(degree, i, j) < 1e-15, "degree {degree}: {i} {j}");
            }
        }
        // The rule of degree 8 is better in one coordinate than in the other.
        let beyond = (0..=degree + 4).map(|i| error(degree, i, degree + 4 - i));
        assert!(beyond.fold(0.0, f64::max) > 1e-10);
    }
}

#[test]
fn gauss_jacobi_rules_integrate_their_degree() {
    for power in 0..3_usize {
        for n in 1..=6 {
            let rule = conical::gauss_jacobi(n, power as u32);
            assert!(rule.is_sorted_by(|a, b| a.0 < b.0));
            for k in 0..2 * n {
                let sum: f64 = rule.iter().map(|(t, w)| w * t.powi(k as i32)).sum();
                let exact = factorial(k) * factorial(power) / factorial(k + power + 1);
                assert!((sum - exact).abs() < 1e-15, "{power} {n} {k}: {:e}", sum - exact);
            }
        }
    }
    for (found, (x, w)) in conical::gauss_jacobi(5, 0).iter().zip(gauss_legendre(5)) {
        assert!((found.0 - 0.5 * (1.0 + x)).abs() < 1e-15 && (found.1 - 0.5 * w).abs() < 1e-15);
    }
}

/// Mass and stiffness between the functions of the basis, in an affine cell.
fn matrices<const DIM: usize>(shape: Shape, rule: &[QuadraturePoint]) -> Vec<f64> {
    let position = |[x, y, z]: [f64; 3]| {
        let all = [2.0 * x + 0.3 * y - 0.2 * z, y - 0.4 * x + 0.1 * z, 0.7 * z + 0.2 * x];
        std::array::from_fn(|i| all[i])
    };
    let positions: Vec<[f64; DIM]> = shape.node_points().iter().map(|x| position(*x)).collect();
    let n = shape.nodes();
    let mut out = vec![0.0; 2 * n * n];
    for p in rule {
        let (mut values, mut reference) = ([0.0; MAX_NODES], [[0.0; 3]; MAX_NODES]);
        shape.values(p.xi, &mut values);
        shape.gradients(p.xi, &mut reference);
        let map = mapping(shape, &positions, p.xi);
        let gradients = reference.map(|g| map.gradient(g, DIM));
        let weight = p.weight * map.determinant;
        for (a, b) in (0..n).flat_map(|a| (0..n).map(move |b| (a, b))) {
            out[a * n + b] += weight * values[a] * values[b];
            let product: f64 = (0..DIM).map(|i| gradients[a][i] * gradients[b][i]).sum();
            out[n * n + a * n + b] += weight * product;
        }
    }
    out
}

#[test]
fn the_stiffness_rule_integrates_affine_cells_exactly_and_a_lower_one_does_not() {
    for shape in Shape::ALL.into_iter().filter(|shape| shape.dim() > 1) {
        let of = |rule: &[QuadraturePoint]| match shape.dim() {
            2 => matrices::<2>(shape, rule),
            _ => matrices::<3>(shape, rule),
        };
        let exact = of(&quadrature(shape, MAX_DEGREE));
        let miss = |rule: &[QuadraturePoint]| {
            of(rule).iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let here = miss(&stiffness_rule(shape));
        assert!(here < 1e-14, "{shape:?}: {here:e}");
        assert!(miss(&quadrature(shape, 2 * shape.order() - 2)) > 1e-4, "{shape:?}");
    }
}

#[test]
fn cubes_keep_the_rule_of_one_point_more_than_the_order() {
    for shape in Shape::ALL.into_iter().filter(|shape| shape.family() == Family::Cube) {
        assert_eq!(stiffness_rule(shape), gauss(shape, shape.order() + 1));
    }
}
