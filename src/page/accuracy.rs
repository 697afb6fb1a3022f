//! A search for accuracy: what it found, how exact that is, and what it cost.

use std::fmt::Write;

use serde_json::Value;

use super::words::{number, number_or_dash, table};
use super::{Charts, Figure, Run};
use crate::chart::{Line, Look, Panel, Panels, Scale};
use crate::html::escaped;

/// Costs grow with this power of the unknowns, as the search takes for granted.
const COST: f64 = 1.3;

/// A value that is smaller than this part of the largest of its quantity is held against that.
const OF_LARGEST: f64 = 0.01;

/// How far the line of uniform meshes is drawn beyond the largest mesh.
const BEYOND: f64 = 100.0;

/// A mesh that was solved, with its error as far as the search knows.
#[derive(Debug, Clone, PartialEq)]
struct Mesh {
    purpose: String,
    cells: String,
    grading: String,
    /// Cells all alike, in the shape of those of the first mesh.
    is_uniform: bool,
    steps: u64,
    tolerance: f64,
    unknowns: f64,
    core_seconds: f64,
    /// The largest error of the wanted results, relative.
    error: f64,
}

/// The tables; nothing where no accuracy was asked for.
pub(super) fn tables(html: &mut String, run: &Run<'_>) {
    let Some(found) = searched(run) else { return };
    html.push_str("<h2 id=\"accuracy\">Accuracy</h2>\n");
    let met = if found["met"] == true { "met" } else { "not met" };
    let _ = writeln!(
        html,
        "<p>Asked for {}: {met}; {}. {} meshes took {} core-seconds.</p>",
        number_or_dash(found["asked"].as_f64()),
        escaped(found["why"].as_str().unwrap_or_default()),
        list(&found["meshes"]).len(),
        number_or_dash(found["core_seconds"].as_f64().map(two_digits)),
    );
    let row = |of: &Value| {
        let parts = [&of["parts"]["mesh"], &of["parts"]];
        let [mesh, all] = parts.map(|of| of.as_object().into_iter().flatten());
        let parts: Vec<String> = mesh
            .chain(all.filter(|(name, _)| *name != "mesh"))
            .filter_map(|(name, part)| Some(format!("{name} {:.1e}", part.as_f64()?)))
            .collect();
        let trusted = if of["trusted"] == true { "yes" } else { "no" };
        let short = |key: &str| of[key].as_f64().map_or("–".to_owned(), |x| format!("{x:.1e}"));
        vec![
            of["quantity"].as_str().unwrap_or_default().to_owned(),
            number_or_dash(of["at"].as_f64()),
            number_or_dash(of["value"].as_f64()),
            short("error"),
            short("relative"),
            parts.join(", "),
            trusted.to_owned(),
        ]
    };
    let rows: Vec<Vec<String>> = list(&found["quantities"]).iter().map(row).collect();
    let head = ["quantity", "at", "value", "error", "relative", "parts of it", "trusted"];
    table(html, &head, &rows);
    let rows: Vec<Vec<String>> = meshes(found).iter().map(Mesh::row).collect();
    let (solved, tried) = (rows.len(), list(&found["meshes"]).len());
    let _ = writeln!(html, "<details><summary>{solved} of {tried} meshes were solved</summary>");
    let head =
        ["for", "cells", "grading", "steps", "tolerance", "unknowns", "core-seconds", "error"];
    table(html, &head, &rows);
    html.push_str("</details>\n");
}

/// Error over size and over cost, the chosen mesh marked, beside uniform meshes.
pub(super) fn charts(run: &Run<'_>) -> Charts {
    let mut charts = Charts { figures: Vec::new(), words: Vec::new() };
    let Some(found) = searched(run) else { return charts };
    let meshes: Vec<Mesh> = meshes(found).into_iter().filter(|mesh| mesh.error > 0.0).collect();
    let Some(chosen) = chosen(found).filter(|mesh| mesh.error > 0.0) else { return charts };
    let asked = found["asked"].as_f64().unwrap_or(0.0);
    let uniform = uniform(&meshes, asked, chosen.unknowns);
    let cost = |unknowns: f64| chosen.core_seconds * (unknowns / chosen.unknowns).powf(COST);
    let of_size = |mesh: &Mesh| mesh.unknowns;
    let of_cost = |mesh: &Mesh| mesh.core_seconds;
    let panels = [
        panel(&meshes, &chosen, asked, &of_size, uniform.clone(), "unknowns"),
        panel(
            &meshes,
            &chosen,
            asked,
            &of_cost,
            uniform.iter().map(|(unknowns, error)| (cost(*unknowns), *error)).collect(),
            "core-seconds of the mesh alone",
        ),
    ];
    let mut caption = "The largest relative error of the wanted results: that of the chosen mesh \
                       is the estimate, those of others are held against its result less that."
        .to_owned();
    if !uniform.is_empty() {
        caption += " The line of cells all alike goes on as the first meshes began; its \
                    cost is that of the chosen mesh, with the power 1.3 of the unknowns.";
    }
    charts.figures.push(Figure {
        id: "accuracy-cost".to_owned(),
        panels: Panels {
            title: "Error of the meshes that were tried".to_owned(),
            panels: panels.to_vec(),
            below: true,
        },
        caption,
    });
    charts
}

