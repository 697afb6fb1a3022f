//! The assembled tangent against central differences of the residual.
//!
//! At an accepted state, with the history of the instant before put back so that the state lies
//! inside its branches and not on their threshold, the residual is differentiable. There, for a
//! vector y that is zero at prescribed components and at stuck components of secondary nodes,
//! A y is compared with (f(u + eps d) - f(u - eps d)) / (2 eps), where d is the direction in the
//! displacements that y becomes (stuck components follow the other side, so that their jump stays).
//! Rows of prescribed components are the identity and take no part.

use column_hpc::case::Case;
use column_hpc::hash::mix;
use column_hpc::law::Branch;
use column_hpc::mesh::MeshFamily;
use column_hpc::partition::{self, Method};
use column_hpc::petsc::{LinearOperator, NonlinearSystem, Vector};
use column_hpc::runtime::Runtime;
use column_hpc::solve::{self, BoundaryValueProblem, LinearChoice, MULTIGRID, Model};
use column_hpc::timers::Timers;
use std::collections::BTreeSet;
use std::path::Path;

/// Largest step of a node (m): small against the least jumps, about 1e-6 m, near which the
/// direction of the traction turns fastest.
const STEP: f64 = 1e-10;

/// The top tilts and slides more and more, comes back, is pressed down, and goes far.
fn case(mesh: &str, law: &str, solver: &str) -> Case {
    let text = format!(
        "
mesh: {{column: {{size: [1.0, 1.0, 2.0], {mesh}}}}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.2}}}}}}
interfaces: [{{name: joint, z: 1.0, law: {law}}}]
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - on: top
    displacement:
      x: {{table: [[0, 0], [1, 2.0e-4], [2, 6.0e-4], [3, 4.0e-4], [5, 8.0e-4], [6, 9.0e-4], [7, 2.6e-3]]}}
      y: 0
      z: {{formula: \"1e-3*min(t, abs(2.9-t)*0.5)*0.6*(0.1 + x + 0.2*y) - 1e-3*max(0, min(1, min(t-3, 8-t))) + 3e-3*max(0, t-8)\"}}
solver: {{linear: {solver}}}
time: {{instants: [0.2, 0.5, 1, 1.5, 2, 2.5, 3, 4, 4.5, 5, 6, 7, 8, 9]}}
"
    );
    Case::read(&text, Path::new("tangent.yaml"), &[]).expect("the case is right")
}

/// Matching and non-matching, for every law.
pub fn tangent_by_differences(runtime: &Runtime) {
    let cohesive = "{linear_softening: {strength: 1.1e6, fracture_energy: 900.0}}";
    for mesh in ["cells: [3, 2, 4]", "bodies: [{cells: [2, 2, 2]}, {cells: [3, 3, 2]}]"] {
        for method in [Method::Metis, Method::Scattered] {
            check(runtime, &case(mesh, cohesive, "multigrid"), method);
            let seen = check(runtime, &case(mesh, cohesive, "mumps"), method);
            for branch in [
                Branch::Stick,
                Branch::StickClosed,
                Branch::Softening,
                Branch::SofteningClosed,
                Branch::Unloading,
                Branch::Broken,
                Branch::BrokenClosed,
            ] {
                assert!(seen.contains(&branch), "{branch:?} is missing in {seen:?}, {mesh}");
            }
        }
        for solver in ["mumps", "multigrid"] {
            check(runtime, &case(mesh, "{tied: {}}", solver), Method::Metis);
        }
    }
}

/// A mesh of a file that multigrid makes finer, its outer boundary drawn apart unevenly.
fn case_of_file(mesh: &str, more: &str, dim: usize) -> Case {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/meshes/interfaces");
    let axes = &["x", "y", "z"][..dim];
    let component = |(i, axis): (usize, &&str)| {
        let next = axes[(i + 1) % dim];
        format!("{axis}: {{formula: \"t*(8e-4*{axis}*{axis} + 2e-4*{next} - 1e-4*{axis})\"}}")
    };
    let components: Vec<String> = axes.iter().enumerate().map(component).collect();
    let text = format!(
        "
mesh: {{file: \"{folder}/{mesh}.msh\", refine: 1{more}}}
materials: {{rock: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.2}}}}}}
interfaces:
  - name: joint
    on: joint
    law: {{linear_softening: {{strength: 2.0e5, fracture_energy: 30.0, augmentation: 10.0}}}}
