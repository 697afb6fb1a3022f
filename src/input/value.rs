//! Values in space and time: a constant, a table over time or over a coordinate, or a formula.

use super::Formula;

/// A prescribed value: displacement, traction, pressure or body force component.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// The same everywhere and always.
    Constant(f64),
    /// Points (time, value) with rising times: linear between, constant beyond.
    Table(Vec<[f64; 2]>),
    /// Points (coordinate, value) along an axis, with rising coordinates: likewise.
    Profile(usize, Vec<[f64; 2]>),
    /// A formula in x, y, z, t.
    Formula(Formula),
}

impl Value {
    /// The value at a point and a time. A formula may yield a number that is not finite;
    /// whoever applies it refuses that.
    pub fn at(&self, point: [f64; 3], time: f64) -> f64 {
        match self {
            Value::Constant(value) => *value,
            Value::Table(rows) => interpolate(rows, time),
            Value::Profile(axis, rows) => interpolate(rows, point[*axis]),
            Value::Formula(formula) => formula.at(point, time),
        }
    }

    /// Whether it is 0 everywhere and always, as far as its form tells.
    pub fn is_zero(&self) -> bool {
        match self {
            Value::Constant(value) => *value == 0.0,
            Value::Table(rows) | Value::Profile(_, rows) => rows.iter().all(|row| row[1] == 0.0),
            Value::Formula(formula) => formula.is_constant() && formula.at([0.0; 3], 0.0) == 0.0,
        }
    }

    /// The same with the opposite sign.
    pub fn negated(&self) -> Value {
        match self {
            Value::Constant(value) => Value::Constant(-value),
            Value::Table(rows) => Value::Table(opposite(rows)),
            Value::Profile(axis, rows) => Value::Profile(*axis, opposite(rows)),
            Value::Formula(formula) => Value::Formula(formula.negated()),
        }
    }

    /// Whether it depends on the point.
    pub fn varies_in_space(&self) -> bool {
        match self {
            Value::Profile(_, rows) => rows.iter().any(|row| row[1] != rows[0][1]),
            Value::Formula(formula) => formula.varies_in_space(),
            _ => false,
        }
    }

    /// The times at which its slope over time may jump: the times of a table.
    pub fn breakpoints(&self) -> Vec<f64> {
        match self {
            Value::Table(rows) => rows.iter().map(|row| row[0]).collect(),
            _ => Vec::new(),
        }
    }
}

fn opposite(rows: &[[f64; 2]]) -> Vec<[f64; 2]> {
    rows.iter().map(|[at, value]| [*at, -value]).collect()
}

/// Linear interpolation in a table with at least one row and strictly rising times.
fn interpolate(rows: &[[f64; 2]], time: f64) -> f64 {
    let next = rows.partition_point(|row| row[0] <= time);
    if next == 0 {
        return rows[0][1];
    }
    let [start, from] = rows[next - 1];
    // At a row's own time its own value, to the last bit.
    if next == rows.len() || time == start {
        return from;
    }
    let [end, to] = rows[next];
    from + (to - from) * ((time - start) / (end - start))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_linear_between_and_constant_beyond() {
        let table = Value::Table(vec![[1.0, -1.0e-4], [2.0, 1.0e-4], [4.0, 5.0]]);
        let at = |time| table.at([9.0; 3], time);
        assert_eq!((at(0.0), at(1.0), at(2.0), at(4.0), at(99.0)), (-1e-4, -1e-4, 1e-4, 5.0, 5.0));
        assert_eq!(at(1.5), 0.0);
        assert!((at(3.0) - 2.50005).abs() < 1e-12);
        assert_eq!(table.breakpoints(), [1.0, 2.0, 4.0]);
    }

    #[test]
    fn a_profile_is_a_table_over_a_coordinate() {
        let profile = Value::Profile(2, vec![[0.0, 1.0], [2.0, 0.0]]);
        let at = |z| profile.at([9.0, 9.0, z], 7.0);
        assert_eq!((at(-1.0), at(0.0), at(0.5), at(2.0), at(3.0)), (1.0, 1.0, 0.75, 0.0, 0.0));
        assert!(
            profile.varies_in_space() && !profile.is_zero() && profile.breakpoints().is_empty()
        );
        assert_eq!(profile.negated().at([0.0, 0.0, 0.5], 0.0), -0.75);
        assert!(!Value::Profile(0, vec![[0.0, 1.0], [2.0, 1.0]]).varies_in_space());
    }

    #[test]
    fn a_negated_value_has_the_opposite_sign() {
        let formula = Value::Formula(Formula::parse("1e-3*x - t").expect("a formula"));
        for value in [Value::Constant(2.5), Value::Table(vec![[0.0, 1.0], [1.0, -3.0]]), formula] {
            for (point, time) in [([0.5; 3], 0.25), ([2.0; 3], 7.0)] {
                assert_eq!(value.negated().at(point, time), -value.at(point, time));
            }
            assert_eq!(value.negated().breakpoints(), value.breakpoints());
        }
    }

    #[test]
    fn zero_and_variation_in_space_are_recognised() {
        let formula = |text: &str| Value::Formula(Formula::parse(text).expect(text));
        assert!(Value::Constant(-0.0).is_zero() && !Value::Constant(1e-300).is_zero());
        assert!(Value::Table(vec![[0.0, 0.0], [1.0, 0.0]]).is_zero());
        assert!(!Value::Table(vec![[0.0, 0.0], [1.0, 1.0]]).is_zero());
        assert!(formula("0*2").is_zero() && !formula("0*x").is_zero());
        assert!(formula("t*z").varies_in_space() && !formula("t").varies_in_space());
        assert!(!Value::Constant(1.0).varies_in_space());
    }
}
