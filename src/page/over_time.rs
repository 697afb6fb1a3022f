//! Charts over time, and of what it took to get there.

use super::figures::look;
use super::words::{Unit, column, pairs};
use super::{Charts, Figure, Run};
use crate::case::{Case, ControlKind, InterfaceSpec};
use crate::chart::{Line, Look, Panel, Panels, Scale};

/// Lines of one chart that can be told apart.
const MOST_LINES: usize = 12;

/// A chart of several columns over time.
struct Chart {
    id: &'static str,
    title: &'static str,
    label: &'static str,
    unit: &'static str,
    /// Names of the lines, and their columns.
    lines: Vec<(String, String)>,
}

/// What is recorded, over the instants.
pub(super) fn charts(run: &Run<'_>) -> Charts {
    let mut charts = Charts { figures: Vec::new(), words: Vec::new() };
    let Some(times) = column(run.history, "time").filter(|times| !times.is_empty()) else {
        return charts;
    };
    for chart in wanted(run) {
        let shown = chart.lines.len().min(MOST_LINES);
        let lines: Vec<(String, Vec<(f64, f64)>)> = chart.lines[..shown]
            .iter()
            .filter_map(|(name, of)| Some((name.clone(), pairs(&times, &column(run.history, of)?))))
            .filter(|(_, points)| !points.is_empty())
            .collect();
        let is_zero = lines.iter().flat_map(|(_, points)| points).all(|(_, y)| *y == 0.0);
        if lines.is_empty() || is_zero {
            continue;
        }
        let caption = if shown < chart.lines.len() {
            format!("The first {shown} of {}; all are in history.csv.", chart.lines.len())
        } else {
            String::new()
        };
        let numbers = lines.iter().flat_map(|(_, points)| points).map(|p| p.1);
        let unit = Unit::of(chart.unit, numbers);
        let single = lines.len() == 1 && chart.lines.len() == 1;
        let lines: Vec<Line> = lines
            .into_iter()
            .enumerate()
            .map(|(style, (name, points))| {
                let points: Vec<_> = points.iter().map(|(t, y)| (*t, unit.number(*y))).collect();
                let look = look(points.len(), true);
                Line::new(if single { "" } else { &name }, points, Some(style), look)
            })
            .collect();
        let points = || lines.iter().flat_map(|line| &line.points);
        let panel = Panel {
            x: time_scale(points().map(|p| p.0)),
            y: Scale::over(points().map(|p| p.1), false),
            x_label: time_label(run).to_owned(),
            y_label: unit.label(chart.label),
            lines,
            front: Vec::new(),
        };
        charts.figures.push(Figure {
            id: chart.id.to_owned(),
            panels: Panels { title: chart.title.to_owned(), panels: vec![panel], below: true },
            caption,
        });
    }
    charts
}

