//! How a run ended, what it met, and what it took, in words and tables.

use std::fmt::Write;

use serde_json::Value;

use super::Run;
use super::over_time::time_label;
use super::words::{flat, number, number_or_dash, table};
use crate::html::escaped;

/// Rows of a table that is shown at once.
const SHOWN: usize = 12;

fn text<'v>(value: &'v Value, key: &str) -> &'v str {
    value[key].as_str().unwrap_or_default()
}

/// Words of a list.
fn sentences(value: &Value) -> Vec<String> {
    let list = value.as_array().into_iter().flatten();
    list.filter_map(Value::as_str).map(str::to_owned).collect()
}

/// Status, message, the numbers of the model.
pub(super) fn summary(html: &mut String, run: &Run<'_>) {
    let report = run.report;
    let outcomes = report["expectations"].as_array().map_or(0, Vec::len);
    let missed = missed(run).len();
    // With stresses at the start there is a row of it.
    let is_instant = |row: &&Vec<Option<f64>>| row.first() != Some(&Some(run.case.start));
    let reached = run.history.rows.iter().filter(is_instant).count();
    let of = run.case.time.len();
    let (class, words) = match text(report, "status") {
        "done" if outcomes == 1 => ("good", "done, the one expectation met".to_owned()),
        "done" if outcomes > 0 => ("good", format!("done, all {outcomes} expectations met")),
        "done" => ("good", "done".to_owned()),
        "accuracy_missed" => ("bad", "less exact than asked".to_owned()),
        "expectation_missed" => ("bad", format!("{missed} of {outcomes} expectations missed")),
        "failed" => ("bad", format!("failed after {reached} of {of} instants")),
        "stopped" => ("wait", format!("stopped after {reached} of {of} instants")),
        other => ("wait", other.to_owned()),
    };
    let _ = writeln!(html, "<p class=\"status {class}\">{}</p>", escaped(&words));
    if let Some(message) = report["message"].as_str() {
        let _ = writeln!(html, "<div class=\"message {class}\">{}</div>", escaped(message));
    }
    let whole = |key: &str| report[key].as_u64().map_or_else(|| "–".to_owned(), grouped);
    let seconds = report["timings"]["total"].as_f64();
    let memory = report["peak_memory_bytes"].as_f64();
    let solver = &report["linear_solver"];
    let facts = [
        ("unknowns", whole("unknowns")),
        ("cells", whole("cells")),
        ("ranks", whole("ranks")),
        ("instants", format!("{reached} of {of}")),
        ("corrections", whole("newton_iterations")),
        ("linear iterations", whole("linear_iterations")),
        ("wall-clock time", seconds.map_or_else(|| "–".to_owned(), duration)),
        ("peak memory of all ranks", memory.map_or_else(|| "–".to_owned(), bytes)),
        ("physics", text(&report["model"], "physics").replace('_', "-")),
        ("linear solver", format!("{}: {}", text(solver, "choice"), text(solver, "why"))),
    ];
    html.push_str("<dl class=\"facts\">\n");
    for (name, value) in facts {
        let _ = writeln!(html, "<div><dt>{name}</dt><dd>{}</dd></div>", escaped(&value));
    }
    html.push_str("</dl>\n");
    reduction(html, report);
}

/// What a reduction of the model says of itself, whatever it says.
fn reduction(html: &mut String, report: &Value) {
    let Some(found) = report.get("reduction").filter(|found| !found.is_null()) else { return };
    html.push_str("<h2 id=\"reduction\">Reduction of the model</h2>\n<div class=\"text\">\n");
    let rows: Vec<Vec<String>> = flat(found).into_iter().map(|(k, v)| vec![k, v]).collect();
    table(html, &[], &rows);
    html.push_str("</div>\n");
}

/// What the run warned of.
pub(super) fn warnings(html: &mut String, run: &Run<'_>) {
    let lists = ["instabilities", "bifurcations", "remarks"].map(|key| sentences(&run.report[key]));
    let all: Vec<&String> = lists.iter().flatten().chain(run.warnings).collect();
    if all.is_empty() {
        return;
    }
    html.push_str("<h2>Warnings</h2>\n");
    let list = |html: &mut String, sentences: &[&String]| {
        html.push_str("<ul class=\"warnings\">\n");
        for sentence in sentences {
            let _ = writeln!(html, "<li>{}</li>", escaped(sentence));
        }
        html.push_str("</ul>\n");
    };
    // A run through many instants may say the same of each.
    let (first, rest) = all.split_at(if all.len() > SHOWN { SHOWN / 2 } else { all.len() });
    list(html, first);
    if !rest.is_empty() {
        let _ = writeln!(html, "<details><summary>{} more</summary>", rest.len());
        list(html, rest);
        html.push_str("</details>\n");
    }
}

fn missed<'r>(run: &'r Run<'_>) -> Vec<&'r Value> {
    let outcomes = run.report["expectations"].as_array().into_iter().flatten();
    outcomes.filter(|outcome| outcome["met"] == false).collect()
}

