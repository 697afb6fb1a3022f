//! `report.html`: one page of a run, which needs nothing else, not even a network.

mod accuracy;
mod case;
mod figures;
mod interfaces;
mod law_path;
mod loads;
mod outcome;
mod over_time;
mod scene;
mod words;

use std::fmt::Write;

use serde_json::Value;

use crate::case::Case;
use crate::chart::{Panels, svg};
use crate::error::Result;
use crate::html::{escaped, inlined};
use crate::output::history::Table;
use crate::results::Directory;
use crate::scene::dark_rules;

/// What a page is made of.
#[derive(Debug, Clone, Copy)]
pub struct Run<'a> {
    /// The content of `report.json`.
    pub report: &'a Value,
    /// All rows of the history.
    pub history: &'a Table,
    /// The case.
    pub case: &'a Case,
    /// The results on disk, from whose fields the scene is drawn; none where there are none.
    pub directory: Option<&'a Directory>,
    /// What the screen was warned of and the report does not hold.
    pub warnings: &'a [String],
}

/// Nothing is fetched and no script runs, whatever the page may come to hold; its own style does.
const POLICY: &str = "<meta http-equiv=\"Content-Security-Policy\" content=\"script-src 'none'; \
     connect-src 'none'; img-src 'none'; font-src 'none'; media-src 'none'; object-src 'none'; \
     frame-src 'none'; worker-src 'none'; manifest-src 'none'; form-action 'none'; base-uri 'none'\">";

const STYLE: &str = include_str!("style.css");

/// A chart with its place on the page.
struct Figure {
    /// Its name in the page.
    id: String,
    panels: Panels,
    caption: String,
}

/// The page.
///
/// # Errors
/// `Bug` when a chart cannot be drawn.
///
/// # Parallel
/// Local; rank 0 does it.
pub fn page(run: &Run<'_>) -> Result<String> {
    let mut html = String::new();
    let title = escaped(&run.case.title);
    // Writing to a string cannot fail.
    let _ = write!(
        html,
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n{POLICY}\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{title}</title>\n\
         <style>\n{}</style>\n</head>\n<body>\n<h1>{title}</h1>\n",
        style()
    );
    outcome::summary(&mut html, run);
    outcome::warnings(&mut html, run);
    outcome::expectations(&mut html, run);
    accuracy::tables(&mut html, run);
    drawn(&mut html, &accuracy::charts(run))?;
    let pictures = scene::drawn(run);
    scene::bodies(&mut html, &pictures)?;
    section(&mut html, "Interfaces", &interfaces::charts(run))?;
    scene::interfaces(&mut html, &pictures)?;
    section(&mut html, "Load and displacement", &loads::charts(run))?;
    section(&mut html, "Over time", &over_time::charts(run))?;
    section(&mut html, "Convergence", &over_time::convergence(run))?;
    outcome::instants(&mut html, run);
    outcome::times(&mut html, run);
    case::case(&mut html, run);
    case::provenance(&mut html, run);
    html.push_str("</body>\n</html>\n");
    Ok(html)
}

/// The style, with the colours of the scene in the dark.
fn style() -> String {
    STYLE.replacen("/* scene */", &dark_rules(), 1)
}

/// Charts, or the words that stand for them.
struct Charts {
    figures: Vec<Figure>,
    /// What is to be said of all of them, or in place of them.
    words: Vec<String>,
}

/// Nothing where there is nothing to show or to say.
fn section(html: &mut String, heading: &str, charts: &Charts) -> Result<()> {
    if charts.figures.is_empty() && charts.words.is_empty() {
        return Ok(());
    }
    let _ = writeln!(html, "<h2>{heading}</h2>");
    for sentence in &charts.words {
        let _ = writeln!(html, "<p>{}</p>", escaped(sentence));
    }
    drawn(html, charts)
}

/// The charts without a heading.
fn drawn(html: &mut String, charts: &Charts) -> Result<()> {
    if charts.figures.is_empty() {
        return Ok(());
    }
    html.push_str("<div class=\"charts\">\n");
    for figure in &charts.figures {
        let wide = if figure.panels.panels.len() > 1 { " class=\"wide\"" } else { "" };
        let chart = svg(&figure.panels)?;
        let _ = write!(
            html,
            "<figure id=\"{}\"{wide}>\n<div class=\"chart\" role=\"img\" aria-label=\"{}\">{}</div>\n",
            escaped(&figure.id),
            escaped(&described(&figure.panels)),
            inlined(&chart).trim_end()
        );
        if !figure.caption.is_empty() {
            let _ = writeln!(html, "<figcaption>{}</figcaption>", escaped(&figure.caption));
        }
        html.push_str("</figure>\n");
    }
    html.push_str("</div>\n");
    Ok(())
}

/// A chart for who cannot see it.
fn described(panels: &Panels) -> String {
    let axes = panels.panels.iter().map(|p| format!("{} over {}", p.y_label, p.x_label));
    format!("{}: {}", panels.title, axes.collect::<Vec<_>>().join("; "))
}

#[cfg(test)]
mod tests;
