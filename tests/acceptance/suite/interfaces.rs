//! Enforcement at the interface: experiments 1 to 4, 14 and 19.

use super::{STRENGTH, YOUNG, base, family, measured, near, sum, trouble};
use crate::scene::{Run, Scene};
use serde_json::json;

/// Adherence and penalties with multiples of E/h, the cells being h = 0.25 m high.
#[test]
#[ignore = "half a minute, for its figures: scripts/stability.sh"]
fn e01_a_penalty_opens_and_costs_iterations() {
    let top = "1.0e-4*(1 + 0.5*(x - 0.5) + 0.25*(y - 0.5))";
    let finer = |scene: &Scene, solver: &str| {
        scene
            .set("mesh.column.cells=[8, 8, 16]")
            .set("materials.rock.elastic.poisson_ratio=0.25")
            .set(&format!("boundary.1.displacement.z={{formula: \"{top}\"}}"))
            .set(&format!("solver.linear={solver}"))
    };
    let iterations = |scene: &Scene| {
        ["gamg", "hypre", "multigrid"]
            .map(|solver| sum(&finer(scene, solver).on(1).column("linear_iterations")))
    };
    let adherence = family("adherence").set("time.instants=[1]");
    let run = adherence.on(1);
    let pulled = 0.5 * STRENGTH * 2.0 / YOUNG;
    let jumps = ["min", "max"].map(|w| run.column(&format!("joint.normal_jump.{w}"))[0]);
    let opening = jumps[0].abs().max(jumps[1].abs()) / pulled;
    assert!(opening < 1e-15, "exact adherence: {jumps:?}");
    let exact = iterations(&adherence);
    let mut rows = Vec::new();
    let penalty = |multiple: f64| {
        let stiffness = multiple * YOUNG / 0.25;
        let law = format!(
            "{{bilinear: {{strength: {STRENGTH:e}, fracture_energy: 900.0, stiffness: \
             {stiffness:e}}}}}"
        );
        (adherence.set(&format!("interfaces.0.law={law}")), stiffness)
    };
    for multiple in [1.0, 1e1, 1e2, 1e3, 1e4, 1e6] {
        let (scene, stiffness) = penalty(multiple);
        let jump = scene.on(1).column("joint.normal_jump.mean")[0];
        let series = pulled / (2.0 / YOUNG + 1.0 / stiffness) / stiffness;
        near("spurious opening", jump, series, 1e-9 * series);
        let counts = iterations(&scene);
        rows.push(json!([multiple, jump / pulled, counts]));
        if multiple >= 1e3 {
            assert!(counts[0] > 5.0 * exact[0], "gamg {counts:?} {exact:?}");
        }
        assert!(counts[1] < 1.6 * exact[1] && counts[2] < 1.6 * exact[2], "{counts:?} {exact:?}");
    }
    // Round-off times the stiffness exceeds the tolerance, with factors too.
    let failure = finer(&penalty(1e8).0, "mumps").attempt(1).err().expect("no convergence");
    assert_eq!(failure.status, Some(3));
    assert!(failure.complaint.contains("no convergence"), "{}", failure.complaint);
    measured("1.penalty", rows);
    measured("1.exact", json!([opening, exact]));
    measured("1.fails_at", 1e8);
}

/// MUMPS counts the null pivots of the saddle-point system, which holds every multiplier.
#[test]
fn e02_no_multiplier_stands_where_a_displacement_is_prescribed() {
    let scene = base("constrained_edges").set("solver.form=saddle_point");
    let run = scene.set("solver.petsc_options=-mat_mumps_icntl_24 1 -ksp_view").on(1);
    let pivots: Vec<&str> = run
        .screen
        .lines()
        .filter(|l| l.contains("INFOG(28)"))
        .map(|l| l.rsplit(' ').next().expect("a number"))
        .collect();
    assert!(!pivots.is_empty() && pivots.iter().all(|p| *p == "0"), "{pivots:?}");
    let mut worst = 0.0_f64;
    for name in ["lower", "upper"] {
        for (row, sign) in [(0, 1.0), (1, -1.0)] {
            for which in ["min", "max"] {
                let found = run.column(&format!("{name}.normal_traction.{which}"))[row];
                worst = worst.max((found / (sign * 3e6) - 1.0).abs());
            }
        }
    }
    assert!(worst < 1e-10, "{worst}");
    measured("2.null_pivots", 0);
    measured("2.traction_error", worst);
}

fn extremes(run: &Run, exact: f64) -> f64 {
    let error = |which: &str| {
        (run.column(&format!("joint.normal_traction.{which}"))[0] / exact - 1.0).abs()
    };
    error("min").max(error("max"))
}