boundary: [{{on: outer, displacement: {{{}}}}}]
solver: {{linear: multigrid}}
time: {{instants: [0.2, 0.5, 1]}}
",
        components.join(", ")
    );
    let case = Case::read(&text, Path::new("tangent.yaml"), &[]).expect("the case is right");
    case.for_dimension(dim).expect("a dimension that fits")
}

/// Meshes of files with crossings, branches and tips, and nodes with frames.
pub fn tangent_in_refined_meshes(runtime: &Runtime) {
    for (mesh, more, dim, method) in [
        ("crossing", "", 2, Method::Metis),
        ("branching", ", raise_order: 2", 2, Method::Scattered),
        ("ending", "", 3, Method::Scattered),
    ] {
        check(runtime, &case_of_file(mesh, more, dim), method);
    }
}

/// Goes through the instants; returns the branches of all ranks at which tangents were compared.
fn check(runtime: &Runtime, case: &Case, method: Method) -> BTreeSet<Branch> {
    let comm = &runtime.comm;
    let timers = Timers::new();
    let mut family = MeshFamily::new(case).expect("a mesh");
    let choice = LinearChoice::new(case, &family.facts()).expect("a choice");
    if choice.preset == MULTIGRID {
        assert!(family.coarsen(4), "levels");
    }
    let mut meshes = partition::share_out(comm, family, method).expect("a partition");
    let finest = meshes.pop().expect("a mesh");
    let problem = BoundaryValueProblem::new(comm, case, finest).expect("a problem");
    let mut model =
        solve::build(runtime, &timers, case, choice, problem, meshes).expect("a problem");
    let mut seen = BTreeSet::new();
    for time in &case.time {
        let history = model.stepper.problem.interfaces.committed.clone();
        let accepted =
            model.stepper.advance(*time).expect("no fault").expect("the instant is reached");
        let reached = model.stepper.problem.interfaces.committed.clone();
        if accepted.steps == 1 {
            model.stepper.problem.interfaces.committed = history;
            compare(runtime, &mut model, *time);
            transposes(runtime, &model);
            single_precision(runtime, &model);
            let response = &model.stepper.problem.interfaces.response;
            seen.extend(response.iter().map(|r| r.branch));
        }
        model.stepper.problem.interfaces.committed = reached;
    }
    // In one order on every rank.
    Branch::ALL.into_iter().filter(|branch| comm.any(seen.contains(branch))).collect()
}

/// The product in single precision at the state of the last tangent, which the cycle takes.
fn single_precision(runtime: &Runtime, model: &Model<'_>) {
    let Some(hierarchy) = model.stepper.problem.hierarchy() else { return };
    let operator = hierarchy.finest();
    let all = operator.discretization();
    let own = &all.nodes.names[..all.nodes.owned];
    let value = |name: u64, c: u64| (mix(3 * name + c) >> 11) as f64 / (1u64 << 52) as f64 - 1.0;
    let components = || 0..all.dim as u64;
    let x: Vec<f64> = own.iter().flat_map(|name| components().map(|c| value(*name, c))).collect();
    let rounded: Vec<f32> = x.iter().map(|x| *x as f32).collect();
    let (mut double, mut single) = (vec![0.0; x.len()], vec![0.0_f32; x.len()]);
    operator.multiply_in(&x, &mut double);
    operator.multiply_in(&rounded, &mut single);
    let apart = double.iter().zip(&single).map(|(a, b)| (a - f64::from(*b)).abs());
    let mut largest =
        [apart.fold(0.0, f64::max), double.iter().fold(0.0, |m: f64, y| m.max(y.abs()))];
    runtime.comm.max(&mut largest);
    assert!(largest[0] < 2e-6 * largest[1], "{largest:?}");
}

