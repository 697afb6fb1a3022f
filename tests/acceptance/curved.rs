//! Observed orders of convergence with a curved interface between meshes that do not match: a round
//! inclusion in an infinite plate, a ball in an infinite body, each cut out between two radii where
//! the exact displacements are prescribed.

#![allow(clippy::print_stdout)] // the figures, with --nocapture

use std::f64::consts::FRAC_PI_2;

use column_hpc::element::{gauss, map_point, mapping};

use crate::blocks::{Block, Blocks, even};
use crate::grid::{Grid, read};
use crate::inclusions::{Ball, ELASTIC, Exact, Inclusion, RADII, lame};
use crate::scene::{Run, Scene};

/// Squares of error and exact values of one quantity.
type Square = [f64; 2];

/// Displacement in L2 and strain in energy.
fn bulk_errors<const DIM: usize>(grid: &Grid, exact: &dyn Exact) -> [Square; 2] {
    let mut sums = [[0.0; 2]; 2];
    for (shape, nodes) in &grid.cells {
        let points: Vec<[f64; DIM]> =
            nodes.iter().map(|n| std::array::from_fn(|i| grid.points[*n][i])).collect();
        let centre =
            points.iter().fold([0.0; DIM], |sum, x| std::array::from_fn(|i| sum[i] + x[i]));
        let far = centre.iter().map(|x| x * x).sum::<f64>().sqrt() / points.len() as f64;
        let body = usize::from(far > 1.0);
        let (lambda, mu) = lame(body);
        for q in gauss(*shape, 4) {
            let map = mapping(*shape, &points, q.xi);
            let weight = q.weight * map.determinant;
            let (mut n, mut slopes) = ([0.0; 27], [[0.0; 3]; 27]);
            shape.values(q.xi, &mut n);
            shape.gradients(q.xi, &mut slopes);
            let x: [f64; DIM] = map_point(*shape, &points, q.xi);
            let x: [f64; 3] = std::array::from_fn(|i| if i < DIM { x[i] } else { 0.0 });
            let u = exact.displacement(body, x);
            let h = gradient(exact, body, x, DIM);
            let (mut error, mut slope_error) = (u, h);
            for (a, node) in nodes.iter().enumerate() {
                let slope = map.gradient(slopes[a], DIM);
                for i in 0..DIM {
                    error[i] -= n[a] * grid.values[*node][i];
                    for j in 0..DIM {
                        slope_error[i][j] -= grid.values[*node][i] * slope[j];
                    }
                }
            }
            let square = |v: [f64; 3]| v.iter().map(|v| v * v).sum::<f64>();
            let energy = |h: [[f64; 3]; 3]| {
                let trace: f64 = (0..3).map(|i| h[i][i]).sum();
                let strain = |k: usize| 0.5 * (h[k / 3][k % 3] + h[k % 3][k / 3]);
                lambda * trace * trace + 2.0 * mu * (0..9).map(|k| strain(k).powi(2)).sum::<f64>()
            };
            let values = [[square(error), square(u)], [energy(slope_error), energy(h)]];
            for (sum, value) in sums.iter_mut().flatten().zip(values.iter().flatten()) {
                *sum += weight * value;
            }
        }
    }
    sums
}

/// By differences, exact to ten digits.
fn gradient(exact: &dyn Exact, body: usize, x: [f64; 3], dim: usize) -> [[f64; 3]; 3] {
    const STEP: f64 = 1e-4;
    let mut h = [[0.0; 3]; 3];
    for j in 0..dim {
        let at = |step: f64| {
            let mut moved = x;
            moved[j] += step;
            exact.displacement(body, moved)
        };
        let [low, high] = [at(-STEP), at(STEP)];
        (0..3).for_each(|i| h[i][j] = (high[i] - low[i]) / (2.0 * STEP));
    }
    h
}

