//! Charts of loads over displacements.

use super::figures::{Axis, COMPUTED, in_pairs, look, numbers, panel};
use super::law_path::Curve;
use super::words::{Unit, column, number, pairs};
use super::{Charts, Run};
use crate::case::{Case, ColumnSpec, Surface, Value};
use crate::chart::{Line, Panel};

/// Reactions below this part of the largest are rounding only.
const ROUNDING: f64 = 1e-9;

/// A displacement that is imposed on a surface along an axis, at the instants.
struct Imposed<'r> {
    surface: &'r Surface,
    axis: usize,
    /// m
    values: Vec<Option<f64>>,
    /// At the start.
    first: f64,
}

/// Reaction over imposed displacement, or load over the displacement of a probe.
pub(super) fn charts(run: &Run<'_>) -> Charts {
    let case = run.case;
    let mut charts = Charts { figures: Vec::new(), words: Vec::new() };
    if run.history.rows.is_empty() {
        return charts;
    }
    let force = if case.dim == 2 { "N/m" } else { "N" };
    let mut panels = Vec::new();
    let largest = largest_reaction(run);
    for imposed in imposed(run) {
        let axis = ["x", "y", "z"][imposed.axis];
        let surface = imposed.surface.name();
        let reaction = column(run.history, &format!("{surface}.reaction_{axis}"));
        let points = pairs(&imposed.values, &reaction.unwrap_or_default());
        if points.iter().all(|point| point.1.abs() <= ROUNDING * largest) {
            continue;
        }
        let from_rest = imposed.first == 0.0 && !case.has_pressure();
        let x = Quantity { words: format!("displacement {axis} of {surface}"), base: "m" };
        let y = Quantity { words: format!("reaction {axis} of {surface}"), base: force };
        panels.push(curve(points, from_rest, x, y));
    }
    let by_displacement = !panels.is_empty();
    if !by_displacement {
        panels = by_probes(run);
    }
    if panels.is_empty() {
        let tractions = case.boundary.iter().flat_map(|entry| entry.traction.iter().flatten());
        let words = if tractions.into_iter().any(changes(case)) {
            "No displacement is imposed that changes, and no probe tells one: name a probe for a curve of \
             load over displacement."
        } else {
            "Neither a displacement nor a traction is imposed that changes: there is no load to draw over \
             a displacement."
        };
        charts.words.push(words.to_owned());
        return charts;
    }
    let section = case.mesh.column().map_or_else(String::new, |column| {
        let unit = if case.dim == 2 { "m wide, and forces are per metre of depth" } else { "m²" };
        format!(" The section is {} {unit}.", number(column.section()))
    });
    charts.words.push(format!(
        "Straight lines join the instants; what happens between them is not recorded.{section}"
    ));
    if by_displacement && case.control.is_some() {
        charts
            .words
            .push("The displacement is what the case prescribes times the load factor.".to_owned());
    }
    charts.figures = in_pairs("load", "Load over displacement", panels);
    charts
}

fn largest_reaction(run: &Run<'_>) -> f64 {
    let columns = run.history.columns.iter().filter(|name| name.contains(".reaction_"));
    let values = columns.filter_map(|name| column(run.history, name)).flatten().flatten();
    values.map(f64::abs).fold(0.0, f64::max)
}

/// A quantity in words, and its unit without prefixes.
struct Quantity {
    words: String,
    base: &'static str,
}

/// A curve through the instants, and `from_rest` through the undeformed state, which the history
/// leaves out.
fn curve(mut points: Curve, from_rest: bool, x: Quantity, y: Quantity) -> Panel {
    if from_rest {
        points.insert(0, (0.0, 0.0));
    }
    let x_unit = Unit::of(x.base, points.iter().map(|p| p.0));
    let y_unit = Unit::of(y.base, points.iter().map(|p| p.1));
    let look = look(points.len(), true);
    let labels = numbers(if from_rest { 0 } else { 1 }, points.len());
    let line = Line { labels, ..Line::new("", points, Some(COMPUTED), look) };
    let x_axis = Axis { words: &x.words, unit: &x_unit };
    panel(vec![line], x_axis, Axis { words: &y.words, unit: &y_unit })
}

