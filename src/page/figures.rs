//! Charts of interfaces, and of loads over displacements.

use super::law_path::{Curve, Mean, along, first_loading};
use super::words::{Unit, column, pairs};
use super::{Charts, Figure, Run};
use crate::case::{Case, InterfaceSpec, Surface, Value};
use crate::law::InterfaceLaw;
use crate::study::chart::{Line, Look, Panel, Panels, Scale};

/// Interfaces that are drawn; a case may have a thousand.
const MOST_INTERFACES: usize = 16;
/// Points that have markers of their own.
const MOST_MARKED: usize = 60;
/// A component whose jumps are below this part of the typical ones does not move: rounding only.
const MOVES: f64 = 1e-6;

/// Styles of lines: colours of the charts.
const MEASURED: usize = 0;
const LAW: usize = 5;

/// Points that can be told apart are marked, and joined where `join` says so.
pub(super) fn look(count: usize, join: bool) -> Look {
    match (count <= MOST_MARKED, join) {
        (false, _) => Look::Joined,
        (true, true) => Look::Marked,
        (true, false) => Look::Points,
    }
}

/// Numbers of all lines, scaled by units, in one pair of axes.
pub(super) fn panel(
    lines: Vec<Line>,
    (x_words, x_unit): (&str, &Unit),
    (y_words, y_unit): (&str, &Unit),
) -> Panel {
    let scaled = |(x, y): &(f64, f64)| (x_unit.number(*x), y_unit.number(*y));
    let lines: Vec<Line> = lines
        .into_iter()
        .map(|line| Line { points: line.points.iter().map(scaled).collect(), ..line })
        .collect();
    let points = || lines.iter().flat_map(|line| &line.points);
    Panel {
        x: Scale::over(points().map(|p| p.0), false),
        y: Scale::over(points().map(|p| p.1), false),
        x_label: x_unit.label(x_words),
        y_label: y_unit.label(y_words),
        lines,
        front: Vec::new(),
    }
}

/// Traction over jump of every interface, with its law.
pub(super) fn interfaces(run: &Run<'_>) -> Charts {
    let all = &run.case.interfaces;
    let mut charts = Charts { figures: Vec::new(), words: Vec::new() };
    if all.is_empty() {
        return charts;
    }
    if run.history.rows.is_empty() {
        charts.words.push("No instant was reached: there is nothing to draw.".to_owned());
        return charts;
    }
    charts.words.push(
        "Means over each interface at the instants of the case. The band is the law along the path of \
         these means: an interface that opens evenly lies on it, one that tilts or breaks bit by bit need \
         not. Tension and opening are positive."
            .to_owned(),
    );
    if all.len() > MOST_INTERFACES {
        charts.words.push(format!(
            "The first {MOST_INTERFACES} of {} interfaces; all are in history.csv.",
            all.len()
        ));
    }
    charts.figures = all
        .iter()
        .take(MOST_INTERFACES)
        .flat_map(|interface| of_interface(run, interface))
        .collect();
    charts
}

/// One figure, or two where both tangential components move.
fn of_interface(run: &Run<'_>, interface: &InterfaceSpec) -> Vec<Figure> {
    let means = means(run, interface);
    let law = interface.law.law();
    let stiffness =
        run.case.materials.first().map_or(1.0, |m| m.young_modulus) / run.case.mesh.height();
    let dim = run.case.dim;
    let paths = along(law, &means, stiffness, dim);
    let most = |c: usize| means.iter().map(|m| m.jump[c].abs()).fold(0.0, f64::max);
    let typical = law.typical_jump().unwrap_or_else(|| (0..3).map(most).fold(1e-9, f64::max));
    let moving = (1..dim).filter(|c| most(*c) > MOVES * typical);
    let effective = interface.fluid_pressure.is_some() || interface.film.is_some();
    let panels: Vec<Panel> = std::iter::once(0)
        .chain(moving)
        .map(|component| {
            let measured: Curve =
                means.iter().map(|m| (m.jump[component], m.traction[component])).collect();
            let curves = Curves { measured, path: &paths[component], component };
            curves.panel(law, (stiffness, dim), effective)
        })
        .collect();
    let mut caption = format!(
        "{}, at z = {}. ",
        interface.law.name().replace('_', " "),
        Unit::text("m", interface.z)
    );
    if let Some(strength) = law.strength() {
        caption += &format!("Strength {}", Unit::text("Pa", strength));
        if let Some(jump) = law.jump_scale() {
            caption += &format!(", nothing is transmitted beyond {}", Unit::text("m", jump));
        }
        caption += ". ";
    }
    if effective {
        caption += "The traction is the effective one, total plus pressure of the fluid. ";
    }
    let index = run.case.interfaces.iter().position(|i| i.name == interface.name);
    if run.case.imperfections.iter().any(|i| Some(i.interface) == index) {
        caption += "The law is drawn without the imperfection. ";
    }
    let mut panels = panels.into_iter().peekable();
    let mut figures = Vec::new();
    while panels.peek().is_some() {
        let number = figures.len();
        let suffix = if number == 0 { String::new() } else { format!("-{}", number + 1) };
        figures.push(Figure {
            id: format!("interface-{}{suffix}", interface.name),
            panels: Panels {
                title: format!("Interface {}: traction over jump", interface.name),
                panels: panels.by_ref().take(2).collect(),
            },
            caption: if number == 0 { caption.trim_end().to_owned() } else { String::new() },
        });
    }
    figures
}

