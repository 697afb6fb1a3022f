//! Charts of interfaces.

use super::figures::{Axis, COMPUTED, in_pairs, look, numbers, panel};
use super::law_path::{Curve, Joint, Mean, Range, along, first_loading};
use super::words::{Unit, column, in_words, number};
use super::{Charts, Figure, Run};
use crate::case::{ColumnSpec, InterfaceSpec};
use crate::chart::{Line, Look, Panel};

/// Interfaces that are drawn; a case may have a thousand.
const MOST_INTERFACES: usize = 16;
/// A component whose jumps are below this part of the typical ones does not move: rounding only.
const MOVES: f64 = 1e-6;
/// The style of the law.
const LAW: usize = 5;
/// Traction over jump of every interface, with its law.
pub(super) fn charts(run: &Run<'_>) -> Charts {
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
        "Means over each interface at the instants of the case, which are numbered where they are few. The \
         band is the law on the path of these means, in one step from instant to instant: an interface that \
         opens evenly lies on it, one that tilts or breaks bit by bit need not. Tension and opening are \
         positive."
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
    // Of a mesh of a file the thickness of the bodies is not known.
    let height = run.case.mesh.column().map_or(1.0, ColumnSpec::height);
    let stiffness = run.case.materials.first().map_or(1.0, |m| m.young_modulus) / height;
    let dim = run.case.dim;
    let joint = Joint { law, stiffness, dim };
    let paths = along(joint, &means);
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
            curves.panel(joint, effective)
        })
        .collect();
    let index = run.case.interfaces.iter().position(|i| i.name == interface.name);
    let place = match interface.height() {
        Some(z) => format!("at z = {} m", number(z)),
        None => interface.place(),
    };
    let mut caption = format!("{}, {place}", interface.law.name().replace('_', " "));
    let given = serde_json::to_value(&interface.law).unwrap_or_default();
    let parameters = given.as_object().and_then(|law| law.values().next()?.as_object());
    // The augmentation changes nothing of the answer.
    for (name, value) in parameters.into_iter().flatten().filter(|(k, _)| *k != "augmentation") {
        let unit = unit_of(name);
        let text = value.as_f64().map_or_else(|| in_words(value), |v| Unit::text(unit, v));
        caption += &format!(", {} {text}", name.replace('_', " "));
    }
    caption += ". ";
    if effective {
        caption += "The traction is the effective one, total plus pressure of the fluid. ";
    }
    if run.case.imperfections.iter().any(|i| Some(i.interface) == index) {
        caption += "The law is drawn without the imperfection. ";
    }
    let title = format!("Interface {}: traction over jump", interface.name);
    let mut figures = in_pairs(&format!("interface-{}", interface.name), &title, panels);
    if let Some(figure) = figures.first_mut() {
        figure.caption = caption.trim_end().to_owned();
    }
    figures
}

/// The unit of a parameter of a law, by its name; none where it has none.
fn unit_of(parameter: &str) -> &'static str {
    let units = [("strength", "Pa"), ("energy", "J/m²"), ("stiffness", "Pa/m"), ("jump", "m")];
    units.iter().find(|(name, _)| parameter.contains(name)).map_or("", |(_, unit)| unit)
}

/// What is drawn of one component.
struct Curves<'a> {
    measured: Curve,
    path: &'a Curve,
    component: usize,
}

impl Curves<'_> {
    fn panel(self, joint: Joint<'_>, effective: bool) -> Panel {
        let Self { measured, path, component } = self;
        let most = |pick: fn(&(f64, f64)) -> f64| measured.iter().map(pick).fold(0.0, f64::max);
        let least = |pick: fn(&(f64, f64)) -> f64| measured.iter().map(pick).fold(0.0, f64::min);
        let largest = most(|p| p.0.abs());
        let reach = reach(joint, component).unwrap_or(0.0).max(1.05 * largest);
        let low = if component == 0 { least(|p| p.1) } else { least(|p| p.0) };
        // Less is rounding.
        let low = if component > 0 && low > -MOVES * reach { 0.0 } else { low };
        let range = Range { low, high: 1.05 * most(|p| p.1), reach };
        let first = first_loading(joint, component, range);
        let every = || measured.iter().chain(&first).chain(path);
        let x_unit = Unit::of("m", every().map(|p| p.0));
        let y_unit = Unit::of("Pa", every().map(|p| p.1));
        let look = look(measured.len(), false);
        let lines = vec![
            Line::new("law on the path", path.clone(), Some(LAW), Look::Band),
            Line::new("law, first loading", first, None, Look::Joined),
            Line {
                labels: numbers(1, measured.len()),
                ..Line::new("computed", measured.clone(), Some(COMPUTED), look)
            },
        ];
        let normal = if effective { "effective normal traction" } else { "normal traction" };
        let tangent = |what: &str| {
            let axis = ["", "x", "y"][component];
            format!("{what} along {axis}")
        };
        let (x, y) = match component {
            0 => ("normal jump".to_owned(), normal.to_owned()),
            _ => (tangent("sliding"), tangent("shear traction")),
        };
        let x_axis = Axis { words: &x, unit: &x_unit };
        panel(lines, x_axis, Axis { words: &y, unit: &y_unit })
    }
}

/// The jump up to which a law is drawn: all of one that ends, and of one that fades what can be
/// seen.
fn reach(joint: Joint<'_>, component: usize) -> Option<f64> {
    let Joint { law, stiffness, dim } = joint;
    let (end, typical) = law.jump_scale().zip(law.typical_jump())?;
    let mut reach = end.min(4.0 * typical);
    // Its scale may be that of another mode.
    let r = law.augmentation(stiffness);
    for _ in 0..10 {
        let mut p = [0.0; 3];
        p[component] = r * reach;
        let carried = law.respond(p, r, 0.0, dim).traction[component];
        if law.strength().is_none_or(|strength| carried <= 0.01 * strength) {
            break;
        }
        reach *= 1.25;
    }
    Some(reach)
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