/// Gauss points of the secondary facets only: what uniform tractions load the primary nodes with.
/// The worst nodal force, relative to the exact one.
fn by_secondary_points(secondary: usize, primary: usize) -> f64 {
    let (s, p) = (1.0 / secondary as f64, 1.0 / primary as f64);
    let mut forces = vec![0.0; primary + 1];
    for facet in 0..secondary {
        for xi in [-1.0 / 3.0_f64.sqrt(), 1.0 / 3.0_f64.sqrt()] {
            let x = s * (facet as f64 + 0.5 + 0.5 * xi);
            let cell = ((x / p) as usize).min(primary - 1);
            let part = x / p - cell as f64;
            forces[cell] += 0.5 * s * (1.0 - part);
            forces[cell + 1] += 0.5 * s * part;
        }
    }
    let end = |node: usize| node == 0 || node == primary;
    let exact = |node: usize| if end(node) { 0.5 * p } else { p };
    forces.iter().enumerate().map(|(i, f)| (f / exact(i) - 1.0).abs()).fold(0.0, f64::max)
}

#[test]
#[ignore = "half a minute, for its figures: scripts/stability.sh"]
fn e03_ratio_and_contrast() {
    let top = "1.0e-4*t*(1 + 0.5*(x - 0.5) + 0.25*(y - 0.5))";
    let contrast = |[lower, upper]: [usize; 2], contrast: f64| {
        family("contrast")
            .set(&format!(
                "mesh.column.bodies=[{{cells: [{lower}, {lower}, {lower}]}}, {{cells: [{upper}, \
                 {upper}, {upper}]}}]"
            ))
            .set(&format!("materials.soft.elastic.young_modulus={:e}", YOUNG / contrast))
            .set("time.instants=[1]")
    };
    let iterations = |scene: &Scene, solver: &str| {
        let scene = scene
            .set("materials.stiff.elastic.poisson_ratio=0.3")
            .set("materials.soft.elastic.poisson_ratio=0.3")
            .set(&format!("boundary.1.displacement.z={{formula: \"{top}\"}}"))
            .set("solver.max_newton=5")
            .set(&format!("solver.linear={solver}"));
        scene.attempt(1).map(|run| sum(&run.column("linear_iterations"))).ok()
    };
    let mut rows = Vec::new();
    for (cells, ratio) in [([8, 12], 1.0), ([4, 10], 1.0), ([4, 10], 10.0), ([4, 10], 1e3)] {
        let exact = 1e-4 / (1.0 / YOUNG + ratio / YOUNG);
        let mut counts = Vec::new();
        let mut error = 0.0_f64;
        for side in ["lower", "upper"] {
            let scene = contrast(cells, ratio).set(&format!("interfaces.0.secondary={side}"));
            error = error.max(extremes(&scene.set("solver.linear=mumps").on(1), exact));
            counts.push(["gamg", "hypre", "multigrid"].map(|solver| iterations(&scene, solver)));
        }
        assert!(error < 1e-9, "{cells:?} {ratio}: {error}");
        if ratio == 1e3 {
            // Multipliers on the stiff and coarse side, and on the soft and fine one.
            assert!(counts[0][0].is_none_or(|c| c > 6.0 * counts[1][0].expect("gamg")));
            assert!(counts[1].iter().all(|c| c.is_some_and(|c| c < 40.0)), "{counts:?}");
            let run = contrast(cells, ratio).on(1);
            assert!(run.screen.contains("multipliers on the upper side"), "{}", run.screen);
        }
        rows.push(json!([cells, ratio, error, by_secondary_points(cells[1], cells[0]), counts]));
    }
    let element_based = by_secondary_points(10, 4);
    assert!(element_based > 1e-3, "{element_based}");
    measured("3.contrast", rows);
}

#[test]
#[ignore = "half a minute, for its figures: scripts/stability.sh"]
fn e04_slivers() {
    let exact = YOUNG / (1.0 - 0.09) * 1e-4;
    let boundary = "[{on: bottom, displacement: {x: 0, z: 0}}, {on: top, displacement: {x: 1.0e-5, \
                    z: {formula: \"1.0e-4*(1 + 0.5*(x - 0.5))\"}}}]";
    let mut rows = Vec::new();
    for n in [3_usize, 7, 15, 63, 127] {
        let bodies = |upper: usize| {
            let high = n.div_ceil(2);
            format!("mesh.column.bodies=[{{cells: [{n}, {high}]}}, {{cells: [{upper}, {high}]}}]")
        };
        let scene = family("slivers").set("time.instants=[1]");
        let error = extremes(&scene.set(&bodies(n + 1)).on(1), exact);
        assert!(error < 1e-10, "{n}: {error}");
        let iterations = |upper: usize, solver: &str| {
            let scene = scene
                .set(&bodies(upper))
                .set(&format!("boundary={boundary}"))
                .set("solver.tolerance=1e-9")
                .set(&format!("solver.linear={solver}"));
            sum(&scene.on(1).column("linear_iterations"))
        };
        let [slivers, matching] = [n + 1, n].map(|u| ["gamg", "hypre"].map(|s| iterations(u, s)));
        for (slivers, matching) in slivers.iter().zip(matching) {
            assert!(*slivers <= 1.3 * matching + 2.0, "{n}: {slivers:?} {matching:?}");
        }
        let failing = by_secondary_points(n + 1, n);
        assert!(failing > 1e-3, "{n}: {failing}");
        rows.push(json!([n, 1.0 / (n + 1) as f64, failing, error, slivers, matching]));
    }
    measured("4.slivers", rows);
}