/// Traction in L2.
fn traction_errors(grid: &Grid, exact: &dyn Exact) -> Square {
    let mut sums = [0.0; 2];
    for (shape, nodes) in &grid.cells {
        for q in gauss(*shape, 4) {
            let (mut n, mut slopes) = ([0.0; 27], [[0.0; 3]; 27]);
            shape.values(q.xi, &mut n);
            shape.gradients(q.xi, &mut slopes);
            let (mut x, mut t, mut along) = ([0.0; 3], [0.0; 3], [[0.0; 3]; 2]);
            for (a, node) in nodes.iter().enumerate() {
                for i in 0..3 {
                    x[i] += n[a] * grid.points[*node][i];
                    t[i] += n[a] * grid.values[*node][i];
                    along[0][i] += slopes[a][0] * grid.points[*node][i];
                    along[1][i] += slopes[a][1] * grid.points[*node][i];
                }
            }
            let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| a[i] * b[i]).sum::<f64>();
            let [u, v] = along;
            let area = if shape.dim() == 1 {
                dot(u, u).sqrt()
            } else {
                (dot(u, u) * dot(v, v) - dot(u, v).powi(2)).sqrt()
            };
            let right = exact.traction(x);
            let error: [f64; 3] = std::array::from_fn(|i| t[i] - right[i]);
            sums[0] += q.weight * area * dot(error, error);
            sums[1] += q.weight * area * dot(right, right);
        }
    }
    sums
}

/// Relative errors of displacement, energy and traction.
fn errors<const DIM: usize>(run: &Run, exact: &dyn Exact) -> [f64; 3] {
    let file = |name: &str| run.directory.join(format!("fields/{name}_000001.vtkhdf"));
    let [displacement, energy] = bulk_errors::<DIM>(&read(&file("bulk"), "displacement"), exact);
    let traction = traction_errors(&read(&file("rim"), "traction"), exact);
    [displacement, energy, traction].map(|[error, exact]| (error / exact).sqrt())
}

/// Orders between two levels.
fn observed(label: &str, levels: [[f64; 3]; 2]) -> [f64; 3] {
    let orders = std::array::from_fn(|i| (levels[0][i] / levels[1][i]).log2());
    println!("{label}: orders {orders:.2?} of {levels:.7?}");
    orders
}

