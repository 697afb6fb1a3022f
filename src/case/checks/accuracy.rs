//! Which results are wanted, and how exactly.

use super::checker::Checker;
use crate::case::sections::AccuracyInstants;
use crate::case::{Case, Expectation};
use crate::input::problems::{shortened, suggestion};

/// Columns that no mesh makes more exact.
const COUNTS: [&str; 4] = ["time", "load_factor", "newton_iterations", "linear_iterations"];

impl Checker<'_> {
    /// What is wanted of the results, and what they must be.
    pub(super) fn wanted(&mut self, case: &Case) -> Vec<Expectation> {
        self.history(case);
        self.accuracy(case);
        self.expectations(case)
    }

    /// What is wanted must be there.
    fn accuracy(&mut self, case: &Case) {
        let Some(section) = &case.file.accuracy else { return };
        // That of the whole case has been looked at.
        if self.end_of_stage.is_some() {
            return;
        }
        let mut columns = case.columns();
        columns.retain(|column| !COUNTS.contains(&column.as_str()));
        if self.sound(&["interfaces", "boundary", "probes", "mesh"]) {
            for (number, name) in section.of.iter().enumerate() {
                if !columns.contains(name) {
                    let base: Vec<String> = columns
                        .iter()
                        .map(|column| column.replace(".min", ".{min,max,mean}"))
                        .filter(|column| !column.ends_with(".max") && !column.ends_with(".mean"))
                        .collect();
                    let reason = format!(
                        "cannot be `{}`: it is no result of the run{}",
                        shortened(name),
                        suggestion(name, &base)
                    );
                    self.add(&format!("accuracy.of.{number}"), reason);
                }
            }
        }
        if let AccuracyInstants::Times(times) = &section.at {
            for (number, time) in times.iter().enumerate() {
                self.instant(&format!("accuracy.at.{number}"), *time, &case.time);
            }
        }
        if case.mesh.refine > 0 && case.mesh.column().is_some() {
            let reason = "cannot stand beside accuracy, which finds the cells";
            self.add("mesh.refine", reason);
        }
        let column = case.file.mesh.column.as_ref();
        if column.is_some_and(|column| column.grading.is_some()) {
            let reason = "cannot stand beside accuracy, which finds how cells grow";
            self.add("mesh.column.grading", reason);
        }
    }
}
