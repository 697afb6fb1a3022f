//! Observed orders of convergence with an interface that opens unevenly.

#![allow(clippy::print_stdout)] // the figures, with --nocapture

use column_hpc::element::{gauss, map_point, mapping};

use crate::grid::{Grid, plane, read};
use crate::lorentz;
use crate::manufactured::{HEIGHT, Manufactured};
use crate::scene::{Run, Scene};

/// Relative errors: displacement in L2, strain in energy, traction with the weights of the nodes.
#[derive(Debug, Clone, Copy)]
struct Errors {
    displacement: f64,
    energy: f64,
    traction: f64,
    /// Part of the traction that changes its sign from node to node.
    checkerboard: f64,
}

/// What is exact at a point of the lower or upper body.
trait Exact {
    /// Displacement, its gradient and Lame's constants.
    fn bulk(&self, upper: bool, point: [f64; 3]) -> ([f64; 3], [[f64; 3]; 3], (f64, f64));
    fn traction(&self, point: [f64; 3]) -> [f64; 3];
}

impl Exact for Manufactured {
    fn bulk(&self, upper: bool, point: [f64; 3]) -> ([f64; 3], [[f64; 3]; 3], (f64, f64)) {
        self.at(upper, point)
    }

    fn traction(&self, point: [f64; 3]) -> [f64; 3] {
        Manufactured::traction(self, point)
    }
}

struct Lorentz;

impl Exact for Lorentz {
    fn bulk(&self, upper: bool, point: [f64; 3]) -> ([f64; 3], [[f64; 3]; 3], (f64, f64)) {
        lorentz::at(upper, point)
    }

    fn traction(&self, point: [f64; 3]) -> [f64; 3] {
        lorentz::traction(point)
    }
}

/// Squares of error and exact values: displacement, energy.
fn bulk_errors<const DIM: usize>(grid: &Grid, exact: &impl Exact) -> [[f64; 2]; 2] {
    let mut sums = [[0.0; 2]; 2];
    for (shape, nodes) in &grid.cells {
        let points: Vec<[f64; DIM]> = nodes.iter().map(|n| plane(grid.points[*n])).collect();
        let upper = nodes.iter().map(|n| grid.points[*n][2]).fold(0.0, f64::max) > HEIGHT + 1e-9;
        for q in gauss(*shape, 5) {
            let map = mapping(*shape, &points, q.xi);
            let weight = q.weight * map.determinant;
            let (mut n, mut gradients) = ([0.0; 27], [[0.0; 3]; 27]);
            shape.values(q.xi, &mut n);
            shape.gradients(q.xi, &mut gradients);
            let x = map_point(*shape, &points, q.xi);
            let point = if DIM == 2 { [x[0], 0.0, x[1]] } else { [x[0], x[1], x[DIM - 1]] };
            let (u, h, (lambda, mu)) = exact.bulk(upper, point);
            let (mut uh, mut hh) = ([0.0; 3], [[0.0; 3]; 3]);
            let axes: &[usize] = if DIM == 2 { &[0, 2] } else { &[0, 1, 2] };
            for (a, node) in nodes.iter().enumerate() {
                let gradient = map.gradient(gradients[a], DIM);
                for i in 0..3 {
                    uh[i] += n[a] * grid.values[*node][i];
                    for (k, j) in axes.iter().enumerate() {
                        hh[i][*j] += grid.values[*node][i] * gradient[k];
                    }
                }
            }
            let energy = |h: &dyn Fn(usize, usize) -> f64| -> f64 {
                let trace: f64 = (0..3).map(|i| h(i, i)).sum();
                let strain = |i: usize, j: usize| 0.5 * (h(i, j) + h(j, i));
                let square: f64 = (0..9).map(|k| strain(k / 3, k % 3).powi(2)).sum();
                lambda * trace * trace + 2.0 * mu * square
            };
            sums[0][0] += weight * (0..3).map(|i| (u[i] - uh[i]).powi(2)).sum::<f64>();
            sums[0][1] += weight * u.iter().map(|u| u * u).sum::<f64>();
            sums[1][0] += weight * energy(&|i, j| h[i][j] - hh[i][j]);
            sums[1][1] += weight * energy(&|i, j| h[i][j]);
        }
    }
    sums
}

