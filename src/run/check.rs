//! `check` and `schema`: what can be said of a case without solving it.

use std::fmt::Write;
use std::path::Path;

use super::resources::disk;
use crate::bulk::Loads;
use crate::case::{self, Case, read_text};
use crate::error::{Error, Result};
use crate::interface::{Sides, unresolved_zones};
use crate::mesh::{Column, LocalMesh};
use crate::reduce::{NONE_OF_USE, Situation, candidates, refusal};
use crate::solve::model::memory::{memory, pressures};
use crate::solve::{LinearChoice, strength_factors};
use crate::space::{AtNode, Prescribed, PrescribedPressure};

/// Largest column that the check walks through node by node.
const MOST_NODES: u64 = 2_000_000;

/// The JSON Schema of the case file.
pub fn schema() -> String {
    serde_json::to_string_pretty(&case::schema()).unwrap_or_default()
}

/// Reads and checks a case; says what will be modelled, why, and how large it is. Local.
///
/// # Errors
/// `Input` with everything that is wrong.
pub fn check(path: &Path, overrides: &[String]) -> Result<String> {
    describe(&Case::read(&read_text(path)?, path, overrides)?)
}

/// What is said of a case that has been read. Local; reads nothing.
///
/// # Errors
/// `Input` when a formula gives no number somewhere, or values disagree.
pub fn describe(case: &Case) -> Result<String> {
    let column = Column::new(case)?;
    let unknowns = column.nodes() * case.dim as u64 + pressures(case, &column);
    let choice = LinearChoice::new(case, &column);
    if column.nodes() <= MOST_NODES {
        let nodes: Vec<u64> = (0..column.nodes()).collect();
        let times = case.load_times();
        let prescribed = Prescribed::new(case, &column);
        let largest = prescribed.largest_value(&nodes, &times);
        let checked = largest.and_then(|l| prescribed.check_agreement(&nodes, &times, l));
        checked.map_err(|AtNode(_, error)| error)?;
        let mesh = LocalMesh::new(&column, (0..column.cells()).collect(), column.cells());
        Loads::new(case, &mesh).check(&times)?;
        if case.has_pressure() {
            let corners = LocalMesh::new(&column.of_first_order(), mesh.cells.clone(), 0);
            let prescribed = PrescribedPressure::new(case, &corners.column);
            let checked = prescribed.check(&corners.nodes, &times);
            checked.map_err(|AtNode(_, error)| error)?;
            Loads::inflow(case, &corners).check(&times)?;
            Loads::injection(case, &corners).check(&times)?;
        }
        let sides = Sides::choose(case, &column);
        let secondary = sides.iter().enumerate().flat_map(|(interface, side)| {
            let own = nodes.iter().filter(|node| side.is_secondary(&column, **node));
            own.map(move |node| (interface, *node))
        });
        strength_factors(case, &column, secondary).map_err(|AtNode(_, error)| error)?;
    }
    let bytes = memory(choice.preset, case, &column, 1);
    let mut text = format!("{}\n", case.title);
    let mut line = |name: &str, what: String| {
        writeln!(text, "{name:<10} {what}").map_err(|e| Error::Bug(format!("check: {e}")))
    };
    line("model", format!("{}, {}D", case.physics.name(), case.dim))?;
    for sentence in &case.left_out {
        line("left out", sentence.clone())?;
    }
    let order = case.mesh.order_words();
    line("mesh", format!("{} cells{order}, {unknowns} unknowns", column.cells()))?;
    for (interface, side) in case.interfaces.iter().zip(Sides::choose(case, &column)) {
        let secondary = if side.secondary.upper { "lower" } else { "upper" };
        let (name, law) = (&interface.name, interface.law.name());
        line(
            "interface",
            format!("{name} at z = {} m: {law}, multipliers on the {secondary} side", interface.z),
        )?;
    }
    let sides = Sides::choose(case, &column);
    for words in unresolved_zones(case, &column, &sides) {
        line("warning", words)?;
    }
    line("reduced", reduction(case, &column, unknowns))?;
    line("linear", format!("{}: {}", choice.preset, choice.why))?;
    line("memory", format!("about {:.2} GB on one rank", bytes / 1e9))?;
    line("disk", format!("about {:.3} GB", disk(case, &column) / 1e9))?;
    line("instants", format!("{}", case.time.len()))?;
    line("output", format!("{}", case.output.directory.display()))?;
    text.push_str("the case is right\n");
    Ok(text)
}

/// Whether a run would try a smaller model, in words.
fn reduction(case: &Case, column: &Column, unknowns: u64) -> String {
    let situation = Situation { unknowns, goes_on: false, has_options: false };
    if let Some(why) = refusal(case, situation) {
        return format!("no: {why}");
    }
    match candidates(case, column).first() {
        Some(first) => format!("if the run can show that {}", first.left_out),
        None => format!("no: {NONE_OF_USE}"),
    }
}
