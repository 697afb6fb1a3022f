//! The stiffness of single cells against that of boxes and against definitions.

use super::*;
use crate::bulk::Stiffness;

const SIZE: [f64; 3] = [0.5, 0.25, 2.0];

const PLANE: &[usize] = &[0, 2];
const SPACE: &[usize] = &[0, 1, 2];

fn elastic() -> Elastic {
    Elastic::new(5.8e9, 0.3)
}

fn matrix_of(general: &General, points: &[[f64; 3]]) -> Vec<f64> {
    let size = points.len() * general.axes.len();
    let mut matrix = vec![f64::NAN; size * size];
    general.matrix(points, &mut matrix);
    matrix
}

fn largest(matrix: &[f64]) -> f64 {
    matrix.iter().fold(0.0, |m, k| m.max(k.abs()))
}

fn differ(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |m, (a, b)| m.max((a - b).abs()))
}

/// The nodes of a cell that is the reference cell stretched, by component.
fn stretched(shape: Shape, axes: &[usize]) -> Vec<[f64; 3]> {
    let place = |xi: &[f64; 3]| {
        let mut x = [0.0; 3];
        axes.iter().enumerate().for_each(|(c, axis)| x[c] = 7.0 + 0.5 * SIZE[*axis] * xi[c]);
        x
    };
    shape.node_points().iter().map(place).collect()
}

/// As `stretched`, with every node moved by up to `by` times its size.
fn distorted(shape: Shape, axes: &[usize], by: f64) -> Vec<[f64; 3]> {
    let mut points = stretched(shape, axes);
    for (a, x) in points.iter_mut().enumerate() {
        for (c, axis) in axes.iter().enumerate() {
            x[c] += by * SIZE[*axis] * ((a * 5 + c * 3) as f64).sin();
        }
    }
    points
}

#[test]
fn boxes_have_the_stiffness_of_boxes() {
    let cells = [Shape::Quad4, Shape::Quad9, Shape::Hex8, Shape::Hex27];
    for (shape, b_bar) in cells.into_iter().flat_map(|s| [(s, false), (s, true)]) {
        let all: &[&'static [usize]] = if shape.dim() == 2 { &[PLANE, &[0, 1]] } else { &[SPACE] };
        for axes in all.iter().copied() {
            let general = General::new(shape, elastic(), axes, b_bar);
            let of_box = Stiffness::new(shape, SIZE, elastic(), axes, b_bar);
            let points = stretched(shape, axes);
            let matrix = matrix_of(&general, &points);
            let error = differ(&matrix, &of_box.matrix) / largest(&of_box.matrix);
            assert!(error < 1e-13, "{shape:?} {b_bar}: {error:e}");
            let u: Vec<f64> = (0..points.len() * axes.len()).map(|i| (i as f64).sin()).collect();
            let (found, exact) = (general.stress(&points, &u), of_box.stress(&u));
            assert!(differ(&found, &exact) < 1e-12 * largest(&exact), "{found:?} {exact:?}");
        }
    }
}

#[test]
fn the_diagonal_is_that_of_the_matrix() {
    for shape in Shape::ALL.into_iter().filter(|s| s.dim() > 1) {
        let axes = if shape.dim() == 2 { PLANE } else { SPACE };
        for b_bar in [false, true] {
            let general = General::new(shape, elastic(), axes, b_bar);
            let points = distorted(shape, axes, 0.03);
            let matrix = matrix_of(&general, &points);
            let size = matrix.len().isqrt();
            let mut diagonal = vec![f64::NAN; size];
            general.diagonal(&points, &mut diagonal);
            let entries: Vec<f64> = matrix.iter().step_by(size + 1).copied().collect();
            assert!(differ(&diagonal, &entries) < 1e-13 * largest(&matrix), "{shape:?} {b_bar}");
        }
    }
}

/// A simplex with sides that are almost straight takes the other rule and the projection, and both
/// change nothing.
#[test]
fn simplices_with_straight_sides_need_no_projection_and_few_points() {
    for shape in [Shape::Tri6, Shape::Tet10] {
        let axes = if shape.dim() == 2 { PLANE } else { SPACE };
        let points = stretched(shape, axes);
        let mut bent = points.clone();
        bent[shape.corners().nodes()][0] += 1e-11;
        for b_bar in [false, true] {
            let general = General::new(shape, elastic(), axes, b_bar);
            assert!(general.is_straight(&points) && !general.is_straight(&bent));
            let (few, many) = (matrix_of(&general, &points), matrix_of(&general, &bent));
            assert!(differ(&few, &many) < 1e-9 * largest(&few), "{shape:?} {b_bar}");
        }
    }
}

/// Bending changes the sign of the volumetric strain across the cell: full integration locks.
#[test]
fn distorted_cells_of_nearly_incompressible_material_are_soft_in_bending() {
    let energy = |shape: Shape, nu: f64, b_bar: bool| {
        let points = distorted(shape, SPACE, 0.003);
        let general = General::new(shape, Elastic::new(1.0, nu), SPACE, b_bar);
        let matrix = matrix_of(&general, &points);
        let bend = |x: &[f64; 3]| [(x[0] - 7.0) * (x[2] - 7.0), 0.0, 0.0];
        let u: Vec<f64> = points.iter().flat_map(bend).collect();
        let rows = matrix.chunks_exact(u.len()).zip(&u);
        rows.map(|(row, v)| v * row.iter().zip(&u).map(|(k, u)| k * u).sum::<f64>()).sum::<f64>()
    };
    for shape in [Shape::Hex8, Shape::Prism6] {
        assert!(energy(shape, 0.4999, false) > 20.0 * energy(shape, 0.0, false), "{shape:?}");
        assert!(energy(shape, 0.4999, true) < 3.0 * energy(shape, 0.0, true), "{shape:?}");
    }
}
