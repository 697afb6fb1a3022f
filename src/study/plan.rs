//! The runs of a study, each checked before the first is launched.

use std::collections::{BTreeMap, BTreeSet};

use super::spec::{Against, Assignment, At, Study};
use super::words::{placed, refuse};
use crate::case::Case;
use crate::error::{Error, Result};
use crate::input::problems::{shortened, suggestion};
use crate::input::tree::Origin;

/// Most runs of a study.
const MOST_RUNS: usize = 100_000;
/// Most mistakes that are listed.
const LISTED: usize = 20;
/// Longest readable part of the name of a run's directory.
const LONGEST_NAME: usize = 60;

/// One run of a study.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Run {
    /// The choice on every axis; empty for a reference.
    pub choices: Vec<usize>,
    /// What it is called: `order=2, cells=4x4x20`.
    pub name: String,
    pub ranks: usize,
    /// `a.b.c=VALUE`, in the order in which they are applied.
    pub overrides: Vec<String>,
    /// What determines its results, as a number of 16 digits.
    pub key: String,
    /// Name of its directory below `runs`.
    pub directory: String,
}

/// All runs: the references, then every combination that is not skipped, the last axis fastest.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plan {
    pub runs: Vec<Run>,
    /// How many of them are references.
    pub references: usize,
}

impl Plan {
    /// Lists the runs and reads the case of each with its overrides.
    ///
    /// # Errors
    /// [`Error::Input`] with one line for each mistake, and the run it was found in.
    pub fn new(study: &Study, version: &str) -> Result<Plan> {
        let plan = Self::listed(study, version)?;
        plan.check(study)?;
        Ok(plan)
    }

    fn listed(study: &Study, version: &str) -> Result<Plan> {
        let all = study.axes.iter().try_fold(1_usize, |n, axis| n.checked_mul(axis.choices.len()));
        let Some(count) = all.filter(|count| *count <= MOST_RUNS) else {
            return Err(Error::Input(format!(
                "{}: the axes have more than {MOST_RUNS} combinations",
                study.path.display()
            )));
        };
        let base = fnv(study.base_text.as_bytes(), FNV_START);
        let run = |choices: Vec<usize>, name: String, ranks: usize, set: Vec<&Assignment>| {
            let overrides: Vec<String> = set.iter().map(|a| a.text.clone()).collect();
            let key = key_of(base, &overrides, ranks, version);
            let directory = format!("{}.{key}", readable(&name));
            Run { choices, name, ranks, overrides, key, directory }
        };
        let mut runs: Vec<Run> = Vec::new();
        for reference in &study.references {
            let set = study.set.iter().chain(&reference.set).collect();
            let ranks = reference.ranks.unwrap_or(study.ranks);
            runs.push(run(Vec::new(), reference.name.clone(), ranks, set));
        }
        for number in 0..count {
            let choices = study.combination(number);
            let skipped = |entry: &Vec<(usize, usize)>| {
                !entry.is_empty() && entry.iter().all(|(axis, choice)| choices[*axis] == *choice)
            };
            if study.skip.iter().any(skipped) {
                continue;
            }
            let chosen = || study.axes.iter().zip(&choices).map(|(axis, c)| &axis.choices[*c]);
            let ranks = chosen().filter_map(|choice| choice.ranks).next_back();
            let set = study.set.iter().chain(chosen().flat_map(|choice| &choice.set)).collect();
            let name = study.name_of(&choices);
            runs.push(run(choices, name, ranks.unwrap_or(study.ranks), set));
        }
        if runs.is_empty() {
            return Err(Error::Input(format!("{}: there is nothing to run", study.path.display())));
        }
        Ok(Plan { runs, references: study.references.len() })
    }

    /// The run with these choices.
    pub fn find(&self, choices: &[usize]) -> Option<usize> {
        self.runs.iter().position(|run| !run.choices.is_empty() && run.choices == choices).or_else(
            || (choices.is_empty() && self.runs.len() > self.references).then_some(self.references),
        )
    }

