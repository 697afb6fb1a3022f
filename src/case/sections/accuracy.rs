//! Which results are wanted, and how exactly.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which results are wanted, and how exactly: the mesh, the steps and the tolerance follow.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AccuracySection {
    /// Columns of history.csv.
    #[schemars(length(min = 1, max = 100))]
    pub of: Vec<String>,
    /// The instants at which they are wanted.
    #[serde(default)]
    pub at: AccuracyInstants,
    /// The largest error, over the value at its instant or a hundredth of the largest value of all
    /// instants, whichever is more.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub relative: f64,
    /// What ends the search with the best answer so far.
    #[serde(default)]
    pub budget: AccuracyBudget,
}

/// Instants: a word, or a list.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum AccuracyInstants {
    /// A word.
    Word(AccuracyWord),
    /// Some of time.instants.
    Times(#[schemars(length(min = 1, max = 10_000))] Vec<f64>),
}

impl Default for AccuracyInstants {
    fn default() -> Self {
        Self::Word(AccuracyWord::All)
    }
}

/// Every instant or the last one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AccuracyWord {
    /// Every instant
    All,
    /// The last instant
    Last,
}

/// What ends a search.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AccuracyBudget {
    /// Wall-clock time in s times ranks, of all meshes; default: no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub core_seconds: Option<f64>,
    /// Most unknowns of a mesh.
    #[serde(default = "most_unknowns")]
    #[schemars(range(min = 1))]
    pub unknowns: u64,
}

fn most_unknowns() -> u64 {
    AccuracyBudget::default().unknowns
}

impl Default for AccuracyBudget {
    fn default() -> Self {
        Self { core_seconds: None, unknowns: 1_000_000 }
    }
}

impl AccuracySection {
    /// Columns of history.csv at all instants, up to a relative error.
    pub fn of(columns: impl IntoIterator<Item = impl Into<String>>, relative: f64) -> Self {
        let of = columns.into_iter().map(Into::into).collect();
        Self { of, at: AccuracyInstants::default(), relative, budget: AccuracyBudget::default() }
    }
}