/// A case on both bodies.
fn scene(mesh: &str, law: &str, boundary: &str) -> Scene {
    let material = |name: &str, body: usize| {
        let (e, nu) = ELASTIC[body];
        format!("{name}: {{elastic: {{young_modulus: {e:e}, poisson_ratio: {nu}}}}}")
    };
    let yaml = format!(
        "
mesh: {{file: \"{mesh}\"}}
materials: {{{}, {}}}
interfaces: [{{name: rim, between: [rim_in, rim_out], law: {{{law}: {{}}}}}}]
boundary:
{boundary}
time: {{instants: [1]}}
",
        material("inner", 0),
        material("outer", 1),
    );
    Scene::new("curved", &yaml)
}

/// So many cells over a quarter of the circle, of the inner and the outer body.
fn inclusion(exact: &Inclusion, law: &str, cells: [usize; 2], order: usize) -> Scene {
    let mut blocks = Blocks::default();
    let place = |[r, angle, _]: [f64; 3]| [r * (FRAC_PI_2 - angle).sin(), r * angle.sin(), 0.0];
    let ends = [[RADII[0], 1.0], [1.0, RADII[1]]];
    let names = [["inner", "core", "rim_in"], ["outer", "rim_out", "edge"]];
    for body in [0, 1] {
        let n = cells[body];
        let [from, to] = ends[body];
        let radii = even(n / 2 * (body + 1), to - from).iter().map(|r| from + r).collect();
        let planes = [radii, even(n, FRAC_PI_2)];
        let [name, low, high] = names[body];
        let sides = [(0, false, low), (0, true, high), (1, false, "axis_x"), (1, true, "axis_y")];
        blocks.add(&Block { name, planes: &planes, order, place: &place, sides: &sides });
    }
    let [core, edge] = [0, 1].map(|body| {
        let [x, y] = exact.formulas(body);
        format!("displacement: {{x: {{formula: \"{x}\"}}, y: {{formula: \"{y}\"}}}}")
    });
    let boundary = format!(
        "  - {{on: axis_x, displacement: {{y: 0}}}}
  - {{on: axis_y, displacement: {{x: 0}}}}
  - {{on: core, {core}}}
  - {{on: edge, {edge}}}"
    );
    scene(&blocks.write(), law, &boundary)
}

/// The sector of directions (1, s, t), s and t from 0 to 1, with so many cells along them.
fn ball(exact: &Ball, law: &str, cells: [usize; 2]) -> Scene {
    let mut blocks = Blocks::default();
    let place = |[r, s, t]: [f64; 3]| {
        let size = (1.0 + s * s + t * t).sqrt();
        [r / size, r * s / size, r * t / size]
    };
    let ends = [[RADII[0], 1.0], [1.0, RADII[1]]];
    let names = [["inner", "core", "rim_in"], ["outer", "rim_out", "edge"]];
    for body in [0, 1] {
        let n = cells[body];
        let [from, to] = ends[body];
        let radii = even(n / 2 * (body + 1), to - from).iter().map(|r| from + r).collect();
        let planes = [radii, even(n, 1.0), even(n, 1.0)];
        let [name, low, high] = names[body];
        let mut sides = vec![(0, false, low), (0, true, high)];
        sides.extend([(1, false, "wall_1"), (1, true, "wall_2")]);
        sides.extend([(2, false, "wall_3"), (2, true, "wall_4")]);
        blocks.add(&Block { name, planes: &planes, order: 1, place: &place, sides: &sides });
    }
    let mut boundary = String::new();
    for (surface, body) in [("core", 0), ("edge", 1)] {
        let parts = ["x", "y", "z"]
            .map(|axis| format!("{axis}: {{formula: \"{}\"}}", exact.formula(body, axis)));
        boundary += &format!("  - {{on: {surface}, displacement: {{{}}}}}\n", parts.join(", "));
    }
    for wall in 1..=4 {
        boundary += &format!("  - {{on: wall_{wall}, displacement: {{normal: 0}}}}\n");
    }
    scene(&blocks.write(), law, &boundary)
}

/// On the axes, where one component is prescribed, the multiplier of that component is dropped and
/// its neighbour extended as a constant: that promises 1.5 for a shear traction that rises from
/// there, as the bonded inclusion has it. Without friction there is none.
#[test]
fn a_round_inclusion_converges_with_the_orders_of_its_cells() {
    for (law, bonded) in [("tied", true), ("contact", false)] {
        let exact = Inclusion::new(bonded);
        for (order, counts) in [(1, [16, 32]), (2, [8, 16])] {
            for pair in [[2, 3], [3, 2]] {
                let level = |n: usize| {
                    let scene = inclusion(&exact, law, pair.map(|part| n * part / 2), order);
                    errors::<2>(&scene.with_fields().on(1), &exact)
                };
                let label = format!("{law}, order {order}, {pair:?}");
                let orders = observed(&label, counts.map(level));
                let p = order as f64;
                assert!(orders[0] > p + 0.9, "{label}: {orders:?}");
                assert!(orders[1] > p - 0.1, "{label}: {orders:?}");
                let least = if bonded { 1.4 } else { p - 0.1 };
                assert!(orders[2] > least, "{label}: {orders:?}");
            }
        }
    }
}

#[test]
fn a_ball_in_a_body_converges_with_the_order_of_its_cells() {
    let exact = Ball::new();
    for (law, pair) in [("tied", [3, 4]), ("contact", [4, 3])] {
        let level = |n: usize| {
            let scene = ball(&exact, law, pair.map(|part| n * part)).with_fields();
            errors::<3>(&scene.on(1), &exact)
        };
        let label = format!("{law}, {pair:?}");
        let orders = observed(&label, [2, 4].map(level));
        assert!(orders[0] > 1.9 && orders[1] > 0.9 && orders[2] > 1.4, "{label}: {orders:?}");
    }
}
