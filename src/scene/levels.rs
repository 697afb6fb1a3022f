//! Numbers as colours: bands between round numbers, and colours that are even to the eye.

use crate::chart::{Unit, number};

use super::drawing::Paint;

/// Dark to light, and from blue to yellow, in even steps of both (of OKLCH); the colour-blind tell
/// them apart by their lightness.
const RISING: [[u8; 3]; 11] = [
    [62, 49, 134],
    [48, 74, 151],
    [17, 99, 161],
    [0, 121, 160],
    [5, 142, 160],
    [12, 162, 159],
    [57, 181, 152],
    [106, 197, 142],
    [153, 210, 129],
    [200, 220, 119],
    [246, 227, 115],
];

/// For numbers on both sides of 0, which is light.
const SIGNED: [[u8; 3]; 11] = [
    [0, 83, 164],
    [58, 113, 182],
    [101, 143, 198],
    [143, 173, 212],
    [186, 202, 224],
    [232, 232, 232],
    [221, 194, 182],
    [206, 158, 136],
    [189, 122, 91],
    [169, 86, 45],
    [140, 55, 1],
];

/// Colours of what is one of several: materials, states.
pub(crate) const KINDS: [[u8; 3]; 11] = [
    [174, 192, 206],
    [222, 196, 150],
    [168, 200, 160],
    [214, 170, 180],
    [190, 178, 220],
    [226, 178, 112],
    [140, 186, 190],
    [200, 150, 120],
    [208, 208, 150],
    [150, 160, 200],
    [205, 205, 205],
];

/// Numbers are of one size if they differ by less than this part of the largest.
const EVEN: f64 = 1e-6;
/// Bands of a scale, at the least about; there are twice as many at the most.
const BANDS: f64 = 7.0;

/// The bands of a quantity; numbers in its unit without prefix.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Levels {
    /// Between one number and the next.
    Bands { bounds: Vec<f64>, unit: Unit },
    /// The same everywhere.
    Even { value: f64, text: String },
    /// Whole numbers with names.
    Kinds(Vec<(i64, String)>),
}

impl Levels {
    /// For numbers of a unit. Damage and the like, from 0 to 1, keeps that range.
    pub fn over(numbers: impl Iterator<Item = f64> + Clone, unit: &str, is_share: bool) -> Self {
        let sound = || numbers.clone().filter(|v| v.is_finite());
        let (mut low, mut high) =
            sound().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        if low > high {
            (low, high) = (0.0, 0.0);
        }
        if is_share {
            (low, high) = (low.min(0.0), high.max(1.0));
        }
        let most = low.abs().max(high.abs());
        if high - low <= EVEN * most {
            // Of what differs by rounding only, the middle.
            let value = 0.5 * (low + high);
            return Levels::Even { value, text: Unit::text(unit, four(value)) };
        }
        let step = round_up((high - low) / (2.0 * BANDS));
        // Rounding at an end makes no band.
        let slack = 1e-6 * step;
        let first = ((low + slack) / step).floor() as i64;
        let last = ((high - slack) / step).ceil() as i64;
        let bounds: Vec<f64> = (first..=last).map(|i| i as f64 * step).collect();
        let unit = Unit::of(unit, bounds.iter().copied());
        Levels::Bands { bounds, unit }
    }

    /// How many colours there are.
    pub fn count(&self) -> usize {
        match self {
            Levels::Bands { bounds, .. } => bounds.len() - 1,
            Levels::Even { .. } => 1,
            Levels::Kinds(kinds) => kinds.len(),
        }
    }

    /// The band of a number; what is beyond the ends belongs to the last ones.
    pub fn band(&self, value: f64) -> usize {
        match self {
            Levels::Bands { bounds, .. } => {
                let inner = &bounds[1..bounds.len() - 1];
                inner.partition_point(|bound| *bound <= value)
            }
            Levels::Even { .. } => 0,
            Levels::Kinds(kinds) => {
                kinds.iter().position(|(kind, _)| *kind as f64 == value.round()).unwrap_or(0)
            }
        }
    }

