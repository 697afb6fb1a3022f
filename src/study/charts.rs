//! The charts that a study asks for, checked.

use super::check::Checker;
use super::file::{ChartSection, Kind};
use super::spec::{BUILT_IN, Chart, Quantity, Study, is_log};
use crate::input::problems::suggestion;

/// Longest name of a chart, which becomes that of its files.
const LONGEST_NAME: usize = 60;

/// A chart as it is to be drawn; none, and a mistake told, where it cannot be.
pub(super) fn chart_of(
    checker: &mut Checker<'_>,
    study: &Study,
    index: usize,
    section: ChartSection,
) -> Option<Chart> {
    let index = index.to_string();
    let at = |name: &'static str| ["charts", index.as_str(), name];
    let name = &section.name;
    check_name(checker, study, &index, name);
    let (x, y) = match section.kind {
        Kind::Lines | Kind::Map => (section.x.clone(), section.y.clone()),
        Kind::StrongScaling | Kind::WeakScaling => {
            let y = section.y.clone().unwrap_or_else(|| "wall_seconds".to_owned());
            (Some("ranks".to_owned()), Some(y))
        }
    };
    let mut quantity = |axis: &'static str, name: Option<String>| {
        let Some(name) = name else {
            checker.add(&["charts", &index], format!("charts.{index}.{axis} is missing"));
            return None;
        };
        let only_axes = section.kind == Kind::Map;
        let found = quantity_of(study, &name, only_axes);
        if found.is_none() {
            let known = known_of(study, only_axes);
            let hint = suggestion(&name, &known);
            let what = format!("charts.{index}.{axis} cannot be `{name}`{hint}");
            checker.add(&at(axis), what);
        }
        found
    };
    let (x, y) = (quantity("x", x), quantity("y", y));
    let series: Vec<usize> = section
        .series
        .iter()
        .filter_map(|name| checker.axis_named(&study.axes, &at("series"), name))
        .collect();
    let filter = checker.place(&study.axes, &at("where"), &section.filter);
    let (x, y) = (x?, y?);
    Some(Chart {
        title: section.title.unwrap_or_else(|| name.replace('_', " ")),
        x_label: section.x_label.unwrap_or_else(|| study.label(&x)),
        y_label: section.y_label.unwrap_or_else(|| study.label(&y)),
        name: section.name,
        kind: section.kind,
        note: section.note,
        x,
        y,
        series,
        filter,
        log: [is_log(section.x_scale), is_log(section.y_scale)],
        pareto: section.pareto,
        fit: section.fit,
    })
}

/// Refuses a name of a chart that files cannot have, or another chart has.
fn check_name(checker: &mut Checker<'_>, study: &Study, index: &str, name: &str) {
    let steps = ["charts", index, "name"];
    let sound = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if name.is_empty() || name.len() > LONGEST_NAME || !name.chars().all(sound) {
        let what = format!("charts.{index}.name must be of letters, digits, _ and -, got `{name}`");
        checker.add(&steps, what);
    }
    if study.charts.iter().any(|chart| chart.name == name) {
        checker.add(&steps, format!("charts.{index}.name: `{name}` is taken"));
    }
}

fn quantity_of(study: &Study, name: &str, only_axes: bool) -> Option<Quantity> {
    if let Some(axis) = study.axes.iter().position(|axis| axis.name == name) {
        return Some(Quantity::Axis(axis));
    }
    known_of(study, only_axes)
        .contains(&name.to_owned())
        .then(|| Quantity::Measure(name.to_owned()))
}

fn known_of(study: &Study, only_axes: bool) -> Vec<String> {
    let mut known: Vec<String> = study.axes.iter().map(|axis| axis.name.clone()).collect();
    if !only_axes {
        known.push("ranks".to_owned());
        known.extend(BUILT_IN.iter().map(|(name, ..)| (*name).to_owned()));
        known.extend(study.measures.iter().map(|measure| measure.name.clone()));
        known.dedup();
    }
    known
}