/// What is drawn of one component.
struct Curves<'a> {
    measured: Curve,
    path: &'a Curve,
    component: usize,
}

impl Curves<'_> {
    fn panel(
        self,
        law: &dyn InterfaceLaw,
        (stiffness, dim): (f64, usize),
        effective: bool,
    ) -> Panel {
        let Self { measured, path, component } = self;
        let most = |pick: fn(&(f64, f64)) -> f64| measured.iter().map(pick).fold(0.0, f64::max);
        let least = |pick: fn(&(f64, f64)) -> f64| measured.iter().map(pick).fold(0.0, f64::min);
        let largest = most(|p| p.0.abs());
        // All of a law that ends, and of one that fades what can be seen.
        let seen =
            law.jump_scale().zip(law.typical_jump()).map(|(end, typical)| end.min(4.0 * typical));
        let reach = seen.map_or(largest, |seen| seen.max(1.05 * largest));
        let low = if component == 0 { least(|p| p.1) } else { least(|p| p.0) };
        let first =
            first_loading(law, component, (low, 1.05 * most(|p| p.1)), reach, (stiffness, dim));
        let numbers = || measured.iter().chain(&first).chain(path);
        let (x, y) =
            (Unit::of("m", numbers().map(|p| p.0)), Unit::of("Pa", numbers().map(|p| p.1)));
        let lines = vec![
            Line::new("law, first loading", first, None, Look::Joined),
            Line::new("law along the path", path.clone(), Some(LAW), Look::Band),
            Line::new(
                "computed mean",
                measured.clone(),
                Some(MEASURED),
                look(measured.len(), false),
            ),
        ];
        let normal = if effective { "effective normal traction" } else { "normal traction" };
        let tangent = |what: &str| {
            let axis = ["", "x", "y"][component];
            format!("{what} along {axis}")
        };
        match component {
            0 => panel(lines, ("normal jump", &x), (normal, &y)),
            _ => panel(lines, (&tangent("sliding"), &x), (&tangent("shear traction"), &y)),
        }
    }
}

/// The means at the instants that have them.
fn means(run: &Run<'_>, interface: &InterfaceSpec) -> Vec<Mean> {
    let of = |quantity: &str| {
        let found = column(run.history, &format!("{}.{quantity}.mean", interface.name));
        found.unwrap_or_else(|| vec![None; run.history.rows.len()])
    };
    let tangents = ["x", "y"]
        .map(|axis| (of(&format!("sliding_{axis}")), of(&format!("shear_traction_{axis}"))));
    let (jump, traction, damage) = (of("normal_jump"), of("normal_traction"), of("damage"));
    (0..run.history.rows.len())
        .filter_map(|row| {
            let along = |pick: usize| {
                let (sliding, shear) = &tangents[pick];
                (sliding[row].unwrap_or(0.0), shear[row].unwrap_or(0.0))
            };
            let [x, y] = [0, 1].map(along);
            Some(Mean {
                jump: [jump[row]?, x.0, y.0],
                traction: [traction[row]?, x.1, y.1],
                damage: damage[row].unwrap_or(0.0),
            })
        })
        .collect()
}

/// A displacement that is imposed on a surface along an axis, at the instants.
struct Imposed {
    surface: Surface,
    axis: usize,
    /// m
    values: Vec<Option<f64>>,
    /// At the start.
    first: f64,
}