/// Squares of error and exact traction, each node with the integral of its shape function.
fn traction_errors(grid: &Grid, dim: usize, exact: &impl Exact) -> [f64; 2] {
    let mut weight = vec![0.0; grid.points.len()];
    for (shape, nodes) in &grid.cells {
        let far = |i: usize| {
            let values = nodes.iter().map(|n| grid.points[*n][i]);
            values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
        };
        let measure = if dim == 2 { far(0) } else { far(0) * far(1) };
        for q in gauss(*shape, 3) {
            let mut n = [0.0; 27];
            shape.values(q.xi, &mut n);
            let part = q.weight * measure / f64::from(1 << shape.dim());
            nodes.iter().zip(n).for_each(|(node, n)| weight[*node] += n * part);
        }
    }
    let mut sums = [0.0; 2];
    for ((point, value), weight) in grid.points.iter().zip(&grid.values).zip(weight) {
        let t = exact.traction(*point);
        sums[0] += weight * (0..3).map(|i| (t[i] - value[i]).powi(2)).sum::<f64>();
        sums[1] += weight * t.iter().map(|t| t * t).sum::<f64>();
    }
    sums
}

/// The traction less its mean over the facets around each node, over the traction.
fn checkerboard(grid: &Grid) -> f64 {
    let mut sums = vec![([0.0; 3], 0.0); grid.points.len()];
    for (shape, nodes) in &grid.cells {
        // Mean of the traction over the facet, by the integrals of the shape functions.
        let mut mean = [0.0; 3];
        for q in gauss(*shape, 3) {
            let mut n = [0.0; 27];
            shape.values(q.xi, &mut n);
            let part = q.weight / f64::from(1 << shape.dim());
            for (node, n) in nodes.iter().zip(n) {
                mean.iter_mut().zip(grid.values[*node]).for_each(|(m, v)| *m += part * n * v);
            }
        }
        for node in nodes {
            let (sum, count) = &mut sums[*node];
            sum.iter_mut().zip(mean).for_each(|(s, m)| *s += m);
            *count += 1.0;
        }
    }
    let (mut differences, mut all) = (0.0, 0.0);
    for (value, (sum, count)) in grid.values.iter().zip(sums) {
        differences += (0..3).map(|i| (value[i] - sum[i] / count).powi(2)).sum::<f64>();
        all += value.iter().map(|v| v * v).sum::<f64>();
    }
    f64::sqrt(differences / all)
}

fn errors(run: &Run, dim: usize, exact: &impl Exact) -> Errors {
    let file = |name: &str| run.directory.join(format!("fields/{name}_000001.vtkhdf"));
    let bulk = read(&file("bulk"), "displacement");
    let [displacement, energy] =
        if dim == 2 { bulk_errors::<2>(&bulk, exact) } else { bulk_errors::<3>(&bulk, exact) };
    let joint = read(&file("joint"), "traction");
    let traction = traction_errors(&joint, dim, exact);
    let relative = |[error, exact]: [f64; 2]| (error / exact).sqrt();
    Errors {
        displacement: relative(displacement),
        energy: relative(energy),
        traction: relative(traction),
        checkerboard: checkerboard(&joint),
    }
}

/// Cells of the two bodies along an edge of the base: level by level twice as many.
fn bodies(dim: usize, order: usize, [lower, upper]: [usize; 2]) -> String {
    let body = |n: usize| {
        let height = n.div_ceil(2);
        if dim == 2 {
            format!("{{cells: [{n}, {height}], order: {order}}}")
        } else {
            format!("{{cells: [{n}, {n}, {height}], order: {order}}}")
        }
    };
    format!("[{}, {}]", body(lower), body(upper))
}

