//! Lengths of time, as people write them.

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
    }
}
