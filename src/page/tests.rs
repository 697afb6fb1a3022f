use std::path::Path;

use serde_json::json;

use super::*;

const CASE: &str = "\
title: Bricks & <mortar>
mesh: {column: {size: [1, 5], cells: [1, 4]}}
materials: {rock: {elastic: {young_modulus: 5.8e9, poisson_ratio: 0}}}
interfaces:
  - {name: joint, z: 2.5, law: {linear_softening: {strength: 1.1e6, fracture_energy: 900}}}
boundary:
  - {on: bottom, displacement: {x: 0, z: 0}}
  - {on: top, displacement: {x: 0, z: {table: [[0, 0], [1, 1.0e-3]]}}}
time: {instants: [0.5, 1]}
expect: [{quantity: joint.damage, at: 1, equals: 0, absolute: 1}]
";

fn case() -> Case {
    Case::read(CASE, Path::new("case.yaml"), &[]).expect("a case")
}

/// The page of a report with rows of a history, the columns of which are those of the case.
fn page_of(report: &Value, rows: usize) -> String {
    let case = case();
    let columns = case.columns();
    let row = |i: usize| vec![Some(0.5 * (i + 1) as f64); columns.len()];
    let history = Table { rows: (0..rows).map(row).collect(), columns };
    let warnings = ["an option was not used".to_owned()];
    page(&Run { report, history: &history, case: &case, directory: None, warnings: &warnings })
        .expect("a page")
}

#[test]
fn text_is_text_and_nothing_is_fetched() {
    let html = page_of(&json!({"status": "failed", "message": "<b>no</b> convergence"}), 2);
    for words in [
        "<h1>Bricks &amp; &lt;mortar&gt;</h1>",
        "failed after 2 of 2 instants",
        "&lt;b&gt;no&lt;/b&gt; convergence",
        "an option was not used",
        "Not compared: the run did not come to its end.",
        "script-src 'none'",
    ] {
        assert!(html.contains(words), "{words}");
    }
    for words in ["<script", "http:", "https:", "src=", "href=", "@import", "url("] {
        assert!(!html.contains(words), "{words}");
    }
    assert!(html.ends_with("</html>\n"));
}

#[test]
fn a_page_needs_neither_rows_nor_keys() {
    for report in [json!({}), json!({"expectations": [], "instants": null, "timings": 3})] {
        let html = page_of(&report, 0);
        assert!(html.contains("No instant was reached") && !html.contains("<svg"), "{html}");
        assert!(!html.contains("id=\"reduction\""));
    }
}

#[test]
fn a_reduction_is_told_whatever_is_in_it() {
    let reduction = json!({
        "applied": true,
        "bound": {"relative_error": 1.25e-7},
        "left_out": [{"what": "sliding", "why": "symmetry"}, {"what": "y", "why": "<plane>"}],
    });
    let html = page_of(&json!({"reduction": reduction}), 1);
    for row in [
        "<tr><td>applied</td><td>yes</td></tr>",
        "<tr><td>bound, relative error</td><td>1.25e-7</td></tr>",
        "<tr><td>left out 1, why</td><td>symmetry</td></tr>",
        "<tr><td>left out 2, why</td><td>&lt;plane&gt;</td></tr>",
    ] {
        assert!(html.contains(row), "{row}");
    }
    let html = page_of(&json!({"reduction": {"applied": false, "reason": "too few cells"}}), 1);
    assert!(html.contains("<td>too few cells</td>"));
}

#[test]
fn numbers_that_are_none_are_left_out_of_charts() {
    let case = case();
    let columns = case.columns();
    let broken = vec![Some(f64::NAN); columns.len()];
    let whole = vec![Some(0.5); columns.len()];
    let history = Table { rows: vec![broken, vec![None; columns.len()], whole], columns };
    let run =
        Run { report: &json!({}), history: &history, case: &case, directory: None, warnings: &[] };
    let html = page(&run).expect("a page");
    assert!(html.contains("<svg") && !html.contains("NaN"), "{html}");
}
