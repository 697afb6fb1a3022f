//! Cells that are turned over or degenerate.

use super::cells::{Cells, first_of};
use super::words::{count, wrong};
use crate::element::{MAX_NODES, Shape, stiffness_rule};
use crate::error::Result;

/// A Jacobian is zero when it is less than this part of the product of its columns.
const ZERO: f64 = 1e-12;

/// Gradients of the basis at the points of a rule.
struct Rule {
    gradients: Vec<[[f64; 3]; MAX_NODES]>,
}

impl Rule {
    fn new(shape: Shape) -> Self {
        // The Jacobian of a simplex of first order is one for the whole cell.
        let is_constant = matches!(shape, Shape::Tri3 | Shape::Tet4);
        let points = stiffness_rule(shape);
        let points = if is_constant { &points[..1] } else { &points[..] };
        let at = |point: &crate::element::QuadraturePoint| {
            let mut gradients = [[0.0; 3]; MAX_NODES];
            shape.gradients(point.xi, &mut gradients);
            gradients
        };
        Self { gradients: points.iter().map(at).collect() }
    }
}

/// Refuses cells with a Jacobian that is not positive at a point of their rule of integration. They
/// are not turned round: that would hide a wrong order of the nodes, and move their sides.
///
/// # Errors
/// `Input` with their number and the first of them.
pub fn check(cells: &Cells) -> Result<()> {
    check_some(cells, 0..cells.shapes.len())
}

/// As [`check`], of some cells only.
///
/// # Errors
/// As [`check`].
pub fn check_some(cells: &Cells, some: impl Iterator<Item = usize>) -> Result<()> {
    let rules: Vec<Rule> = Shape::ALL.map(Rule::new).into();
    let view = cells.view();
    let mut turned = Vec::new();
    let mut bad = Vec::new();
    for cell in some {
        let shape = cells.shapes[cell];
        let mut points = [[0.0; 3]; MAX_NODES];
        let nodes = view.cell_nodes(cell);
        for (point, node) in points.iter_mut().zip(nodes) {
            *point = cells.points[*node as usize];
        }
        let rule = &rules[shape as usize];
        let at = |gradients| relative(&points[..nodes.len()], gradients, shape.dim());
        if rule.gradients.iter().all(|gradients| at(gradients) > ZERO) {
            continue;
        }
        let is_turned = rule.gradients.iter().all(|gradients| at(gradients) < -ZERO);
        if is_turned { turned.push(cell) } else { bad.push(cell) }
    }
    if !bad.is_empty() {
        return Err(wrong(format!(
            "degenerate or folded, with a Jacobian that is not positive at all points of \
             integration: {}; flat cells have to be meshed anew, folded ones of second order have \
             middle nodes in a wrong order or too far from the middle (finer mesh, \
             Mesh.HighOrderOptimize in Gmsh)",
            first_of(cells, &bad)
        )));
    }
    if turned.is_empty() {
        return Ok(());
    }
    let remedy = if cells.dim() == 2 {
        "in the plane z = 0, nodes run counter-clockwise seen from +z: turn the surface round \
         (Reverse Surface, or a negative physical tag in Gmsh; Orientation in SALOME)"
    } else {
        "write the nodes in the order of the format, or turn the cells round in the program that \
         meshed them"
    };
    Err(wrong(format!(
        "{} of {} turned over, with a negative Jacobian, the first being {}; {remedy}",
        turned.len(),
        count(cells.shapes.len(), "cell"),
        cells.describe(turned[0])
    )))
}

/// The determinant of dx_i/dxi_d against the product of the lengths of its columns.
fn relative(points: &[[f64; 3]], gradients: &[[f64; 3]; MAX_NODES], dim: usize) -> f64 {
    let mut columns = [[0.0; 3]; 3];
    for (x, gradient) in points.iter().zip(gradients) {
        for (column, slope) in columns.iter_mut().zip(gradient) {
            for (sum, x) in column.iter_mut().zip(x) {
                *sum += slope * x;
            }
        }
    }
    if dim == 2 {
        columns[2] = [0.0, 0.0, 1.0];
    }
    let [a, b, c] = columns;
    let determinant = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0]);
    let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let product = length(a) * length(b) * length(c);
    // Not a number counts as zero.
    if product > 0.0 && product.is_finite() { determinant / product } else { 0.0 }
}
