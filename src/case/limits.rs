//! When a run writes checkpoints and when it stops: lengths of time, and the rules for them.

use super::checker::Checker;
use super::file::CaseFile;

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

/// A length of time in seconds: `90 s`, `10 min`, `2 h` or `HH:MM:SS`.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    let wrong = || format!("must be like 10 min, 90 s, 2 h or 23:30:00, got `{text}`");
    let text = text.trim();
    let units = [("min", 60.0), ("s", 1.0), ("h", 3600.0)];
    let found = units.iter().find_map(|(unit, length)| {
        text.strip_suffix(unit)?.trim().parse::<f64>().ok().map(|number| number * length)
    });
    let clock = || {
        let parts: Vec<u32> = text.split(':').map(str::parse).collect::<Result<_, _>>().ok()?;
        match parts[..] {
            [hours, minutes, seconds] if minutes < 60 && seconds < 60 => {
                Some(f64::from(hours) * 3600.0 + f64::from(minutes * 60 + seconds))
            }
            _ => None,
        }
    };
    found.or_else(clock).filter(|s| *s > 0.0 && s.is_finite()).ok_or_else(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_of_time_are_read_as_they_are_said() {
        for (text, exact) in [
            ("10 min", 600.0),
            ("1.5min", 90.0),
            ("90 s", 90.0),
            ("2 h", 7200.0),
            ("23:30:00", 84600.0),
            ("00:00:05", 5.0),
        ] {
            assert_eq!(seconds(text), Ok(exact), "{text}");
        }
        for text in ["", "10", "ten min", "-5 s", "0 s", "1:2", "00:61:00", "1e999 s", "NaN s"] {
            assert!(seconds(text).is_err(), "{text}");
        }
        assert_eq!(every_of("5 instants"), Ok(Every::Instants(5)));
        assert_eq!(every_of("1 instant"), Ok(Every::Instants(1)));
        assert_eq!(every_of("30 s"), Ok(Every::Seconds(30.0)));
        assert!(every_of("0 instants").is_err() && every_of("many instants").is_err());
    }
}
