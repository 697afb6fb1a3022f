//! `check` and `schema`: what can be said of a case without solving it.

use std::fmt::Write;
use std::path::Path;

use super::resources::disk;
use crate::bulk::{InitialStress, Loads};
use crate::case::{self, Case, read_text};
use crate::error::{Error, Result};
use crate::interface::{Sides, unresolved_zones};
use crate::mesh::{LocalMesh, MeshFamily};
use crate::reduce::{NONE_OF_USE, Situation, candidates_in, refusal};
use crate::solve::model::memory::{memory, pressures};
use crate::solve::{self, LinearChoice, check_fit, starts, strength_factors};
use crate::space::{AtNode, Prescribed, PrescribedPressure, check_directions};

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
    let family = solve::family(case)?;
    let facts = family.facts();
    let case = &case.clone().for_dimension(facts.dim)?;
    let unknowns = facts.nodes * case.dim as u64 + pressures(case, &facts);
    let choice = LinearChoice::new(case, &facts)?;
    let sides = Sides::choose(case, &facts);
    if facts.nodes <= MOST_NODES {
        let mesh = family.whole()?;
        for (number, stage) in case.in_stages().into_iter().enumerate() {
            on_whole_mesh(stage, &mesh, &sides).map_err(|error| match error {
                Error::Input(text) if number > 0 => {
                    Error::Input(format!("stages.{number}: {text}"))
                }
                other => other,
            })?;
        }
    }
    let bytes = memory(choice.preset, case, &facts, 1);
    let mut text = format!("{}\n", case.title);
    let mut line = |name: &str, what: String| {
        writeln!(text, "{name:<10} {what}").map_err(|e| Error::Bug(format!("check: {e}")))
    };
    line("model", format!("{}, {}D", case.physics.name(), case.dim))?;
    for sentence in &case.left_out {
        line("left out", sentence.clone())?;
    }
    let (order, refined) = (case.mesh.order_words(), case.mesh.refined_words());
    line("mesh", format!("{} cells{order}{refined}, {unknowns} unknowns", facts.cells))?;
    for (interface, side) in case.interfaces.iter().zip(&sides) {
        let secondary = side.secondary.name();
        let (name, law) = (&interface.name, interface.law.name());
        line(
            "interface",
            format!(
                "{name} {}: {law}{}, multipliers on the {secondary} side",
                interface.place(),
                interface.start_words()
            ),
        )?;
    }
    for words in unresolved_zones(case, &facts) {
        line("warning", words)?;
    }
    line("reduced", reduction(case, &family, unknowns))?;
    line("linear", format!("{}: {}", choice.preset, choice.why))?;
    line("memory", format!("about {:.2} GB on one rank", bytes / 1e9))?;
    line("disk", format!("about {:.3} GB", disk(case, &facts) / 1e9))?;
    line("instants", format!("{}", case.time.len()))?;
    if !case.stages.is_empty() {
        let ends: Vec<String> = case.stages.iter().map(|stage| stage.until.to_string()).collect();
        line("stages", format!("{}, until {}", ends.len(), ends.join(", ")))?;
    }
    line("output", format!("{}", case.output.directory.display()))?;
    text.push_str("the case is right\n");
    Ok(text)
}

/// What is checked node by node, on the whole mesh. Local.
fn on_whole_mesh(case: &Case, mesh: &LocalMesh, sides: &[Sides]) -> Result<()> {
    let times = case.load_times();
    let prescribed = Prescribed::new(case);
    let largest = prescribed.largest_value(&mesh.nodes, &times);
    let checked = largest.and_then(|largest| {
        prescribed.check_agreement(&mesh.nodes, &times, largest)?;
        check_directions(mesh, &prescribed, &times, largest)
    });
    checked.map_err(|AtNode(_, error)| error)?;
    Loads::new(case, mesh).check(&times)?;
    InitialStress::new(case, mesh)?;
    check_fit(case, mesh, sides, &prescribed)?;
    if case.has_pressure() {
        let corners = mesh.corners();
        let checked = PrescribedPressure::new(case).check(corners.nodes.iter(), &times);
        checked.map_err(|AtNode(_, error)| error)?;
        Loads::inflow(case, &corners).check(&times)?;
        Loads::injection(case, &corners).check(&times)?;
    }
    let secondary = || {
        sides.iter().flat_map(|side| {
            let own = mesh.nodes.iter().filter(|(_, _, marks)| side.is_secondary(marks));
            own.map(|(name, point, _)| (side.interface, name, point))
        })
    };
    let factors = strength_factors(case, secondary()).map(|_| ());
    let checked = factors.and_then(|()| starts(case, secondary()).map(|_| ()));
    checked.map_err(|AtNode(_, error)| error)
}

/// Whether a run would try a smaller model, in words.
fn reduction(case: &Case, family: &MeshFamily, unknowns: u64) -> String {
    let has_stages = !case.stages.is_empty();
    let situation = Situation { unknowns, goes_on: false, has_options: false, has_stages };
    if let Some(why) = refusal(case, situation) {
        return format!("no: {why}");
    }
    match candidates_in(case, family).first() {
        Some(first) => format!("if the run can show that {}", first.left_out),
        None => format!("no: {NONE_OF_USE}"),
    }
}
