//! Rules on tetrahedra: the symmetric ones of low degree, conical products beyond.

use super::conical;
use super::gauss::QuadraturePoint;
use crate::element::shape::Shape;

/// The rule on the reference tetrahedron that is exact for polynomials of a total degree: up to 1
/// (1 point), 2 (4), 3 (8), 5 (14), beyond (degree / 2 + 1)^3. All weights are positive.
///
/// # Source
/// Degree 2: Hammer and Stroud (1956), MTAC 10, 137-139; Keast (1986), Comput. Methods Appl. Mech.
/// Engrg 55, 339-348. Degree 3: Witherden and Vincent (2015), Comput. Math. Appl. 69, 1232-1241.
/// Degree 5: Walkington (2000); Witherden and Vincent have the same one.
pub fn points(degree: usize) -> Vec<QuadraturePoint> {
    match degree {
        0 | 1 => vec![point([0.25; 3], 1.0)],
        2 => corners((5.0 - 5.0_f64.sqrt()) / 20.0, 0.25).to_vec(),
        3 => [
            corners(0.328_163_302_516_381_7, 0.136_217_842_537_087_35),
            corners(0.108_047_249_898_428_61, 0.113_782_157_462_912_65),
        ]
        .concat(),
        4 | 5 => [
            &corners(0.310_885_919_263_300_6, 0.112_687_925_718_015_85)[..],
            &corners(0.092_735_250_310_891_22, 0.073_493_043_116_361_96),
            &edges(0.045_503_704_125_649_65, 0.042_546_020_777_081_466),
        ]
        .concat(),
        _ => conical::tetrahedron(degree / 2 + 1),
    }
}

/// The four points with three barycentric coordinates `a`; weights are fractions of the volume.
fn corners(a: f64, weight: f64) -> [QuadraturePoint; 4] {
    let b = 1.0 - 3.0 * a;
    [[a, a, a], [b, a, a], [a, b, a], [a, a, b]].map(|xi| point(xi, weight))
}

/// The six points with two barycentric coordinates `a`.
fn edges(a: f64, weight: f64) -> [QuadraturePoint; 6] {
    let b = 0.5 - a;
    let all = [[a, a, b], [a, b, a], [b, a, a], [b, b, a], [b, a, b], [a, b, b]];
    all.map(|xi| point(xi, weight))
}

fn point(xi: [f64; 3], weight: f64) -> QuadraturePoint {
    QuadraturePoint { xi, weight: Shape::Tet4.volume() * weight }
}
