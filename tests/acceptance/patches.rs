//! Constant strain, prescribed as a linear displacement on the whole outer surface, interface edges
//! included: the tractions of the interface are the exact ones, whatever the meshes.

use crate::scene::{Run, Scene};

const YOUNG_MODULUS: f64 = 5.8e9;
const POISSON_RATIO: f64 = 0.3;
const SIZE: [f64; 3] = [2.0, 1.5, 1.0];

/// Displacement gradients at the instants 1, 2, 3: tension, shear, everything with compression.
const GRADIENTS: [[[f64; 3]; 3]; 3] = [
    [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0e-4]],
    [[0.0, 0.0, 2.0e-4], [0.0, 0.0, -0.5e-4], [0.0, 0.0, 0.0]],
    [[0.7e-4, 0.3e-4, 0.9e-4], [-0.2e-4, -0.4e-4, 0.6e-4], [0.5e-4, 0.1e-4, -1.1e-4]],
];

/// The gradient as the dimension knows it: plane strain has no y.
fn gradient(instant: usize, dim: usize) -> [[f64; 3]; 3] {
    let mut g = GRADIENTS[instant];
    if dim == 2 {
        g[1] = [0.0; 3];
        g.iter_mut().for_each(|row| row[1] = 0.0);
    }
    g
}

/// Isotropic elasticity.
fn stress(g: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let mu = YOUNG_MODULUS / (2.0 * (1.0 + POISSON_RATIO));
    let lambda = 2.0 * mu * POISSON_RATIO / (1.0 - 2.0 * POISSON_RATIO);
    let trace = g[0][0] + g[1][1] + g[2][2];
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            mu * (g[i][j] + g[j][i]) + if i == j { lambda * trace } else { 0.0 }
        })
    })
}

/// Component `i` of the displacement in space and time; between the instants one strain fades into
/// the next.
fn formula(i: usize, dim: usize) -> String {
    let terms = (0..3).map(|k| {
        let g = gradient(k, dim)[i];
        // A formula in 2D knows no y.
        let axes = ["x", "y", "z"].iter().enumerate().filter(|axis| dim == 3 || axis.0 != 1);
        let sum: Vec<String> = axes.map(|(j, axis)| format!("({:e})*{axis}", g[j])).collect();
        format!("max(0, 1-abs(t-{}))*({})", k + 1, sum.join(" + "))
    });
    terms.collect::<Vec<_>>().join(" + ")
}

/// The case; `mesh` holds the cells, `interfaces` that whole section.
fn patch(dim: usize, mesh: &str, interfaces: &str) -> Scene {
    let [x, y, z] = SIZE;
    let (size, axes, surfaces) = if dim == 2 {
        (format!("[{x}, {z}]"), vec![0, 2], "bottom top left right")
    } else {
        (format!("[{x}, {y}, {z}]"), vec![0, 1, 2], "bottom top left right front back")
    };
    let components: Vec<String> = axes
        .iter()
        .map(|i| format!("{}: {{formula: \"{}\"}}", ["x", "y", "z"][*i], formula(*i, dim)))
        .collect();
    let components = components.join(", ");
    let boundary: Vec<String> = surfaces
        .split(' ')
        .map(|s| format!("  - {{on: {s}, displacement: {{{components}}}}}\n"))
        .collect();
    let probes = if dim == 2 { "[0.77, 0.31]" } else { "[0.77, 0.93, 0.31]" };
    let yaml = format!(
        "
mesh: {{column: {{size: {size}, {mesh}}}}}
materials: {{rock: {{elastic: {{young_modulus: {YOUNG_MODULUS:e}, poisson_ratio: {POISSON_RATIO}}}}}}}
{interfaces}
boundary:
{}time: {{instants: [1, 2, 3]}}
solver: {{tolerance: 1.0e-13}}
probes: [{{name: inside, at: {probes}}}]
",
        boundary.concat()
    );
    Scene::new(&format!("patch_{dim}d"), &yaml)
}

/// Tractions and probe, relative to the largest traction and displacement of the instant.
fn assert_constant_strain(run: &Run, dim: usize, interface: bool, relative: f64) {
    let point = [0.77, if dim == 2 { 0.0 } else { 0.93 }, 0.31];
    let components: &[(usize, &str)] =
        if dim == 2 { &[(0, "x"), (2, "z")] } else { &[(0, "x"), (1, "y"), (2, "z")] };
    for instant in 0..3 {
        let g = gradient(instant, dim);
        let sigma = stress(g);
        let largest = (0..3).map(|i| sigma[i][2].abs()).fold(0.0, f64::max);
        let near = |name: &str, exact: f64, scale: f64| {
            let value = run.column(name)[instant];
            assert!(
                (value - exact).abs() <= relative * scale,
                "{}: {name} at {} is {value:e}, exact {exact:e}, error {:e} of {scale:e}",
                run.label,
                instant + 1,
                value - exact
            );
        };
        for (i, axis) in components {
            let u: f64 = (0..3).map(|j| g[*i][j] * point[j]).sum();
            near(&format!("inside.displacement_{axis}"), u, 1e-4);
            if interface {
                let name = if *i == 2 {
                    "normal_traction".into()
                } else {
                    format!("shear_traction_{axis}")
                };
                for which in ["min", "max", "mean"] {
                    near(&format!("joint.{name}.{which}"), sigma[*i][2], largest);
                }
            }
        }
    }
}

