//! Patch tests, and the sweeps against the matrices of the cells.

use super::testkit::{Grid, REGULAR, Shaken, forces};
use crate::assembly::{CellSet, Cells};
use crate::bulk::Elastic;
use crate::element::{Family, Shape};

const SHAKEN: Shaken = Shaken { corners: 0.15, middles: 0.0 };
const BENT: Shaken = Shaken { corners: 0.1, middles: 0.04 };

fn bodies() -> impl Iterator<Item = (Shape, Shaken)> {
    let shapes = Shape::ALL.into_iter().filter(|s| s.dim() > 1);
    shapes.flat_map(|s| [(s, REGULAR), (s, SHAKEN), (s, BENT)])
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, v| m.max(v.abs()))
}

/// u = h x.
fn linear(h: [[f64; 3]; 3]) -> impl Fn([f64; 3]) -> [f64; 3] {
    move |x| h.map(|row| row.iter().zip(x).map(|(h, x)| h * x).sum())
}

/// Twice the density of energy under the displacement gradient `h` in a space of `dim` dimensions.
fn density(elastic: Elastic, h: [[f64; 3]; 3], dim: usize) -> f64 {
    let trace: f64 = (0..dim).map(|i| h[i][i]).sum();
    let pairs = (0..dim).flat_map(|i| (0..dim).map(move |j| (i, j)));
    let squares: f64 = pairs.map(|(i, j)| (0.5 * (h[i][j] + h[j][i])).powi(2)).sum();
    elastic.lambda * trace * trace + 2.0 * elastic.mu * squares
}

/// Matrices of the cells times u, and the sums of the lengths of their forces.
fn by_matrices(cells: &Cells, dim: usize, u: &[f64]) -> [Vec<f64>; 2] {
    let (mut force, mut sizes) = (vec![0.0; u.len()], vec![0.0; u.len() / dim]);
    let mut buffer = Vec::new();
    for cell in 0..cells.len() {
        let unknowns: Vec<usize> = cells
            .nodes(cell)
            .iter()
            .flat_map(|n| (0..dim).map(move |c| *n as usize * dim + c))
            .collect();
        let matrix = cells.matrix(cell, &mut buffer);
        let row = |row: &[f64]| row.iter().zip(&unknowns).map(|(k, i)| k * u[*i]).sum::<f64>();
        let of_cell: Vec<f64> = matrix.chunks_exact(unknowns.len()).map(row).collect();
        for (node, f) in cells.nodes(cell).iter().zip(of_cell.chunks_exact(dim)) {
            sizes[*node as usize] += f.iter().map(|f| f * f).sum::<f64>().sqrt();
            (0..dim).for_each(|c| force[*node as usize * dim + c] += f[c]);
        }
    }
    [force, sizes]
}

#[test]
fn a_constant_strain_passes_the_patch_test() {
    let h = [[1e-3, 2e-4, -3e-4], [1e-4, 5e-4, 6e-4], [2e-4, 7e-4, -4e-4]];
    for (shape, shaken) in bodies() {
        let grid = Grid::new(shape, 3, shaken);
        let (dim, u) = (shape.dim(), grid.values(linear(h)));
        for (nu, b_bar) in [(0.3, false), (0.3, true), (0.499, true)] {
            let elastic = Elastic::new(1.0, nu);
            let cells = grid.with(elastic, b_bar);
            let force = forces(&cells, &u);
            for (node, f) in force.chunks_exact(dim).enumerate().filter(|(n, _)| grid.is_inside(*n))
            {
                let rest = largest(f) / largest(&force);
                assert!(rest < 1e-12, "{shape:?} {b_bar} node {node}: {rest:e}");
            }
            let energy: f64 = force.iter().zip(&u).map(|(f, u)| f * u).sum();
            let exact = density(elastic, h, dim);
            assert!((energy / exact - 1.0).abs() < 1e-12, "{shape:?} {b_bar}: {energy} {exact}");
            let trace: f64 = (0..dim).map(|i| h[i][i]).sum();
            for cell in 0..cells.len() {
                let of = |n: &u32| u[*n as usize * dim..][..dim].to_vec();
                let of_cell: Vec<f64> = cells.nodes(cell).iter().flat_map(of).collect();
                let stress = cells.stress(cell, &of_cell);
                let xx = elastic.lambda * trace + 2.0 * elastic.mu * h[0][0];
                let xy = elastic.mu * (h[0][1] + h[1][0]);
                assert!((stress[0] - xx).abs() < 1e-12 * xx.abs(), "{shape:?} {stress:?} {xx}");
                assert!((stress[3] - xy).abs() < 1e-12 * xx.abs(), "{shape:?} {stress:?} {xy}");
            }
        }
    }
}

