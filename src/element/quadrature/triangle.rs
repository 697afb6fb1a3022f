//! Rules on triangles, which are the same whichever corner comes first, up to degree 5.

use std::sync::LazyLock;

use super::gauss::{QuadraturePoint, gauss};
use crate::element::shape::Shape;

/// A point of a rule on a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrianglePoint {
    /// Barycentric coordinates, sum 1.
    pub barycentric: [f64; 3],
    /// Weight as a fraction of the area of the triangle; the weights of a rule sum to 1.
    pub weight: f64,
}

const DEGREE_1: [TrianglePoint; 1] = [point([1.0 / 3.0; 3], 1.0)];

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

/// The seven-point rule of degree 5 (Radon 1948; Dunavant 1985), to double precision: the numbers
/// are (6 -+ sqrt 15) / 21 and (155 -+ sqrt 15) / 1200.
#[rustfmt::skip]
const DEGREE_5: [TrianglePoint; 7] = {
    const A1: f64 = 0.101_286_507_323_456_34;
    const B1: f64 = 0.797_426_985_353_087_3;
    const W1: f64 = 0.125_939_180_544_827_14;
    const A2: f64 = 0.470_142_064_105_115_1;
    const B2: f64 = 0.059_715_871_789_769_82;
    const W2: f64 = 0.132_394_152_788_506_2;
    [
        point([1.0 / 3.0; 3], 0.225),
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

/// A rule on the triangle that is exact for polynomials of total degree 1 (1 point), 2 (3), 4
/// (6), 5 (7) or 8 (25).
///
/// # Panics
/// If there is no such rule here.
pub fn triangle(degree: usize) -> &'static [TrianglePoint] {
    match degree {
        1 => &DEGREE_1,
        2 => &DEGREE_2,
        4 => &DEGREE_4,
        5 => &DEGREE_5,
        8 => &DEGREE_8,
        _ => panic!("triangle rules have degree 1, 2, 4, 5 or 8, not {degree}"),
    }
}

/// The rule on the reference triangle that is exact for a degree of at most 8.
pub fn points(degree: usize) -> Vec<QuadraturePoint> {
    let of = |p: &TrianglePoint| {
        let [_, x, y] = p.barycentric;
        QuadraturePoint { xi: [x, y, 0.0], weight: Shape::Tri3.volume() * p.weight }
    };
    let kept = [1, 2, 4, 5, 8].into_iter().find(|kept| *kept >= degree).unwrap_or(degree);
    triangle(kept).iter().map(of).collect()
}