/// Reaction over imposed displacement, or load over the displacement of a probe.
pub(super) fn load_displacement(run: &Run<'_>) -> Charts {
    let case = run.case;
    let mut charts = Charts { figures: Vec::new(), words: Vec::new() };
    if run.history.rows.is_empty() {
        return charts;
    }
    let force = if case.dim == 2 { "N/m" } else { "N" };
    let mut panels = Vec::new();
    for imposed in imposed(run) {
        let axis = ["x", "y", "z"][imposed.axis];
        let surface = imposed.surface.name();
        let reaction = column(run.history, &format!("{surface}.reaction_{axis}"));
        let mut points = pairs(&imposed.values, &reaction.unwrap_or_default());
        // A run starts undeformed; the history leaves that out.
        if imposed.first == 0.0 && !case.has_pressure() {
            points.insert(0, (0.0, 0.0));
        }
        let x = (format!("displacement {axis} of {surface}"), "m");
        panels.push(curve(points, x, (format!("reaction {axis} of {surface}"), force)));
    }
    let by_displacement = !panels.is_empty();
    if !by_displacement {
        panels = by_probes(run);
    }
    if panels.is_empty() {
        if case.boundary.iter().any(|entry| entry.traction.iter().flatten().any(changes(case))) {
            charts.words.push(
                "No displacement is imposed that changes, and no probe tells one: name a probe for a curve \
                 of load over displacement."
                    .to_owned(),
            );
        }
        return charts;
    }
    charts.words.push(format!(
        "Straight lines join the instants; what happens between them is not recorded. The section is {} {}.",
        super::words::number(case.mesh.section()),
        if case.dim == 2 { "m wide, and forces are per metre of depth" } else { "m²" }
    ));
    if by_displacement && case.control.is_some() {
        charts
            .words
            .push("The displacement is what the case prescribes times the load factor.".to_owned());
    }
    let mut panels = panels.into_iter().peekable();
    while panels.peek().is_some() {
        charts.figures.push(Figure {
            id: format!("load-{}", charts.figures.len() + 1),
            panels: Panels {
                title: "Load over displacement".to_owned(),
                panels: panels.by_ref().take(2).collect(),
            },
            caption: String::new(),
        });
    }
    charts
}

fn curve(
    points: Curve,
    (x_words, x_base): (String, &str),
    (y_words, y_base): (String, &str),
) -> Panel {
    let x = Unit::of(x_base, points.iter().map(|p| p.0));
    let y = Unit::of(y_base, points.iter().map(|p| p.1));
    let look = look(points.len(), true);
    let line = Line::new("", points, Some(MEASURED), look);
    panel(vec![line], (&x_words, &x), (&y_words, &y))
}

/// Whether a value is not the same at all instants, where the loads have a factor or change themselves.
fn changes(case: &Case) -> impl Fn(&Value) -> bool + '_ {
    let middle = case.mesh.lengths().map(|length| 0.5 * length);
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
fn imposed(run: &Run<'_>) -> Vec<Imposed> {
    let case = run.case;
    let loads = loads(run);
    let mut found: Vec<Imposed> = Vec::new();
    for entry in &case.boundary {
        // The load axis first.
        for axis in [2, 0, 1] {
            let Some(value) = &entry.displacement[axis] else { continue };
            let taken = found.iter().any(|i| i.surface == entry.on && i.axis == axis);
            let point = middle(case, entry.on);
            let at = |(time, factor): (f64, f64)| factor * value.at(point, time);
            let values: Vec<Option<f64>> =
                loads.iter().map(|load| load.map(at).filter(|value| value.is_finite())).collect();
            let first = match &case.control {
                Some(_) => 0.0,
                None => value.at(point, case.start),
            };
            let moves = values.iter().flatten().any(|value| *value != first);
            if moves && !taken {
                found.push(Imposed { surface: entry.on, axis, values, first });
            }
        }
    }
    found
}

/// The middle of a surface.
fn middle(case: &Case, surface: Surface) -> [f64; 3] {
    let mut point = case.mesh.lengths().map(|length| 0.5 * length);
    if let Some((axis, far)) = surface.axis() {
        point[axis] = if far { case.mesh.lengths()[axis] } else { 0.0 };
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
            let point = middle(case, entry.on);
            let tractions: Vec<Option<f64>> =
                loads.iter().map(|load| load.map(|(time, f)| f * value.at(point, time))).collect();
            let moved = column(run.history, &format!("{}.displacement_{name}", probe.name));
            let x = (format!("displacement {name} of {}", probe.name), "m");
            let y = (format!("traction {name} on {}", entry.on.name()), "Pa");
            panels.push(curve(pairs(&moved.unwrap_or_default(), &tractions), x, y));
        }
    }
    panels
}
