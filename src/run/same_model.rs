//! Whether a checkpoint is of the model of a case.

use serde_json::Value;

use super::run_state::RunState;
use crate::case::Case;
use crate::output::directory::first_difference;
use crate::output::history::Table;
use crate::solve::Model;

/// What tells the mesh of a file from another one, in hexadecimal digits; none of a column, which
/// the case describes.
pub fn digest(case: &Case, model: &Model<'_>) -> Option<String> {
    case.mesh.file().map(|_| format!("{:016x}", model.mesh.facts.digest))
}

/// In which of what the solution depends on the case is another one, in words.
pub fn difference(state: &RunState, case: &Case) -> Option<String> {
    let before: Value = match serde_json::from_str(state.case.get()) {
        Ok(before) => before,
        Err(cause) => return Some(format!("its case: {cause}")),
    };
    // Both have been text, so that equal numbers are equal.
    let now: Value = serde_json::from_str(&case.resolved().to_string()).unwrap_or_default();
    if let Some(words) = other_stages(state, &before, &now) {
        return Some(words);
    }
    let stages = case.in_stages();
    let span = stages.get(state.stage).map(|own| (own.start, own.time.last().copied()));
    let is_inside = |(start, end): (f64, Option<f64>)| {
        let time = state.step.time;
        state.stage == 0 || time >= start && end.is_some_and(|end| time <= end)
    };
    if !span.is_some_and(is_inside) {
        let (stage, time) = (state.stage, state.step.time);
        return Some(format!("its state of time {time} is not one of stages.{stage}"));
    }
    let [before, now] = [before, now].map(physics);
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
    if state.history.columns != case.columns() && with_columns(&state.history, case).is_none() {
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

/// In what the stages up to that of the state are other ones, in words. A run without stages goes
/// on as the first stage of one with stages, in which that changes nothing.
fn other_stages(state: &RunState, before: &Value, now: &Value) -> Option<String> {
    let stages = |of: &Value| of["stages"].as_array().cloned().unwrap_or_default();
    let (before, now) = (stages(before), stages(now));
    if before.is_empty() {
        let first = now.first()?;
        let is_plain = first.as_object().is_some_and(|keys| keys.len() == 1);
        let is_over = first["until"].as_f64().is_some_and(|until| until < state.step.time);
        return (!is_plain || is_over).then(|| {
            format!(
                "it has no stages and is at time {}; to go on with stages the first one says \
                 nothing but an `until` that is not before that",
                state.step.time
            )
        });
    }
    (0..=state.stage).find_map(|number| {
        let of = |stages: &[Value]| {
            stages.get(number).map_or_else(|| "nothing".to_owned(), Value::to_string)
        };
        let (before, now) = (of(&before), of(&now));
        (before != now).then(|| {
            format!(
                "`stages.{number}` is {before} there and {now} here; stages that have begun stay \
                 as they are, others may be added"
            )
        })
    })
}

/// The rows of an earlier run under the columns of a case that has more, as where later stages
/// have other supports: the new ones are empty. None where columns are lacking.
pub fn with_columns(history: &Table, case: &Case) -> Option<Table> {
    let columns = case.columns();
    let old: Vec<Option<usize>> = columns.iter().map(|name| history.column(name)).collect();
    let kept = old.iter().flatten().count();
    if kept < history.columns.len() || case.stages.is_empty() && kept < columns.len() {
        return None;
    }
    let row = |row: &Vec<Option<f64>>| old.iter().map(|at| row[(*at)?]).collect();
    Some(Table { rows: history.rows.iter().map(row).collect(), columns })
}

/// A resolved case without what may change from run to run: how it is solved, what is written and
/// checked, the instants, and the stages.
fn physics(mut case: Value) -> Value {
    if let Value::Object(sections) = &mut case {
        // Of how it is solved this alone changes what is solved.
        let lumped = sections.get("solver").and_then(|solver| solver.get("lumped_storage"));
        let lumped = lumped.cloned().unwrap_or(Value::Bool(false));
        for key in ["title", "solver", "output", "limits", "expect", "stages"] {
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
