//! Tables for the screen, as text of fixed width.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;

use super::expectations::Outcome;
use crate::output::history::Table;
use crate::timers::Timings;

/// What is told of one accepted instant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Instant {
    /// Time in s.
    pub time: Option<f64>,
    /// Linearised corrections.
    pub newton_iterations: Option<f64>,
    /// Iterations of the linear solver.
    pub linear_iterations: Option<f64>,
    /// By name of interface.
    pub interfaces: BTreeMap<String, InterfaceState>,
}

/// What is told of an interface at an instant; none without multiplier nodes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct InterfaceState {
    /// Mean normal traction in Pa.
    pub normal_traction_mean: Option<f64>,
    /// Mean normal jump in m.
    pub normal_jump_mean: Option<f64>,
    /// Largest damage.
    pub damage_max: Option<f64>,
}

/// The instants of a history from row `first` on.
pub fn instants(history: &Table, interfaces: &[String], first: usize) -> Vec<Instant> {
    history
        .rows
        .iter()
        .skip(first)
        .map(|row| {
            let value = |name: &str| row[history.column(name)?];
            let state = |name: &String| InterfaceState {
                normal_traction_mean: value(&format!("{name}.normal_traction.mean")),
                normal_jump_mean: value(&format!("{name}.normal_jump.mean")),
                damage_max: value(&format!("{name}.damage.max")),
            };
            Instant {
                time: value("time"),
                newton_iterations: value("newton_iterations"),
                linear_iterations: value("linear_iterations"),
                interfaces: interfaces.iter().map(|name| (name.clone(), state(name))).collect(),
            }
        })
        .collect()
}

/// The two lines above the lines of [`instant_line`].
pub fn instant_header(interfaces: &[String]) -> String {
    let mut above = format!("{:>12} {:>6} {:>7}", "", "", "");
    let mut names = format!("{:>12} {:>6} {:>7}", "time", "newton", "linear");
    for name in interfaces {
        let _ = write!(above, "  {name:^38}");
        let _ = write!(names, "  {:>14} {:>14} {:>8}", "traction mean", "jump mean", "damage");
    }
    format!("{}\n{names}", above.trim_end())
}

/// One instant: time, iterations, then of each interface mean normal traction, mean normal jump and
/// largest damage, in the order of `interfaces`.
pub fn instant_line(instant: &Instant, interfaces: &[String]) -> String {
    let count = |v: Option<f64>| v.map_or("-".into(), |v| format!("{v:.0}"));
    let mut line = format!(
        "{:>12} {:>6} {:>7}",
        instant.time.map_or("-".into(), |t| format!("{t:.6}")),
        count(instant.newton_iterations),
        count(instant.linear_iterations)
    );
    for state in interfaces.iter().map(|name| instant.interfaces.get(name)) {
        let number = |v: Option<f64>| v.map_or("-".into(), |v| format!("{v:.6e}"));
        let _ = write!(
            line,
            "  {:>14} {:>14} {:>8}",
            number(state.and_then(|s| s.normal_traction_mean)),
            number(state.and_then(|s| s.normal_jump_mean)),
            state.and_then(|s| s.damage_max).map_or("-".into(), |d| format!("{d:.4}"))
        );
    }
    line
}

/// Header and one line per expectation; empty without any.
pub fn expectations(outcomes: &[Outcome]) -> String {
    if outcomes.is_empty() {
        return String::new();
    }
    let width = outcomes.iter().map(|o| o.quantity.chars().count()).max().unwrap_or(0).max(8);
    let mut text = format!(
        "{:<width$} {:>10} {:>20} {:>20} {:>11} {:>11}  met\n",
        "quantity", "at", "value", "expected", "error", "tolerance"
    );
    for o in outcomes {
        let value = o.value.map_or("-".into(), |v| format!("{v:.12e}"));
        let error = o.error.map_or("-".into(), |v| format!("{v:.3e}"));
        let met = if o.met { "yes" } else { "NO" };
        let note = o.note.as_ref().map(|n| format!(" ({n})")).unwrap_or_default();
        let _ = writeln!(
            text,
            "{:<width$} {:>10} {value:>20} {:>20} {error:>11} {:>11}  {met}{note}",
            o.quantity,
            o.at,
            format!("{:.12e}", o.equals),
            format!("{:.3e}", o.tolerance)
        );
    }
    text
}

/// One line per phase with its share of the total.
pub fn times(timings: &Timings) -> String {
    let t = timings;
    let mut text = format!("{:<10} {:>10} {:>7}\n", "phase", "seconds", "share");
    for (name, seconds) in [
        ("mesh", t.mesh),
        ("partition", t.partition),
        ("assembly", t.assembly),
        ("solve", t.solve),
        ("output", t.output),
        ("total", t.total),
    ] {
        let share = if t.total > 0.0 { 100.0 * seconds / t.total } else { 0.0 };
        let _ = writeln!(text, "{name:<10} {seconds:>10.3} {share:>6.1}%");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_come_from_the_history_and_line_up() {
        let columns = [
            "time",
            "newton_iterations",
            "linear_iterations",
            "joint.normal_traction.mean",
            "joint.normal_jump.mean",
            "joint.damage.max",
        ];
        let history = Table {
            columns: columns.map(String::from).to_vec(),
            rows: vec![
                vec![Some(1.0), Some(3.0), Some(40.0), Some(1_017_312.07), Some(1e-4), Some(0.25)],
                vec![Some(2.0), Some(2.0), Some(9.0), None, None, None],
            ],
        };
        let interfaces = ["joint".to_string()];
        let found = instants(&history, &interfaces, 0);
        assert_eq!(found[0].interfaces["joint"].normal_traction_mean, Some(1_017_312.07));
        assert_eq!(found[1].interfaces["joint"].damage_max, None);
        let header = instant_header(&interfaces);
        let lines: Vec<_> = found.iter().map(|i| instant_line(i, &interfaces)).collect();
        let width = header.lines().last().unwrap().len();
        assert!(lines.iter().all(|l| l.len() == width), "{header}\n{}", lines.join("\n"));
        assert!(lines[0].contains("1.017312e6") && lines[0].contains("0.2500"), "{}", lines[0]);
    }

    #[test]
    fn a_missed_expectation_stands_out_with_its_reason() {
        let missed = Outcome {
            quantity: "joint.normal_traction".into(),
            at: 3.0,
            equals: 1.0e6,
            value: None,
            error: None,
            tolerance: 1.0,
            met: false,
            note: Some("the history has no row at 3".into()),
        };
        let text = expectations(std::slice::from_ref(&missed));
        assert!(
            text.lines().last().unwrap().ends_with("NO (the history has no row at 3)"),
            "{text}"
        );
        assert_eq!(expectations(&[]), "");
    }

    #[test]
    fn shares_are_of_the_total() {
        let text = times(&Timings { solve: 1.5, total: 2.0, ..Timings::default() });
        assert!(text.contains("solve           1.500   75.0%"), "{text}");
    }
}