    /// The run that a measure of another run is compared with: that with some other labels.
    pub fn moved(&self, run: &Run, labels: &[(usize, usize)]) -> Option<usize> {
        let mut choices = run.choices.clone();
        for (axis, choice) in labels {
            *choices.get_mut(*axis)? = *choice;
        }
        self.find(&choices)
    }

    fn check(&self, study: &Study) -> Result<()> {
        let mut mistakes = Mistakes::default();
        for run in &self.runs {
            match Case::read(&study.base_text, &study.base, &run.overrides) {
                Ok(case) => self.check_measures(study, run, &case, &mut mistakes),
                Err(error) => mistakes.add_of_case(study, run, &error),
            }
        }
        let lines = mistakes.lines(study);
        if lines.is_empty() { Ok(()) } else { Err(refuse(&lines)) }
    }

    /// Whether everything that is measured is there in a run.
    fn check_measures(&self, study: &Study, run: &Run, case: &Case, mistakes: &mut Mistakes) {
        let columns = case.columns();
        for measure in &study.measures {
            let mut add = |text: String| mistakes.add(measure.origin, text, run);
            if !columns.contains(&measure.column) {
                let hint = suggestion(&measure.column, &columns);
                add(format!("`{}` is no column of history.csv{hint}", measure.column));
            }
            if let At::Times(times) = &measure.at
                && let Some(time) = times.iter().find(|time| !case.time.contains(time))
            {
                add(format!("{}: {time} is none of time.instants", measure.name));
            }
            if let Some(Against::Axes(labels)) = &measure.against
                && !run.choices.is_empty()
                && self.moved(run, labels).is_none()
            {
                add(format!("{}: the run it is compared with is skipped", measure.name));
            }
        }
    }
}

/// Mistakes of all runs, each to be told once.
#[derive(Default)]
struct Mistakes {
    /// Of the study, by place and kind.
    found: BTreeMap<(Origin, String), Mistake>,
    /// Of the base case: the line, and the name of a run that has it.
    elsewhere: BTreeSet<(String, String)>,
}

/// One that several runs may have.
struct Mistake {
    text: String,
    /// Name of the first run that has it.
    run: String,
    /// How many have it.
    count: usize,
}

impl Mistakes {
    fn add(&mut self, origin: Origin, text: String, run: &Run) {
        // Hints in brackets may differ from run to run.
        let kind = text.split(" (known: ").next().unwrap_or_default().to_owned();
        let first = || Mistake { text, run: run.name.clone(), count: 0 };
        self.found.entry((origin, kind)).or_insert_with(first).count += 1;
    }

    /// Adds what is wrong with the case of a run, line by line.
    fn add_of_case(&mut self, study: &Study, run: &Run, error: &Error) {
        for line in error.to_string().lines() {
            match study.origin_of(run, line) {
                Some((origin, text)) => self.add(origin, text, run),
                None => drop(self.elsewhere.insert((line.to_owned(), run.name.clone()))),
            }
        }
    }

    /// A line for each, as many as are listed.
    fn lines(self, study: &Study) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        for ((origin, _), Mistake { text, run, count }) in self.found {
            let more = if count > 1 { format!(", and {} more", count - 1) } else { String::new() };
            let run = if run.is_empty() { "the base case" } else { &run };
            lines.push(placed(&study.path, origin, &format!("{text} (run {run}{more})")));
        }
        let mut told = BTreeSet::new();
        for (line, run) in self.elsewhere {
            // A mistake of the base case is told once.
            if told.insert(line.clone()) {
                lines.push(format!("{line} (run {run})"));
            }
        }
        if lines.len() > LISTED {
            let more = lines.len() - LISTED;
            lines.truncate(LISTED);
            lines.push(format!("and {more} more"));
        }
        lines
    }
}

impl Study {
    /// The choices of the combination of this number, the last axis fastest.
    fn combination(&self, mut number: usize) -> Vec<usize> {
        let mut choices = vec![0; self.axes.len()];
        for (choice, axis) in choices.iter_mut().zip(&self.axes).rev() {
            *choice = number % axis.choices.len();
            number /= axis.choices.len();
        }
        choices
    }