/// One pair of axes.
fn panel(
    meshes: &[Mesh],
    chosen: &Mesh,
    asked: f64,
    of: &dyn Fn(&Mesh) -> f64,
    uniform: Vec<(f64, f64)>,
    label: &str,
) -> Panel {
    let points = |wanted: &dyn Fn(&&Mesh) -> bool| -> Vec<(f64, f64)> {
        meshes.iter().filter(wanted).map(|mesh| (of(mesh), mesh.error)).collect()
    };
    let is_base = |mesh: &&Mesh| mesh.purpose.starts_with("base");
    let mut lines = vec![
        Line::new("solved for an estimate", points(&|mesh| !is_base(mesh)), Some(1), Look::Points),
        Line::new("held against what was asked", points(&is_base), Some(0), Look::Marked),
        Line::new("chosen", vec![(of(chosen), chosen.error)], Some(2), Look::Points),
    ];
    let shown: Vec<f64> = meshes.iter().map(of).collect();
    let ends = [f64::min, f64::max].map(|end| shown.iter().copied().reduce(end).unwrap_or(1.0));
    if asked > 0.0 {
        let level = ends.map(|x| (x, asked)).to_vec();
        lines.push(Line::new("asked", level, None, Look::Joined));
    }
    if !uniform.is_empty() {
        lines.push(Line::new("cells all alike", uniform, Some(3), Look::Joined));
    }
    lines.retain(|line| !line.points.is_empty());
    let all = || lines.iter().flat_map(|line| &line.points);
    Panel {
        x: Scale::over(all().map(|p| p.0), true),
        y: Scale::over(all().map(|p| p.1), true),
        x_label: label.to_owned(),
        y_label: "relative error".to_owned(),
        lines,
        front: Vec::new(),
    }
}

/// Unknowns and errors of meshes with cells all alike: those that were solved, and what the last
/// two of them promise, down to what was asked. None where these do not promise anything.
fn uniform(meshes: &[Mesh], asked: f64, largest: f64) -> Vec<(f64, f64)> {
    let alike = meshes.iter().filter(|mesh| mesh.is_uniform);
    let mut points: Vec<(f64, f64)> = alike.map(|mesh| (mesh.unknowns, mesh.error)).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points.dedup_by(|a, b| a.0 == b.0);
    let &[.., (u1, e1), (u2, e2)] = &points[..] else { return Vec::new() };
    let slope = (e2 / e1).ln() / (u2 / u1).ln();
    if slope >= 0.0 || !slope.is_finite() {
        return Vec::new();
    }
    let end = if asked > 0.0 && asked < e2 { u2 * (asked / e2).powf(1.0 / slope) } else { u2 };
    let end = end.min(BEYOND * largest.max(u2));
    points.push((end, e2 * (end / u2).powf(slope)));
    points
}

impl Mesh {
    fn row(&self) -> Vec<String> {
        vec![
            self.purpose.clone(),
            self.cells.clone(),
            self.grading.clone(),
            self.steps.to_string(),
            number(self.tolerance),
            number(self.unknowns),
            number(two_digits(self.core_seconds)),
            format!("{:.1e}", self.error),
        ]
    }
}

fn searched<'r>(run: &Run<'r>) -> Option<&'r Value> {
    run.report.get("accuracy").filter(|found| found.is_object())
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn two_digits(value: f64) -> f64 {
    let unit = 10f64.powi(value.abs().max(f64::MIN_POSITIVE).log10().floor() as i32 - 1);
    (value / unit).round() * unit
}

/// The chosen mesh with the error that was estimated.
fn chosen(found: &Value) -> Option<Mesh> {
    let place = found["chosen"].as_u64()? as usize;
    let mesh = list(&found["meshes"]).get(place)?;
    let errors = list(&found["quantities"]).iter().filter_map(|of| of["relative"].as_f64());
    Some(Mesh { error: errors.fold(0.0, f64::max), ..solved(found, mesh)? })
}

/// All that were solved, in their order.
fn meshes(found: &Value) -> Vec<Mesh> {
    list(&found["meshes"]).iter().filter_map(|mesh| solved(found, mesh)).collect()
}

