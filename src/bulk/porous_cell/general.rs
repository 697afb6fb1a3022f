//! Porous cells that are no boxes.

use super::{MAX_CORNERS, Point, PorousCell, entries};
use crate::bulk::PorousMedium;
use crate::bulk::rule::{Physical, RulePoint};
use crate::element::{Family, QuadraturePoint, Shape, quadrature};

impl PorousCell {
    /// Integrates over a cell of any geometry with these nodes by displacement component (m).
    pub fn of_points(shape: Shape, points: &[[f64; 3]], medium: PorousMedium) -> Self {
        let (dim, corners) = (shape.dim(), shape.corners());
        // Simplices, prisms and pyramids have no directions of their own.
        let is_cube = shape.family() == Family::Cube;
        let lengths = lengths(shape, points);
        let longest = lengths[..dim].iter().fold(0.0_f64, |m, h| m.max(*h));
        let size = if is_cube { lengths } else { [longest; 3] };
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
                slopes[a] =
                    if is_cube { [0, 1, 2].map(|d| 2.0 * g[d] / size[d]) } else { gradients[a] };
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

/// How long a cell is at its centre along twice each reference coordinate (m).
fn lengths(shape: Shape, points: &[[f64; 3]]) -> [f64; 3] {
    let centre = RulePoint::new(shape, QuadraturePoint { xi: shape.centroid(), weight: 1.0 });
    std::array::from_fn(|d| {
        let along = |i: usize| -> f64 {
            points.iter().zip(&centre.gradients).map(|(x, g)| x[i] * g[d]).sum()
        };
        2.0 * (0..3).map(|i| along(i).powi(2)).sum::<f64>().sqrt()
    })
}
