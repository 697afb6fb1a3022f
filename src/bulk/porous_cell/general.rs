//! Porous cells that are no boxes.

use nalgebra::{Matrix3, Vector3};

use super::{MAX_CORNERS, Point, PorousCell, entries};
use crate::bulk::PorousMedium;
use crate::bulk::rule::{Physical, RulePoint};
use crate::element::{Family, QuadraturePoint, Shape, quadrature};

impl PorousCell {
    /// Integrates over a cell of any geometry with these nodes by displacement component (m).
    pub fn of_points(shape: Shape, points: &[[f64; 3]], medium: PorousMedium) -> Self {
        let (dim, corners) = (shape.dim(), shape.corners());
        let Directions { size, rows } = directions(shape, points);
        let (mut along, mut of_rule) = (Vec::new(), Vec::new());
        for q in quadrature(shape, 2 * shape.order() + 1) {
            let (of_nodes, of_corners) = (RulePoint::new(shape, q), RulePoint::new(corners, q));
            let physical = match dim {
                2 => of_nodes.physical::<2>(points),
                _ => of_nodes.physical::<3>(points),
            };
            let (mut values, mut gradients) = ([0.0; MAX_CORNERS], [[0.0; 3]; MAX_CORNERS]);
            values[..corners.nodes()].copy_from_slice(&of_corners.values);
            let mut slopes = gradients;
            for (a, g) in of_corners.gradients.iter().enumerate() {
                gradients[a] = physical.by_position(*g, dim);
                slopes[a] = match rows {
                    None => [0, 1, 2].map(|d| 2.0 * g[d] / size[d]),
                    Some(rows) => rows.map(|row| (0..dim).map(|i| row[i] * gradients[a][i]).sum()),
                };
            }
            along.push(slopes);
            let Physical { determinant, gradients: nodal, .. } = physical;
            let nodal = nodal[..shape.nodes()].iter();
            of_rule.push(Point {
                volume: q.weight * determinant,
                divergence: nodal.flat_map(|g| g.iter().copied().take(dim)).collect(),
                values,
                gradients,
            });
        }
        let np = corners.nodes();
        let mut gradients = vec![0.0; np * np];
        for q in &of_rule {
            for (entry, (a, b)) in gradients.iter_mut().zip(entries(np)) {
                let product = |c: usize| q.gradients[a][c] * q.gradients[b][c];
                *entry += q.volume * (0..dim).map(product).sum::<f64>();
            }
        }
        let cell = Self::integrate(shape, size, medium, of_rule, &along);
        Self { gradients: Some(gradients), ..cell }
    }
}

/// The directions along which a cell has lengths.
struct Directions {
    /// Lengths (m).
    size: [f64; 3],
    /// Unit vectors; none where they are the reference coordinates.
    rows: Option<[[f64; 3]; 3]>,
}

/// Those of a cell: of cubes their reference coordinates. Simplices, prisms and pyramids have none
/// of their own; there they are the principal ones of the sum of e e^T over the edges e between
/// corners, weighted so that regular cells of one edge length have this one along all directions,
/// pyramids a little more along their bases.
fn directions(shape: Shape, points: &[[f64; 3]]) -> Directions {
    let mut tensor = Matrix3::zeros();
    let mut add = |a: usize, b: usize, weight: f64| {
        let edge = Vector3::from(points[b]) - Vector3::from(points[a]);
        tensor += edge * edge.transpose() * weight;
    };
    match shape.family() {
        Family::Simplex => {
            let corners = shape.corners().nodes();
            let pairs = (0..corners).flat_map(|b| (0..b).map(move |a| (a, b)));
            pairs.for_each(|(a, b)| add(a, b, 2.0 / corners as f64));
        }
        Family::Prism => {
            let third = 1.0 / 3.0;
            for k in 0..3 {
                add(k, (k + 1) % 3, third);
                add(3 + k, 3 + (k + 1) % 3, third);
                add(k, 3 + k, third);
            }
        }
        Family::Pyramid => {
            for k in 0..4 {
                add(k, (k + 1) % 4, 0.5);
                add(k, 4, 0.25);
            }
        }
        _ => return Directions { size: lengths(shape, points), rows: None },
    }
    let mut principal = tensor.symmetric_eigen();
    if shape.dim() == 2 {
        // In the plane: the direction across it comes last.
        let across = (0..3).max_by(|i, j| {
            let z = |i: usize| principal.eigenvectors[(2, i)].abs();
            z(*i).total_cmp(&z(*j))
        });
        let across = across.unwrap_or(2);
        principal.eigenvectors.swap_columns(across, 2);
        principal.eigenvalues.swap_rows(across, 2);
    }
    let vectors = &principal.eigenvectors;
    Directions {
        size: [0, 1, 2].map(|k| principal.eigenvalues[k].max(0.0).sqrt()),
        rows: Some([0, 1, 2].map(|k| [0, 1, 2].map(|i| vectors[(i, k)]))),
    }
}

/// How long a cube is at its centre along twice each reference coordinate (m).
fn lengths(shape: Shape, points: &[[f64; 3]]) -> [f64; 3] {
    let centre = RulePoint::new(shape, QuadraturePoint { xi: shape.centroid(), weight: 1.0 });
    std::array::from_fn(|d| {
        let along = |i: usize| -> f64 {
            points.iter().zip(&centre.gradients).map(|(x, g)| x[i] * g[d]).sum()
        };
        2.0 * (0..3).map(|i| along(i).powi(2)).sum::<f64>().sqrt()
    })
}

#[cfg(test)]
#[path = "stability_tests.rs"]
mod tests;
