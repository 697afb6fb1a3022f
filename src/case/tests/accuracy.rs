//! Which results are wanted, and cells that grow.

use super::mistakes::message;
use super::*;

#[test]
fn an_accuracy_takes_the_place_of_the_cells() {
    let case = good(&["mesh.column.cells=", "accuracy={of: [top.reaction_z], relative: 1e-3}"]);
    let column = case.mesh.column().expect("a column");
    assert_eq!((column.orders.as_slice(), &column.cells), (&[2][..], &Cells::Uniform([1; 3])));
    let wanted = case.sections().accuracy.as_ref().expect("an accuracy");
    assert_eq!((wanted.relative, wanted.budget.unknowns), (1e-3, 1_000_000));
    let again = Case::read(&case.resolved().to_string(), Path::new("case.yaml"), &[]);
    assert_eq!(again.as_ref(), Ok(&case));
}

#[test]
fn what_the_run_cannot_give_is_told_with_what_there_is() {
    let text = message("mesh", "mesh", &["accuracy={of: [top.reaction], relative: 1e-3}"]);
    let start = "accuracy.of.0 cannot be `top.reaction`: it is no result of the run; did you mean \
                 `top.reaction_";
    assert!(text.contains(start) && text.contains("joint.damage.{min,max,mean}"), "{text}");
    let text =
        message("mesh", "mesh", &["accuracy={of: [top.reaction_z], at: [17], relative: 0.1}"]);
    assert!(text.contains("accuracy.at.0 must be one of time.instants"), "{text}");
    let both = ["accuracy={of: [top.reaction_z], relative: 0.1}", "mesh.refine=1"];
    assert!(message("mesh", "mesh", &both).contains("mesh.refine cannot stand beside accuracy"));
}

#[test]
fn places_that_cells_cannot_grow_away_from_are_told() {
    let text = message("mesh", "mesh", &["mesh.column.grading={z: {towards: [left], ratio: 4}}"]);
    let reason = "mesh.column.grading.z.towards.0 cannot be `left`; cells along z grow away from: \
                  bottom, top, joint";
    assert!(text.contains(reason), "{text}");
    let text = message("mesh", "mesh", &["mesh.column.grading={x: {towards: [left], ratio: 0.5}}"]);
    assert!(text.contains("mesh.column.grading.x.ratio must be at least 1, got 0.5"), "{text}");
}
