//! The study as checked types.

use std::path::PathBuf;
use std::time::Duration;

use super::file::{Kind, Scale};
use crate::input::Formula;
use crate::input::tree::Origin;
use crate::output::history::Table;

/// One `a.b.c=VALUE`, and where it was written.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Assignment {
    pub text: String,
    pub origin: Origin,
}

/// One value of an axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Choice {
    pub label: String,
    pub number: Option<f64>,
    pub ranks: Option<usize>,
    pub set: Vec<Assignment>,
}

/// Something that varies.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    pub name: String,
    pub unit: Option<String>,
    pub choices: Vec<Choice>,
}

/// A run besides, to compare with.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Reference {
    pub name: String,
    pub ranks: Option<usize>,
    pub set: Vec<Assignment>,
}

/// Instants.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum At {
    Last,
    Times(Vec<f64>),
}

/// What an error is against.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Against {
    Number(f64),
    /// A formula in t, and the axes whose numbers are x and y.
    Formula(Formula, [Option<usize>; 2]),
    /// The index of a reference.
    Reference(usize),
    /// Pairs of an axis and a choice of it.
    Axes(Vec<(usize, usize)>),
    History(Table),
}

/// What is measured in history.csv.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Measure {
    pub name: String,
    pub unit: Option<String>,
    pub column: String,
    pub at: At,
    /// None: the value itself.
    pub against: Option<Against>,
    pub relative: bool,
    pub origin: Origin,
}

/// What runs along an axis of a chart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Quantity {
    /// The index of an axis.
    Axis(usize),
    /// A column of the table of results.
    Measure(String),
}

/// A chart.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chart {
    pub name: String,
    pub kind: Kind,
    pub title: String,
    pub note: Option<String>,
    pub x: Quantity,
    pub y: Quantity,
    pub series: Vec<usize>,
    /// Pairs of an axis and a choice of it.
    pub filter: Vec<(usize, usize)>,
    pub x_label: String,
    pub y_label: String,
    pub log: [bool; 2],
    pub pareto: bool,
    pub fit: bool,
}

/// A checked study.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Study {
    pub path: PathBuf,
    pub text: String,
    pub title: String,
    pub base: PathBuf,
    pub base_text: String,
    /// What all runs change of the base case, the defaults of a study first.
    pub set: Vec<Assignment>,
    pub axes: Vec<Axis>,
    /// Each entry: pairs of an axis and a choice of it.
    pub skip: Vec<Vec<(usize, usize)>>,
    pub references: Vec<Reference>,
    pub ranks: usize,
    pub repeats: usize,
    pub limit: Duration,
    /// Words, of which `{ranks}` is the number of ranks.
    pub launcher: Vec<String>,
    pub measures: Vec<Measure>,
    pub charts: Vec<Chart>,
    pub directory: PathBuf,
    pub keep_all: bool,
}

impl Study {
    /// Name and unit of a measure.
    pub fn label_of(&self, measure: &str) -> String {
        self.label(&Quantity::Measure(measure.to_owned()))
    }

    /// Name and unit of a quantity, for charts.
    pub fn label(&self, quantity: &Quantity) -> String {
        let with = |name: &str, unit: Option<&str>| match unit {
            Some(unit) => format!("{} [{unit}]", name.replace('_', " ")),
            None => name.replace('_', " "),
        };
        match quantity {
            Quantity::Axis(axis) => with(&self.axes[*axis].name, self.axes[*axis].unit.as_deref()),
            Quantity::Measure(name) => {
                let own = self.measures.iter().find(|m| m.name == *name);
                let built_in = BUILT_IN.iter().find(|(known, ..)| known == name);
                match (own, built_in) {
                    (Some(measure), _) => with(name, measure.unit.as_deref()),
                    (None, Some((_, words, unit))) => {
                        with(words, Some(unit).filter(|u| !u.is_empty()).copied())
                    }
                    (None, None) => with(name, None),
                }
            }
        }
    }
}

/// What is measured of every run: name, words and unit.
pub(super) const BUILT_IN: [(&str, &str, &str); 9] = [
    ("wall_seconds", "wall time", "s"),
    ("core_seconds", "core-seconds", "s"),
    ("solve_seconds", "time of the solution", "s"),
    ("memory_mb", "memory of all ranks", "MB"),
    ("cells", "cells", ""),
    ("unknowns", "unknowns", ""),
    ("corrections", "corrections", ""),
    ("iterations", "linear iterations", ""),
    ("iterations_per_correction", "linear iterations per correction", ""),
];

/// Whether the axes of a chart are logarithmic.
pub(super) fn is_log(scale: Scale) -> bool {
    scale == Scale::Log
}