/// What takes the place of time.
pub(super) fn time_label(run: &Run<'_>) -> &'static str {
    match run.case.control.as_ref().map(|control| &control.kind) {
        Some(ControlKind::Dissipation(_)) => "dissipated part of the energy",
        _ => "time [s]",
    }
}

/// Logarithmic where most instants would lie on each other.
fn time_scale(times: impl Iterator<Item = f64> + Clone) -> Scale {
    let mut sorted: Vec<f64> = times.clone().collect();
    sorted.sort_by(f64::total_cmp);
    let crowded = match (sorted.first(), sorted.get(sorted.len() / 2), sorted.last()) {
        (Some(first), Some(middle), Some(last)) => *first > 0.0 && *middle < last / 30.0,
        _ => false,
    };
    Scale::over(times, crowded)
}

/// All charts, in their order on the page.
fn wanted(run: &Run<'_>) -> Vec<Chart> {
    let case = run.case;
    let mut charts = vec![damage(case)];
    charts.extend(case.control.as_ref().map(|_| load_factor()));
    charts.extend(case.has_pressure().then(|| pressures(case)));
    charts.extend([displacements(run), fluxes(case), energies(case)]);
    charts.extend(case.flow.as_ref().map(|_| masses(case)));
    charts
}

fn damage(case: &Case) -> Chart {
    let names = case.interfaces.iter().map(|interface| &interface.name);
    Chart {
        id: "damage",
        title: "Damage, largest of each interface",
        label: "damage",
        unit: "",
        lines: names.map(|name| (name.clone(), format!("{name}.damage.max"))).collect(),
    }
}

fn load_factor() -> Chart {
    Chart {
        id: "load-factor",
        title: "Load factor",
        label: "load factor",
        unit: "",
        lines: vec![(String::new(), "load_factor".to_owned())],
    }
}

/// Of probes, and the means of films.
fn pressures(case: &Case) -> Chart {
    let probes = case.probes.iter().map(|p| (p.name.clone(), format!("{}.pressure", p.name)));
    let films = case.interfaces.iter().filter(|interface| interface.film.is_some());
    let of_film =
        |i: &InterfaceSpec| (format!("interface {}", i.name), format!("{}.pressure.mean", i.name));
    Chart {
        id: "pressure",
        title: "Pressure of the fluid",
        label: "pressure",
        unit: "Pa",
        lines: probes.chain(films.map(of_film)).collect(),
    }
}

fn displacements(run: &Run<'_>) -> Chart {
    let all = run.case.probes.iter().flat_map(|probe| {
        run.case.axis_names().map(move |axis| {
            (format!("{}, {axis}", probe.name), format!("{}.displacement_{axis}", probe.name))
        })
    });
    Chart {
        id: "probes",
        title: "Displacement of the probes",
        label: "displacement",
        unit: "m",
        // Those that stay where they are say nothing.
        lines: all.filter(|(_, of)| is_moving(run, of)).collect(),
    }
}

fn fluxes(case: &Case) -> Chart {
    let interfaces = case.interfaces.iter().filter(|interface| case.has_flux(interface));
    let both_sides = |interface: &InterfaceSpec| {
        [("lower", "flux_lower"), ("upper", "flux_upper")].map(|(side, of)| {
            (format!("{}, {side} side", interface.name), format!("{}.{of}", interface.name))
        })
    };
    Chart {
        id: "flux",
        title: "Flow from interfaces into the rock",
        label: "mass flux",
        unit: "kg/m²/s",
        lines: interfaces.flat_map(both_sides).collect(),
    }
}

fn energies(case: &Case) -> Chart {
    let names: &[&str] = if case.has_pressure() {
        &["elastic", "dissipated", "external", "fluid"]
    } else {
        &["elastic", "dissipated", "external"]
    };
    Chart {
        id: "energy",
        title: "Energies",
        label: "energy",
        unit: if case.dim == 2 { "J/m" } else { "J" },
        lines: columns_of("energy", names),
    }
}

fn masses(case: &Case) -> Chart {
    Chart {
        id: "mass",
        title: "Mass of the fluid since the start",
        label: "mass",
        unit: if case.dim == 2 { "kg/m" } else { "kg" },
        lines: columns_of("mass", &["in", "out", "stored"]),
    }
}

/// Lines that are called as their columns, `prefix.name`.
fn columns_of(prefix: &str, names: &[&str]) -> Vec<(String, String)> {
    names.iter().map(|name| ((*name).to_owned(), format!("{prefix}.{name}"))).collect()
}

/// Whether a displacement is more than the rounding of others.
fn is_moving(run: &Run<'_>, name: &str) -> bool {
    let most = |name: &str| {
        let values = column(run.history, name).unwrap_or_default();
        values.into_iter().flatten().map(f64::abs).fold(0.0, f64::max)
    };
    let probes = run.history.columns.iter().filter(|column| column.contains(".displacement_"));
    most(name) > 1e-9 * probes.map(|name| most(name)).fold(0.0, f64::max)
}

/// Corrections and what was out of balance at the end, instant by instant.
pub(super) fn convergence(run: &Run<'_>) -> Charts {
    let mut charts = Charts { figures: Vec::new(), words: Vec::new() };
    let corrections = column(run.history, "newton_iterations").unwrap_or_default();
    let residuals = run.report.get("residual_norms").and_then(|list| list.as_array());
    let residuals: Vec<f64> = residuals.into_iter().flatten().filter_map(|v| v.as_f64()).collect();
    let counted: Vec<(f64, f64)> = numbered(corrections.into_iter().flatten());
    if counted.is_empty() {
        return charts;
    }
    let balanced = residuals.iter().filter(|norm| **norm > 0.0).count();
    let line = |points: Vec<(f64, f64)>| {
        let look = if points.len() <= 60 { Look::Marked } else { Look::Joined };
        Line::new("", points, Some(0), look)
    };
    let mut panels = vec![Panel {
        x: Scale::whole(1.0, counted.iter().map(|p| p.0)),
        y: Scale::whole(0.0, counted.iter().map(|p| p.1)),
        x_label: "instant".to_owned(),
        y_label: "corrections".to_owned(),
        lines: vec![line(counted)],
        front: Vec::new(),
    }];
    if balanced > 0 {
        let points = numbered(residuals.iter().copied());
        panels.push(Panel {
            x: Scale::whole(1.0, points.iter().map(|p| p.0)),
            y: Scale::over(points.iter().map(|p| p.1), true),
            x_label: "instant".to_owned(),
            y_label: "forces out of balance [N]".to_owned(),
            lines: vec![line(points)],
            front: Vec::new(),
        });
    }
    let mut caption =
        "Left: linearised corrections, those of steps that were cut included. ".to_owned();
    if balanced > 0 {
        caption += "Right: 2-norm of what is out of balance when an instant is accepted. ";
    }
    if balanced < residuals.len() {
        caption +=
            &format!("Exactly 0, and not shown, at {} instants. ", residuals.len() - balanced);
    }
    charts.figures.push(Figure {
        id: "convergence".to_owned(),
        panels: Panels {
            title: "Corrections and balance by instant".to_owned(),
            panels,
            below: true,
        },
        caption: caption.trim_end().to_owned(),
    });
    charts
}

fn numbered(values: impl Iterator<Item = f64>) -> Vec<(f64, f64)> {
    values.enumerate().map(|(index, value)| (index as f64 + 1.0, value)).collect()
}
