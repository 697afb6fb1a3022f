//! Rules of integration on the reference cells.

mod conical;
mod gauss;
mod tetrahedron;
mod triangle;
#[cfg(test)]
mod tests;

pub use gauss::{QuadraturePoint, gauss};
pub use triangle::{TrianglePoint, triangle};

use gauss::gauss_legendre;

use super::shape::{Family, Shape};

/// The highest degree of [`quadrature`].
pub const MAX_DEGREE: usize = 8;

/// A rule that is exact on the reference cell for polynomials of a `degree` of at most
/// [`MAX_DEGREE`]; all weights are positive, all points inside.
///
/// The degree is that in each coordinate of a cube; that in all coordinates together of a simplex;
/// that in the two of the triangle and that in the third of a prism; that in all together of a
/// pyramid, and in each of x / (1 - z), y / (1 - z) and z, in which its basis is a polynomial.
///
/// Cubes: [`gauss()`]. Triangles: [`triangle()`]. Tetrahedra: symmetric rules up to degree 5,
/// conical products beyond. Prisms: triangle times line. Pyramids: conical products.
///
/// # Panics
/// If the degree is higher.
pub fn quadrature(shape: Shape, degree: usize) -> Vec<QuadraturePoint> {
    assert!(degree <= MAX_DEGREE, "rules have at most degree {MAX_DEGREE}, not {degree}");
    let of_line = degree / 2 + 1;
    match (shape.family(), shape.dim()) {
        (Family::Cube, _) => gauss(shape, of_line),
        (Family::Simplex, 2) => triangle::points(degree),
        (Family::Simplex, _) => tetrahedron::points(degree),
        (Family::Prism, _) => prism(&triangle::points(degree), &gauss_legendre(of_line)),
        (Family::Pyramid, _) => conical::pyramid(of_line),
    }
}

/// A rule on the reference triangle for polynomials of any `degree`: that of [`quadrature`] up to
/// [`MAX_DEGREE`], conical products beyond.
pub fn quadrature_on_triangle(degree: usize) -> Vec<QuadraturePoint> {
    if degree <= MAX_DEGREE { triangle::points(degree) } else { conical::triangle(degree / 2 + 1) }
}

/// A rule that integrates stiffness and mass of an affine cell of uniform material exactly: of
/// twice the order of the shape.
///
/// The mass, a product of two functions of the basis, has this degree in the sense of
/// [`quadrature`]; the stiffness has it in those coordinates in which a derivative leaves the
/// degree as it is (cubes, prisms, pyramids), and two less in a simplex. For cubes this is the
/// Gauss rule with one point more along each axis than the order.
pub fn stiffness_rule(shape: Shape) -> Vec<QuadraturePoint> {
    quadrature(shape, 2 * shape.order())
}

/// The points of the triangle run fastest.
fn prism(triangle: &[QuadraturePoint], line: &[(f64, f64)]) -> Vec<QuadraturePoint> {
    let at = |&(z, weight): &(f64, f64)| {
        triangle.iter().map(move |p| {
            let [x, y, _] = p.xi;
            QuadraturePoint { xi: [x, y, z], weight: p.weight * weight }
        })
    };
    line.iter().flat_map(at).collect()
}
