//! Platens as they are written and checked.

use std::path::Path;

use crate::case::sections::{
    BoundarySection, CaseFile, Components, MaterialSection, MeshSection, RigidSection, Surface,
    TimeSection,
};
use crate::case::{Case, Motion, Value};

fn read(platen: &str, more: &str) -> Result<Case, String> {
    let text = format!(
        "
mesh: {{column: {{size: [1, 1, 2], cells: [1, 1, 2]}}}}
materials: {{rock: {{elastic: {{young_modulus: 1.0e9, poisson_ratio: 0}}}}}}
boundary:
  - {{on: bottom, displacement: {{x: 0, y: 0, z: 0}}}}
  - {{on: top, rigid: {{{platen}}}}}
{more}
time: {{instants: [1, 2]}}
"
    );
    Case::read(&text, Path::new("case.yaml"), &[]).map_err(|error| error.to_string())
}

#[test]
fn a_platen_binds_what_it_names_and_turns_what_it_binds() {
    let platen = "z: free, x: {table: [[0, 0], [1, 1]]}, rotation: free, force: {z: -3}";
    let case = read(platen, "").expect("a good case");
    let rigid = case.boundary[1].rigid.as_ref().expect("a platen");
    assert_eq!(rigid.along[2], Some(Motion::Free));
    assert_eq!(rigid.along[1], None);
    assert_eq!(rigid.about, [const { Some(Motion::Free) }; 3]);
    assert_eq!(rigid.force[2], Some(Value::Constant(-3.0)));
    assert_eq!([0, 1, 2].map(|axis| case.boundary[1].is_carried(axis)), [true, false, true]);
    assert_eq!(case.breakpoints(), [1.0]);
    let columns = case.columns();
    let of = |name: &str| columns.contains(&format!("top.{name}"));
    assert!(["reaction_z", "displacement_y", "rotation_x", "moment_z"].into_iter().all(of));

    // Without a rotation what is prescribed is one value for the whole surface.
    let case = read("z: free, x: 0.5", "").expect("a good case");
    let rigid = case.boundary[1].rigid.as_ref().expect("a platen");
    assert_eq!(rigid.about, [const { Some(Motion::Fixed) }; 3]);
    assert_eq!(case.boundary[1].displacement[0], Some(Value::Constant(0.5)));
    assert!(!case.boundary[1].is_carried(0) && case.boundary[1].is_carried(2));
}

#[test]
fn a_platen_is_built_in_code() {
    let held = Components::xz(0.0, 0.0);
    let file = CaseFile::new(MeshSection::column([1.0, 2.0], [1, 2]), TimeSection::instants([1.0]))
        .material("rock", MaterialSection::elastic(1e9, 0.0))
        .boundary(BoundarySection::on(Surface::Bottom).displacement(held))
        .boundary(BoundarySection::on(Surface::Top).rigid(RigidSection::pressed(-1e6)));
    let case = Case::build(file).expect("a good case");
    let rigid = case.boundary[1].rigid.as_ref().expect("a platen");
    // In 2D it turns about y alone.
    assert_eq!(rigid.about, [None, Some(Motion::Fixed), None]);
    assert!(case.columns().contains(&"top.rotation_y".to_owned()));
    assert!(!case.columns().contains(&"top.rotation_x".to_owned()));
}

#[test]
fn mistakes_of_platens_are_told() {
    for (platen, more, words) in [
        ("rotation: fixed", "", "binds no component"),
        (
            "z: fixed, force: {z: 1}",
            "",
            "force.z acts on a motion that is prescribed: give z: free",
        ),
        ("z: free, force: {x: 1}", "", "force.x acts on what is not bound"),
        ("z: free, moment: {y: 1}", "", "give rotation.y: free, or leave the moment out"),
        ("z: free, force: {normal: 1}", "", "force.normal has no meaning for a platen"),
        ("z: free, rotation: {z: free}", "", "rotation.z turns nothing that the platen binds"),
        ("z: {formula: \"x*t\"}", "", "rigid.z varies in space"),
        ("z: free", "  - {on: top, rigid: {x: free}}", "is the second one on its surface"),
        (
            "z: free",
            "  - {on: top, displacement: {z: 0}}",
            "gives the displacement along z of nodes",
        ),
        ("z: free", "  - {on: left, displacement: {z: 0}}", "leave z out of one of them"),
        ("z: free", "probes: [{name: top, at: [0, 0, 0]}]", "is the name of a platen"),
    ] {
        let error = read(platen, more).expect_err(words);
        assert!(error.contains(words), "{error}");
    }
    // Still components agree as other displacements do.
    read("x: fixed, z: free", "  - {on: left, displacement: {x: 0}}").expect("a good case");
    let error = read("x: 0.1, z: free", "  - {on: left, displacement: {x: 0}}");
    assert!(error.is_err_and(|error| error.contains("disagrees with boundary.1")));
}

#[test]
fn a_platen_that_nothing_holds_is_told_beforehand() {
    let text = |held: &str| {
        format!(
            "
mesh: {{column: {{size: [1, 2], cells: [1, 2]}}}}
materials: {{rock: {{elastic: {{young_modulus: 1.0e9, poisson_ratio: 0}}}}}}
boundary: [{{on: left, displacement: {{{held}}}}}, {{on: top, rigid: {{z: free, rotation: free}}}}]
time: {{instants: [1]}}
"
        )
    };
    let read = |held: &str| Case::read(&text(held), Path::new("case.yaml"), &[]);
    let error = read("x: 0").expect_err("nothing holds it along z").to_string();
    assert!(error.contains("can move freely: translation along z"), "{error}");
    let mut good = text("x: 0").replace("on: top", "on: right");
    good = good.replace("z: free, rotation: free", "z: fixed, x: free");
    Case::read(&good, Path::new("case.yaml"), &[]).expect("the other side holds it along z");
}
