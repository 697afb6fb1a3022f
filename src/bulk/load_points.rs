//! Where loads act: points of cells and facets with their share of the measure.

use super::RulePoint;
use crate::case::Value;
use crate::element::Shape;
use crate::error::{Error, Result};

/// A point of a loaded cell or facet.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadPoint {
    /// Where it is (m).
    pub position: [f64; 3],
    /// Weight times measure (m3 or m2; 2D: m2 or m).
    pub weight: f64,
    /// Of a facet the unit normal that points out of its cell; of a cell zero.
    pub normal: [f64; 3],
}

impl LoadPoint {
    /// The value of a load here; `name` says where it stands in the case.
    ///
    /// # Errors
    /// `Input` when it is no finite number.
    pub fn value(&self, of: &Value, time: f64, name: impl Fn() -> String) -> Result<f64> {
        let value = of.at(self.position, time);
        if value.is_finite() {
            return Ok(value);
        }
        let ([x, y, z], name) = (self.position, name());
        Err(Error::Input(format!(
            "{name} is {value} at ({x}, {y}, {z}) m at time {time}; the formula must give finite \
             numbers wherever the load acts, at every instant"
        )))
    }
}

/// The points of a cell or a facet with these nodes (m), which are in the order of its shape; those
/// of a facet run so that its normal points out of the cell. Displacement components lie along
/// `axes`. `is_box` says that the cell is a box, whose measure is known without rounding.
pub fn load_points(
    shape: Shape,
    rule: &[RulePoint],
    points: &[[f64; 3]],
    axes: &[usize],
    is_box: bool,
) -> Vec<LoadPoint> {
    let of_box = is_box.then(|| box_measure(points, shape.dim()) / f64::from(1 << shape.dim()));
    let point = |of_rule: &RulePoint| {
        let values = || points.iter().zip(&of_rule.values);
        let position = std::array::from_fn(|i| values().map(|(x, n)| x[i] * n).sum());
        let (mut normal, jacobian) = normal_and_jacobian(of_rule, points, axes, shape.dim());
        if is_box {
            snap(&mut normal);
        }
        LoadPoint { position, weight: of_rule.weight * of_box.unwrap_or(jacobian), normal }
    };
    rule.iter().map(point).collect()
}

/// Volume of a box, area of a face of it, length of an edge: the product of its `dim` largest
/// lengths. The others are zero up to rounding.
fn box_measure(points: &[[f64; 3]], dim: usize) -> f64 {
    let far = points.iter().fold(points[0], |far, x| {
        std::array::from_fn(|i| {
            if (x[i] - points[0][i]).abs() > (far[i] - points[0][i]).abs() { x[i] } else { far[i] }
        })
    });
    let mut lengths = [0, 1, 2].map(|i| (far[i] - points[0][i]).abs());
    for _ in dim..3 {
        let least = (0..3).min_by(|i, j| lengths[*i].total_cmp(&lengths[*j])).unwrap_or_default();
        lengths[least] = f64::INFINITY;
    }
    lengths.into_iter().filter(|length| length.is_finite()).product()
}

/// Unit normal and the determinant of the Jacobian of a facet; zero and that of a cell.
fn normal_and_jacobian(
    of_rule: &RulePoint,
    points: &[[f64; 3]],
    axes: &[usize],
    dim: usize,
) -> ([f64; 3], f64) {
    if dim == axes.len() {
        let along = |x: &[f64; 3]| {
            let mut out = [0.0; 3];
            axes.iter().enumerate().for_each(|(c, axis)| out[c] = x[*axis]);
            out
        };
        let points: Vec<[f64; 3]> = points.iter().map(along).collect();
        let physical =
            if dim == 2 { of_rule.physical::<2>(&points) } else { of_rule.physical::<3>(&points) };
        return ([0.0; 3], physical.determinant);
    }
    let tangent = |d: usize| -> [f64; 3] {
        let gradients = || points.iter().zip(&of_rule.gradients);
        std::array::from_fn(|i| gradients().map(|(x, g)| x[i] * g[d]).sum())
    };
    let mut normal = [0.0; 3];
    if dim == 1 {
        let t = tangent(0);
        (normal[axes[0]], normal[axes[1]]) = (t[axes[1]], -t[axes[0]]);
    } else {
        let (s, t) = (tangent(0), tangent(1));
        normal = std::array::from_fn(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            s[j] * t[k] - s[k] * t[j]
        });
    }
    let length = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
    (normal.map(|n| n / length), length)
}