    /// What a combination is called.
    fn name_of(&self, choices: &[usize]) -> String {
        let one = |(axis, choice): (&super::spec::Axis, &usize)| {
            format!("{}={}", axis.name, axis.choices[*choice].label)
        };
        let names: Vec<String> = self.axes.iter().zip(choices).map(one).collect();
        names.join(", ")
    }

    /// Where the override was written that a message of a case is about, and what it says of it.
    fn origin_of(&self, run: &Run, line: &str) -> Option<(Origin, String)> {
        let rest = line.strip_prefix("--set ")?;
        let chosen = self.axes.iter().zip(&run.choices).flat_map(|(a, c)| &a.choices[*c].set);
        let reference =
            self.references.iter().filter(|r| run.choices.is_empty() && r.name == run.name);
        let own = chosen.chain(reference.flat_map(|r| &r.set)).chain(&self.set);
        own.filter_map(|assignment| {
            let shown = shortened(&assignment.text);
            let text = rest.strip_prefix(shown.as_str())?.strip_prefix(": ")?;
            Some((assignment.origin, text.to_owned()))
        })
        .next()
    }
}

const FNV_START: u64 = 0xcbf2_9ce4_8422_2325;

/// The hash of Fowler, Noll and Vo (64 bits, 1a): the same with every compiler and machine.
fn fnv(bytes: &[u8], start: u64) -> u64 {
    bytes
        .iter()
        .fold(start, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// What determines the results of a run.
fn key_of(base: u64, overrides: &[String], ranks: usize, version: &str) -> String {
    let mut hash = base;
    for part in overrides.iter().map(String::as_str).chain([&*ranks.to_string(), version]) {
        // The zero keeps `ab`, `c` from being `a`, `bc`.
        hash = fnv(&[0], fnv(part.as_bytes(), hash));
    }
    format!("{hash:016x}")
}

/// A name for a directory: letters, digits and `-_.+`.
fn readable(name: &str) -> String {
    let mut text = String::new();
    for c in name.chars() {
        match c {
            'a'..='z' | 'A'..='Z' | '0'..='9' | '-' | '.' | '+' => text.push(c),
            '=' => text.push('-'),
            _ if text.ends_with('_') => {}
            _ => text.push('_'),
        }
        if text.len() >= LONGEST_NAME {
            break;
        }
    }
    if text.is_empty() { "base".to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_follows_everything_that_determines_a_run() {
        let base = fnv(b"mesh: {}", FNV_START);
        let overrides = |words: &[&str]| words.iter().map(|w| (*w).to_owned()).collect::<Vec<_>>();
        let key = |words: &[&str], ranks, version| key_of(base, &overrides(words), ranks, version);
        let first = key(&["a=1", "b=2"], 1, "v1");
        assert_eq!(first.len(), 16);
        assert_eq!(first, key(&["a=1", "b=2"], 1, "v1"));
        for other in [
            key(&["a=1", "b=3"], 1, "v1"),
            key(&["b=2", "a=1"], 1, "v1"),
            key(&["a=1b=2"], 1, "v1"),
            key(&["a=1", "b=2"], 2, "v1"),
            key(&["a=1", "b=2"], 1, "v2"),
            key_of(fnv(b"mesh: {} ", FNV_START), &overrides(&["a=1", "b=2"]), 1, "v1"),
        ] {
            assert_ne!(first, other);
        }
        // The published value for the letter a.
        assert_eq!(fnv(b"a", FNV_START), 0xaf63_dc4c_8601_ec8c);
    }

    #[test]
    fn directories_can_be_read() {
        assert_eq!(readable("order=2, cells=4x4x20"), "order-2_cells-4x4x20");
        assert_eq!(readable("law={tied: {}}/.."), "law-_tied_..");
        assert_eq!(readable(""), "base");
    }
}
