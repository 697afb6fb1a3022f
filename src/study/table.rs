//! `study.csv` and `study.json`.

use std::fs;
use std::path::Path;

use serde_json::{Value as Json, json};

use super::measure::Row;
use super::plan::Plan;
use super::record::{Record, cores, machine_memory};
use super::spec::{BUILT_IN, Study};
use crate::error::{Error, Result};
use crate::output::atomic;
use crate::report::versions;

/// Name of the table.
pub(super) const TABLE: &str = "study.csv";
/// Name of everything that is known; it marks the directory of a study.
pub(super) const EVERYTHING: &str = "study.json";

/// Measures that differ from launch to launch.
const SPREAD: [&str; 4] = ["wall_seconds", "core_seconds", "solve_seconds", "memory_mb"];

/// Names of all measures in the order of the table.
pub(super) fn measures(study: &Study) -> Vec<String> {
    let built_in = BUILT_IN.iter().map(|(name, ..)| (*name).to_owned());
    study.measures.iter().map(|m| m.name.clone()).chain(built_in).collect()
}

/// Writes `study.csv`: a row for each run.
///
/// # Errors
/// `System` with the path and the reason.
pub(super) fn write_table(study: &Study, plan: &Plan, rows: &[Row], path: &Path) -> Result<()> {
    let failed = |cause: &dyn std::fmt::Display| Error::Bug(format!("table of the study: {cause}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    let own_ranks = study.axes.iter().any(|axis| axis.name == "ranks");
    let names = measures(study);
    let mut head = vec!["run".to_owned()];
    head.extend(study.axes.iter().map(|axis| axis.name.clone()));
    head.extend((!own_ranks).then(|| "ranks".to_owned()));
    head.extend(["status", "repeats"].map(str::to_owned));
    for name in &names {
        head.push(name.clone());
        if SPREAD.contains(&name.as_str()) {
            head.extend(["q1", "q3"].map(|quartile| format!("{name}.{quartile}")));
        }
    }
    head.extend(["message", "directory"].map(str::to_owned));
    writer.write_record(&head).map_err(|e| failed(&e))?;
    for row in rows {
        let run = &plan.runs[row.run];
        let mut fields = vec![run.name.clone()];
        fields.extend(study.axes.iter().enumerate().map(|(axis, of)| {
            run.choices.get(axis).map_or_else(String::new, |c| of.choices[*c].label.clone())
        }));
        fields.extend((!own_ranks).then(|| run.ranks.to_string()));
        fields.push(row.status.map_or_else(|| "not_run".to_owned(), |status| status.name()));
        fields.push(row.launches.to_string());
        for name in &names {
            let found = row.values.get(name);
            let text = |index: usize| found.map_or_else(String::new, |q| format!("{:e}", q[index]));
            fields.push(text(1));
            if SPREAD.contains(&name.as_str()) {
                fields.extend([text(0), text(2)]);
            }
        }
        fields.extend([row.message.replace('\n', "; "), format!("runs/{}", run.directory)]);
        writer.write_record(&fields).map_err(|e| failed(&e))?;
    }
    let bytes = writer.into_inner().map_err(|e| failed(&e))?;
    atomic::write_text(path, &String::from_utf8_lossy(&bytes))
}

/// Writes `study.json`.
///
/// # Errors
/// `System` with the path and the reason.
pub(super) fn write_everything(
    study: &Study,
    plan: &Plan,
    rows: &[Row],
    records: &[Record],
    path: &Path,
) -> Result<()> {
    let runs: Vec<Json> = rows
        .iter()
        .map(|row| {
            let (run, record) = (&plan.runs[row.run], &records[row.run]);
            let labels: Vec<(String, Json)> = run
                .choices
                .iter()
                .zip(&study.axes)
                .map(|(choice, axis)| {
                    (axis.name.clone(), axis.choices[*choice].label.clone().into())
                })
                .collect();
            let medians: serde_json::Map<String, Json> =
                row.values.iter().map(|(name, q)| (name.clone(), q[1].into())).collect();
            json!({
                "run": run.name,
                "axes": labels.into_iter().collect::<serde_json::Map<_, _>>(),
                "reference": row.run < plan.references,
                "ranks": run.ranks,
                "overrides": run.overrides,
                "directory": format!("runs/{}", run.directory),
                "status": row.status,
                "message": row.message,
                "measures": medians,
                "launches": record.launches,
                "version": record.version,
            })
        })
        .collect();
    let everything = json!({
        "title": study.title,
        "study": study.text,
        "base": study.base_text,
        "runs": runs,
        "versions": versions(),
        "machine": machine(),
    });
    let text = serde_json::to_string_pretty(&everything)
        .map_err(|cause| Error::Bug(format!("study: {cause}")))?;
    atomic::write_text(path, &(text + "\n"))
}

/// The machine: processor, cores, memory.
pub(super) fn machine() -> Json {
    let processor = fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    json!({
        "processor": processor,
        "cores": cores(),
        "memory_bytes": machine_memory(),
        "system": fs::read_to_string("/proc/sys/kernel/osrelease").ok().map(|t| t.trim().to_owned()),
    })
}
