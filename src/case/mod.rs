//! The case file as checked types: whatever is in a [`Case`] can be computed.
//!
//! A case comes from the text of a file ([`Case::read`]) or from [`sections`] that are built in
//! code ([`Case::build`]).

mod bodies;
mod build;
mod checked;
mod checks;
mod schema;
pub mod sections;
mod stages;

pub use crate::input::{Formula, Value};
pub use crate::law::LawSpec;
pub use checked::{Case, Search, Stage};
pub use checks::{
    AtRest, BULK, CLOSEST_PLANES, Control, ControlKind, Every, FlowSpec, Imperfection,
};
pub use checks::{InterfaceQuantity, NodeStart, PhysicsDecision, StressSpec};
pub use schema::schema;
pub use sections::{BoundarySpec, Cells, ColumnSpec, Expectation, Fields, FileSpec, FilmSpec};
pub use sections::{Form, Formulation, InterfaceSpec, Linear, Location, Material, MeshSource};
pub use sections::{Gap, Side, SolverSpec, Stability, Surface, SurfaceBit};
pub use sections::{MeshSpec, Motion, OutputSpec, Porous, Probe, Reduce, RigidSpec};
pub use sections::{column_axes, turned};

use std::collections::BTreeSet;
use std::path::Path;

use crate::error::{Error, Result};
use crate::input::problems::Problems;
use crate::input::text::{LARGEST, read_text_of};
use crate::input::tree::{self, Data, Node, Origin};
use checks::Checker;
use sections::CaseFile;

/// Most overrides.
const MOST_OVERRIDES: usize = 1000;

impl Case {
    /// Reads a case from the text of its file; every rank that reads the same text gets the same.
    ///
    /// `path` is for messages and the defaults of title and output directory; nothing is read
    /// from it. `overrides` are `a.b.c=VALUE` with YAML values, applied in order: missing sections
    /// are created, list items are numbered from 0, an empty VALUE takes the key away. Local.
    ///
    /// # Errors
    /// [`Error::Input`] with one line for each mistake: file, line, column, path, reason.
    pub fn read(text: &str, path: &Path, overrides: &[String]) -> Result<Case> {
        let mut problems = Problems::new(path, overrides);
        let mut tree = tree::parse(text).map_err(|error| {
            let place =
                error.place.map_or(String::new(), |(line, column)| format!("{line}:{column}:"));
            Error::Input(format!("{}:{place} {}", path.display(), error.reason))
        })?;
        if tree.data == Data::Empty && overrides.is_empty() {
            return Err(Error::Input(format!(
                "{}: the case file is empty; cases/wtnv146/case.yaml is an example",
                path.display()
            )));
        }
        check_overrides(overrides)?;
        for (number, assignment) in overrides.iter().enumerate() {
            if let Err(reason) = tree.set(assignment, number) {
                problems.at(Origin::Override(number), reason);
            }
        }
        read_tree(tree, path, problems, None)
    }

    /// The times between start and end, rising, at which a table bends or a step is to end: no step
    /// passes over one.
    pub fn breakpoints(&self) -> Vec<f64> {
        let of_interfaces = self.interfaces.iter().filter_map(|i| i.fluid_pressure.as_ref());
        let of_boundary =
            self.boundary.iter().flat_map(|b| b.displacement.iter().chain(&b.traction));
        let along_normals =
            self.boundary.iter().flat_map(|b| [&b.normal_displacement, &b.normal_traction]);
        let mut values: Vec<&Value> = of_boundary.chain(along_normals).flatten().collect();
        values.extend(self.boundary.iter().flat_map(|b| &b.rigid).flat_map(RigidSpec::values));
        if self.has_pressure() {
            values.extend(self.boundary.iter().flat_map(|b| b.pressure.iter().chain(&b.flux)));
            let films = self.interfaces.iter().filter_map(|i| i.film.as_ref());
            values.extend(films.filter_map(|film| film.injection.as_ref()));
        }
        values.extend(of_interfaces.chain(&self.body_force));
        match self.control.as_ref().map(|control| &control.kind) {
            // The loads are those of one time.
            Some(ControlKind::Dissipation(_)) => return Vec::new(),
            Some(ControlKind::Opening(equals)) => values.push(equals),
            None => {}
        }
        let mut times: Vec<f64> = values.iter().flat_map(|value| value.breakpoints()).collect();
        times.extend(&self.search.stops);
        times.retain(|time| self.start < *time && self.time.last().is_some_and(|end| time < end));
        times.sort_by(f64::total_cmp);
        times.dedup();
        times
    }