/// The normal of a face of a box without rounding.
fn snap(normal: &mut [f64; 3]) {
    for n in normal {
        *n = if n.abs() > 0.5 { n.signum() } else { 0.0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::{map_point, quadrature};

    const SPACE: &[usize] = &[0, 1, 2];

    fn rule(shape: Shape) -> Vec<RulePoint> {
        RulePoint::all(shape, quadrature(shape, 2 * shape.order() + 1))
    }

    /// The reference cell, bent and moved.
    fn bent(shape: Shape) -> Vec<[f64; 3]> {
        let place = |[x, y, z]: [f64; 3]| {
            [2.0 * x + 0.1 * y * z, y + 0.2 * x - 0.1 * x * y, 0.5 * z + 0.1 * x + 3.0]
        };
        shape.node_points().iter().map(|x| place(*x)).collect()
    }

    /// Of every facet: the integrals of the normal, and of the normal times the position.
    fn around(shape: Shape, points: &[[f64; 3]], axes: &[usize]) -> ([f64; 3], f64) {
        let (mut sum, mut flux) = ([0.0; 3], 0.0);
        for (index, facet) in shape.facets().iter().enumerate() {
            let of_facet = shape.facet_shape(index).expect("a body");
            let nodes: Vec<[f64; 3]> = facet.iter().map(|a| points[*a]).collect();
            for p in load_points(of_facet, &rule(of_facet), &nodes, axes, false) {
                assert!((p.normal.iter().map(|n| n * n).sum::<f64>() - 1.0).abs() < 1e-14);
                for ((sum, normal), x) in sum.iter_mut().zip(p.normal).zip(p.position) {
                    *sum += p.weight * normal;
                    flux += p.weight * normal * x;
                }
            }
        }
        (sum, flux)
    }

    #[test]
    fn normals_close_and_their_flux_is_the_volume() {
        for shape in Shape::ALL.into_iter().filter(|s| s.dim() == 3) {
            let points = bent(shape);
            let (sum, flux) = around(shape, &points, SPACE);
            let inside = load_points(shape, &rule(shape), &points, SPACE, false);
            let volume: f64 = inside.iter().map(|p| p.weight).sum();
            assert!(sum.iter().all(|s| s.abs() < 1e-13), "{shape:?} {sum:?}");
            assert!((flux / 3.0 - volume).abs() < 1e-12 * volume, "{shape:?} {flux} {volume}");
            assert!(inside.iter().all(|p| p.normal == [0.0; 3]));
            let centre = map_point(shape, &points, shape.centroid());
            assert!(inside.iter().all(|p| (p.position[2] - centre[2]).abs() < 1.5));
        }
    }

    #[test]
    fn normals_of_edges_point_outwards_in_either_plane() {
        for axes in [[0, 1], [0, 2]] {
            for shape in Shape::ALL.into_iter().filter(|s| s.dim() == 2) {
                let place = |xi: &[f64; 3]| {
                    let mut x = [7.0; 3];
                    x[axes[0]] = 2.0 * xi[0] + 0.1 * xi[0] * xi[1];
                    x[axes[1]] = xi[1] + 0.2 * xi[0];
                    x
                };
                let points: Vec<[f64; 3]> = shape.node_points().iter().map(place).collect();
                let (sum, flux) = around(shape, &points, &axes);
                let inside = load_points(shape, &rule(shape), &points, &axes, false);
                let area: f64 = inside.iter().map(|p| p.weight).sum();
                assert!(sum.iter().all(|s| s.abs() < 1e-13), "{shape:?} {sum:?}");
                assert!((flux / 2.0 - area).abs() < 1e-12 * area, "{shape:?} {flux} {area}");
            }
        }
    }

    /// New nodes of a refined mesh are worked out: the faces of its boxes are even up to rounding.
    #[test]
    fn rounding_is_no_length_of_a_box() {
        let size = [0.7, 0.3, 1.1];
        for shape in [Shape::Hex8, Shape::Hex27] {
            let mut number = 0_u64;
            let mut rounded = |x: f64| {
                number += 1;
                f64::from_bits((x.to_bits() + number * 7 % 5).wrapping_sub(2))
            };
            let place = |xi: &[f64; 3]| [0, 1, 2].map(|i| rounded(size[i] * (0.5 * xi[i] + 1.0)));
            let points: Vec<[f64; 3]> = shape.node_points().iter().map(place).collect();
            for (index, facet) in shape.facets().iter().enumerate() {
                let of_facet = shape.facet_shape(index).expect("a body");
                let nodes: Vec<[f64; 3]> = facet.iter().map(|a| points[*a]).collect();
                let rule = rule(of_facet);
                let general = load_points(of_facet, &rule, &nodes, SPACE, false);
                for (p, general) in
                    load_points(of_facet, &rule, &nodes, SPACE, true).iter().zip(general)
                {
                    assert!((p.weight / general.weight - 1.0).abs() < 1e-13, "{shape:?} {index}");
                }
                let edge: Vec<[f64; 3]> = nodes[..2].to_vec();
                let length = box_measure(&edge, 1);
                let direct = (0..3).map(|i| (edge[0][i] - edge[1][i]).powi(2)).sum::<f64>().sqrt();
                assert!((length / direct - 1.0).abs() < 1e-13, "{length} {direct}");
            }
            let all = load_points(shape, &rule(shape), &points, SPACE, true);
            let volume: f64 = all.iter().map(|p| p.weight).sum();
            assert!((volume / size.iter().product::<f64>() - 1.0).abs() < 1e-13, "{volume}");
        }
    }

    #[test]
    fn faces_of_boxes_have_exact_normals_and_measures() {
        for shape in [Shape::Hex8, Shape::Hex27] {
            let size = [0.1, 0.7, 0.3];
            let place = |xi: &[f64; 3]| std::array::from_fn(|i| size[i] * (0.5 * xi[i] + 0.5));
            let points: Vec<[f64; 3]> = shape.node_points().iter().map(place).collect();
            let towards = [(2, -1.0), (2, 1.0), (1, -1.0), (0, 1.0), (1, 1.0), (0, -1.0)];
            for (index, (facet, (axis, side))) in shape.facets().iter().zip(towards).enumerate() {
                let of_facet = shape.facet_shape(index).expect("a body");
                let nodes: Vec<[f64; 3]> = facet.iter().map(|a| points[*a]).collect();
                let (rule, mut exact) = (rule(of_facet), [0.0; 3]);
                exact[axis] = side;
                let of_box = load_points(of_facet, &rule, &nodes, SPACE, true);
                let general = load_points(of_facet, &rule, &nodes, SPACE, false);
                for (p, general) in of_box.iter().zip(&general) {
                    assert_eq!(p.normal, exact);
                    assert!((p.weight / general.weight - 1.0).abs() < 1e-14);
                }
            }
        }
    }
}