/// Errors over the levels and the orders between the last two.
fn observed(
    exact: &impl Exact,
    (dim, order): (usize, usize),
    coarsest: [usize; 2],
    levels: u32,
    scene: impl Fn(&str) -> Scene,
) -> Errors {
    let run = |level: u32| {
        let cells = coarsest.map(|n| n << level);
        let run = scene(&bodies(dim, order, cells)).in_any_steps().with_fields().on(1);
        errors(&run, dim, exact)
    };
    let all: Vec<Errors> = (0..levels).map(run).collect();
    let between =
        |of: fn(&Errors) -> f64| (of(&all[all.len() - 2]) / of(&all[all.len() - 1])).log2();
    let orders = Errors {
        displacement: between(|e| e.displacement),
        energy: between(|e| e.energy),
        traction: between(|e| e.traction),
        checkerboard: between(|e| e.checkerboard),
    };
    let last = &all[all.len() - 1];
    assert!(last.checkerboard < 0.05, "{last:?}");
    println!("{dim}D, order {order}, {coarsest:?}: {orders:.2?} from {all:.9?}");
    orders
}

fn check(dim: usize, order: usize, coarsest: [usize; 2], levels: u32) {
    let exact = Manufactured::new(dim);
    let scene = |bodies: &str| Scene::new("manufactured", &exact.yaml(bodies));
    let orders = observed(&exact, (dim, order), coarsest, levels, scene);
    assert_optimal((dim, order), coarsest, orders);
}

fn assert_optimal((dim, order): (usize, usize), coarsest: [usize; 2], orders: Errors) {
    let p = order as f64;
    assert!(orders.displacement > p + 0.9, "{dim}D {order} {coarsest:?}: {orders:?}");
    assert!(orders.energy > p - 0.1, "{dim}D {order} {coarsest:?}: {orders:?}");
    // What is left at a node beside the mean around it is the slope of the traction times the width
    // of a facet; a checkerboard would stay.
    assert!(orders.checkerboard > 0.4, "{dim}D {order} {coarsest:?}: {orders:?}");
    assert!(orders.traction > p - 0.1, "{dim}D {order} {coarsest:?}: {orders:?}");
}

#[test]
fn in_2d() {
    for order in [1, 2] {
        check(2, order, [4, 4], 4);
        check(2, order, [4, 6], 4);
        check(2, order, [6, 4], 4);
    }
}

#[test]
fn in_3d() {
    for order in [1, 2] {
        let coarsest = 4 / order;
        check(3, order, [coarsest; 2], 3);
        check(3, order, [coarsest, 3 * coarsest / 2], 3);
    }
}

/// Where prescribed displacements meet the edge of the interface, multipliers are dropped there and
/// their functions extended as constants, which promises 1.5 of second order. Here the slope of the
/// traction vanishes at that edge, which a constant represents well.
#[test]
fn with_a_held_edge() {
    let exact = Manufactured::held_on_the_left();
    for (order, least) in [(1, 0.9), (2, 1.4)] {
        for coarsest in [[4, 4], [4, 6], [6, 4]] {
            let scene = |bodies: &str| Scene::new("held", &exact.yaml(bodies));
            let orders = observed(&exact, (2, order), coarsest, 4, scene);
            assert!(orders.traction > least, "{order} {coarsest:?}: {orders:?}");
            assert!(orders.energy > order as f64 - 0.5, "{order} {coarsest:?}: {orders:?}");
        }
    }
}

#[test]
fn of_a_jump_that_turns() {
    for order in [1, 2] {
        for coarsest in [[4, 4], [4, 6], [6, 4]] {
            let scene = |bodies: &str| Scene::new("lorentz", &lorentz::yaml(bodies));
            let orders = observed(&Lorentz, (2, order), coarsest, 4, scene);
            assert_optimal((2, order), coarsest, orders);
        }
    }
}