    /// The times at which loads and prescribed displacements are evaluated.
    pub fn load_times(&self) -> Vec<f64> {
        let of = |time: &f64| self.control.as_ref().map_or(*time, |c| c.load_time(*time));
        let mut times: Vec<f64> = self.time.iter().map(of).chain(self.breakpoints()).collect();
        times.extend(self.starts_in_equilibrium().then_some(self.start));
        times.sort_by(f64::total_cmp);
        times.dedup();
        times
    }

    /// The case as a case file with every default written out.
    pub fn resolved(&self) -> serde_json::Value {
        // Every key is a string and every number finite, so that nothing can fail.
        serde_json::to_value(&self.file).expect("a checked case is valid JSON")
    }
}

/// The case of a tree in which `problems` have been found so far; of a mesh file that has been read
/// with its dimension.
fn read_tree(
    mut tree: Node,
    path: &Path,
    mut problems: Problems,
    dim_of_file: Option<usize>,
) -> Result<Case> {
    let broken = schema::check(&mut tree, &mut problems);
    let file = match sections_of(&tree, &broken, path) {
        Ok(file) => file,
        Err(error) if problems.is_empty() => return Err(error),
        Err(_) => return Err(problems.into_error()),
    };
    if !file.stages.is_empty() {
        return stages::case(&tree, file, path, problems, broken, dim_of_file);
    }
    Checker::new(&tree, problems, broken, dim_of_file).case(file, path)
}

/// The sections of a tree, with placeholders for those that are broken.
fn sections_of(tree: &Node, broken: &BTreeSet<String>, path: &Path) -> Result<CaseFile> {
    serde_json::from_value(readable(tree, broken))
        .map_err(|error| Error::Input(format!("{}: {error}", path.display())))
}

/// Refuses more overrides than anyone types.
fn check_overrides(overrides: &[String]) -> Result<()> {
    let bytes: usize = overrides.iter().map(String::len).sum();
    if overrides.len() > MOST_OVERRIDES {
        let count = overrides.len();
        return Err(Error::Input(format!(
            "--set is given {count} times; at most {MOST_OVERRIDES}"
        )));
    }
    if bytes as u64 > LARGEST {
        return Err(Error::Input(format!(
            "--set: {bytes} bytes are given in all; at most {LARGEST} are read"
        )));
    }
    Ok(())
}

/// The tree with placeholders for sections that cannot be read, so that the others are checked.
fn readable(tree: &Node, broken: &BTreeSet<String>) -> serde_json::Value {
    let mut sections = tree.to_json();
    if let Some(object) = sections.as_object_mut() {
        for section in broken {
            let placeholder = match section.as_str() {
                "mesh" => serde_json::json!({"column": {"size": [1, 1], "cells": [1, 1]}}),
                "materials" => serde_json::json!({}),
                "time" => serde_json::json!({"instants": []}),
                _ => {
                    object.remove(section);
                    continue;
                }
            };
            object.insert(section.clone(), placeholder);
        }
    }
    sections
}

/// Reads the text of a case file.
///
/// # Errors
/// [`Error::Input`] when it is missing, unreadable, a directory, too large or not UTF-8.
pub fn read_text(path: &Path) -> Result<String> {
    read_text_of("case file", path)
}

#[cfg(test)]
mod tests;
