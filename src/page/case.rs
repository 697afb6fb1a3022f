//! What was asked, what was modelled, and with what: tables of the case.

use std::fmt::Write;

use serde_json::Value;

use super::Run;
use super::words::{Unit, flat, in_words, number, table};
use crate::html::escaped;

/// Mesh, materials, interfaces, what is prescribed, and how it was solved.
pub(super) fn case(html: &mut String, run: &Run<'_>) {
    html.push_str("<h2>Case</h2>\n<div class=\"text\">\n");
    mesh(html, run);
    materials(html, run);
    interfaces(html, run);
    boundary(html, run);
    solver(html, run);
    left_out(html, run);
    let whole = serde_json::to_string_pretty(&run.report["case"]).unwrap_or_default();
    let _ = write!(
        html,
        "<details><summary>The whole case, defaults written out</summary><pre>{}</pre></details>\n</div>\n",
        escaped(&whole)
    );
}

fn pairs(html: &mut String, heading: &str, rows: Vec<(String, String)>) {
    let _ = writeln!(html, "<h3>{heading}</h3>");
    let rows: Vec<Vec<String>> = rows.into_iter().map(|(name, value)| vec![name, value]).collect();
    table(html, &[], &rows);
}

fn mesh(html: &mut String, run: &Run<'_>) {
    let (case, mesh) = (run.case, &run.case.mesh);
    let shape = if case.dim == 2 { "2D, plane strain" } else { "3D" };
    let mut rows = Vec::new();
    if let Some(column) = mesh.column() {
        let size = column.size.iter().map(|length| number(*length)).collect::<Vec<_>>();
        rows.push(("column".to_owned(), format!("{} m, {shape}", size.join(" × "))));
    } else {
        rows.push(("mesh".to_owned(), format!("of a file, {shape}")));
    }
    rows.push((
        "cells".to_owned(),
        format!("{}{}", in_words(&run.report["cells"]), mesh.order_words()),
    ));
    let given = &run.report["case"]["mesh"];
    for (key, value) in flat(given).into_iter().filter(|(key, _)| key != "column, size") {
        rows.push((format!("given: {key}"), value));
    }
    for sentence in case.formulations() {
        rows.push(("elements".to_owned(), sentence));
    }
    pairs(html, "Mesh", rows);
}

fn materials(html: &mut String, run: &Run<'_>) {
    html.push_str("<h3>Materials</h3>\n");
    let rows: Vec<Vec<String>> = run
        .case
        .materials
        .iter()
        .map(|material| {
            let place = match (material.z, &material.groups[..]) {
                (Some([low, high]), _) => format!("{} to {} m", number(low), number(high)),
                (None, []) => "everywhere".to_owned(),
                (None, groups) => groups.join(", "),
            };
            let porous = material.porous.as_ref().and_then(|p| serde_json::to_value(p).ok());
            vec![
                material.name.clone(),
                place,
                Unit::text("Pa", material.young_modulus),
                number(material.poisson_ratio),
                porous.map_or_else(|| "–".to_owned(), |porous| in_words(&porous)),
            ]
        })
        .collect();
    let place = if run.case.mesh.column().is_some() { "z" } else { "groups" };
    table(html, &["name", place, "Young's modulus", "Poisson's ratio", "porous [SI]"], &rows);
}

fn interfaces(html: &mut String, run: &Run<'_>) {
    if run.case.interfaces.is_empty() {
        return;
    }
    html.push_str("<h3>Interfaces</h3>\n");
    let given = &run.report["case"]["interfaces"];
    let rows: Vec<Vec<String>> = run
        .case
        .interfaces
        .iter()
        .enumerate()
        .map(|(index, interface)| {
            let parameters = given[index]["law"].as_object().and_then(|law| law.values().next());
            let fluid = given[index].get("fluid").filter(|fluid| !fluid.is_null());
            vec![
                interface.name.clone(),
                match interface.height() {
                    Some(z) => format!("{} m", number(z)),
                    None => interface.place(),
                },
                interface.law.name().replace('_', " "),
                parameters.map_or_else(String::new, in_words),
                fluid.map_or_else(|| "–".to_owned(), in_words),
            ]
        })
        .collect();
    let place = if run.case.mesh.column().is_some() { "z" } else { "place" };
    table(html, &["name", place, "law", "parameters [SI]", "fluid [SI]"], &rows);
}

fn boundary(html: &mut String, run: &Run<'_>) {
    let entries: Vec<&Value> =
        run.report["case"]["boundary"].as_array().into_iter().flatten().collect();
    let mut rows = Vec::new();
    for entry in entries {
        let Some(keys) = entry.as_object() else { continue };
        let surface = entry["on"].as_str().unwrap_or_default();
        for (key, value) in keys.iter().filter(|(key, _)| *key != "on") {
            rows.push(vec![surface.to_owned(), key.clone(), in_words(value)]);
        }
    }
    if !rows.is_empty() {
        html.push_str("<h3>Prescribed</h3>\n");
        table(html, &["surface", "what", "value [SI]; tables: time, value"], &rows);
    }
}

fn solver(html: &mut String, run: &Run<'_>) {
    let used = &run.report["linear_solver"];
    let text = |key: &str| used[key].as_str().unwrap_or_default();
    let mut rows = vec![("used".to_owned(), format!("{}: {}", text("choice"), text("why")))];
    for section in ["solver", "control", "initial", "gravity", "body_force", "limits"] {
        let Some(value) = run.report["case"].get(section).filter(|value| !value.is_null()) else {
            continue;
        };
        rows.push((section.replace('_', " "), in_words(value)));
    }
    pairs(html, "Solver", rows);
}

fn left_out(html: &mut String, run: &Run<'_>) {
    let parts: Vec<&Value> =
        run.report["model"]["left_out"].as_array().into_iter().flatten().collect();
    if parts.is_empty() {
        return;
    }
    html.push_str("<h3>Left out of the model</h3>\n<ul>\n");
    for part in parts {
        let text = |key: &str| escaped(part[key].as_str().unwrap_or_default());
        let _ = writeln!(html, "<li>{}: {}</li>", text("what"), text("why"));
    }
    html.push_str("</ul>\n");
}

/// Versions, and how the model was shared out.
pub(super) fn provenance(html: &mut String, run: &Run<'_>) {
    html.push_str("<h2>How it was made</h2>\n<div class=\"text\">\n");
    let mut rows = flat(&run.report["versions"]);
    rows.extend(
        flat(&run.report["partition"])
            .into_iter()
            .map(|(key, value)| (format!("partition, {key}"), value)),
    );
    let rows: Vec<Vec<String>> = rows.into_iter().map(|(key, value)| vec![key, value]).collect();
    table(html, &[], &rows);
    html.push_str("</div>\n");
}