    /// Between which numbers a band lies.
    pub fn range(&self, band: usize) -> [f64; 2] {
        match self {
            Levels::Bands { bounds, .. } => {
                let low = if band == 0 { f64::NEG_INFINITY } else { bounds[band] };
                let is_last = band + 2 == bounds.len();
                [low, if is_last { f64::INFINITY } else { bounds[band + 1] }]
            }
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// Whether there are colours between two numbers: whether an area may need cutting.
    pub fn can_be_cut(&self) -> bool {
        matches!(self, Levels::Bands { .. })
    }

    /// The colour of a band.
    pub fn color(&self, band: usize) -> [u8; 3] {
        match self {
            Levels::Bands { bounds, .. } => {
                let [low, high] = [bounds[band], bounds[band + 1]];
                let (least, most) = (bounds[0], bounds[bounds.len() - 1]);
                let middle = 0.5 * (low + high);
                if least < 0.0 && most > 0.0 {
                    let reach = most.max(-least);
                    between(&SIGNED, 0.5 + 0.5 * middle / reach)
                } else {
                    let count = (bounds.len() - 1) as f64;
                    // The first and the last band have the colours at the ends.
                    let share = if count > 1.0 { band as f64 / (count - 1.0) } else { 0.5 };
                    between(&RISING, share)
                }
            }
            Levels::Even { value, .. } if *value < 0.0 => SIGNED[3],
            Levels::Even { value, .. } if *value == 0.0 => SIGNED[5],
            Levels::Even { .. } => RISING[6],
            Levels::Kinds(kinds) => KINDS[kinds[band].0.rem_euclid(KINDS.len() as i64) as usize],
        }
    }

    /// The numbers between the bands as they are written, and the prefixed unit.
    pub fn marks(&self) -> (Vec<String>, String) {
        match self {
            Levels::Bands { bounds, unit } => {
                let texts = bounds.iter().map(|bound| number(tidy(unit.number(*bound)))).collect();
                (texts, unit.name.clone())
            }
            _ => (Vec::new(), String::new()),
        }
    }
}

/// A colour with the light that falls on it: 1 is the colour itself.
pub(crate) fn lit(color: [u8; 3], light: f64) -> Paint {
    Paint::Color(color.map(|c| (f64::from(c) * light).round().clamp(0.0, 255.0) as u8))
}

/// The next of 1, 2, 2.5 and 5 times a power of ten.
pub(crate) fn round_up(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    let factors = [1.0, 2.0, 2.5, 5.0, 10.0];
    let fits = factors.iter().map(|f| f * power).find(|step| *step >= value * (1.0 - 1e-9));
    fits.unwrap_or(10.0 * power)
}

/// A number with four digits.
pub(crate) fn four(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

/// Without the rounding of a product.
fn tidy(value: f64) -> f64 {
    if value.abs() < 1e-12 { 0.0 } else { value }
}

fn between(table: &[[u8; 3]; 11], share: f64) -> [u8; 3] {
    let at = share.clamp(0.0, 1.0) * (table.len() - 1) as f64;
    let below = (at.floor() as usize).min(table.len() - 2);
    let part = at - below as f64;
    let [low, high] = [table[below], table[below + 1]];
    let mix = |c: usize| (1.0 - part) * f64::from(low[c]) + part * f64::from(high[c]);
    [0, 1, 2].map(|c| mix(c).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn over(numbers: &[f64], unit: &str) -> Levels {
        Levels::over(numbers.iter().copied(), unit, false)
    }

    #[test]
    fn bands_lie_between_round_numbers() {
        let levels = over(&[0.0, 1.7e-3, f64::NAN], "m");
        let (texts, unit) = levels.marks();
        assert_eq!(texts.first().zip(texts.last()), Some((&"0".into(), &"1.8".into())));
        assert_eq!((texts.len(), unit.as_str()), (10, "mm"));
        for (value, band) in [(-1.0, 0), (0.0, 0), (2.1e-4, 1), (1.7e-3, 8), (5.0, 8)] {
            assert_eq!(levels.band(value), band, "{value}");
            let [low, high] = levels.range(band);
            assert!(low <= value && value < high);
        }
        for numbers in [[0.0, 1.0], [-3.0, 1e-4], [4.0e6, 4.1e6], [-1e-9, 2e-9]] {
            let count = over(&numbers, "Pa").count();
            assert!((6..=16).contains(&count), "{numbers:?}: {count}");
        }
    }

    #[test]
    fn what_is_even_is_one_colour() {
        let told = |numbers: &[f64]| match over(numbers, "Pa") {
            Levels::Even { text, .. } => text,
            other => panic!("{other:?}"),
        };
        assert_eq!(told(&[5.8e6, 5.8e6 + 1e-3]), "5.8 MPa");
        assert_eq!(told(&[]), "0 Pa");
        let share = Levels::over([0.25, 0.25].into_iter(), "", true);
        assert_eq!(share.marks().0.last(), Some(&"1".to_owned()));
    }

    #[test]
    fn colours_are_even_steps_of_lightness() {
        let light = |[r, g, b]: [u8; 3]| {
            let linear = |c: u8| (f64::from(c) / 255.0).powf(2.2);
            (0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b)).cbrt()
        };
        let steps: Vec<f64> = RISING.windows(2).map(|p| light(p[1]) - light(p[0])).collect();
        assert!(steps.iter().all(|step| (0.03..0.08).contains(step)), "{steps:?}");
        for i in 0..5 {
            let [low, high] = [light(SIGNED[i]), light(SIGNED[10 - i])];
            assert!((low - high).abs() < 0.06, "{low} {high}");
        }
        let signed = over(&[-1.0, 3.0], "Pa");
        assert_ne!(signed.color(0), signed.color(signed.count() - 1));
    }

    #[test]
    fn round_numbers_are_the_next_ones() {
        for (value, round) in [(0.9, 1.0), (1.0, 1.0), (1.1, 2.0), (21.0, 25.0), (0.03, 0.05)] {
            assert!((round_up(value) / round - 1.0).abs() < 1e-12, "{value}");
        }
    }
}
