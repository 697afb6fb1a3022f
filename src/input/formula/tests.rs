use super::*;

fn value(text: &str) -> f64 {
    Formula::parse(text).expect(text).at([2.0, 3.0, 5.0], 7.0)
}

#[test]
fn precedence_and_associativity_are_those_of_mathematics() {
    for (text, expected) in [
        ("1+2*3", 7.0),
        ("(1+2)*3", 9.0),
        ("8-3-2", 3.0),
        ("16/4/2", 2.0),
        ("2^3^2", 512.0),
        ("-2^2", -4.0),
        ("(-2)^2", 4.0),
        ("2^-1", 0.5),
        ("1/2", 0.5),
        ("--3", 3.0),
        ("-x^2*2", -8.0),
        ("2*-3", -6.0),
    ] {
        assert_eq!(value(text), expected, "{text}");
    }
}

#[test]
fn comparisons_and_steps_are_one_or_zero() {
    for (text, expected) in [
        ("x < y", 1.0),
        ("x > y", 0.0),
        ("x <= 2", 1.0),
        ("x ≥ 2.5", 0.0),
        ("x + 1 >= y", 1.0),
        ("(x < 3)*(y < 3)", 0.0),
        ("max(x > 1, y)", 3.0),
        ("step(t - 7)", 1.0),
        ("5*step(t - 7.5) - step(0)", -1.0),
    ] {
        assert_eq!(value(text), expected, "{text}");
    }
    assert!(value("(0/0) < 1").is_nan() && value("step(0/0)").is_nan());
    let complaint = Formula::parse("1 < 2 < 3").expect_err("two comparisons");
    assert_eq!(complaint, "expected an operator before `<` at column 7 of the formula");
}

#[test]
fn variables_numbers_and_functions_are_evaluated() {
    for (text, expected) in [
        ("x+10*y+100*z+1000*t", 7532.0),
        ("1e-5*1E+5", 1.0),
        (".5 + 1.", 1.5),
        ("cos(pi)", -1.0),
        ("sin(0)", 0.0),
        ("sqrt(16) + abs(-1)", 5.0),
        ("ln(exp(2))", 2.0),
        ("min(x, y, -1) + max(x, y, z)", 4.0),
    ] {
        assert!((value(text) - expected).abs() < 1e-15, "{text}");
    }
    assert!(value("min(0/0, 1)").is_nan() && value("max(1, 0/0)").is_nan());
    assert!(value("1/(x-2)").is_infinite());
}

#[test]
fn the_variables_in_use_are_known() {
    let formula = |text: &str| Formula::parse(text).expect(text);
    assert!(formula("1+z").varies_in_space() && !formula("sin(t)").varies_in_space());
    assert!(formula("max(1, -y)").uses_y() && !formula("x*z").uses_y());
    assert!(formula("2*pi").is_constant() && !formula("t").is_constant());
}

#[test]
fn mistakes_are_told_with_their_column() {
    for (text, expected) in [
        ("1e-4*(0.5+x", "`)` is missing at column 12 of the formula"),
        ("2x", "expected an operator before `x` at column 2 of the formula"),
        ("", "a number, a variable or `(` is missing at column 1 of the formula"),
        ("1+", "a number, a variable or `(` is missing at column 3 of the formula"),
        ("1)", "a closing parenthesis without an opening one at column 2 of the formula"),
        ("1e*2", "`1e` is not a number at column 1 of the formula"),
        ("1e999", "`1e999` is not a number at column 1 of the formula"),
        ("sqrt 2", "`(` is missing after `sqrt` at column 6 of the formula"),
        ("sqrt(1,2)", "`sqrt` takes one argument(s) at column 9 of the formula"),
        ("max(1)", "`max` takes two or more argument(s) at column 6 of the formula"),
        (
            "1 + foo",
            "unknown name `foo` (known: x, y, z, t, pi, sqrt, exp, ln, sin, cos, abs, \
             step, min, max) at column 5 of the formula",
        ),
        ("2*#", "expected a number, a variable or `(` but found `#` at column 3 of the formula"),
    ] {
        assert_eq!(Formula::parse(text), Err(expected.to_owned()), "{text}");
    }
}

#[test]
fn size_and_depth_are_bounded() {
    let deep = format!("{}1{}", "(".repeat(80), ")".repeat(80));
    assert_eq!(
        Formula::parse(&deep),
        Err("more than 64 nested parts at column 65 of the formula".to_owned())
    );
    let long = "1+".repeat(600) + "1";
    assert_eq!(
        Formula::parse(&long),
        Err("the formula has 1201 characters; at most 1000 are read".to_owned())
    );
    assert_eq!(value(&("1+".repeat(400) + "1")), 401.0);
}
