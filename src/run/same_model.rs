//! Whether a checkpoint is of the model of a case.

use serde_json::Value;

use super::run_state::RunState;
use crate::case::Case;
use crate::output::directory::first_difference;
use crate::solve::Model;

/// What tells the mesh of a file from another one, in hexadecimal digits; none of a column, which
/// the case describes.
pub fn digest(case: &Case, model: &Model<'_>) -> Option<String> {
    case.mesh.file().map(|_| format!("{:016x}", model.mesh.facts.digest))
}

/// In which of what the solution depends on the case is another one, in words.
pub fn difference(state: &RunState, case: &Case) -> Option<String> {
    let before = match serde_json::from_str(state.case.get()) {
        Ok(before) => physics(before),
        Err(cause) => return Some(format!("its case: {cause}")),
    };
    // Both have been text, so that equal numbers are equal.
    let now = physics(serde_json::from_str(&case.resolved().to_string()).unwrap_or_default());
    if before != now {
        let key = first_difference(&before, &now);
        let at = |case: &Value| {
            let pointer = format!("/{}", key.replace('.', "/"));
            case.pointer(&pointer).map_or("nothing".into(), Value::to_string)
        };
        return Some(format!(
            "`{key}` is {} there and {} here; a run goes on with the same model only",
            at(&before),
            at(&now)
        ));
    }
    if state.history.columns != case.columns() {
        return Some("its history has other columns; keep interfaces, supports and probes".into());
    }
    let times: Vec<f64> = state.history.rows.iter().filter_map(|row| row[0]).collect();
    // The row of the start is that of no instant.
    let times = &times[times.len().saturating_sub(state.accepted)..];
    if case.time.get(..state.accepted) != Some(times) {
        return Some(format!(
            "it has gone through the instants {times:?}, which time.instants has to begin with"
        ));
    }
    let (time, last) = (state.step.time, times.last().copied().unwrap_or(case.start));
    let next = case.time.get(state.accepted);
    if time < last || next.is_some_and(|next| time >= *next) {
        let next = next.map_or("the end".into(), f64::to_string);
        return Some(format!("its state is of time {time}, not between {last} and {next}"));
    }
    if state.step.load_factor.is_some() != case.control.is_some() {
        return Some("its load factor is not of this case".into());
    }
    None
}

/// A resolved case without what may change from run to run: how it is solved, what is written and
/// checked, and the instants.
fn physics(mut case: Value) -> Value {
    if let Value::Object(sections) = &mut case {
        // Of how it is solved this alone changes what is solved.
        let lumped = sections.get("solver").and_then(|solver| solver.get("lumped_storage"));
        let lumped = lumped.cloned().unwrap_or(Value::Bool(false));
        for key in ["title", "solver", "output", "limits", "expect"] {
            sections.remove(key);
        }
        if let Some(Value::Object(time)) = sections.get_mut("time") {
            time.remove("instants");
            time.remove("tolerance");
        }
        sections.insert("lumped_storage".into(), lumped);
    }
    case
}
