//! Scales of charts: what lies where, and where the marks are.

/// How numbers are laid along an axis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Scale {
    /// Logarithmic, between two positive numbers.
    Log(f64, f64),
    /// The same, with marks at these numbers.
    Marked(f64, f64, Vec<f64>),
    /// Linear.
    Linear(f64, f64),
    /// Linear, for whole numbers.
    Integer(f64, f64),
    /// Names at 0, 1, 2, ...
    Names(Vec<String>),
}

/// Most marks of an axis.
const MOST_MARKS: usize = 9;

impl Scale {
    /// That holds all numbers, with a margin; of numbers that are not positive a logarithmic scale
    /// holds none.
    pub fn over(numbers: impl Iterator<Item = f64> + Clone, log: bool) -> Self {
        let sound = |v: &f64| v.is_finite() && (!log || *v > 0.0);
        let low = numbers.clone().filter(sound).fold(f64::INFINITY, f64::min);
        let high = numbers.filter(sound).fold(f64::NEG_INFINITY, f64::max);
        if low > high {
            return if log { Scale::Log(0.1, 10.0) } else { Scale::Linear(0.0, 1.0) };
        }
        if log {
            // A tenth of the width on both sides, and a factor of two at least in all.
            let margin = (0.06 * (high / low).ln()).max(0.35);
            Scale::Log(low * (-margin).exp(), high * margin.exp())
        } else {
            let margin = if high > low { 0.06 * (high - low) } else { 0.5 * high.abs().max(1e-12) };
            // What is not far from zero starts there.
            let start = if low >= 0.0 && low < 0.4 * high { 0.0 } else { low - margin };
            Scale::Linear(start, high + margin)
        }
    }

    /// For counts up to the largest of them, from `first` on.
    pub fn whole(first: f64, counts: impl Iterator<Item = f64>) -> Self {
        let most = counts.filter(|count| count.is_finite()).fold(first + 1.0, f64::max);
        Scale::Integer(
            first - if first > 0.0 { 0.5 } else { 0.0 },
            most + 0.05 * (most - first).max(9.0),
        )
    }

    /// Logarithmic over numbers, with marks at them.
    pub fn marked(mut numbers: Vec<f64>) -> Self {
        numbers.sort_by(f64::total_cmp);
        numbers.dedup();
        match Scale::over(numbers.iter().copied(), true) {
            Scale::Log(low, high) => Scale::Marked(low, high, numbers),
            other => other,
        }
    }

    /// Where a number lies, from 0 to 1; none where the scale does not have it.
    pub fn place(&self, number: f64) -> Option<f64> {
        let place = match self {
            Scale::Log(low, high) | Scale::Marked(low, high, _) => {
                (number / low).ln() / (high / low).ln()
            }
            Scale::Linear(low, high) | Scale::Integer(low, high) => (number - low) / (high - low),
            Scale::Names(names) => (number + 0.5) / names.len() as f64,
        };
        (-1e-9..=1.0 + 1e-9).contains(&place).then_some(place)
    }

    /// The marks: places from 0 to 1 and what is written there.
    pub fn marks(&self) -> Vec<(f64, String)> {
        let numbers = match self {
            Scale::Names(names) => {
                let at = |index: usize| (index as f64 + 0.5) / names.len() as f64;
                return names.iter().enumerate().map(|(i, name)| (at(i), name.clone())).collect();
            }
            Scale::Marked(_, _, marks) => marks.clone(),
            Scale::Log(low, high) => log_marks(*low, *high),
            Scale::Linear(low, high) => linear_marks(*low, *high, 0.0),
            Scale::Integer(low, high) => linear_marks(*low, *high, 1.0),
        };
        let powers = matches!(self, Scale::Log(low, high) if *low < 0.9e-3 || *high > 5e4);
        let step = numbers.windows(2).map(|p| p[1] - p[0]).fold(f64::INFINITY, f64::min);
        let text = |v: f64| match self {
            Scale::Log(..) | Scale::Marked(..) => plain_or_power(v, powers),
            _ => linear_text(v, step),
        };
        numbers.into_iter().filter_map(|v| Some((self.place(v)?, text(v)))).collect()
    }
}

