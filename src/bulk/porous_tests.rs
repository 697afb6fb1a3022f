//! The porous medium and its cells against their definitions.

use super::super::PorousMedium;
use super::*;
use crate::case::{Material, Porous};
use crate::element::Shape;

fn medium() -> PorousMedium {
    let material = Material {
        name: "rock".into(),
        z: None,
        young_modulus: 2.0,
        poisson_ratio: 0.2,
        porous: None,
    };
    let porous = Porous {
        biot: 0.8,
        porosity: 0.15,
        permeability: 0.3,
        viscosity: 2.0,
        fluid_compressibility: 0.4,
        fluid_density: 3.0,
        density: 5.0,
        reference_pressure: 0.0,
    };
    PorousMedium::new(&material, &porous, 3)
}

#[test]
fn the_content_is_the_product_of_density_porosity_and_volume() {
    let m = medium();
    for (strain, p) in [(0.0, 0.0), (0.02, 0.3), (-0.01, -0.2), (1e-9, 1e-9)] {
        let rho = (m.fluid * p).exp();
        let phi = m.biot - (m.biot - m.porosity) * (-strain - p * m.grains).exp();
        let change = rho * phi * (1.0 + strain) - m.porosity;
        assert!((m.content(strain, p) - change).abs() < 1e-15);
        assert!((m.porosity_at(strain, p) - phi).abs() < 1e-15);
    }
    let small = m.content(1e-12, 0.0);
    assert!((small / (m.biot * 1e-12) - 1.0).abs() < 1e-11, "no cancellation");
}

#[test]
fn at_rest_the_content_grows_by_biot_and_by_the_storage() {
    let m = medium();
    let step = 1e-6;
    let slope = |to: &dyn Fn(f64) -> f64| (to(step) - to(-step)) / (2.0 * step);
    assert!((slope(&|e| m.content(e, 0.0)) - m.biot).abs() < 1e-11);
    assert!((slope(&|p| m.content(0.0, p)) - m.storage()).abs() < 1e-11);
}

fn cell(dim: usize, order: usize) -> PorousCell {
    let size = if dim == 2 { [0.5, 1.0, 2.0] } else { [0.5, 0.25, 2.0] };
    let shape = Shape::of(dim, order);
    PorousCell::new(&Prototype { size, material: 0, shape }, medium(), dim)
}

/// The linearised balance is that of the tangent: central differences at rest.
#[test]
fn the_tangent_at_rest_is_the_difference_of_the_balance() {
    for (dim, order, lumped) in
        [(2, 1, false), (3, 1, true), (2, 2, false), (3, 2, true), (3, 1, false)]
    {
        let cell = cell(dim, order);
        let gravity = [0.0; 3];
        let step = FlowStep { length: 0.01, theta: 0.7, gravity, lumped };
        let (np, n) = (cell.corners(), cell.points[0].divergence.len());
        let at = |u: &[f64], p: &[f64]| {
            let (mut rows, mut sizes) = (vec![0.0; np], vec![0.0; np]);
            let end = PoroState { displacement: u, pressure: p };
            let sums = BalanceSums { rows: &mut rows, sizes: &mut sizes };
            cell.add_balance(end, &vec![0.0; np], &step, sums);
            rows
        };
        let h = 1e-6;
        let matrix = cell.compressibility(&step);
        let difference = |change: &dyn Fn(f64) -> Vec<f64>| -> Vec<f64> {
            let pairs = change(h).into_iter().zip(change(-h));
            pairs.map(|(a, b)| (a - b) / (2.0 * h)).collect()
        };
        for b in 0..np {
            let column = difference(&|h| {
                let mut p = vec![0.0; np];
                p[b] = h;
                at(&vec![0.0; n], &p)
            });
            for a in 0..np {
                assert!((column[a] - matrix[a * np + b]).abs() < 1e-8, "{dim} {order} {lumped}");
            }
        }
        for j in 0..n {
            let column = difference(&|h| {
                let mut u = vec![0.0; n];
                u[j] = h;
                at(&u, &vec![0.0; np])
            });
            let mut unit = vec![0.0; n];
            unit[j] = 1.0;
            let mut volume = [0.0; MAX_CORNERS];
            cell.add_volume(&unit, &mut volume);
            for a in 0..np {
                assert!((column[a] - volume[a]).abs() < 1e-8, "{dim} {order} {lumped}");
            }
        }
    }
}

#[test]
fn a_constant_pressure_pushes_outwards_with_b_p_on_every_face() {
    let cell = cell(3, 2);
    let mut force = vec![0.0; cell.points[0].divergence.len()];
    cell.add_force(&[2.0; 8], &mut force);
    // On the face towards +x: b p times its area, 0.25 x 2.
    let shape = Shape::of(3, 2);
    let right = shape.node_points().iter().enumerate().filter(|(_, x)| x[0] == 1.0);
    let total: f64 = right.map(|(a, _)| force[3 * a]).sum();
    assert!((total - 0.8 * 2.0 * 0.5).abs() < 1e-14, "{total}");
}

/// Undrained and without flow, what cells of first order are held back by makes the pressures of a
/// line of cells independent of each other: the matrix that is left when the displacements are
/// eliminated has no entry of the wrong sign.
#[test]
fn what_is_held_back_makes_a_line_of_cells_monotone() {
    let cell = cell(2, 1);
    let m = cell.medium;
    for lumped in [false, true] {
        let still = FlowStep { length: 0.0, theta: 1.0, gravity: [0.0; 3], lumped };
        let held = cell.held_back(&still)[1];
        // Along z: two pressures; the displacements give b^2/M times 1/4 h everywhere.
        let h = cell.size[1];
        let off = m.biot * m.biot / m.oedometric * 0.25 * h - held / h
            + if lumped { 0.0 } else { m.storage() * h / 6.0 };
        assert!(off.abs() < 1e-14, "{off}");
    }
    let long = FlowStep { length: 1e9, theta: 1.0, gravity: [0.0; 3], lumped: false };
    assert_eq!(cell.held_back(&long), [0.0; 3]);
}