/// Expected and found values, those that differ first.
pub(super) fn expectations(html: &mut String, run: &Run<'_>) {
    let all = run.report["expectations"].as_array().map_or(&[][..], Vec::as_slice);
    if all.is_empty() && run.case.expect.is_empty() {
        return;
    }
    html.push_str("<h2>Expectations</h2>\n");
    if all.is_empty() {
        html.push_str("<p>Not compared: the run did not come to its end.</p>\n");
        return;
    }
    let missed = missed(run).len();
    let words = match missed {
        0 => format!("all {} are met", all.len()),
        _ => format!("{missed} of {} are missed", all.len()),
    };
    let open = if missed > 0 || all.len() <= SHOWN { " open" } else { "" };
    let _ = writeln!(html, "<details{open}><summary>{words}</summary>");
    html.push_str(
        "<div class=\"scroll\"><table id=\"expectations\">\n<tr><th>quantity</th><th>at</th><th>expected</th>\
         <th>computed</th><th>error</th><th>tolerance</th><th></th></tr>\n",
    );
    let mut sorted: Vec<&Value> = all.iter().collect();
    sorted.sort_by_key(|outcome| outcome["met"] != false);
    for outcome in sorted {
        let met = outcome["met"] != false;
        let (class, verdict) = if met { ("", "met") } else { (" class=\"missed\"", "missed") };
        let value = |key: &str| number_or_dash(outcome[key].as_f64());
        let cells = [
            text(outcome, "quantity").to_owned(),
            value("at"),
            value("equals"),
            value("value"),
            short(outcome["error"].as_f64()),
            short(outcome["tolerance"].as_f64()),
            match outcome["note"].as_str() {
                Some(note) => format!("{verdict}: {note}"),
                None => verdict.to_owned(),
            },
        ];
        let cells = cells.map(|cell| format!("<td>{}</td>", escaped(&cell)));
        let _ = writeln!(html, "<tr{class}>{}</tr>", cells.concat());
    }
    html.push_str("</table></div></details>\n");
}

/// Two digits, which is all that errors are good for.
fn short(value: Option<f64>) -> String {
    match value {
        None => "–".to_owned(),
        Some(0.0) => "0".to_owned(),
        Some(value) => format!("{value:.1e}"),
    }
}

/// One row for each instant.
pub(super) fn instants(html: &mut String, run: &Run<'_>) {
    let all: Vec<&Value> = run.report["instants"].as_array().into_iter().flatten().collect();
    if all.is_empty() {
        return;
    }
    let interfaces = &run.case.interfaces;
    let few = &interfaces[..interfaces.len().min(4)];
    let open = if all.len() <= SHOWN { " open" } else { "" };
    let _ = writeln!(html, "<details{open}><summary>{} instants</summary>", all.len());
    let mut head =
        vec![time_label(run).to_owned(), "corrections".into(), "linear iterations".into()];
    for interface in few {
        let name = &interface.name;
        head.extend(
            ["mean traction [Pa]", "mean jump [m]", "damage"].map(|of| format!("{name}: {of}")),
        );
    }
    let rows: Vec<Vec<String>> = all
        .iter()
        .map(|instant| {
            let value = |key: &str| number_or_dash(instant[key].as_f64());
            let mut row =
                vec![value("time"), value("newton_iterations"), value("linear_iterations")];
            for interface in few {
                let state = &instant["interfaces"][interface.name.as_str()];
                let keys = ["normal_traction_mean", "normal_jump_mean", "damage_max"];
                row.extend(keys.map(|key| number_or_dash(state[key].as_f64())));
            }
            row
        })
        .collect();
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    table(html, &head, &rows);
    html.push_str("</details>\n");
}

/// Seconds by phase of the slowest rank.
pub(super) fn times(html: &mut String, run: &Run<'_>) {
    let Some(phases) = run.report["timings"].as_object() else { return };
    let seconds = |name: &str| phases.get(name).and_then(Value::as_f64).unwrap_or(0.0);
    let total = seconds("total");
    // In the order of a run.
    let known = ["mesh", "partition", "assembly", "solve", "output"];
    let further = phases.keys().map(String::as_str).filter(|n| *n != "total" && !known.contains(n));
    let mut rows: Vec<(&str, f64)> =
        known.into_iter().chain(further).map(|name| (name, seconds(name))).collect();
    let rest = total - rows.iter().map(|(_, s)| s).sum::<f64>();
    rows.push(("other, start-up included", rest.max(0.0)));
    html.push_str("<h2>Time by phase</h2>\n<div class=\"bars\" id=\"times\">\n");
    for (name, seconds) in rows {
        let share = if total > 0.0 { (100.0 * seconds / total).clamp(0.0, 100.0) } else { 0.0 };
        let _ = writeln!(
            html,
            "<span>{}</span><div><i style=\"width:{share:.1}%\"></i></div><span>{}, {share:.0} %</span>",
            escaped(name),
            duration(seconds)
        );
    }
    let _ = writeln!(html, "<b>total</b><div></div><b>{}</b>\n</div>", duration(total));
    html.push_str("<p>Of the slowest rank in each phase; of this run alone where it went on from another.</p>\n");
}

/// `12 345 678`.
fn grouped(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) && digits.len() > 4 {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

/// `3.2 ms`, `12 s`, `1 h 02 min`.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 0.001 => "< 1 ms".to_owned(),
        s if s < 1.0 => format!("{:.0} ms", s * 1e3),
        s if s < 100.0 => format!("{} s", number((s * 100.0).round() / 100.0)),
        s if s < 3600.0 => format!("{:.0} min {:02.0} s", (s / 60.0).floor(), (s % 60.0).floor()),
        s => format!("{:.0} h {:02.0} min", (s / 3600.0).floor(), (s % 3600.0 / 60.0).floor()),
    }
}

fn bytes(bytes: f64) -> String {
    if bytes < 1e9 { format!("{:.0} MB", bytes / 1e6) } else { format!("{:.1} GB", bytes / 1e9) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped_and_times_handy() {
        assert_eq!(grouped(1234), "1234");
        assert_eq!(grouped(1_234_567), "1\u{202f}234\u{202f}567");
        assert_eq!(duration(0.0124), "12 ms");
        assert_eq!(duration(12.345), "12.35 s");
        assert_eq!(duration(125.0), "2 min 05 s");
        assert_eq!(duration(3725.0), "1 h 02 min");
        assert_eq!(bytes(59_883_520.0), "60 MB");
    }
}
