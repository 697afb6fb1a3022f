//! What is told of a search: lines on the screen, and the report.

use std::collections::BTreeMap;
use std::path::Path;

use super::Found;
use super::errors::Errors;
use super::trial::{Trials, Tried};
use crate::case::Case;
use crate::case::sections::AccuracySection;
use crate::error::Result;
use crate::output::directory::{PAGE, REPORT};
use crate::report::accuracy::{Accuracy, Mesh, Parts, Quantity};
use crate::report::{Report, Status};
use crate::run::carry_out::Output;
use crate::run::session::Ended;
use crate::run::{page, screen};
use crate::runtime::Runtime;

/// What is looked for.
pub fn start(case: &Case, wanted: &AccuracySection) {
    tracing::info!("{}", case.title);
    let of = wanted.of.join(", ");
    tracing::info!("accuracy   {of} within {:e}", wanted.relative);
}

/// A mesh and its worst error.
pub fn mesh(trials: &Trials<'_>, base: usize, errors: &Errors) {
    let tried = &trials.tried[base];
    let (cells, wanted) = (words(trials, tried), trials.wanted());
    let relative = |value: usize| errors.size(value) / errors.allowed[value];
    let worst = (0..wanted.len()).max_by(|a, b| relative(*a).total_cmp(&relative(*b)));
    let Some(worst) = worst else { return };
    let value = tried.values.as_ref().map_or(0.0, |values| values[worst]);
    let names = trials.family.axes().into_iter().map(|(_, name)| name);
    let of = |(name, parts): (&str, &Vec<super::estimate::Part>)| {
        let order =
            parts[worst].order.map_or(String::new(), |order| format!(" (order {order:.1})"));
        format!("{name} {:.1e}{order}", -parts[worst].missing)
    };
    let mut parts: Vec<String> = names.zip(&errors.axes).map(of).collect();
    if parts.len() > 1 {
        parts.push(format!("mixed {:.1e}", -errors.mixed(worst)));
    }
    parts.extend(errors.beside.time.as_ref().map(|t| format!("time {:.1e}", -t[worst].missing)));
    parts.push(format!("solver {:.1e}", -errors.beside.solver[worst]));
    let (of, at) = wanted[worst];
    tracing::info!("mesh       {cells}, {} unknowns", tried.unknowns);
    tracing::info!(
        "           {of} at {at}: {value:.6e}, error {:.1e}{}: {}",
        -errors.missing(worst),
        if errors.are_trusted(worst) { "" } else { ", not trusted" },
        parts.join(", ")
    );
}

/// The cells of a mesh in words.
fn words(trials: &Trials<'_>, tried: &Tried) -> String {
    let family = trials.family;
    if family.is_of_file() {
        return format!("refine {}", tried.plan.levels[0]);
    }
    let axes: Vec<usize> = family.axes().into_iter().map(|(axis, _)| axis).collect();
    let join = |numbers: Vec<String>| numbers.join(" x ");
    let bodies: Vec<String> = family
        .cells(&tried.plan)
        .iter()
        .map(|n| join(axes.iter().map(|axis| n[*axis].to_string()).collect()))
        .collect();
    let ratios: Vec<f64> = axes.iter().map(|axis| family.ratio(&tried.plan, *axis)).collect();
    let graded = if ratios.iter().all(|ratio| *ratio == 1.0) {
        String::new()
    } else {
        format!(", graded {}", join(ratios.iter().map(|ratio| format!("{ratio:.0}")).collect()))
    };
    format!("{} cells{graded}", bodies.join(" + "))
}

