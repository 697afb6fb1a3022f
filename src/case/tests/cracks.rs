//! The state of interfaces at the start.

use super::mistakes::message;
use super::*;

const LAW: &str = "law: {linear_softening: {strength: 1.1e6, fracture_energy: 900}}";

/// The interface of `GOOD` with a law and a state at the start.
fn with(law: &str, initial: &str) -> String {
    format!("law: {law}\n    initial: {initial}")
}

/// The complaint about `initial` beside a law.
fn complaint(law: &str, initial: &str) -> String {
    message(LAW, &with(law, initial), &[])
}

const COHESIVE: &str = "{linear_softening: {strength: 1.1e6, fracture_energy: 900}}";

#[test]
fn the_start_of_an_interface_is_read() {
    let initial = "{damage: {formula: \"x < 0.3\"}, gap: {formula: \"1.0e-4*(x < 0.3)\"}}";
    let case = read_with(LAW, &with(COHESIVE, initial), &[]).expect("a good case");
    let interface = &case.interfaces[0];
    assert_eq!((interface.joins_at_start(), interface.has_gap), (None, false));
    let at = |x: f64| interface.start_at(0, [x, 0.0, 2.5]).expect("a state");
    assert_eq!(at(0.2), NodeStart { damage: 1.0, gap: 1e-4, aperture: 0.0 });
    assert_eq!(at(0.3), NodeStart::default());
    let case = read_with(LAW, &with("{contact: {}}", "{gap: 0}"), &["boundary.1.displacement={}"]);
    assert!(case.is_err(), "a contact holds nothing");
    let crack = with(COHESIVE, "{damage: 1}");
    let free = message(LAW, &crack, &["boundary.1={on: top, traction: {z: -1}}"]);
    assert!(free.contains("body 2") && free.contains("a contact holds what is pressed"), "{free}");
    // A crack holds what is pressed on it, as contact does.
    let pressed = "boundary.1={on: top, displacement: {x: 0, y: 0}, traction: {z: -1}}";
    assert!(read_with(LAW, &crack, &[pressed]).is_ok());
}

#[test]
fn what_makes_no_sense_is_refused() {
    for (law, initial, words) in [
        (COHESIVE, "{}", "interfaces.0.initial has no entries"),
        (COHESIVE, "{damage: 1.5}", "initial.damage must be between 0 and 1, got 1.5"),
        (COHESIVE, "{damage: -1}", "initial.damage must be between 0 and 1, got -1"),
        (COHESIVE, "{damage: .nan}", "initial.damage must be finite, got NaN"),
        (COHESIVE, "{damage: {formula: \"t\"}}", "initial.damage.formula uses t: a state at the"),
        (COHESIVE, "{damaged: 1}", "initial.damaged is not a known key; did you mean `damage`?"),
        (COHESIVE, "{gap: 1.0e-4}", "initial.gap needs damage: 1 where the lips lie apart"),
        (COHESIVE, "{damage: 0.5, gap: 1.0e-4}", "initial.gap needs damage: 1, got 0.5"),
        (COHESIVE, "{aperture: 1.0e-5}", "initial.aperture is of an interface along which fluid"),
        (COHESIVE, "{aperture: -1.0e-5}", "initial.aperture must be at least 0, got -1e-5"),
        ("{tied: {}}", "{damage: 1}", "initial.damage is of laws that soften: tied holds for good"),
        ("{tied: {}}", "{gap: 1}", "initial.gap is of lips that can touch: tied ones are one"),
        ("{contact: {}}", "{damage: 1}", "initial.damage is of laws that soften: nothing holds by"),
    ] {
        let told = complaint(law, initial);
        assert!(told.contains(words), "{law} {initial}: {told}");
    }
}

#[test]
fn formulas_are_asked_at_the_nodes() {
    for (initial, x, words) in [
        (
            "{damage: {formula: \"2*x\"}}",
            1.0,
            "interfaces.0.initial.damage: it is 2 at (1, 0, 2.5) m; it must be between 0 and 1",
        ),
        ("{damage: {formula: \"ln(x - 1)\"}}", 0.0, "initial.damage: it is NaN at (0, 0, 2.5) m"),
        (
            "{damage: {formula: \"x > 0.5\"}, gap: 1.0e-4}",
            0.5,
            "initial.gap: it is 1e-4 at (0.5, 0, 2.5) m; lips that anything holds together",
        ),
        ("{damage: 1, gap: {formula: \"1/x\"}}", 0.0, "initial.gap: it is inf at (0, 0, 2.5) m"),
    ] {
        let case = read_with(LAW, &with(COHESIVE, initial), &[]).expect("a readable case");
        let told = case.interfaces[0].start_at(0, [x, 0.0, 2.5]).expect_err("a refusal");
        assert!(told.to_string().contains(words), "{initial}: {told}");
    }
}
