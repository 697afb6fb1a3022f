//! Gauss rules on lines, quadrilaterals and hexahedra, and rules on triangles.

use std::sync::LazyLock;

use super::Shape;

/// A point of a rule on a reference cell [-1, 1]^dim.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuadraturePoint {
    /// Reference coordinates; zero beyond the dimension of the shape.
    pub xi: [f64; 3],
    /// Weight; the weights of a rule sum to 2^dim.
    pub weight: f64,
}

/// A point of a rule on a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrianglePoint {
    /// Barycentric coordinates, sum 1.
    pub barycentric: [f64; 3],
    /// Weight as a fraction of the area of the triangle; the weights of a rule sum to 1.
    pub weight: f64,
}

/// Tensor product of the Gauss-Legendre rule with `n` points along each axis (1, 2, 3 or 5): exact
/// for polynomials of degree 2n - 1 in each coordinate. The first coordinate runs fastest.
///
/// # Panics
/// If there is no such rule here.
pub fn gauss(shape: Shape, n: usize) -> Vec<QuadraturePoint> {
    let line = gauss_legendre(n);
    let mut points = vec![QuadraturePoint { xi: [0.0; 3], weight: 1.0 }];
    for axis in 0..shape.dim() {
        points = line
            .iter()
            .flat_map(|&(x, w)| {
                points.iter().map(move |p| {
                    let mut xi = p.xi;
                    xi[axis] = x;
                    QuadraturePoint { xi, weight: p.weight * w }
                })
            })
            .collect();
    }
    points
}

/// Points and weights of the Gauss-Legendre rule on [-1, 1].
fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let two = 1.0 / 3.0_f64.sqrt();
    let three = 0.6_f64.sqrt();
    let root = (10.0_f64 / 7.0).sqrt();
    let (inner, outer) = ((5.0 - 2.0 * root).sqrt() / 3.0, (5.0 + 2.0 * root).sqrt() / 3.0);
    let seventy = 13.0 * 70.0_f64.sqrt();
    let (more, less) = ((322.0 + seventy) / 900.0, (322.0 - seventy) / 900.0);
    match n {
        1 => vec![(0.0, 2.0)],
        2 => vec![(-two, 1.0), (two, 1.0)],
        3 => vec![(-three, 5.0 / 9.0), (0.0, 8.0 / 9.0), (three, 5.0 / 9.0)],
        5 => {
            vec![(-outer, less), (-inner, more), (0.0, 128.0 / 225.0), (inner, more), (outer, less)]
        }
        _ => panic!("Gauss rules have 1, 2, 3 or 5 points along each axis, not {n}"),
    }
}

#[rustfmt::skip]
const DEGREE_2: [TrianglePoint; 3] = {
    const A: f64 = 1.0 / 6.0;
    const B: f64 = 2.0 / 3.0;
    const W: f64 = 1.0 / 3.0;
    [point([B, A, A], W), point([A, B, A], W), point([A, A, B], W)]
};

/// The six-point rule of degree 4 (Strang and Fix 1973; Dunavant 1985), to double precision.
#[rustfmt::skip]
const DEGREE_4: [TrianglePoint; 6] = {
    const A1: f64 = 0.445_948_490_915_964_9;
    const B1: f64 = 0.108_103_018_168_070_23;
    const W1: f64 = 0.223_381_589_678_011_47;
    const A2: f64 = 0.091_576_213_509_770_74;
    const B2: f64 = 0.816_847_572_980_458_5;
    const W2: f64 = 0.109_951_743_655_321_87;
    [
        point([B1, A1, A1], W1), point([A1, B1, A1], W1), point([A1, A1, B1], W1),
        point([B2, A2, A2], W2), point([A2, B2, A2], W2), point([A2, A2, B2], W2),
    ]
};

const fn point(barycentric: [f64; 3], weight: f64) -> TrianglePoint {
    TrianglePoint { barycentric, weight }
}

/// The rule of degree 8 with 25 points: that of the square with one edge drawn together to a point
/// (Stroud 1971), where the determinant takes up one of the nine degrees.
static DEGREE_8: LazyLock<Vec<TrianglePoint>> = LazyLock::new(|| {
    let collapsed = |p: QuadraturePoint| {
        let [x, y] = [0, 1].map(|d| 0.5 * (1.0 + p.xi[d]));
        point([1.0 - x, x * (1.0 - y), x * y], 0.5 * p.weight * x)
    };
    gauss(Shape::Quad4, 5).into_iter().map(collapsed).collect()
});

/// A rule on the triangle that is exact for polynomials of total degree 2 (3 points), 4 (6) or 8
/// (25).
///
/// # Panics
/// If there is no such rule here.
pub fn triangle(degree: usize) -> &'static [TrianglePoint] {
    match degree {
        2 => &DEGREE_2,
        4 => &DEGREE_4,
        8 => &DEGREE_8,
        _ => panic!("triangle rules have degree 2, 4 or 8, not {degree}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_rules_integrate_monomials_of_degree_2n_minus_1() {
        let exact = |k: u32| if k % 2 == 1 { 0.0 } else { 2.0 / f64::from(k + 1) };
        for shape in [Shape::Line2, Shape::Quad4, Shape::Hex8] {
            for n in [1, 2, 3, 5_u32] {
                let rule = gauss(shape, n as usize);
                assert_eq!(rule.len(), (n as usize).pow(shape.dim() as u32));
                for k in 0..2 * n {
                    let sum: f64 = rule
                        .iter()
                        .map(|p| {
                            let monomial: f64 =
                                (0..shape.dim()).map(|d| p.xi[d].powi(k as i32)).product();
                            p.weight * monomial
                        })
                        .sum();
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
        let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
        let error = |degree: usize, i: u32, j: u32| {
            let sum: f64 = triangle(degree)
                .iter()
                .map(|p| {
                    p.weight * p.barycentric[0].powi(i as i32) * p.barycentric[1].powi(j as i32)
                })
                .sum();
            (sum - 2.0 * factorial(i) * factorial(j) / factorial(i + j + 2)).abs()
        };
        for degree in [2_u32, 4, 8] {
            for i in 0..=degree {
                for j in 0..=degree - i {
                    assert!(error(degree as usize, i, j) < 1e-15, "degree {degree}: {i} {j}");
                }
            }
            // The rule of degree 8 is better in one coordinate than in the other.
            let beyond = (0..=degree + 4).map(|i| error(degree as usize, i, degree + 4 - i));
            assert!(beyond.fold(0.0, f64::max) > 1e-10);
        }
    }
}
