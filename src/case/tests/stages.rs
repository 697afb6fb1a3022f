//! Stages: what each has, and what is refused.

use super::*;

fn yaml(stages: &str) -> String {
    format!(
        "mesh: {{column: {{size: [1, 2], cells: [1, 2]}}}}
materials: {{rock: {{elastic: {{young_modulus: 1.0e9, poisson_ratio: 0.2}}}}}}
interfaces:
  - {{name: joint, z: 1, law: {{linear_softening: {{strength: 1.0e6, fracture_energy: 900}}}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, z: 0}}}}
  - {{on: left, displacement: {{normal: 0}}}}
  - {{on: top, traction: {{x: 1, z: -1}}}}
time: {{instants: [1, 2, 3]}}
stages:
{stages}"
    )
}

fn read(stages: &str) -> Result<Case> {
    Case::read(&yaml(stages), Path::new("case.yaml"), &[])
}

#[test]
fn a_stage_has_what_was_before_but_for_what_it_changes() {
    let case = read(
        "  - {until: 1}
  - {until: 2, boundary: [{on: left, displacement: {x: free}}, {on: top, traction: {z: -2}}],
     materials: {rock: {elastic: {young_modulus: 2.0e9}}}}
  - {until: 3, boundary: [{on: top, displacement: {z: 0}}], fluid: {joint: {pressure: 5}}}
",
    )
    .expect("a case");
    let stages = case.in_stages();
    let spans: Vec<_> = stages.iter().map(|stage| (stage.start, stage.time.clone())).collect();
    assert_eq!(spans, [(0.0, vec![1.0]), (1.0, vec![2.0]), (2.0, vec![3.0])]);
    let surfaces = |stage: &Case| -> Vec<Surface> {
        stage.boundary.iter().map(|entry| entry.on.clone()).collect()
    };
    assert_eq!(surfaces(stages[0]), [Surface::Bottom, Surface::Left, Surface::Top]);
    assert_eq!(surfaces(stages[1]), [Surface::Bottom, Surface::Top]);
    let traction = |stage: &Case, axis: usize| stage.boundary[1].traction[axis].clone();
    assert_eq!(traction(stages[1], 0), Some(Value::Constant(1.0)));
    assert_eq!(traction(stages[2], 2), Some(Value::Constant(-2.0)));
    assert_eq!(stages[2].boundary[1].displacement[2], Some(Value::Constant(0.0)));
    let moduli = stages.iter().map(|stage| stage.materials[0].young_modulus);
    assert_eq!(moduli.collect::<Vec<_>>(), [1e9, 2e9, 2e9]);
    let fluid = |stage: &&Case| stage.interfaces[0].fluid_pressure.is_some();
    assert_eq!(stages.iter().map(fluid).collect::<Vec<_>>(), [false, false, true]);
    // The columns are those of all stages.
    let columns = case.columns();
    assert!(["left.reaction_x", "top.reaction_z"].iter().all(|c| columns.iter().any(|d| d == c)));
    let again = Case::read(&case.resolved().to_string(), Path::new("case.yaml"), &[]);
    assert_eq!(again, Ok(case));
}

#[test]
fn what_no_stage_can_say_is_refused() {
    for (stages, words) in [
        ("  - {until: 1}\n  - {until: 2}\n", "stages.1.until must be the last of time.instants, 3"),
        ("  - {until: 1.5}\n  - {until: 3}\n", "stages.0.until must be one of time.instants"),
        (
            "  - {until: 2}\n  - {until: 1}\n  - {until: 3}\n",
            "stages.1.until must be above the end of the stage before, 2, got 1",
        ),
        (
            "  - {until: 3, boundary: [{on: right, displacement: free}]}\n",
            "stages.0.boundary.0.displacement frees what is not prescribed on `right`",
        ),
        (
            "  - {until: 3, boundary: [{on: left, displacement: {x: 0, normal: free}}]}\n",
            "is changed twice on `left` in one stage",
        ),
        ("  - {until: 3, boundary: [{on: left}]}\n", "stages.0.boundary.0 changes nothing"),
        ("  - {until: 3, fluid: {joit: {pressure: 1}}}\n", "did you mean `joint`"),
        ("  - {until: 3, materials: {rok: {elastic: {density: 1}}}}\n", "did you mean `rock`"),
        (
            "  - {until: 3, materials: {rock: {porous: {density: 1}}}}\n",
            "stages.0.materials.rock.porous changes what the material does not have",
        ),
        (
            "  - {until: 1}\n  - {until: 3, boundary: [{on: bottom, displacement: free}]}\n",
            "stages.1: boundary leaves a body free",
        ),
        (
            "  - {until: 3}\ncontrol: {dissipation: {of: joint, step: 0.1}}\n",
            "control cannot stand beside stages",
        ),
        ("  - {until: 3, boundary: [{on: top, displacement: {z: fre}}]}\n", "cannot be `fre`"),
    ] {
        let error = read(stages).expect_err(stages).to_string();
        assert!(error.contains(words), "{stages}: {error}");
    }
}