/// Writes what was found into the report, and the page. Collective.
///
/// # Errors
/// As those of a run.
pub fn close(
    runtime: &Runtime,
    case: &Case,
    wanted: &AccuracySection,
    trials: &Trials<'_>,
    found: Found,
    ended: Ended,
    output: Option<Output<'_>>,
) -> Result<Ended> {
    let met = ended.met && found.met;
    let told = ended.told.map(|(mut report, history)| {
        report.accuracy = Some(accuracy(trials, wanted, &found));
        if !found.met && report.status == Status::Done {
            report.status = Status::AccuracyMissed;
        }
        (report, history)
    });
    let family_case = trials.family.case(&trials.tried[found.base].plan);
    let write = |report: &Report, directory: &Path| -> Result<()> {
        report.write(&directory.join(REPORT))?;
        let Some((_, history)) = &told else { return Ok(()) };
        let is_wanted = output.is_some_and(|output| output.page);
        if is_wanted {
            let shown = if case.stages.is_empty() { &family_case } else { case };
            page::write(&directory.join(PAGE), report, history, shown, &[])?;
        }
        Ok(())
    };
    let written = match (&told, output) {
        (Some((report, _)), Some(output)) => write(report, output.directory),
        _ => Ok(()),
    };
    runtime.comm.agree(written)?;
    if let Some((report, _)) = &told {
        summary(report);
        screen::close(report, output.map(|output| output.directory));
    }
    Ok(Ended { met, told })
}

/// The results and their errors on the screen.
fn summary(report: &Report) {
    let Some(of) = &report.accuracy else { return };
    tracing::info!("");
    tracing::info!("{:<32} {:>12} {:>14} {:>10} {:>9}", "accuracy", "time", "value", "error", "");
    for quantity in &of.quantities {
        tracing::info!(
            "{:<32} {:>12.6} {:>14.6e} {:>10.1e} {}",
            quantity.quantity,
            quantity.at,
            quantity.value,
            quantity.error,
            if quantity.trusted { "" } else { "not trusted" }
        );
    }
    tracing::info!("{} meshes, {:.1} core-seconds: {}", of.meshes.len(), of.core_seconds, of.why);
    if !of.met {
        tracing::warn!("warning: the accuracy that was asked for is not reached: {}", of.why);
    }
}

fn accuracy(trials: &Trials<'_>, wanted: &AccuracySection, found: &Found) -> Accuracy {
    let (errors, base) = (&found.errors, &trials.tried[found.base]);
    let quantity = |(number, (of, at)): (usize, (&str, f64))| {
        let value = base.values.as_ref().map_or(0.0, |values| values[number]);
        let names = trials.family.axes().into_iter().map(|(_, name)| name.to_owned());
        let of_axis = errors.axes.iter().map(|parts| -parts[number].missing + 0.0);
        let time = errors.beside.time.as_ref().map(|time| -time[number].missing + 0.0);
        let mut mesh = names.zip(of_axis).collect::<BTreeMap<String, f64>>();
        if mesh.len() > 1 {
            mesh.insert("mixed".to_owned(), -errors.mixed(number) + 0.0);
        }
        Quantity {
            quantity: of.to_owned(),
            at,
            value,
            error: -errors.missing(number) + 0.0,
            relative: errors.size(number) / (errors.allowed[number] / wanted.relative).max(1e-300),
            parts: Parts {
                mesh,
                interface: None,
                time,
                solver: -errors.beside.solver[number] + 0.0,
            },
            trusted: errors.are_trusted(number) && !base.is_doubtful,
        }
    };
    let axes = [0, 1, 2];
    let mesh = |tried: &Tried| Mesh {
        purpose: tried.purpose.clone(),
        cells: trials.family.cells(&tried.plan),
        grading: axes.map(|axis| trials.family.ratio(&tried.plan, axis)),
        refine: if trials.family.is_of_file() { tried.plan.levels[0] } else { 0 },
        steps: 1 << tried.plan.steps,
        tolerance: tried.plan.tolerance,
        unknowns: tried.unknowns,
        core_seconds: tried.core_seconds,
        values: tried.values.clone(),
    };
    Accuracy {
        asked: wanted.relative,
        met: found.met,
        why: found.why.clone(),
        quantities: trials.wanted().into_iter().enumerate().map(quantity).collect(),
        meshes: trials.tried.iter().map(mesh).collect(),
        chosen: found.base,
        core_seconds: trials.tried.iter().map(|tried| tried.core_seconds).sum(),
    }
}
