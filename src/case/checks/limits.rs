//! When a run writes checkpoints and when it stops.

use super::checker::Checker;
use crate::case::sections::file::CaseFile;
use crate::input::duration::seconds;

/// How often a checkpoint is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Every {
    /// After so many seconds of a run.
    Seconds(f64),
    /// After so many instants.
    Instants(usize),
}

/// Without a word in the case file.
const USUAL: Every = Every::Seconds(600.0);

impl Checker<'_> {
    /// How often checkpoints are written, and the wall-clock time of the run (s).
    pub fn limits(&mut self, file: &CaseFile) -> (Every, Option<f64>) {
        let mut every = USUAL;
        if let Some(section) = &file.output.checkpoint {
            match every_of(&section.every) {
                Ok(given) => every = given,
                Err(reason) => self.add("output.checkpoint.every", reason),
            }
        }
        let mut wall = None;
        if let Some(limits) = &file.limits {
            match seconds(&limits.wall) {
                Ok(given) => wall = Some(given),
                Err(reason) => self.add("limits.wall", reason),
            }
        }
        (every, wall)
    }
}

fn every_of(text: &str) -> Result<Every, String> {
    let count = text.trim().strip_suffix("instants").or(text.trim().strip_suffix("instant"));
    let Some(count) = count else { return seconds(text).map(Every::Seconds) };
    match count.trim().parse() {
        Ok(count) if count > 0 => Ok(Every::Instants(count)),
        _ => Err(format!("must be a positive number of instants, got `{text}`")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checkpoints_come_after_a_time_or_a_number_of_instants() {
        assert_eq!(every_of("5 instants"), Ok(Every::Instants(5)));
        assert_eq!(every_of("1 instant"), Ok(Every::Instants(1)));
        assert_eq!(every_of("30 s"), Ok(Every::Seconds(30.0)));
        assert!(every_of("0 instants").is_err() && every_of("many instants").is_err());
    }
}
