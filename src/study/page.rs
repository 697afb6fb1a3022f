//! `study.html`: one page that needs nothing else, not even a network.

use std::fmt::Write;

use super::draw::Drawn;
use super::measure::Row;
use super::plan::Plan;
use super::spec::Study;
use super::table::{machine, measures};
use crate::html::{escaped, inlined};
use crate::report::versions;

const STYLE: &str = "body{font-family:sans-serif;max-width:72rem;margin:2rem auto;padding:0 1rem;\
line-height:1.45;color:#1e1e1e;background:#fff}figure{margin:1.5rem 0}figure svg{max-width:100%;height:auto}\
figcaption{max-width:44rem}.scroll{overflow-x:auto}table{border-collapse:collapse;font-size:.85rem}\
th,td{border:1px solid #bbb;padding:.25rem .5rem;text-align:right;white-space:nowrap}\
td:first-child,th:first-child{text-align:left}tr.failed{background:#fbe3d8}tr.front td:first-child{font-weight:bold}\
pre{background:#f4f4f4;padding:.75rem;overflow-x:auto;font-size:.85rem}";

/// The page; `charts` in the order of the study's.
pub(super) fn page(study: &Study, plan: &Plan, rows: &[Row], charts: &[Drawn]) -> String {
    let mut html = String::new();
    let title = escaped(&study.title);
    // Writing to a string cannot fail.
    let _ = write!(
        html,
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n<title>{title}</title>\n\
         <style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n"
    );
    let done = rows.iter().filter(|row| row.has_results()).count();
    let missing = rows.iter().filter(|row| row.status.is_none()).count();
    let failed = rows.len() - done - missing;
    let _ = writeln!(
        html,
        "<p>{} runs: {done} came to their end, {failed} failed, {missing} not run.</p>",
        rows.len()
    );
    for (chart, drawn) in study.charts.iter().zip(charts) {
        let words = escaped(&format!("{}: {} over {}", chart.title, chart.y_label, chart.x_label));
        let svg = inlined(&drawn.svg);
        let _ = write!(html, "<figure role=\"img\" aria-label=\"{words}\">\n{svg}\n<figcaption>");
        for sentence in chart.note.iter().chain(&drawn.remarks) {
            let _ = write!(html, "{} ", escaped(sentence));
        }
        html.push_str("</figcaption>\n</figure>\n");
    }
    let front: Vec<usize> = charts.iter().flat_map(|drawn| drawn.front.clone()).collect();
    failures(&mut html, plan, rows);
    table(&mut html, study, plan, rows, &front);
    let _ = write!(
        html,
        "<h2>How it was made</h2>\n<details><summary>The study file</summary><pre>{}</pre></details>\n\
         <details><summary>The base case</summary><pre>{}</pre></details>\n<ul>\n",
        escaped(&study.text),
        escaped(&study.base_text)
    );
    for (name, version) in versions() {
        let _ = writeln!(html, "<li>{}: {}</li>", escaped(&name), escaped(&version));
    }
    if let Some(machine) = machine().as_object() {
        for (name, value) in machine {
            let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
            let _ = writeln!(html, "<li>{}: {}</li>", name.replace('_', " "), escaped(&text));
        }
    }
    html.push_str("</ul>\n</body>\n</html>\n");
    html
}

fn failures(html: &mut String, plan: &Plan, rows: &[Row]) {
    let failed =
        |row: &&Row| row.status.is_some_and(|s| !s.has_results()) || !row.message.is_empty();
    if !rows.iter().any(|row| failed(&row)) {
        return;
    }
    html.push_str("<h2>What failed, and why</h2>\n<dl>\n");
    for row in rows.iter().filter(failed) {
        let status = row.status.map_or("", |status| status.words());
        let name = escaped(&plan.runs[row.run].name);
        let message = escaped(&row.message).replace('\n', "<br>");
        let _ = writeln!(html, "<dt>{name}: {status}</dt>\n<dd>{message}</dd>");
    }
    html.push_str("</dl>\n");
}

fn table(html: &mut String, study: &Study, plan: &Plan, rows: &[Row], front: &[usize]) {
    let names = measures(study);
    html.push_str("<h2>All runs</h2>\n");
    if !front.is_empty() {
        html.push_str("<p>★: on a Pareto front, no other run is both cheaper and better.</p>\n");
    }
    html.push_str("<div class=\"scroll\"><table>\n<tr><th>run</th><th>ranks</th><th>status</th>");
    for name in &names {
        let _ = write!(html, "<th>{}</th>", escaped(&study.label_of(name)));
    }
    html.push_str("</tr>\n");
    for row in rows {
        let run = &plan.runs[row.run];
        let on = front.contains(&row.run);
        let class = match (on, row.has_results()) {
            (true, _) => " class=\"front\"",
            (false, false) => " class=\"failed\"",
            _ => "",
        };
        let star = if on { " ★" } else { "" };
        let status = row.status.map_or("not run", |status| status.words());
        let name = if run.name.is_empty() { "the base case" } else { &run.name };
        let name = escaped(name);
        let _ =
            write!(html, "<tr{class}><td>{name}{star}</td><td>{}</td><td>{status}</td>", run.ranks);
        for name in &names {
            let text = row.value(name).map_or_else(String::new, short);
            let _ = write!(html, "<td>{text}</td>");
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</table></div>\n");
}

/// Three digits, or a whole number.
fn short(value: f64) -> String {
    if value == value.trunc() && value.abs() < 1e15 {
        return format!("{value}");
    }
    match value.abs() {
        size if !(1e-3..1e6).contains(&size) => format!("{value:.2e}"),
        size => {
            let digits = (2 - size.log10().floor() as i32).clamp(0, 6) as usize;
            format!("{value:.digits$}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in
            [(2560.0, "2560"), (0.0, "0"), (1.23456, "1.23"), (123.456, "123"), (4.2e-5, "4.20e-5")]
        {
            assert_eq!(short(value), text);
        }
    }
}