/// Ratios, and the orders of both sides: the same, of first order, then orders that differ across
/// the interface, and second order on both sides.
const PAIRS: [((usize, usize), [usize; 2]); 8] = [
    ((2, 3), [1, 1]),
    ((2, 8), [1, 1]),
    ((8, 2), [1, 1]),
    ((11, 12), [1, 1]),
    ((2, 3), [1, 2]),
    ((3, 3), [2, 1]),
    ((4, 3), [2, 2]),
    ((2, 5), [2, 2]),
];

/// Every second pair from `first` on with every secondary side, joined by `law`, on 1 to 4 ranks in
/// turn.
fn non_matching(dim: usize, law: &str, first: usize) {
    for (ratio, orders) in PAIRS.iter().skip(first).step_by(2) {
        joined(dim, law, *ratio, *orders);
    }
}

/// Bodies of so many cells per edge and of these orders, either side as the secondary one.
fn joined(dim: usize, law: &str, (lower, upper): (usize, usize), orders: [usize; 2]) {
    let bodies = |lower: usize, upper: usize| {
        let body = |n: usize, order: usize| match dim {
            2 => format!("{{cells: [{n}, 2], order: {order}}}"),
            _ => format!("{{cells: [{n}, {n}, 2], order: {order}}}"),
        };
        format!("bodies: [{}, {}]", body(lower, orders[0]), body(upper, orders[1]))
    };
    let sides = ["", ", secondary: lower", ", secondary: upper"];
    // Without a word it is one of them.
    let sides = sides.iter().enumerate().skip(usize::from(lower + orders[0] > 3));
    for (index, secondary) in sides {
        let ranks = 1 + (index + lower + orders[0]) % 4;
        let interfaces = format!("interfaces: [{{name: joint, z: 0.4, law: {law}{secondary}}}]");
        let run = patch(dim, &bodies(lower, upper), &interfaces).on(ranks);
        let label = format!("{} {lower}:{upper} {orders:?}{secondary} {law}", run.label);
        assert_constant_strain(&Run { label, ..run }, dim, true, 1e-10);
    }
}

const TIED: &str = "{tied: {}}";
/// Stronger than any traction here.
const COHESIVE: &str = "{linear_softening: {strength: 1.0e7, fracture_energy: 9.0e4}}";

// The laws share the pairs out, in the plane the other way than in space.

#[test]
fn tied_in_2d() {
    non_matching(2, TIED, 0);
}

#[test]
fn tied_in_3d() {
    non_matching(3, TIED, 1);
}

#[test]
fn unbroken_in_2d() {
    non_matching(2, COHESIVE, 1);
}

#[test]
fn unbroken_in_3d() {
    non_matching(3, COHESIVE, 0);
}

#[test]
#[ignore = "a minute: cargo test --release --test acceptance patches -- --ignored"]
fn every_pair_with_the_other_law() {
    for (dim, [tied, unbroken]) in [(2, [1, 0]), (3, [0, 1])] {
        non_matching(dim, TIED, tied);
        non_matching(dim, COHESIVE, unbroken);
    }
}

/// Without an interface: displacement, reactions and energy to 1e-12.
#[test]
fn bulk() {
    for (dim, mesh) in [(2, "cells: [5, 4]"), (3, "cells: [5, 4, 3]")] {
        for (ranks, order) in [(1, 1), (3, 1), (1, 2), (3, 2)] {
            let run = patch(dim, mesh, "").set(&format!("mesh.order={order}")).on(ranks);
            assert_constant_strain(&run, dim, false, 1e-12);
            let [x, y, z] = if dim == 2 { [SIZE[0], 1.0, SIZE[2]] } else { SIZE };
            let near = |name: &str, instant: usize, exact: f64, scale: f64| {
                let value = run.column(name)[instant];
                assert!((value - exact).abs() <= 1e-12 * scale, "{}: {name} {value:e}", run.label);
            };
            let mut before = ([[0.0; 3]; 3], [[0.0; 3]; 3], 0.0);
            for instant in 0..3 {
                let g = gradient(instant, dim);
                let sigma = stress(g);
                let scale = sigma.as_flattened().iter().fold(0.0_f64, |m, s| m.max(s.abs()));
                // The parts that the edges take from the sides cancel between opposite sides.
                for (i, axis) in ["x", "y", "z"].iter().enumerate().filter(|a| dim == 3 || a.0 != 1)
                {
                    let force = sigma[i][2] * x * y;
                    near(&format!("top.reaction_{axis}"), instant, force, scale * x * y);
                    near(&format!("bottom.reaction_{axis}"), instant, -force, scale * x * y);
                }
                let product = |a: [[f64; 3]; 3], b: [[f64; 3]; 3]| -> f64 {
                    a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| a * b).sum()
                };
                let energy = 0.5 * product(sigma, g) * x * y * z;
                near("energy.elastic", instant, energy, energy);
                // Elastic: the work between two states is the difference of their energies.
                let work = before.2 + energy - 0.5 * product(before.0, before.1) * x * y * z;
                near("energy.external", instant, work, work.abs().max(energy));
                before = (sigma, g, work);
            }
        }
    }
}