fn log_marks(low: f64, high: f64) -> Vec<f64> {
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    let inside = |factors: &[f64]| -> Vec<f64> {
        let all = (first..=last).flat_map(|e| factors.iter().map(move |f| f * 10f64.powi(e)));
        all.filter(|v| (low..=high).contains(v)).collect()
    };
    let decades = inside(&[1.0]);
    if decades.len() > MOST_MARKS {
        let stride = decades.len().div_ceil(MOST_MARKS);
        return decades.into_iter().step_by(stride).collect();
    }
    // As many as there is room for.
    let finer: [&[f64]; 4] = [
        &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
        &[1.0, 2.0, 3.0, 5.0],
        &[1.0, 2.0, 5.0],
        &[1.0, 3.0],
    ];
    let fitting = finer.iter().map(|factors| inside(factors)).find(|m| m.len() <= MOST_MARKS);
    fitting.unwrap_or(decades)
}

/// Marks that are `least` apart or more.
fn linear_marks(low: f64, high: f64, least: f64) -> Vec<f64> {
    let rough = ((high - low) / 6.0).max(least);
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].iter().map(|f| f * power).find(|s| *s >= rough);
    let step = step.unwrap_or(10.0 * power);
    let first = (low / step).ceil() as i64;
    (0..100)
        .map(|i| (first + i) as f64 * step)
        .take_while(|v| *v <= high * (1.0 + 1e-12) || *v <= high)
        .collect()
}

fn linear_text(value: f64, step: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e6).contains(&value.abs()) {
        return plain_or_power(value, true);
    }
    let digits = (-step.log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.digits$}")
}

/// `0.05`, or `5·10⁻²` where powers are wanted.
fn plain_or_power(value: f64, powers: bool) -> String {
    if !powers {
        return format!("{}", (value * 1e9).round() / 1e9);
    }
    let exponent = (value.abs().log10() + 1e-9).floor() as i32;
    let factor = (value / 10f64.powi(exponent) * 1e3).round() / 1e3;
    let digits = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let sign = if exponent < 0 { "⁻" } else { "" };
    let number: String = exponent
        .unsigned_abs()
        .to_string()
        .chars()
        .filter_map(|c| Some(digits[c.to_digit(10)? as usize]))
        .collect();
    let power = format!("10{sign}{number}");
    match factor {
        1.0 => power,
        -1.0 => format!("-{power}"),
        _ => format!("{factor}·{power}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(scale: &Scale) -> Vec<String> {
        scale.marks().into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn every_axis_has_marks_that_can_be_read() {
        assert_eq!(
            texts(&Scale::Log(0.9e-6, 1.1)),
            ["10⁻⁶", "10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²", "10⁻¹", "10⁰"]
        );
        assert_eq!(texts(&Scale::Linear(0.0, 1.06)), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(texts(&Scale::Names(vec!["a".into(), "b".into()])), ["a", "b"]);
        for (low, high) in [(1e-12, 1e9), (3.0, 3.1), (0.02, 0.5), (1e5, 2e6)] {
            let count = Scale::over([low, high].into_iter(), true).marks().len();
            assert!((2..=MOST_MARKS + 1).contains(&count), "{low} to {high}: {count}");
        }
    }

    #[test]
    fn places_are_shares_of_the_axis() {
        assert!((Scale::Log(1.0, 100.0).place(10.0).unwrap() - 0.5).abs() < 1e-12);
        assert_eq!(Scale::Linear(0.0, 4.0).place(1.0), Some(0.25));
        assert_eq!(Scale::Names(vec![String::new(); 2]).place(1.0), Some(0.75));
        assert_eq!(Scale::Log(1.0, 10.0).place(0.0), None);
        assert_eq!(Scale::Linear(0.0, 1.0).place(f64::NAN), None);
        // Nothing to show is no reason to fail.
        assert!(!Scale::over([0.0, -1.0].into_iter(), true).marks().is_empty());
        assert!(!Scale::over([2.0].into_iter(), false).marks().is_empty());
    }

    #[test]
    fn powers_are_written_as_such() {
        assert_eq!(plain_or_power(2e-7, true), "2·10⁻⁷");
        assert_eq!(plain_or_power(1e10, true), "10¹⁰");
        assert_eq!(plain_or_power(-1e-7, true), "-10⁻⁷");
        assert_eq!(plain_or_power(0.05, false), "0.05");
    }
}