/// The transposes of the interpolations at the state of the last tangent: y . P x = x . P^T y.
fn transposes(runtime: &Runtime, model: &Model<'_>) {
    let problem = &model.stepper.problem;
    let Some(hierarchy) = problem.hierarchy() else { return };
    for transfer in hierarchy.transfers() {
        let [fine, coarse] = transfer.unknowns();
        let numbers = |n: usize, seed: u64| -> Vec<f64> {
            (0..n as u64)
                .map(|i| (mix(seed + i) >> 11) as f64 / (1u64 << 52) as f64 - 1.0)
                .collect()
        };
        let seed = runtime.comm.rank() as u64 * 1_000_000;
        let (x, y) = (numbers(coarse, seed), numbers(fine, seed + 500_000));
        let (mut up, mut down) = (vec![0.0; fine], vec![0.0; coarse]);
        transfer.multiply(&x, &mut up);
        transfer.multiply_transpose(&y, &mut down);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut sums = [dot(&y, &up), dot(&x, &down), dot(&up, &up).max(dot(&down, &down))];
        runtime.comm.sum(&mut sums);
        assert!(sums[2] > 0.0 && (sums[0] - sums[1]).abs() <= 1e-12 * sums[2], "{sums:?}");
    }
}

/// A y against the central difference, at the state that the problem evaluated last.
fn compare(runtime: &Runtime, model: &mut Model<'_>, time: f64) {
    let (problem, snes) = (&mut model.stepper.problem, &mut model.stepper.snes);
    let dim = problem.all.dim;
    let owned = problem.all.nodes.owned * dim;
    let u = problem.displacement[..owned].to_vec();
    let mut f = vec![0.0; owned];
    problem.residual(&u, &mut f).expect("a residual");
    problem.tangent(&u, snes.matrix_mut()).expect("a tangent");

    let mut free: Vec<bool> =
        (0..owned).map(|i| !problem.all.prescribed[i / dim][i % dim]).collect();
    let compared = free.clone();
    for (rows, response) in problem.all.secondary.iter().zip(&problem.interfaces.response) {
        for c in (0..dim).filter(|c| rows.rows[*c].is_some() && response.state.stuck[*c]) {
            free[rows.node as usize * dim + c] = false;
        }
    }
    let mut y = Vector::new(&runtime.petsc, owned, dim).expect("a vector");
    let mut direction = vec![0.0; owned];
    for i in (0..owned).filter(|i| free[*i]) {
        // The same numbers on any number of ranks.
        let name = problem.all.nodes.names[i / dim] * dim as u64 + (i % dim) as u64;
        direction[i] = (mix(name) >> 11) as f64 / (1u64 << 52) as f64 - 1.0;
    }
    y.write().expect("values").copy_from_slice(&direction);
    let mut product = y.duplicate().expect("a vector");
    snes.matrix().multiply(&y, &mut product).expect("a product");
    problem.direction(&u, &mut direction, &mut |_, _| Ok(())).expect("a direction");

    let mut at = |sign: f64| {
        let moved: Vec<f64> = u.iter().zip(&direction).map(|(u, d)| u + sign * STEP * d).collect();
        let mut f = vec![0.0; owned];
        problem.residual(&moved, &mut f).expect("a residual");
        f
    };
    let (plus, minus) = (at(1.0), at(-1.0));
    problem.residual(&u, &mut f).expect("a residual");
    let product = product.read().expect("values");
    let (mut error, mut largest) = (0.0_f64, 0.0_f64);
    for i in (0..owned).filter(|i| compared[*i]) {
        let difference = (plus[i] - minus[i]) / (2.0 * STEP);
        error = error.max((difference - product[i]).abs());
        largest = largest.max(product[i].abs());
    }
    let mut worst = [error, largest];
    runtime.comm.max(&mut worst);
    assert!(worst[1] > 0.0 && worst[0] <= 1e-7 * worst[1], "at {time}: {worst:?}");
}