/// The reference column in units of length and force: 1 m, 1 N have so many.
fn in_units(length: f64, force: f64) -> Scene {
    let pressure = force / (length * length);
    let z: Vec<String> = [-1e-4, 1e-4, 1e-3, 5e-4, 1.2e-3, 1.7e-3, 1.7e-3, -1e-4]
        .iter()
        .enumerate()
        .map(|(i, z)| format!("[{}, {:e}]", i + 1, z * length))
        .collect();
    let law = format!(
        "{{linear_softening: {{strength: {:e}, fracture_energy: {:e}}}}}",
        STRENGTH * pressure,
        900.0 * force / length
    );
    family("millimetres")
        .set(&format!("mesh.column.size=[{length:e}, {length:e}, {:e}]", 5.0 * length))
        .set("mesh.column.cells=[4, 4, 20]")
        .set(&format!("materials.rock.elastic.young_modulus={:e}", YOUNG * pressure))
        .set("materials.rock.elastic.poisson_ratio=0.25")
        .set(&format!("interfaces.0={{name: joint, z: {:e}, law: {law}}}", 2.5 * length))
        .set(&format!(
            "boundary.1.displacement.x={{table: [[6, 0], [7, {:e}], [8, 0]]}}",
            1e-3 * length
        ))
        .set(&format!("boundary.1.displacement.z={{table: [[0, 0], {}]}}", z.join(", ")))
}

/// Powers of two round nothing: every number is the same but for its exponent.
const ROUNDED_ALIKE: &str = "powers of two";

#[test]
fn e14_iterations_do_not_know_the_units() {
    let mut rows = Vec::new();
    for solver in ["mumps", "gamg"] {
        let scene = |length: f64, force: f64| {
            in_units(length, force).set(&format!("solver.linear={solver}")).on(1)
        };
        let first = scene(1.0, 1.0);
        for (name, length, force) in [
            ("N, m, Pa", 1.0, 1.0),
            ("N, mm, MPa", 1e3, 1.0),
            ("GN, m, GPa", 1.0, 1e-9),
            (ROUNDED_ALIKE, 1024.0, 1.0 / 1_073_741_824.0),
        ] {
            let run = scene(length, force);
            let counts = ["newton_iterations", "linear_iterations"].map(|c| run.column(c));
            rows.push(json!([solver, name, sum(&counts[0]), sum(&counts[1])]));
            assert_eq!(counts[0], first.column("newton_iterations"), "{}", run.label);
            // Where rounding differs, a residual that is at its bound may take one iteration more,
            // and a start that is good enough in one system may be solved on in the other.
            for (mine, theirs) in first.column("linear_iterations").iter().zip(&counts[1]) {
                let more = match mine.min(*theirs) {
                    _ if name == ROUNDED_ALIKE => 0.0,
                    0.0 => 2.0,
                    _ => 1.0,
                };
                assert!((mine - theirs).abs() <= more, "{}: {mine} and {theirs}", run.label);
            }
            let scale = force / (length * length);
            for (mine, theirs) in first
                .column("joint.normal_traction.mean")
                .iter()
                .zip(run.column("joint.normal_traction.mean"))
            {
                near(name, theirs / scale, *mine, 1e-8 * STRENGTH);
            }
        }
    }
    measured("14.units", rows);
}

/// Contact after rupture has no memory of the sliding, whatever the augmentation.
#[test]
fn e19_closed_after_shear_while_open() {
    let mut rows = Vec::new();
    for augmentation in [0.51, 1.0, 10.0, 1e3] {
        let law = "interfaces.0.law.linear_softening.augmentation";
        let run = family("sheared_while_open").set(&format!("{law}={augmentation}")).on(1);
        let normal = run.column("joint.normal_traction.mean");
        let mut error = 0.0_f64;
        for row in [2, 3, 5] {
            error = error.max((normal[row] + 116_000.0).abs());
        }
        let mut shear = 0.0_f64;
        for name in ["x.min", "x.max", "y.min", "y.max"] {
            let column = run.column(&format!("joint.shear_traction_{name}"));
            shear = column[2..].iter().fold(shear, |m, t| m.max(t.abs()));
        }
        assert!(error < 1e-6 && shear < 1e-4, "{augmentation}: {error} {shear}");
        rows.push(json!([augmentation, error, shear, trouble(&run)]));
    }
    measured("19.reclosure", rows);
}