/// A mesh of the report; none where it was not solved.
fn solved(found: &Value, mesh: &Value) -> Option<Mesh> {
    let values: Vec<f64> = list(mesh.get("values")?).iter().filter_map(Value::as_f64).collect();
    let number = |key: &str| mesh[key].as_f64();
    let counts = |mesh: &Value| -> Vec<Vec<u64>> {
        let of_body = |n: &Value| list(n).iter().filter_map(Value::as_u64).collect();
        list(&mesh["cells"]).iter().map(of_body).collect()
    };
    let grading: Vec<f64> = list(&mesh["grading"]).iter().filter_map(Value::as_f64).collect();
    let first = list(&found["meshes"]).first().unwrap_or(mesh);
    let (cells, is_even) = (counts(mesh), grading.iter().all(|ratio| *ratio == 1.0));
    let joined = |n: &Vec<u64>| n.iter().map(u64::to_string).collect::<Vec<_>>().join(" x ");
    let words = match cells.is_empty() {
        true => format!("refine {}", mesh["refine"].as_u64().unwrap_or(0)),
        false => cells.iter().map(joined).collect::<Vec<_>>().join(" + "),
    };
    Some(Mesh {
        purpose: mesh["purpose"].as_str().unwrap_or_default().to_owned(),
        is_uniform: is_even && are_similar(&cells, &counts(first)),
        cells: words,
        grading: grading.iter().map(|r| format!("{r:.0}")).collect::<Vec<_>>().join(" x "),
        steps: mesh["steps"].as_u64().unwrap_or(1),
        tolerance: number("tolerance").unwrap_or(0.0),
        unknowns: number("unknowns").filter(|unknowns| *unknowns > 0.0)?,
        // What no clock has seen is not zero on a logarithmic scale.
        core_seconds: number("core_seconds")?.max(1e-3),
        error: error(found, &values)?,
    })
}

/// Whether all numbers of cells are those of another mesh times one factor, but for the direction
/// across a plane.
fn are_similar(cells: &[Vec<u64>], first: &[Vec<u64>]) -> bool {
    let pairs = cells.iter().flatten().zip(first.iter().flatten());
    let ratios: Vec<f64> = pairs
        .filter(|(own, other)| (**own, **other) != (1, 1))
        .map(|(own, other)| *own as f64 / (*other).max(1) as f64)
        .collect();
    ratios.windows(2).all(|pair| pair[0] == pair[1])
}

/// The largest relative error of the results of a mesh against what the search takes for exact.
fn error(found: &Value, values: &[f64]) -> Option<f64> {
    let wanted = list(&found["quantities"]);
    let exact = |of: &Value| Some(of["value"].as_f64()? - of["error"].as_f64()?);
    let mut largest = 0.0_f64;
    for (of, value) in wanted.iter().zip(values) {
        let own = exact(of)?;
        let alike = wanted.iter().filter(|other| other["quantity"] == of["quantity"]);
        let most = alike.filter_map(exact).fold(0.0_f64, |most, value| most.max(value.abs()));
        let scale = own.abs().max(OF_LARGEST * most);
        if scale > 0.0 {
            largest = largest.max((value - own).abs() / scale);
        }
    }
    (values.len() == wanted.len()).then_some(largest)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// A mesh of `n` x `4 n` cells whose result is 1 + c/n^2, as those of cells of first order.
    fn tried(purpose: &str, n: u64, grading: f64, c: f64) -> Value {
        let value = 1.0 + c / (n * n) as f64;
        json!({"purpose": purpose, "cells": [[n, 1, 2 * n], [n, 1, 2 * n]],
            "grading": [grading, 1.0, 1.0], "refine": 0, "steps": 1, "tolerance": 1e-9,
            "unknowns": 8 * n * n, "core_seconds": 0.01 * n as f64, "values": [value]})
    }

    fn report() -> Value {
        json!({"asked": 1e-3, "met": true, "why": "enough", "core_seconds": 1.25, "chosen": 3,
            "quantities": [{"quantity": "joint.normal_traction.mean", "at": 1.0,
                "value": 1.0004, "error": 0.0004, "relative": 0.0005, "trusted": true,
                "parts": {"mesh": {"x": 0.0004}, "interface": null, "time": null, "solver": 0.0}}],
            "meshes": [tried("start", 2, 1.0, 0.4), tried("all axes with half of the cells", 4, 1.0, 0.4),
                {"purpose": "base", "cells": [], "values": null}, tried("base", 8, 8.0, 0.0256)]})
    }

    #[test]
    fn errors_are_those_against_what_is_taken_for_exact() {
        let found = report();
        let errors: Vec<f64> = meshes(&found).iter().map(|mesh| mesh.error).collect();
        let exact = [0.1, 0.025, 0.0004];
        assert_eq!(errors.len(), 3, "a mesh without a solution has no point");
        assert!(errors.iter().zip(exact).all(|(own, exact)| (own - exact).abs() < 1e-12));
        assert_eq!(chosen(&found).expect("a mesh").error, 0.0005);
    }

    #[test]
    fn cells_all_alike_go_on_as_they_began() {
        let found = report();
        let line = uniform(&meshes(&found), 1e-3, 512.0);
        // An error that falls with the unknowns: a hundredth takes a hundred times as many.
        let (unknowns, error) = *line.last().expect("a line");
        assert!((unknowns / 3200.0 - 1.0).abs() < 1e-9 && (error / 1e-3 - 1.0).abs() < 1e-9);
        assert_eq!(line.len(), 3, "the graded mesh is none of them");
        assert!(uniform(&meshes(&found)[..1], 1e-3, 512.0).is_empty());
    }
}
