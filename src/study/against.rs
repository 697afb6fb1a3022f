//! What the error of a measure is against, checked.

use super::check::Checker;
use super::file::AgainstSection;
use super::spec::{Against, Axis, Reference};
use crate::input::Formula;
use crate::input::problems::suggestion;
use crate::output::history::Table;

impl Checker<'_> {
    /// What the measure of this index is compared with; none, and a mistake told, where that is not
    /// one thing.
    pub fn against(
        &mut self,
        index: &str,
        section: &AgainstSection,
        axes: &[Axis],
        references: &[Reference],
    ) -> Option<Against> {
        let AgainstSection { equals, formula, run, axes: labels, history, .. } = section;
        match (equals, formula, run, labels, history) {
            (Some(number), None, None, None, None) => Some(Against::Number(*number)),
            (None, Some(text), None, None, None) => self.by_formula(index, text, section, axes),
            (None, None, Some(name), None, None) => self.by_reference(index, name, references),
            (None, None, None, Some(labels), None) => {
                Some(Against::Axes(self.place(axes, &key(index, "axes"), labels)))
            }
            (None, None, None, None, Some(name)) => self.by_history(index, name),
            _ => {
                let what = "must have one of equals, formula, run, axes, history";
                let here = ["measures", index, "against"];
                self.add(&here, format!("measures.{index}.against {what}"));
                None
            }
        }
    }

    fn by_formula(
        &mut self,
        index: &str,
        text: &str,
        section: &AgainstSection,
        axes: &[Axis],
    ) -> Option<Against> {
        let mut named = |name: &str, axis: &Option<String>| match axis {
            Some(axis) => self.axis_named(axes, &key(index, name), axis).map(Some),
            None => Some(None),
        };
        let named = [named("x", &section.x)?, named("y", &section.y)?];
        match Formula::parse(text) {
            Ok(formula) => Some(Against::Formula(formula, named)),
            Err(reason) => {
                let what = format!("measures.{index}.against.formula: {reason}");
                self.add(&key(index, "formula"), what);
                None
            }
        }
    }

    fn by_reference(
        &mut self,
        index: &str,
        name: &str,
        references: &[Reference],
    ) -> Option<Against> {
        let found = references.iter().position(|reference| reference.name == name);
        if found.is_none() {
            let known: Vec<String> = references.iter().map(|r| r.name.clone()).collect();
            let hint = suggestion(name, &known);
            let what = format!("measures.{index}.against.run: `{name}` is no reference{hint}");
            self.add(&key(index, "run"), what);
        }
        found.map(Against::Reference)
    }

    fn by_history(&mut self, index: &str, name: &str) -> Option<Against> {
        let table = Table::read(&self.beside(name));
        table
            .map(Against::History)
            .map_err(|error| self.add(&key(index, "history"), error.to_string()))
            .ok()
    }
}

/// The steps to a key of what the measure of this index is compared with.
fn key<'a>(index: &'a str, name: &'a str) -> [&'a str; 4] {
    ["measures", index, "against", name]
}