#[test]
fn rigid_motions_need_no_force() {
    let turn = linear([[0.0, -1.0, 2.0], [1.0, 0.0, 0.5], [-2.0, -0.5, 0.0]]);
    for (shape, shaken) in bodies() {
        let grid = Grid::new(shape, 3, shaken);
        let u = grid.values(|x| turn(x).map(|u| u + 3.0));
        for b_bar in [false, true] {
            let cells = grid.with(Elastic::new(5.8e9, 0.3), b_bar);
            let force = forces(&cells, &u);
            let of_motion = cells.largest_diagonal() * largest(&u);
            assert!(largest(&force) < 1e-13 * of_motion, "{shape:?} {b_bar}");
        }
    }
}

#[test]
fn the_sweep_gives_the_forces_of_the_matrices() {
    for (shape, shaken) in bodies() {
        let grid = Grid::new(shape, 3, shaken);
        let dim = shape.dim();
        let u: Vec<f64> =
            (0..grid.points.len() * dim).map(|i| (1.7 * i as f64 * i as f64).sin()).collect();
        for b_bar in [false, true] {
            let mut cells = grid.with(Elastic::new(5.8e9, 0.3), b_bar);
            let [exact, sizes] = by_matrices(&cells, dim, &u);
            let (mut force, mut found) = (vec![0.0; u.len()], vec![0.0; u.len() / dim]);
            cells.add_forces(CellSet::All, &u, &mut force, Some(&mut found));
            let close = |a: &[f64], b: &[f64]| {
                let differ: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
                assert!(largest(&differ) < 1e-13 * largest(b), "{shape:?} {b_bar}");
            };
            close(&force, &exact);
            close(&found, &sizes);
            let mut apart = vec![0.0; u.len()];
            let (owned, ghosts) = apart.split_at_mut(u.len() / (2 * dim) * dim);
            cells.add_forces_apart(&u, owned, ghosts);
            assert_eq!(apart, force, "{shape:?}");
            // A part of the cells alone.
            let half: Vec<u32> = (0..cells.len() as u32).step_by(2).collect();
            let others: Vec<u32> = (1..cells.len() as u32).step_by(2).collect();
            let mut sum = vec![0.0; u.len()];
            for set in [half, others] {
                cells.set_layer(set);
                cells.add_forces(CellSet::Layer, &u, &mut sum, None);
            }
            close(&sum, &exact);
        }
    }
}

/// Cells of second order hold every quadratic function, and the rule is exact where the Jacobian is
/// constant.
#[test]
fn the_energy_of_a_quadratic_field_is_exact_in_second_order() {
    let elastic = Elastic::new(1.0, 0.25);
    for shape in Shape::ALL.into_iter().filter(|s| s.dim() > 1 && s.order() == 2) {
        let is_simplex = shape.family() == Family::Simplex;
        let grid = Grid::new(shape, 3, if is_simplex { SHAKEN } else { REGULAR });
        let (dim, cells) = (shape.dim(), grid.with(elastic, false));
        let u =
            grid.values(|x| [x[0] * x[1], x[1] * x[1] - x[0] * x[0], x[0] * x[1] + x[2] * x[2]]);
        let energy: f64 = forces(&cells, &u).iter().zip(&u).map(|(f, u)| f * u).sum();
        // div = 3 y (+ 2 z); the squares of the strains by hand, over the unit square or cube.
        let (div, squares) = if dim == 2 {
            (3.0, 5.0 / 3.0 + 0.5 / 3.0)
        } else {
            (3.0 + 3.0 + 4.0 / 3.0, 5.0 / 3.0 + 0.5 / 3.0 + 4.0 / 3.0 + 0.5 / 3.0 + 0.5 / 3.0)
        };
        let exact = elastic.lambda * div + 2.0 * elastic.mu * squares;
        assert!((energy / exact - 1.0).abs() < 1e-12, "{shape:?}: {energy} {exact}");
    }
}
