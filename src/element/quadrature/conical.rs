//! Rules on triangles, tetrahedra and pyramids of any degree: those of the cube drawn together to a
//! point (an edge, then a point), whose determinant is the weight of Gauss-Jacobi rules.
//!
//! # Source
//! Stroud (1971), Approximate Calculation of Multiple Integrals, sections 2.3 to 2.5: conical
//! products.

use super::gauss::{QuadraturePoint, gauss_legendre};

/// The triangle, exact for polynomials of total degree 2n - 1, with n^2 points.
pub fn triangle(n: usize) -> Vec<QuadraturePoint> {
    let [of_x, of_y] = [0, 1].map(|power| gauss_jacobi(n, power));
    let row = |&(y, w_y): &(f64, f64)| {
        let at = move |&(x, w_x): &(f64, f64)| QuadraturePoint {
            xi: [x * (1.0 - y), y, 0.0],
            weight: w_x * w_y,
        };
        of_x.iter().map(at).collect::<Vec<_>>()
    };
    of_y.iter().flat_map(row).collect()
}

/// The tetrahedron, exact for polynomials of total degree 2n - 1, with n^3 points.
pub fn tetrahedron(n: usize) -> Vec<QuadraturePoint> {
    let [of_x, of_y, of_z] = [0, 1, 2].map(|power| gauss_jacobi(n, power));
    let mut points = Vec::with_capacity(n.pow(3));
    for &(z, w_z) in &of_z {
        for &(y, w_y) in &of_y {
            for &(x, w_x) in &of_x {
                let xi = [x * (1.0 - y) * (1.0 - z), y * (1.0 - z), z];
                points.push(QuadraturePoint { xi, weight: w_x * w_y * w_z });
            }
        }
    }
    points
}

/// The pyramid, exact for polynomials of total degree 2n - 1, and for what has that degree in each
/// of x / (1 - z), y / (1 - z) and z, with n^3 points.
pub fn pyramid(n: usize) -> Vec<QuadraturePoint> {
    let (across, upwards) = (gauss_legendre(n), gauss_jacobi(n, 2));
    let mut points = Vec::with_capacity(n.pow(3));
    for &(z, w_z) in &upwards {
        for &(y, w_y) in &across {
            for &(x, w_x) in &across {
                let xi = [x * (1.0 - z), y * (1.0 - z), z];
                points.push(QuadraturePoint { xi, weight: w_x * w_y * w_z });
            }
        }
    }
    points
}

/// Points on [0, 1] and weights that integrate (1 - t)^power f(t) exactly for f of degree 2n - 1.
///
/// Newton's method for one zero of the Jacobi polynomial P^(power, 0) after the other, those found
/// divided out, from the zeros of Chebyshev's.
///
/// # Source
/// Karniadakis and Sherwin (2005), Spectral/hp Element Methods, appendix B.
pub(super) fn gauss_jacobi(n: usize, power: u32) -> Vec<(f64, f64)> {
    let mut zeros: Vec<f64> = Vec::with_capacity(n);
    for k in 0..n {
        let chebyshev = -((2 * k + 1) as f64 / (2 * n) as f64 * std::f64::consts::PI).cos();
        let mut x = zeros.last().map_or(chebyshev, |last| 0.5 * (last + chebyshev));
        for _ in 0..100 {
            let [value, slope] = jacobi(n, power, x);
            let others: f64 = zeros.iter().map(|zero| 1.0 / (x - zero)).sum();
            let step = value / (slope - others * value);
            x -= step;
            if step.abs() < 2.0 * f64::EPSILON {
                break;
            }
        }
        zeros.push(x);
    }
    let weight = |x: f64| 1.0 / ((1.0 - x * x) * jacobi(n, power, x)[1].powi(2));
    zeros.into_iter().map(|x| (0.5 * (1.0 + x), weight(x))).collect()
}

/// The Jacobi polynomial P_n^(power, 0) on [-1, 1] and its derivative, by the recurrence over n.
fn jacobi(n: usize, power: u32, x: f64) -> [f64; 2] {
    let a = f64::from(power);
    let mut last = [1.0, 0.0];
    if n == 0 {
        return last;
    }
    let mut this = [0.5 * ((a + 2.0) * x + a), 0.5 * (a + 2.0)];
    for k in 2..=n {
        let (k, twice) = (k as f64, 2.0 * k as f64 + a);
        let divisor = 2.0 * k * (k + a) * (twice - 2.0);
        let linear = (twice - 1.0) * twice * (twice - 2.0) / divisor;
        let constant = (twice - 1.0) * a * a / divisor;
        let back = 2.0 * (k + a - 1.0) * (k - 1.0) * twice / divisor;
        let along = linear * x + constant;
        let next =
            [along * this[0] - back * last[0], along * this[1] + linear * this[0] - back * last[1]];
        (last, this) = (this, next);
    }
    this
}