/// Whether a value is not the same at all instants, where the loads have a factor or change
/// themselves.
fn changes(case: &Case) -> impl Fn(&Value) -> bool + '_ {
    let middle = lengths(case).map(|length| 0.5 * length);
    move |value| {
        let mut values = case.time.iter().map(|time| value.at(middle, *time));
        let first = value.at(middle, case.start);
        case.control.is_some() && !value.is_zero() || values.any(|value| value != first)
    }
}

/// The loads at each row: their time, and what they are multiplied by.
fn loads(run: &Run<'_>) -> Vec<Option<(f64, f64)>> {
    let times = column(run.history, "time").unwrap_or_default();
    let factors = column(run.history, "load_factor").unwrap_or_default();
    let of = |time: f64| run.case.control.as_ref().map_or(time, |control| control.load_time(time));
    times.iter().zip(&factors).map(|(time, factor)| Some((of((*time)?), (*factor)?))).collect()
}

/// The displacements that change, each once, in the middle of their surfaces.
fn imposed<'r>(run: &Run<'r>) -> Vec<Imposed<'r>> {
    let case = run.case;
    let loads = loads(run);
    let mut found: Vec<Imposed<'r>> = Vec::new();
    for entry in &case.boundary {
        // The load axis first.
        for axis in [2, 0, 1] {
            let Some(value) = &entry.displacement[axis] else { continue };
            let taken = found.iter().any(|i| *i.surface == entry.on && i.axis == axis);
            let point = middle(case, &entry.on);
            let at = |(time, factor): (f64, f64)| factor * value.at(point, time);
            let values: Vec<Option<f64>> =
                loads.iter().map(|load| load.map(at).filter(|value| value.is_finite())).collect();
            let first = at_start(case, value, point);
            let moves = values.iter().flatten().any(|value| *value != first);
            if moves && !taken {
                found.push(Imposed { surface: &entry.on, axis, values, first });
            }
        }
    }
    found
}

/// What a value is before the first step: nothing under a load factor, which starts from 0.
fn at_start(case: &Case, value: &Value, point: [f64; 3]) -> f64 {
    if case.control.is_some() { 0.0 } else { value.at(point, case.start) }
}

/// Lengths of the column along x, y, z (m); 0 where the mesh comes from a file.
fn lengths(case: &Case) -> [f64; 3] {
    case.mesh.column().map_or([0.0; 3], ColumnSpec::lengths)
}

/// The middle of a surface of a column; the origin for a group of a file.
fn middle(case: &Case, surface: &Surface) -> [f64; 3] {
    let mut point = lengths(case).map(|length| 0.5 * length);
    if let Some((axis, far)) = surface.axis() {
        point[axis] = if far { lengths(case)[axis] } else { 0.0 };
    }
    point
}

/// Tractions that change over the displacement of the first probe along them.
fn by_probes(run: &Run<'_>) -> Vec<Panel> {
    let case = run.case;
    let loads = loads(run);
    let mut panels = Vec::new();
    let Some(probe) = case.probes.first() else { return panels };
    for entry in &case.boundary {
        for axis in [2, 0, 1] {
            let Some(value) = entry.traction[axis].as_ref().filter(|v| changes(case)(v)) else {
                continue;
            };
            let name = ["x", "y", "z"][axis];
            let point = middle(case, &entry.on);
            let tractions: Vec<Option<f64>> =
                loads.iter().map(|load| load.map(|(time, f)| f * value.at(point, time))).collect();
            let moved = column(run.history, &format!("{}.displacement_{name}", probe.name));
            let words = format!("displacement {name} of {}", probe.name);
            let x = Quantity { words, base: "m" };
            let words = format!("traction {name} on {}", entry.on.name());
            let y = Quantity { words, base: "Pa" };
            let points = pairs(&moved.unwrap_or_default(), &tractions);
            let from_rest = at_start(case, value, point) == 0.0 && !case.has_pressure();
            panels.push(curve(points, from_rest, x, y));
        }
    }
    panels
}
