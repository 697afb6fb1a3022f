//! Mistakes about stability and imperfections.

use super::mistakes::message;

const IMPERFECTION: &str = "initial={imperfection: [{interface: joint, factor: 0.9}]}";

#[test]
fn a_mistake_in_an_imperfection_is_told() {
    for (assignment, expected) in [
        (
            "initial={imperfection: [{interface: jont, factor: 0.9}]}",
            "initial.imperfection.0.interface must name an interface, got `jont`; did you mean \
             `joint`? (known: joint)",
        ),
        (
            "initial={imperfection: [{interface: joint, factor: 0}]}",
            "initial.imperfection.0.factor must be positive, got 0",
        ),
        (
            "initial={imperfection: [{interface: joint, factor: {formula: 1+t}}]}",
            "initial.imperfection.0.factor.formula uses t: an imperfection is the same at all times",
        ),
        (
            "initial={imperfection: [{interface: joint, factor: {table: [[0, 1]]}}]}",
            "initial.imperfection.0.factor needs `over`: x, y or z; an imperfection is the same at all times",
        ),
        (
            "initial={imperfection: [{interface: joint, factor: 2}, {interface: joint, factor: 3}]}",
            "initial.imperfection.1.interface `joint` has an imperfection already",
        ),
        ("initial={}", "initial has no entries"),
    ] {
        let expected = format!("--set {assignment}: {expected}");
        assert_eq!(message("mesh", "mesh", &[assignment]), expected);
    }
}

#[test]
fn an_imperfection_needs_a_strength() {
    for law in ["contact", "tied"] {
        let law = format!("interfaces.0.law={{{law}: {{}}}}");
        assert_eq!(
            message("mesh", "mesh", &[&law, IMPERFECTION]),
            format!(
                "--set {IMPERFECTION}: initial.imperfection.0.interface names `joint`, which has no \
                 strength to be multiplied"
            )
        );
    }
}

#[test]
fn a_state_is_followed_where_it_can_be() {
    for (assignment, expected) in [
        (
            "solver={stability: folow}",
            "solver.stability cannot be `folow`; did you mean `follow`? (known: auto, off, warn, \
             follow, stop)",
        ),
        (
            "solver={stability: follow, form: saddle_point}",
            "solver.stability needs form: condensed, whose tangent is symmetric",
        ),
    ] {
        let expected = format!("--set {assignment}: {expected}");
        assert_eq!(message("mesh", "mesh", &[assignment]), expected);
    }
    let control = "control={dissipation: {of: joint, step: 0.1}}";
    let text = message("mesh", "mesh", &["expect=", control, "solver.stability=follow"]);
    let expected = "solver.stability=follow: solver.stability follow cannot stand beside control: a \
                    path goes through states that are not stable";
    assert_eq!(text, format!("--set {expected}"));
}
