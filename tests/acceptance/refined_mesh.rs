//! Meshes from files, refined by the program: a coarse box refined is the fine box.

use crate::scene::{Scene, fresh};
use std::fmt::Write as _;

/// Cells of a box of 1 x 1 x 2 m along x, y, z, cut at z = 1.
type Counts = [usize; 3];

/// The file of a box of hexahedra, or of twice as many prisms, with groups for both bodies, the
/// joint and three sides.
fn file([nx, ny, nz]: Counts, of_prisms: bool) -> String {
    let node = |i: usize, j: usize, k: usize| 1 + i + (nx + 1) * (j + (ny + 1) * k);
    let mut nodes = String::new();
    for k in 0..=nz {
        for j in 0..=ny {
            for i in 0..=nx {
                let at = |i: usize, n: usize| i as f64 / n as f64;
                let z = 2.0 * at(k, nz);
                let _ = writeln!(nodes, "{} {} {} {z}", node(i, j, k), at(i, nx), at(j, ny));
            }
        }
    }
    let mut elements = Vec::new();
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let ring = |k| {
                    [node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k)]
                };
                let group = if 2 * k < nz { 1 } else { 2 };
                let halves = |k| {
                    let [a, b, c, d] = ring(k);
                    [[a, b, c], [a, c, d]]
                };
                if of_prisms {
                    for (low, high) in halves(k).into_iter().zip(halves(k + 1)) {
                        elements.push((6, group, [low, high].concat()));
                    }
                } else {
                    elements.push((5, group, [ring(k), ring(k + 1)].concat()));
                }
                let levels = [(3, nz / 2), (4, 0), (5, nz)];
                for (group, level) in levels.into_iter().filter(|_| k == 0) {
                    if of_prisms {
                        elements.extend(halves(level).map(|half| (2, group, half.to_vec())));
                    } else {
                        elements.push((3, group, ring(level).to_vec()));
                    }
                }
                if i == 0 {
                    let side = [
                        node(0, j, k),
                        node(0, j, k + 1),
                        node(0, j + 1, k + 1),
                        node(0, j + 1, k),
                    ];
                    elements.push((3, 6, side.to_vec()));
                }
            }
        }
    }
    let mut text =
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n6\n3 1 \"lower\"\n3 2 \"upper\"\n\
                    2 3 \"joint\"\n2 4 \"foot\"\n2 5 \"head\"\n2 6 \"flank\"\n$EndPhysicalNames\n"
            .to_owned();
    let count = (nx + 1) * (ny + 1) * (nz + 1);
    let _ = writeln!(text, "$Nodes\n{count}\n{nodes}$EndNodes\n$Elements\n{}", elements.len());
    for (number, (kind, group, nodes)) in elements.iter().enumerate() {
        let nodes: Vec<String> = nodes.iter().map(usize::to_string).collect();
        let _ = writeln!(text, "{} {kind} 2 {group} {group} {}", number + 1, nodes.join(" "));
    }
    text + "$EndElements\n"
}

/// The box, pulled unevenly until its joint softens, and pressed on a side.
fn scene(counts: Counts, refine: usize) -> Scene {
    of_file(&file(counts, false), refine)
}

fn of_file(file: &str, refine: usize) -> Scene {
    let folder = fresh();
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join("box.msh");
    std::fs::write(&path, file).expect("a file");
    let yaml = format!(
        "
mesh: {{file: \"{}\", refine: {refine}}}
materials:
  lower: {{elastic: {{young_modulus: 5.8e9, poisson_ratio: 0.2}}}}
  upper: {{elastic: {{young_modulus: 3.0e9, poisson_ratio: 0.3}}}}
interfaces:
  - name: joint
    on: joint
    law: {{linear_softening: {{strength: 1.1e6, fracture_energy: 900.0}}}}
boundary:
  - {{on: foot, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{on: head, displacement: {{x: 0, y: 0, z: {{formula: \"1e-4*t*(6+x)\"}}}}}}
  - {{on: flank, traction: {{normal: -2.0e5}}}}
time: {{instants: [1, 2]}}
probes: [{{name: p, at: [0.25, 0.5, 1.5]}}]
solver: {{linear: mumps}}
",
        path.display()
    );
    Scene::new("box", &yaml)
}

/// The coarse meshes are levels of multigrid: it needs as many iterations however fine the last is.
#[test]
fn multigrid_needs_no_more_iterations_on_a_finer_mesh() {
    let with =
        |times, preset: &str| scene([4, 4, 4], times).set(&format!("solver.linear={preset}")).on(1);
    let once = with(1, "multigrid");
    scene([4, 4, 4], 1).on(1).assert_same(&once, 1e-8);
    // The second is large enough that the program takes it by itself.
    let of_each = [once, with(2, "auto")].map(|run| {
        assert_eq!(run.report["linear_solver"]["choice"], "multigrid");
        let sum = |name: &str| run.column(name).iter().sum::<f64>();
        sum("linear_iterations") / sum("newton_iterations")
    });
    assert!(of_each[0] < 15.0 && of_each[1] < 1.25 * of_each[0] + 1.0, "{of_each:?}");
}

#[test]
fn a_coarse_box_refined_gives_the_history_of_the_fine_one() {
    let fine = scene([4, 4, 8], 0).on(1);
    let damage = fine.column("joint.damage.max");
    assert!(damage[1] > 0.0, "{damage:?}");
    for (counts, times, ranks) in [([2, 2, 4], 1, 2), ([1, 1, 2], 2, 1)] {
        scene(counts, times).on(ranks).assert_same(&fine, 1e-10);
    }
}

/// Hexahedra in layers are joined to coarser ones, an odd layer is left alone.
#[test]
fn layers_of_a_file_have_coarser_meshes() {
    let scene = scene([11, 12, 14], 0);
    let eliminated = scene.on(1);
    for ranks in [1, 3] {
        let run = scene.set("solver.linear=multigrid").on(ranks);
        assert_eq!(run.report["linear_solver"]["choice"], "multigrid", "{}", run.label);
        eliminated.assert_same(&run, 1e-8);
        let per_correction =
            run.column("linear_iterations")[1] / run.column("newton_iterations")[1];
        assert!(per_correction < 30.0, "{}: {per_correction} iterations", run.label);
    }
}

/// A coarsest level that is too large for elimination has cycles of smoothed aggregation. Prisms
/// have no coarser ones.
#[test]
fn a_large_coarsest_level_is_not_eliminated() {
    let scene = of_file(&file([14, 14, 16], true), 0)
        .set("mesh.raise_order=2")
        .set("solver.linear=multigrid")
        .set("time.instants=[2]");
    let cycles = scene.on(2);
    let eliminated = scene
        .set(
            "solver.petsc_options=-mg_coarse_pc_type cholesky -mg_coarse_ksp_type preonly \
             -mg_coarse_pc_factor_mat_solver_type mumps",
        )
        .on(2);
    cycles.assert_same(&eliminated, 1e-8);
    let [of_cycles, of_elimination] = [&cycles, &eliminated]
        .map(|run| run.column("linear_iterations")[0] / run.column("newton_iterations")[0]);
    // As many would mean that the options choose nothing.
    assert!(of_elimination < of_cycles && of_cycles < 2.0 * of_elimination + 2.0);
}
