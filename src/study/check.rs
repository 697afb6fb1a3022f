//! From the study file as it is written to checked types.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde_json::Value as Json;

use super::file::{
    AtSection, AxisSection, Expect, Keep, MeasureSection, Norm, ReferenceSection, StudyFile,
};
use super::spec::{Assignment, At, Axis, BUILT_IN, Choice, Measure, Reference, Study};
use super::words::{assignment, label, number_of, size};
use crate::case::read_text;
use crate::input::duration::seconds;
use crate::input::problems::{Problems, suggestion};
use crate::input::tree::Node;

/// Pairs of an axis and a choice of it.
pub(super) type Place = Vec<(usize, usize)>;

pub(super) struct Checker<'a> {
    pub tree: &'a Node,
    pub path: &'a Path,
    pub problems: Problems<'a>,
}

impl Checker<'_> {
    /// The study without its charts; mistakes are added to the problems.
    pub fn study(&mut self, file: StudyFile, text: String) -> Study {
        let base = self.beside(&file.base);
        let base_text = read_text(&base).unwrap_or_else(|error| {
            self.add(&["base"], error.to_string());
            String::new()
        });
        let mut set = self.defaults(file.expect);
        set.extend(self.assignments(&["set"], &file.set));
        let axes: Vec<Axis> =
            file.axes.iter().enumerate().map(|(index, axis)| self.axis(index, axis)).collect();
        self.names(&axes);
        let mut skip = Vec::new();
        for (index, entry) in file.skip.iter().enumerate() {
            skip.push(self.place(&axes, &["skip", &index.to_string()], entry));
        }
        let references = self.references(&file.references);
        let limit = seconds(&file.limit).unwrap_or_else(|reason| {
            self.add(&["limit"], format!("limit {reason}"));
            1.0
        });
        let launcher: Vec<String> = file.launcher.split_whitespace().map(str::to_owned).collect();
        if launcher.is_empty() {
            self.add(&["launcher"], "launcher is empty".to_owned());
        }
        let measures = self.measures(&file.measures, &axes, &references);
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let directory = match &file.output.directory {
            Some(directory) => PathBuf::from(directory),
            None => Path::new("results").join(&stem),
        };
        Study {
            path: self.path.to_path_buf(),
            text,
            title: file.title.unwrap_or(stem),
            base,
            base_text,
            set,
            axes,
            skip,
            references,
            ranks: size(file.ranks),
            repeats: size(file.repeats),
            limit: Duration::from_secs_f64(limit.min(1e9)),
            launcher,
            measures,
            charts: Vec::new(),
            directory,
            keep_all: file.output.keep == Keep::All,
        }
    }

    /// Adds a mistake at the place of these steps.
    pub fn add(&mut self, steps: &[&str], text: String) {
        self.problems.at(self.tree.locate_key(steps.iter().copied()), text);
    }

    /// A path that is relative to the study file.
    pub fn beside(&self, name: &str) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(name)
    }

    /// What all runs change of the base case without being told.
    fn defaults(&self, expect: Expect) -> Vec<Assignment> {
        let defaults = ["output.fields=none", "expect=[]"];
        let kept = if expect == Expect::Keep { 1 } else { 2 };
        let origin = self.tree.origin;
        defaults[..kept]
            .iter()
            .map(|text| Assignment { text: (*text).to_owned(), origin })
            .collect()
    }

    fn references(&self, sections: &[ReferenceSection]) -> Vec<Reference> {
        sections
            .iter()
            .enumerate()
            .map(|(index, section)| Reference {
                name: section.name.clone(),
                ranks: section.ranks.map(size),
                set: self.assignments(&["references", &index.to_string(), "set"], &section.set),
            })
            .collect()
    }

    fn assignments(&self, steps: &[&str], set: &BTreeMap<String, Json>) -> Vec<Assignment> {
        let one = |(key, value): (&String, &Json)| {
            let origin = self.tree.locate_key([steps, &[key.as_str()]].concat());
            Assignment { text: assignment(key, value), origin }
        };
        set.iter().map(one).collect()
    }

    fn axis(&mut self, index: usize, section: &AxisSection) -> Axis {
        let index = index.to_string();
        let here = ["axes", index.as_str()];
        let mut choices = Vec::new();
        match (&section.key, &section.values, &section.ranks, &section.choices) {
            (Some(key), Some(values), None, None) => {
                for (number, value) in values.iter().enumerate() {
                    let origin =
                        self.tree.locate_key(["axes", &index, "values", &number.to_string()]);
                    choices.push(Choice {
                        label: label(value),
                        number: number_of(value),
                        ranks: None,
                        set: vec![Assignment { text: assignment(key, value), origin }],
                    });
                }
            }
            (None, None, Some(ranks), None) => choices.extend(ranks.iter().map(|ranks| Choice {
                label: ranks.to_string(),
                number: Some(*ranks as f64),
                ranks: Some(size(*ranks)),
                set: Vec::new(),
            })),
            (None, None, None, Some(sections)) => {
                for (number, choice) in sections.iter().enumerate() {
                    let steps = ["axes", &index, "choices", &number.to_string(), "set"];
                    choices.push(Choice {
                        label: choice.label.clone(),
                        number: choice.number.or(choice.label.parse().ok()),
                        ranks: choice.ranks.map(size),
                        set: self.assignments(&steps, &choice.set),
                    });
                }
            }
            _ => self
                .add(&here, format!("axes.{index} must have key and values, or ranks, or choices")),
        }
        for (number, choice) in choices.iter().enumerate() {
            if choices[..number].iter().any(|other| other.label == choice.label) {
                self.add(&here, format!("axes.{index} has `{}` twice", choice.label));
            }
        }
        Axis { name: section.name.clone(), unit: section.unit.clone(), choices }
    }

    /// Refuses names of axes that are not told apart.
    fn names(&mut self, axes: &[Axis]) {
        for (index, axis) in axes.iter().enumerate() {
            let taken = axes[..index].iter().any(|other| other.name == axis.name)
                || BUILT_IN.iter().any(|(name, ..)| *name == axis.name)
                || ["status", "run", "repeats", "directory"].contains(&axis.name.as_str());
            if taken {
                let what = format!("axes.{index}.name: `{}` is taken", axis.name);
                self.add(&["axes", &index.to_string(), "name"], what);
            }
        }
    }

    /// The axis of a name.
    pub fn axis_named(&mut self, axes: &[Axis], steps: &[&str], name: &str) -> Option<usize> {
        let found = axes.iter().position(|axis| axis.name == name);
        if found.is_none() {
            let known: Vec<String> = axes.iter().map(|axis| axis.name.clone()).collect();
            let hint = suggestion(name, &known);
            self.add(steps, format!("{}: `{name}` is no axis{hint}", steps.join(".")));
        }
        found
    }

    /// Names of axes with a label each.
    pub fn place(
        &mut self,
        axes: &[Axis],
        steps: &[&str],
        entry: &BTreeMap<String, Json>,
    ) -> Place {
        let mut place = Vec::new();
        for (name, value) in entry {
            let here = [steps, &[name.as_str()]].concat();
            let Some(axis) = self.axis_named(axes, &here, name) else { continue };
            let wanted = label(value);
            match axes[axis].choices.iter().position(|choice| choice.label == wanted) {
                Some(choice) => place.push((axis, choice)),
                None => {
                    let known: Vec<String> =
                        axes[axis].choices.iter().map(|choice| choice.label.clone()).collect();
                    let hint = suggestion(&wanted, &known);
                    self.add(&here, format!("{}: `{wanted}` is no value{hint}", here.join(".")));
                }
            }
        }
        place
    }

    fn measures(
        &mut self,
        sections: &[MeasureSection],
        axes: &[Axis],
        references: &[Reference],
    ) -> Vec<Measure> {
        let mut measures: Vec<Measure> = Vec::new();
        for (index, section) in sections.iter().enumerate() {
            let index = index.to_string();
            let taken = measures.iter().any(|m| m.name == section.name)
                || BUILT_IN.iter().any(|(name, ..)| *name == section.name)
                || axes.iter().any(|axis| axis.name == section.name);
            if taken {
                let what = format!("measures.{index}.name: `{}` is taken", section.name);
                self.add(&["measures", &index, "name"], what);
            }
            measures.extend(self.measure(&index, section, axes, references));
        }
        measures
    }

    fn measure(
        &mut self,
        index: &str,
        section: &MeasureSection,
        axes: &[Axis],
        references: &[Reference],
    ) -> Option<Measure> {
        let here = ["measures", index];
        let (column, against) = match (&section.value, &section.error, &section.against) {
            (Some(column), None, None) => (column, None),
            (None, Some(column), Some(against)) => {
                (column, Some(self.against(index, against, axes, references)?))
            }
            _ => {
                let what = "must have value, or error and against";
                self.add(&here, format!("measures.{index} {what}"));
                return None;
            }
        };
        let at = match &section.at {
            AtSection::Last(_) => At::Last,
            AtSection::One(time) => At::Times(vec![*time]),
            AtSection::Several(times) => At::Times(times.clone()),
        };
        if section.value.is_some() && matches!(&at, At::Times(times) if times.len() > 1) {
            let what = format!("measures.{index}.at must be one instant for a value");
            self.add(&["measures", index, "at"], what);
        }
        let word = if section.value.is_some() { "value" } else { "error" };
        Some(Measure {
            name: section.name.clone(),
            unit: section.unit.clone(),
            column: column.clone(),
            at,
            against,
            relative: section.norm == Norm::Relative,
            origin: self.tree.locate_key(["measures", index, word]),
        })
    }
}
