//! Paths and branches: experiments 7 and 8.

use super::{CRITICAL, ENERGY, STRENGTH, YOUNG, family, measured, near, sum};
use crate::scene::Scene;
use serde_json::json;

fn column_of(height: f64) -> Scene {
    family("snap_back")
        .set(&format!("mesh.column.size=[1.0, 1.0, {height:e}]"))
        .set(&format!("interfaces.0.z={:e}", 0.5 * height))
}

#[test]
fn e07_snap_back() {
    let mut rows = Vec::new();
    for ratio in [0.5, 0.9, 0.99, 1.01, 2.0, 5.0] {
        let height = ratio * YOUNG * CRITICAL / STRENGTH;
        let peak = STRENGTH * height / YOUNG;
        // To half of the rupture where the path leads there, else past the peak by a fiftieth.
        let end = if ratio < 1.0 { 0.5 * (CRITICAL + peak) } else { 1.02 * peak };
        let prescribed = column_of(height)
            .set("control=")
            .set(&format!("boundary.1.displacement.z={{formula: \"{end:e}*t\"}}"))
            .set("time.instants=[0.5, 0.9, 1]")
            .attempt(1);
        let outcome = match prescribed {
            Ok(run) => {
                assert!(ratio < 1.0, "false convergence: {:?}", run.column("joint.damage.mean"));
                near("damage", run.column("joint.damage.mean")[2], 0.5, 1e-8);
                json!(sum(&run.corrections()))
            }
            Err(failure) => {
                assert!(ratio > 1.0 && failure.status == Some(3), "{}", failure.complaint);
                let says = failure.complaint.contains("gives way over its whole area");
                assert!(says && failure.complaint.contains("control"), "{}", failure.complaint);
                json!(null)
            }
        };
        let run = column_of(height)
            .set("control={dissipation: {of: joint, step: 0.05}}")
            .set("time.instants=[1]")
            .on(1);
        let path: Vec<[f64; 2]> = run
            .column("load_factor")
            .into_iter()
            .zip(run.column("joint.normal_traction.mean"))
            .map(|(u, t)| [u, t])
            .collect();
        let mut error = 0.0_f64;
        for (part, [factor, _]) in run.column("time").into_iter().zip(&path) {
            let exact = part * CRITICAL + (1.0 - part) * peak;
            error = error.max((factor / exact - 1.0).abs());
        }
        assert!(error < 1e-8, "{ratio}: {error}");
        let dissipated = *run.column("energy.dissipated").last().expect("a row");
        near("rupture", dissipated, ENERGY, 1e-8 * ENERGY);
        rows.push(json!([ratio, outcome, error, dissipated, sum(&run.corrections()), path]));
    }
    measured("7.snap_back", rows);
}

/// Damage of both interfaces, traction and dissipation at the time 2 and 4, and what is told.
#[test]
fn e08_the_even_branch_is_silent() {
    let mut rows = Vec::new();
    // Pulled by 1 mm: u = sum of the jumps + t L/E.
    let part = |factor: f64, open: f64| {
        let bulk = factor * STRENGTH * 3.0 / YOUNG;
        (1e-3 - bulk) / (open * CRITICAL - bulk)
    };
    let even = [part(1.0, 2.0); 2];
    for (case, factor, stability, parts) in [
        ("two_equal_interfaces", None, "off", even),
        ("two_equal_interfaces", None, "warn", even),
        ("two_equal_interfaces", None, "follow", [part(1.0, 1.0), 0.0]),
        ("weaker_by_a_thousandth", Some(0.999), "auto", [0.0, part(0.999, 1.0)]),
        ("weaker_by_a_thousandth", Some(0.99999999), "follow", [0.0, part(0.99999999, 1.0)]),
    ] {
        let mut scene = family(case).set(&format!("solver.stability={stability}"));
        if let Some(factor) = factor {
            scene = scene.set(&format!("initial.imperfection.0.factor={factor}"));
        }
        let run = scene.on(1);
        let damage = ["lower", "upper"].map(|n| run.column(&format!("{n}.damage.mean"))[1]);
        for (found, exact) in damage.iter().zip(parts) {
            near(&run.label, *found, exact, 1e-8);
        }
        let (unstable, forks) = (run.told("instabilities"), run.told("bifurcations"));
        match stability {
            "off" => assert!(unstable.is_empty() && forks.is_empty(), "silent"),
            "warn" => assert!(unstable[0].contains("has 3 negative eigenvalues"), "{unstable:?}"),
            _ => assert!(unstable.is_empty(), "{unstable:?}"),
        }
        let energy = run.column("energy.dissipated")[3];
        rows.push(json!([case, factor, stability, damage, energy, unstable.len(), forks.len()]));
    }
    measured("8.branches", rows);
    for stability in ["off", "follow"] {
        let run = family("two_equal_interfaces")
            .set("boundary.1.displacement.z={table: [[0, 0], [1, 0.002]]}")
            .set("time.instants=[0.1, 0.2, 0.28, 0.285, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1]")
            .set(&format!("solver.stability={stability}"))
            .on(1);
        let points = run.column("top.reaction_z").into_iter().zip(run.column("time"));
        let points: Vec<[f64; 2]> = points.map(|(force, time)| [2e-3 * time, force]).collect();
        measured(&format!("8.path_{stability}"), vec![json!(points)]);
    }
}

/// One half may turn against the other, in either direction.
#[test]
fn e08_tilting() {
    let tilting = |stability: &str| {
        column_of(8.4)
            .set("control=")
            .set("mesh.column.cells=[4, 4, 32]")
            .set(&format!(
                "boundary.1.displacement.z={{formula: \"{:e}*t\"}}",
                STRENGTH * 8.4 / YOUNG + 1e-5
            ))
            .set("time.instants=[1]")
            .set(&format!("solver.stability={stability}"))
            .on(1)
    };
    let spread = |stability: &str| {
        let run = tilting(stability);
        (["min", "max"].map(|w| run.column(&format!("joint.damage.{w}"))[0]), run)
    };
    let (even, off) = spread("off");
    assert!(off.told("instabilities").is_empty() && even[1] - even[0] < 1e-8, "{even:?}");
    let told = spread("warn").1.told("instabilities");
    assert!(told[0].contains("2 negative eigenvalues"), "{told:?}");
    assert!(told[0].contains("tilting of interface joint"), "{told:?}");
    let (tilted, follow) = spread("follow");
    assert!(follow.told("bifurcations").len() == 1 && tilted[1] - tilted[0] > 0.1, "{tilted:?}");
    measured("8.tilt", vec![even.to_vec(), tilted.to_vec()]);
}
