//! From the differences between meshes to errors.

/// Lowest order at which an error may seem to fall and be believed.
const LOWEST_ORDER: f64 = 0.5;

/// A difference whose next ones are not known stands for the error after it with this factor.
const SAFETY: f64 = 1.5;

/// One part of the error of a quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// Exact minus found.
    pub missing: f64,
    /// At which it was seen to fall.
    pub order: Option<f64>,
    /// Whether the differences fall as they should.
    pub trusted: bool,
}

impl Part {
    /// No error.
    pub const NONE: Self = Self { missing: 0.0, order: None, trusted: true };
}

/// The error of the finest of three values, each on a part of the mesh (or on steps) halved
/// against the next: the differences d1 = v0 - v1, d2 = v1 - v2 fall by q = d1/d2, and what is
/// left is their geometric sum, d1 q/(1 - q), with no order above the `highest` one. Outside of
/// plausible orders, and without a third value, it is the difference with a factor of safety.
/// What is below `noise` needs no order.
pub fn part(v0: f64, v1: Option<f64>, v2: Option<f64>, highest: f64, noise: f64) -> Part {
    let Some(v1) = v1 else {
        return Part { missing: v0.abs(), order: None, trusted: false };
    };
    let d1 = v0 - v1;
    let Some(d2) = v2.map(|v2| v1 - v2) else {
        return Part { missing: SAFETY * d1, order: None, trusted: d1.abs() <= noise };
    };
    if d1.abs() <= noise && d2.abs() <= 8.0 * noise {
        return Part { missing: d1, order: None, trusted: true };
    }
    let q = d1 / d2;
    let [fast, slow] = [highest, LOWEST_ORDER].map(|r| (-r).exp2());
    if q > 0.0 && q <= slow {
        // Faster than it can, once: the next difference is believed no smaller than it can.
        let believed = q.max(fast);
        let trusted = q >= fast * fast;
        return Part { missing: d1 * believed / (1.0 - believed), order: Some(-q.log2()), trusted };
    }
    // Not monotone, or slower than anything converges.
    let largest = if q.is_finite() && q.abs() < 1.0 { d1.abs() } else { d1.abs().max(d2.abs()) };
    Part { missing: SAFETY * largest.copysign(d1), order: None, trusted: false }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_of_the_size_is_extrapolated_to_its_limit() {
        for order in [0.7_f64, 1.0, 2.0, 3.5] {
            let value = |h: f64| 5.0 + 0.3 * h.powf(order);
            let of = part(value(0.25), Some(value(0.5)), Some(value(1.0)), 4.0, 1e-9);
            assert!((value(0.25) + of.missing - 5.0).abs() < 1e-12, "{order}: {of:?}");
            assert!(of.trusted && (of.order.expect("an order") - order).abs() < 1e-9);
        }
    }

    #[test]
    fn what_does_not_converge_is_not_trusted() {
        let turns = part(1.0, Some(1.1), Some(1.05), 2.0, 1e-9);
        assert!(!turns.trusted && turns.missing.abs() >= 0.1, "{turns:?}");
        let grows = part(1.0, Some(1.2), Some(1.3), 2.0, 1e-9);
        assert!(!grows.trusted && grows.missing.abs() >= 0.2, "{grows:?}");
        assert!(!part(1.0, Some(1.1), None, 2.0, 1e-9).trusted);
        assert!(!part(1.0, None, None, 2.0, 1e-9).trusted);
        assert_eq!(part(1.0, Some(1.0), Some(1.0), 2.0, 1e-9), Part { order: None, ..Part::NONE });
    }
}
