//! Observed orders of convergence of pore pressure and displacement together (WTNV141).

#![allow(clippy::print_stdout)] // the figures, with --nocapture

use std::f64::consts::PI;

use column_hpc::element::{gauss, map_point, mapping};

use crate::grid::{plane, read};
use crate::scene::{Run, Scene};

/// Pressure and displacement of `cases/wtnv141` at a time.
fn exact(time: f64, [x, z]: [f64; 2]) -> (f64, [f64; 2]) {
    let size = 1e-6 * (-2.0 * PI * PI * 0.05 * time).exp();
    let ((sx, cx), (sz, cz)) = ((PI * x).sin_cos(), (PI * z).sin_cos());
    (size * sx * sz, [-size * cx * sz / (2.0 * PI), -size * sx * cz / (2.0 * PI)])
}

/// The shipped case with `steps` equal steps to `end`.
fn scene(cells: usize, steps: usize, end: f64) -> Scene {
    let instants: Vec<String> =
        (1..=steps).map(|n| format!("{:e}", end * n as f64 / steps as f64)).collect();
    Scene::shipped("wtnv141/case.yaml")
        .set(&format!("mesh.column.cells=[{cells}, {cells}]"))
        .set(&format!("time.instants=[{}]", instants.join(", ")))
        .set(&format!("output.fields=[{end:e}]"))
        .set("expect=")
        .in_any_steps()
        .with_fields()
}

/// Relative errors in L2 of pressure and displacement at the last of `steps` instants.
fn errors(run: &Run, steps: usize, end: f64) -> [f64; 2] {
    let file = run.directory.join(format!("fields/bulk_{steps:06}.vtkhdf"));
    let (p, u) = (read(&file, "pressure"), read(&file, "displacement"));
    let mut sums = [[0.0; 2]; 2];
    for (shape, nodes) in &p.cells {
        let points: Vec<[f64; 2]> = nodes.iter().map(|n| plane(p.points[*n])).collect();
        for q in gauss(*shape, 5) {
            let weight = q.weight * mapping(*shape, &points, q.xi).determinant;
            let mut n = [0.0; 27];
            shape.values(q.xi, &mut n);
            let (pressure, [ux, uz]) = exact(end, map_point(*shape, &points, q.xi));
            let mut error = [-pressure, -ux, -uz];
            for (node, n) in nodes.iter().zip(n) {
                error[0] += n * p.values[*node][0];
                error[1] += n * u.values[*node][0];
                error[2] += n * u.values[*node][2];
            }
            sums[0][0] += weight * error[0] * error[0];
            sums[0][1] += weight * pressure * pressure;
            sums[1][0] += weight * (error[1] * error[1] + error[2] * error[2]);
            sums[1][1] += weight * (ux * ux + uz * uz);
        }
    }
    sums.map(|[error, exact]| f64::sqrt(error / exact))
}

/// Cells of both orders with steps whose error is a part of those of the last level. The
/// displacement follows the pressure, whose error is of second order in any norm; see the next
/// test.
#[test]
fn in_space() {
    let (steps, end) = (4, 0.1);
    for (order, coarsest) in [(2, 8), (1, 16)] {
        let of = |level: usize| {
            let run = scene(coarsest << level, steps, end).set(&format!("mesh.order={order}"));
            errors(&run.on(1), steps, end)
        };
        let all = [0, 1, 2].map(of);
        assert_orders(&format!("order {order}"), &all, [1.9, 1.9]);
    }
}

/// The displacement alone: with nodal values that make the initial pressure the best one in L2,
/// whose error is of higher order as a load, the displacements of the start converge with third
/// order.
#[test]
fn of_the_equilibrium_at_the_start() {
    let end = 1e-9;
    let of = |cells: usize| {
        let phase = PI / cells as f64;
        let along = 6.0 * (1.0 - phase.cos()) / (phase * phase * (2.0 + phase.cos()));
        let size = 1e-6 * along * along;
        let pressure = format!("initial.pressure={{formula: \"{size:e}*sin(pi*x)*sin(pi*z)\"}}");
        errors(&scene(cells, 1, end).set(&pressure).on(1), 1, end)
    };
    let all = [8, 16, 32, 64].map(of);
    assert_orders("start", &all, [1.9, 2.9]);
}

/// Prints relative errors level by level, and asserts the orders between the last two.
fn assert_orders(label: &str, all: &[[f64; 2]], least: [f64; 2]) {
    for (field, least) in least.into_iter().enumerate() {
        let errors: Vec<f64> = all.iter().map(|e| e[field]).collect();
        let orders: Vec<f64> = errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect();
        let name = ["pressure", "displacement"][field];
        let words: Vec<String> = errors.iter().map(|error| format!("{error:.2e}")).collect();
        println!("{label}, {name}: errors {}, orders {orders:.2?}", words.join(", "));
        assert!(orders.last().is_some_and(|o| *o >= least), "{label}, {name}: {orders:?}");
    }
}

/// Differences to many steps on the same mesh, in which errors of space cancel.
#[test]
fn in_time() {
    let end = 0.4;
    let of = |steps: usize, theta: f64| {
        let run = scene(8, steps, end).set(&format!("time.theta={theta}")).on(1);
        let file = run.directory.join(format!("fields/bulk_{steps:06}.vtkhdf"));
        ["pressure", "displacement"].map(|name| read(&file, name).values)
    };
    let finest = of(256, 0.5);
    let difference = |values: &[[f64; 3]], exact: &[[f64; 3]]| {
        let square = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>();
        let (values, exact) = (values.as_flattened(), exact.as_flattened());
        let errors: Vec<f64> = values.iter().zip(exact).map(|(a, b)| a - b).collect();
        (square(&errors) / square(exact)).sqrt()
    };
    for (theta, least) in [(1.0, 0.9), (0.5, 1.9)] {
        let all = [4, 8, 16, 32].map(|steps| {
            let [p, u] = of(steps, theta);
            [difference(&p, &finest[0]), difference(&u, &finest[1])]
        });
        assert_orders(&format!("theta {theta}"), &all, [least; 2]);
    }
}
