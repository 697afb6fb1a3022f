//! Medians, fitted exponents and Pareto fronts.

/// The quartiles of some numbers, between them linearly: lower, median, upper; none of no numbers.
pub fn quartiles(values: &[f64]) -> Option<[f64; 3]> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    let at = |share: f64| {
        let place = share * last as f64;
        let below = place.floor() as usize;
        let above = (below + 1).min(last);
        sorted[below] + (sorted[above] - sorted[below]) * (place - below as f64)
    };
    Some([at(0.25), at(0.5), at(0.75)])
}

/// The exponent b of y = a x^b through the points by least squares of the logarithms, with a.
///
/// None of fewer than two points with different positive x and positive y.
pub fn power_law(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let logs: Vec<(f64, f64)> = points
        .iter()
        .filter(|(x, y)| *x > 0.0 && *y > 0.0 && x.is_finite() && y.is_finite())
        .map(|(x, y)| (x.ln(), y.ln()))
        .collect();
    let count = logs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let spread: f64 = logs.iter().map(|p| (p.0 - x).powi(2)).sum();
    if logs.len() < 2 || spread <= 1e-12 * count {
        return None;
    }
    let slope = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / spread;
    Some((slope, (y - slope * x).exp()))
}

/// Which points no other point beats: none is at most as large in both numbers and smaller in one.
pub fn pareto(points: &[(f64, f64)]) -> Vec<bool> {
    let beats = |a: &(f64, f64), b: &(f64, f64)| a.0 <= b.0 && a.1 <= b.1 && a != b;
    let finite = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite();
    points
        .iter()
        .map(|p| finite(p) && !points.iter().any(|other| finite(other) && beats(other, p)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_lie_between_the_sorted_values() {
        assert_eq!(quartiles(&[]), None);
        assert_eq!(quartiles(&[3.0]), Some([3.0; 3]));
        assert_eq!(quartiles(&[4.0, 1.0, 3.0, 2.0, 5.0]), Some([2.0, 3.0, 4.0]));
        assert_eq!(quartiles(&[1.0, 2.0, f64::NAN]), Some([1.25, 1.5, 1.75]));
    }

    #[test]
    fn a_power_law_is_found_again() {
        let points: Vec<(f64, f64)> = [1.0f64, 10.0, 250.0].map(|x| (x, 3.0 * x.powf(1.5))).into();
        let (exponent, factor) = power_law(&points).unwrap();
        assert!((exponent - 1.5).abs() < 1e-12 && (factor - 3.0).abs() < 1e-11);
        // What has no logarithm does not count, and one place has no slope.
        assert_eq!(power_law(&[(1.0, 2.0), (3.0, 0.0), (-1.0, 4.0)]), None);
        assert_eq!(power_law(&[(2.0, 1.0), (2.0, 3.0)]), None);
    }

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let points = [(1.0, 9.0), (2.0, 3.0), (3.0, 3.0), (4.0, 1.0), (5.0, 2.0), (0.5, f64::NAN)];
        assert_eq!(pareto(&points), [true, true, false, true, false, false]);
        // Equal points are both on it.
        assert_eq!(pareto(&[(1.0, 1.0), (1.0, 1.0)]), [true, true]);
        assert!(pareto(&[]).is_empty());
    }
}
