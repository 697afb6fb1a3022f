//! Numbers as text, and units with the prefix that makes them handy.

/// A unit with the prefix that makes numbers handy.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Unit {
    /// Numbers are multiplied by it.
    pub factor: f64,
    pub name: String,
}

const PREFIXES: [(i32, &str); 8] =
    [(-12, "p"), (-9, "n"), (-6, "µ"), (-3, "m"), (0, ""), (3, "k"), (6, "M"), (9, "G")];

impl Unit {
    /// For numbers in the unit `base`.
    pub fn of(base: &str, numbers: impl Iterator<Item = f64>) -> Self {
        let most = numbers.filter(|v| v.is_finite()).fold(0.0, |most: f64, v| most.max(v.abs()));
        // Nobody speaks of kilometres of a jump, nor of kilokilograms.
        let range = match base {
            "m" => -12..=0,
            "s" | "kg" | "kg/m" | "kg/m²/s" | "J/m²" | "" => 0..=0,
            _ => -12..=9,
        };
        let exponent = if most > 0.0 { (most.log10() + 1e-9).floor() as i32 } else { 0 };
        let wanted = exponent.div_euclid(3) * 3;
        let (exponent, prefix) = PREFIXES
            .into_iter()
            .filter(|(e, _)| range.contains(e))
            .min_by_key(|(e, _)| (e - wanted).abs())
            .unwrap_or((0, ""));
        Self { factor: 10f64.powi(-exponent), name: format!("{prefix}{base}") }
    }

    /// `words [unit]`.
    pub fn label(&self, words: &str) -> String {
        if self.name.is_empty() { words.to_owned() } else { format!("{words} [{}]", self.name) }
    }

    /// A number in this unit.
    pub fn number(&self, value: f64) -> f64 {
        // Division by a power of ten that is exact rounds once.
        if self.factor > 1.0 { value * self.factor } else { value / (1.0 / self.factor).round() }
    }

    /// The number with its unit.
    pub fn text(base: &str, value: f64) -> String {
        let unit = Self::of(base, std::iter::once(value));
        format!("{} {}", number(unit.number(value)), unit.name).trim_end().to_owned()
    }
}

/// Six digits at most.
pub(crate) fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let size = value.abs();
    if !(1e-3..1e6).contains(&size) {
        let text = format!("{value:.5e}");
        return match text.split_once('e') {
            Some((digits, power)) => format!("{}e{power}", without_zeros(digits)),
            None => text,
        };
    }
    let digits = (5 - size.log10().floor() as i32).clamp(0, 8) as usize;
    without_zeros(&format!("{value:.digits$}")).to_owned()
}

fn without_zeros(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_have_the_prefix_of_their_numbers() {
        for (base, most, name, power) in [
            ("Pa", 1.1e6, "MPa", -6),
            ("Pa", 0.0, "Pa", 0),
            ("m", 1.6e-3, "mm", 3),
            ("m", 2e-5, "µm", 6),
            ("m", 5000.0, "m", 0),
            ("N/m", 2.5e7, "MN/m", -6),
            ("s", 1e-4, "s", 0),
            ("Pa", 1e-30, "pPa", 12),
        ] {
            let unit = Unit::of(base, [most, f64::NAN].into_iter());
            assert_eq!(unit, Unit { factor: 10f64.powi(power), name: name.into() });
        }
        assert_eq!(Unit::text("Pa", 5.8e9), "5.8 GPa");
        assert_eq!(Unit::of("m", [1e-3].into_iter()).label("jump"), "jump [mm]");
        assert_eq!(Unit::of("", [3.0].into_iter()).label("damage"), "damage");
    }

    #[test]
    fn numbers_have_six_digits_at_most() {
        assert_eq!(number(1_017_312.072), "1.01731e6");
        assert_eq!(number(-0.001636), "-0.001636");
    }
}
