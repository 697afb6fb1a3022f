//! The porous medium and its cells against their definitions.

use super::super::PorousMedium;
use super::*;
use crate::case::{Material, Porous};
use crate::mesh::axes;

fn medium() -> PorousMedium {
    let material = Material {
        name: "rock".into(),
        z: None,
        groups: Vec::new(),
        young_modulus: 2.0,
        poisson_ratio: 0.2,
        density: None,
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
    PorousCell::new(shape, size, medium(), axes(dim))
}

/// A box has the matrices of a box, also turned, and its coupling turns with it.
#[test]
fn boxes_by_their_points_are_boxes() {
    let step = FlowStep { length: 0.01, theta: 0.7, gravity: [0.0; 3], lumped: false };
    for (dim, order) in [(2, 1), (3, 1), (2, 2), (3, 2)] {
        let of_box = cell(dim, order);
        let shape = Shape::of(dim, order);
        // The plane of the first and the last component turned by 30 degrees.
        let (cos, sin) = (0.75_f64.sqrt(), 0.5);
        let last = dim - 1;
        let turn = |x: [f64; 3]| {
            let mut out = x;
            (out[0], out[last]) = (cos * x[0] - sin * x[last], sin * x[0] + cos * x[last]);
            out
        };
        let place = |xi: &[f64; 3]| std::array::from_fn(|c| 0.5 * of_box.size[c] * xi[c]);
        let points: Vec<[f64; 3]> = shape.node_points().iter().map(|xi| turn(place(xi))).collect();
        let turned = PorousCell::of_points(shape, &points, medium());
        let close = |a: &[f64], b: &[f64]| {
            let largest = b.iter().fold(0.0_f64, |m, b| m.max(b.abs()));
            let differ = a.iter().zip(b).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
            assert!(a.len() == b.len() && differ <= 1e-13 * largest, "{dim} {order} {differ:e}");
        };
        close(&turned.compressibility(&step), &of_box.compressibility(&step));
        close(&turned.held_back(&step)[..dim], &of_box.held_back(&step)[..dim]);
        close(&turned.yielding(), &of_box.yielding());
        let np = of_box.corners();
        let column = |c: &PorousCell, b: usize| -> Vec<f64> {
            c.coupling().iter().skip(b).step_by(np).copied().collect()
        };
        for b in 0..np {
            let rows = column(&of_box, b);
            let exact = rows.chunks_exact(dim).flat_map(|row| {
                let mut v = [0.0; 3];
                v[..dim].copy_from_slice(row);
                turn(v).into_iter().take(dim)
            });
            close(&column(&turned, b), &exact.collect::<Vec<_>>());
        }
    }
}

/// In cells of every kind a uniform pressure does the work of the change of volume, and a linear
/// pressure flows as Darcy says.
#[test]
fn cells_of_every_kind_couple_and_flow() {
    for shape in Shape::ALL.into_iter().filter(|s| s.dim() > 1) {
        let dim = shape.dim();
        let place = |(a, xi): (usize, &[f64; 3])| {
            let shift = |c: usize| 0.03 * ((a * 5 + c * 3) as f64).sin();
            std::array::from_fn(|c| if c < dim { xi[c] + 0.1 * xi[0] + shift(c) } else { 0.0 })
        };
        let points: Vec<[f64; 3]> = shape.node_points().iter().enumerate().map(place).collect();
        let cell = PorousCell::of_points(shape, &points, medium());
        let np = cell.corners();
        let volume: f64 = cell.points.iter().map(|q| q.volume).sum();
        let u: Vec<f64> = points.iter().flat_map(|x| x[..dim].to_vec()).collect();
        let mut stored = [0.0; MAX_CORNERS];
        cell.add_volume(&u, &mut stored);
        let sum: f64 = stored[..np].iter().sum();
        let exact = cell.medium.biot * dim as f64 * volume;
        assert!((sum / exact - 1.0).abs() < 1e-12, "{shape:?} {sum} {exact}");
        let mut force = vec![0.0; u.len()];
        cell.add_force(&vec![2.0; np], &mut force);
        let work: f64 = force.iter().zip(&u).map(|(f, u)| f * u).sum();
        assert!((work / (2.0 * exact) - 1.0).abs() < 1e-12, "{shape:?} {work}");
        // p = 3 x - y at the corners: the power of the flow is mobility |grad p|^2 V where the
        // corners alone make the geometry.
        if shape.order() == 1 {
            let p: Vec<f64> = points.iter().map(|x| 3.0 * x[0] - x[1]).collect();
            let (mut rows, mut sizes) = (vec![0.0; np], vec![0.0; np]);
            let sums = BalanceSums { rows: &mut rows, sizes: &mut sizes };
            let fluid = PorousMedium { fluid: 0.0, ..medium() };
            PorousCell { medium: fluid, ..cell.clone() }.add_flow(&p, &[0.0; 3], 1.0, sums);
            let power: f64 = rows.iter().zip(&p).map(|(r, p)| r * p).sum();
            let exact = 10.0 * fluid.mobility * volume;
            assert!((power / exact - 1.0).abs() < 1e-12, "{shape:?} {power} {exact}");
        }
    }
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
