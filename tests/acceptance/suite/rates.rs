//! Newton's method, steps and ranks: experiments 11 to 13.

use super::{CRITICAL, ENERGY, STRENGTH, YOUNG, base, family, measured};
use super::{near, sum, trouble};
use serde_json::json;

const AUGMENTATION: &str = "interfaces.0.law.linear_softening.augmentation";

/// The case with its reversals, and single steps from rest to multiples of the elastic limit.
#[test]
fn e11_cycles() {
    let refused = family("overshoot").set(&format!("{AUGMENTATION}=0.5")).attempt(1);
    assert_eq!(refused.err().expect("refused").status, Some(2));
    let limit = STRENGTH * 5.0 / YOUNG;
    let single = |multiple: f64, augmentation: f64| {
        let run = family("overshoot")
            .set(&format!(
                "boundary.1.displacement.z={{table: [[0, 0], [1, {:e}]]}}",
                multiple * limit
            ))
            .set("time.instants=[1]")
            .set(&format!("{AUGMENTATION}={augmentation}"))
            .on(1);
        let height = 5.0 / (YOUNG * CRITICAL / STRENGTH);
        let opened = ((multiple - 1.0) * limit / (1.0 - height)).clamp(0.0, CRITICAL);
        near(&run.label, run.column("energy.dissipated")[0], ENERGY * opened / CRITICAL, 1e-6);
        json!([sum(&run.corrections()), trouble(&run)])
    };
    let mut rows = Vec::new();
    for augmentation in [0.51, 0.55, 0.6, 1.0, 10.0, 1e4] {
        // The exact values do not know the augmentation.
        let run =
            base("overshoot").in_any_steps().set(&format!("{AUGMENTATION}={augmentation}")).on(1);
        let [cycles, cuts] = trouble(&run);
        if augmentation < 0.52 {
            assert!(cycles > 0 && cuts > 0, "{cycles} {cuts}");
        } else if augmentation > 0.58 {
            assert_eq!([cycles, cuts], [0, 0], "{}", run.label);
        }
        let singles = [0.5, 1.2, 3.0].map(|multiple| single(multiple, augmentation));
        rows.push(json!([augmentation, sum(&run.corrections()), [cycles, cuts], singles]));
    }
    measured("11.cycles", rows);
    // Points that soften without a change of branch may alternate too, which only the limit of
    // corrections ends; the step is cut, and the answer right.
    let law = "{linear_softening: {strength: 1.0e7, fracture_energy: 1.0e4}}";
    let run = base("constrained_edges")
        .in_any_steps()
        .set(&format!("interfaces.0.law={law}"))
        .set(&format!("interfaces.1.law={law}"))
        .on(1);
    measured("11.alternation", json!([sum(&run.corrections()), trouble(&run)]));
}

#[test]
fn e12_steps() {
    // Opened and sheared at a changing angle; the rock is stiff enough for a unique answer.
    let turning = |law: &str| {
        let scene = family("step_size")
            .set("mesh.column.size=[1.0, 1.0, 0.5]")
            .set("interfaces.0.z=0.25")
            .set(
                "boundary.1.displacement={x: {formula: \"1.5e-3*min(t, 1)\"}, y: 0, z: {formula: \
                 \"5.0e-3*max(0, t - 0.5)\"}}",
            );
        if law.is_empty() { scene } else { scene.set(&format!("interfaces.0.law={law}")) }
    };
    let mixed = "{benzeggagh_kenane: {strength: 1.1e6, shear_strength: 2.2e6, fracture_energy: 900.0, \
                 shear_fracture_energy: 3600.0, exponent: 2.0}}";
    let mut rows = Vec::new();
    for steps in [1, 2, 10, 100, 1000] {
        let instants: Vec<String> =
            (1..=steps).map(|i| (1.5 * f64::from(i) / f64::from(steps)).to_string()).collect();
        let instants = format!("time.instants=[{}]", instants.join(", "));
        let last = |scene: crate::scene::Scene| {
            let run = scene.set(&instants).on(1);
            let of = |name: &str| *run.column(name).last().expect("a row");
            let (dissipated, external) = (of("energy.dissipated"), of("energy.external"));
            (dissipated, external, sum(&run.corrections()), trouble(&run)[1])
        };
        let (dissipated, external, corrections, cuts) = last(family("step_size"));
        near("dissipated", dissipated, ENERGY, 1e-10 * ENERGY);
        // 1000 instants of these are no better than 100 for the point.
        let turned = if steps <= 100 {
            let one = last(turning("")).0;
            near("one energy for all modes", one, ENERGY, 1e-10 * ENERGY);
            json!([one, last(turning(mixed)).0])
        } else {
            json!(null)
        };
        if steps == 1000 {
            near("external", external, ENERGY, 1e-4 * ENERGY);
        }
        rows.push(json!([steps, dissipated, external, corrections, cuts, turned]));
    }
    let of = |row: &serde_json::Value| row[5][1].as_f64().expect("a number");
    // Steps that press open lips are cut: without that a single step dissipates less than half.
    let finest = of(&rows[3]);
    assert!(rows[..3].iter().all(|row| of(row) < finest && of(row) > 0.93 * finest), "{rows:?}");
    measured("12.steps", rows);
}

#[test]
#[ignore = "half a minute, for its figures: scripts/stability.sh"]
fn e13_scattered_cells() {
    let scene = base("partition");
    let one = scene.on(1);
    let mut rows = Vec::new();
    for ranks in [2, 3, 4, 7] {
        let run = scene.scattered().on(ranks);
        one.assert_same(&run, 1e-8);
        assert_eq!(one.corrections(), run.corrections());
        let pairs = run.report["partition"]["cut_pairs"].as_u64();
        assert!(pairs > Some(0), "{:?}", run.report);
        // Which of two equal interfaces opens is a choice, the same everywhere.
        let fork = base("two_equal_interfaces").in_any_steps().scattered().on(ranks);
        assert_eq!(fork.told("bifurcations").len(), 1, "{}", fork.label);
        rows.push(json!([ranks, pairs, one.difference(&run), fork.column("lower.damage.mean")[1]]));
    }
    measured("13.scattered", rows);
}
