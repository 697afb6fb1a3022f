//! The study file as it is written: its sections, keys and forms, from which the schema is made.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::Value as Json;

/// Study file of column-hpc: a family of cases, what is measured, and the charts.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct StudyFile {
    /// Title; default: the name of the file.
    pub title: Option<String>,
    /// The case that is varied; relative to the study file.
    pub base: String,
    /// What all runs change of it: dotted keys and values, as for --set; a value left empty takes
    /// the key away.
    #[serde(default)]
    pub set: BTreeMap<String, Json>,
    /// Whether the expectations of the base case hold for its variants.
    #[serde(default)]
    pub expect: Expect,
    /// What varies; every combination is run.
    #[serde(default)]
    #[schemars(length(max = 20))]
    pub axes: Vec<AxisSection>,
    /// Combinations that are not run: names of axes with a label each.
    #[serde(default)]
    pub skip: Vec<BTreeMap<String, Json>>,
    /// Runs besides, to compare with.
    #[serde(default)]
    pub references: Vec<ReferenceSection>,
    /// Ranks of every run, where no axis says otherwise.
    #[serde(default = "one")]
    #[schemars(range(min = 1, max = 1_000_000))]
    pub ranks: u64,
    /// How often each run is launched; the median counts.
    #[serde(default = "one")]
    #[schemars(range(min = 1, max = 1000))]
    pub repeats: u64,
    /// Wall-clock time of one launch, as 10 min or 90 s; it is ended after that.
    #[serde(default = "limit")]
    pub limit: String,
    /// How the program is launched; {ranks} stands for the number of ranks.
    #[serde(default = "launcher")]
    pub launcher: String,
    /// What is measured besides times, iterations and memory.
    #[serde(default)]
    #[schemars(length(max = 100))]
    pub measures: Vec<MeasureSection>,
    /// The charts.
    #[serde(default)]
    #[schemars(length(max = 100))]
    pub charts: Vec<ChartSection>,
    /// What is written.
    #[serde(default)]
    pub output: OutputSection,
}

fn one() -> u64 {
    1
}

fn limit() -> String {
    "10 min".to_owned()
}

fn launcher() -> String {
    "mpirun --quiet -n {ranks}".to_owned()
}

/// What becomes of the expectations of the base case.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum Expect {
    /// They are left out
    #[default]
    Drop,
    /// They hold: a run that misses one is told so
    Keep,
}

/// Something that varies.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct AxisSection {
    /// Its name.
    pub name: String,
    /// Unit of its numbers, for charts.
    pub unit: Option<String>,
    /// The dotted key of the case that takes `values`.
    pub key: Option<String>,
    /// The values of `key`.
    #[schemars(length(min = 1, max = 1000))]
    pub values: Option<Vec<Json>>,
    /// Instead: numbers of ranks.
    #[schemars(length(min = 1, max = 1000), inner(range(min = 1, max = 1_000_000)))]
    pub ranks: Option<Vec<u64>>,
    /// Instead: choices that set several keys together.
    #[schemars(length(min = 1, max = 1000))]
    pub choices: Option<Vec<ChoiceSection>>,
}

/// One of the choices of an axis.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ChoiceSection {
    /// Its name.
    pub label: String,
    /// Dotted keys of the case and their values.
    #[serde(default)]
    pub set: BTreeMap<String, Json>,
    /// Ranks.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub ranks: Option<u64>,
    /// The number it stands for on the axis of a chart.
    pub number: Option<f64>,
}

/// A run besides, to compare with.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ReferenceSection {
    /// Its name.
    pub name: String,
    /// Dotted keys of the case and their values.
    #[serde(default)]
    pub set: BTreeMap<String, Json>,
    /// Ranks.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub ranks: Option<u64>,
}

/// What is measured: the value of a column of history.csv, or its error.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MeasureSection {
    /// Its name: a column of study.csv.
    pub name: String,
    /// Unit, for charts.
    pub unit: Option<String>,
    /// A column of history.csv whose value is taken.
    pub value: Option<String>,
    /// A column of history.csv whose error is taken.
    pub error: Option<String>,
    /// The instant, several of them (the largest error counts), or `last`.
    pub at: AtSection,
    /// What an error is against.
    pub against: Option<AgainstSection>,
    /// Whether the error is over the largest reference value, or as it is.
    #[serde(default)]
    pub norm: Norm,
}

/// Instants.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum AtSection {
    /// The last row
    Last(LastWord),
    /// One instant.
    One(f64),
    /// Several instants.
    Several(#[schemars(length(min = 1, max = 10_000))] Vec<f64>),
}

/// The end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum LastWord {
    /// The last row
    Last,
}

/// What an error is divided by.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum Norm {
    /// The largest reference value
    #[default]
    Relative,
    /// Nothing
    Absolute,
}

/// What an error is against; one of the keys.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct AgainstSection {
    /// A number.
    pub equals: Option<f64>,
    /// A formula in t, the instant, and x, the number of the axis named by `x`.
    pub formula: Option<String>,
    /// The axis whose number is x in the formula.
    pub x: Option<String>,
    /// The axis whose number is y in the formula.
    pub y: Option<String>,
    /// A run of `references`.
    pub run: Option<String>,
    /// The run with these labels, and else the same as the one that is measured.
    pub axes: Option<BTreeMap<String, Json>>,
    /// A stored history.csv; relative to the study file.
    pub history: Option<String>,
}

/// A chart.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ChartSection {
    /// Name of its files.
    pub name: String,
    /// What it is.
    pub kind: Kind,
    /// Title.
    pub title: Option<String>,
    /// A sentence below it, on the page.
    pub note: Option<String>,
    /// Measure or axis along x.
    pub x: Option<String>,
    /// Measure or axis along y.
    pub y: Option<String>,
    /// Axes of which every combination of labels is a line.
    #[serde(default)]
    pub series: Vec<String>,
    /// Only runs with these labels.
    #[serde(default, rename = "where")]
    pub filter: BTreeMap<String, Json>,
    /// Label along x; default: name and unit.
    pub x_label: Option<String>,
    /// Label along y; default: name and unit.
    pub y_label: Option<String>,
    /// Scale along x.
    #[serde(default)]
    pub x_scale: Scale,
    /// Scale along y.
    #[serde(default)]
    pub y_scale: Scale,
    /// Whether the runs that no other beats in both measures are marked.
    #[serde(default)]
    pub pareto: bool,
    /// Whether the legend tells the fitted exponents.
    #[serde(default)]
    pub fit: bool,
}

/// Kinds of charts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum Kind {
    /// Points joined by lines
    Lines,
    /// Time and efficiency of one problem on more and more ranks
    StrongScaling,
    /// Time and efficiency of a problem that grows with the ranks
    WeakScaling,
    /// How runs ended, by two axes
    Map,
}

/// Scales of charts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum Scale {
    /// Logarithmic
    #[default]
    Log,
    /// Linear
    Linear,
}

/// What is written.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct OutputSection {
    /// The output directory; default: results/ and the name of the study file.
    pub directory: Option<String>,
    /// What is kept of each run.
    #[serde(default)]
    pub keep: Keep,
}

/// What is kept of each run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum Keep {
    /// history.csv and report.json
    #[default]
    Tables,
    /// Everything
    All,
}
