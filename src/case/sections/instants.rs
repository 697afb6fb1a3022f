//! Instants as the case file gives them: times, and ranges of times.

use schemars::JsonSchema;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

/// Most instants of a case.
const MOST: usize = 10_000;

/// A range of times, or a list of times and ranges.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum InstantsSection {
    // First: three times alone would also be the fields of a range.
    /// Times and ranges, one after the other.
    List(#[schemars(length(min = 1, max = 10_000))] Vec<InstantSection>),
    /// A range alone.
    Range(RangeSection),
}

/// A time or a range.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum InstantSection {
    /// A time in s.
    Time(f64),
    /// A range of times.
    Range(RangeSection),
}

/// Times at equal distances.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RangeSection {
    /// Where the range starts, in s, which is no instant of it.
    pub from: f64,
    /// The last instant, in s.
    pub to: f64,
    /// Number of instants.
    #[schemars(range(min = 1, max = 10_000))]
    pub steps: usize,
}

impl RangeSection {
    /// The times, the last one to the last bit.
    fn times(&self) -> impl Iterator<Item = f64> {
        let Self { from, to, steps } = *self;
        let at = move |k: usize| {
            if k == steps { to } else { from + (to - from) * (k as f64 / steps as f64) }
        };
        (1..=steps).map(at)
    }
}

/// Reads instants.
///
/// # Errors
/// That of the text, or that there are too many.
pub fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<f64>, D::Error> {
    let list = match InstantsSection::deserialize(deserializer)? {
        InstantsSection::Range(range) => vec![InstantSection::Range(range)],
        InstantsSection::List(list) => list,
    };
    let count: usize = list.iter().map(InstantSection::count).sum();
    if count > MOST {
        return Err(D::Error::custom(format!(
            "time.instants are {count}; at most {MOST} are taken"
        )));
    }
    let times = |one: InstantSection| -> Vec<f64> {
        match one {
            InstantSection::Time(time) => vec![time],
            InstantSection::Range(range) => range.times().collect(),
        }
    };
    Ok(list.into_iter().flat_map(times).collect())
}

impl InstantSection {
    fn count(&self) -> usize {
        match self {
            InstantSection::Time(_) => 1,
            InstantSection::Range(range) => range.steps,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(text: &str) -> Result<Vec<f64>, String> {
        let mut json = serde_json::Deserializer::from_str(text);
        read(&mut json).map_err(|error| error.to_string())
    }

    #[test]
    fn ranges_stand_for_their_times() {
        let even = times(r#"{"from": 0, "to": 1, "steps": 4}"#);
        assert_eq!(even, Ok(vec![0.25, 0.5, 0.75, 1.0]));
        let mixed = times(r#"[0.5, {"from": 0.5, "to": 0.8, "steps": 3}, 2]"#).expect("times");
        assert_eq!((mixed.len(), mixed[0], mixed[3], mixed[4]), (5, 0.5, 0.8, 2.0));
        assert_eq!(times("[1, 2, 3]"), Ok(vec![1.0, 2.0, 3.0]));
        let many = times(r#"[1, {"from": 1, "to": 2, "steps": 10000}]"#);
        assert!(many.is_err_and(|words| words.contains("10001; at most 10000")));
    }
}
