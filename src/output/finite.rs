//! Numbers that are none stay out of files.

use std::path::Path;

use super::vtkhdf::{Array, Data, Grid, Values};
use crate::error::{Error, Result};

/// The error of a number that is not finite, instead of the file that was to hold it. `place` says
/// where and when it is.
pub fn refused(what: &str, value: f64, place: &str, file: &Path) -> Error {
    Error::Numerics(format!(
        "{what} is {value} {place}, which does not go into {}: take smaller steps (more \
         time.instants), and look at loads, materials and laws there",
        file.display()
    ))
}

/// Refuses a row of a table that is not finite somewhere; `when` says of which instant it is.
///
/// # Errors
/// [`Error::Numerics`] with the name of the first column that holds none.
///
/// # Parallel
/// Local: agree on it.
pub fn check_row(file: &Path, when: &str, columns: &[String], row: &[Option<f64>]) -> Result<()> {
    let mut values = columns.iter().zip(row).filter_map(|(name, value)| Some((name, (*value)?)));
    let broken = values.find(|(_, value)| !value.is_finite());
    broken.map_or(Ok(()), |(name, value)| Err(refused(name, value, when, file)))
}

/// Refuses fields that are not finite somewhere; `known` is the data that never change.
///
/// # Errors
/// [`Error::Numerics`] with the name, the place and the time of the first value that is none.
///
/// # Parallel
/// Local: agree on it.
pub fn check_fields(file: &Path, time: f64, grid: &Grid, known: Data, data: Data) -> Result<()> {
    let cells = known.cells.iter().find_map(|array| match array.values {
        Values::I64(names) if array.name == "global_cell_id" => Some(names),
        _ => None,
    });
    let point = |row: usize| {
        let [x, y, z] = grid.points[row];
        format!("at ({x}, {y}, {z}) m")
    };
    let cell = |row: usize| match cells {
        Some(names) => format!("in cell {}", names[row]),
        None => format!("in cell {row} of this rank"),
    };
    let fail = |(array, _, value): (&Array, usize, f64), place: String| {
        Err(refused(array.name, value, &format!("{place} at time {time}"), file))
    };
    if let Some(found) = data.points.iter().find_map(first) {
        return fail(found, point(found.1));
    }
    data.cells.iter().find_map(first).map_or(Ok(()), |found| fail(found, cell(found.1)))
}

/// The first value of an array that is not finite, and its row.
fn first<'a, 'v>(array: &'a Array<'v>) -> Option<(&'a Array<'v>, usize, f64)> {
    let Values::F64(values) = array.values else { return None };
    let at = values.iter().position(|value| !value.is_finite())?;
    Some((array, at / array.components, values[at]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Shape;

    #[test]
    fn the_first_value_that_is_none_is_named_with_its_place() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 2.5], [0.0, 0.0, 2.5]];
        let shapes = [Shape::Quad4];
        let grid = Grid { points: &points, connectivity: &[0, 1, 2, 3], shapes: &shapes };
        let says = |displacement: &[f64], stress: &[f64]| {
            let array = |name, components, values| Array { name, components, values };
            let names = [array("global_cell_id", 1, Values::I64(&[17]))];
            let known = Data { points: &[], cells: &names };
            let points = [array("displacement", 3, Values::F64(displacement))];
            let cells = [array("stress", 6, Values::F64(stress))];
            let data = Data { points: &points, cells: &cells };
            check_fields(Path::new("bulk_000002.vtkhdf"), 0.5, &grid, known, data)
        };
        let (mut u, mut stress) = (vec![0.0; 12], vec![0.0; 6]);
        assert_eq!(says(&u, &stress), Ok(()));
        stress[4] = f64::INFINITY;
        let error = says(&u, &stress).expect_err("a stress that is none");
        let begin =
            "stress is inf in cell 17 at time 0.5, which does not go into bulk_000002.vtkhdf: ";
        assert!(error.to_string().starts_with(begin), "{error}");
        u[8] = f64::NAN;
        let error = says(&u, &stress).expect_err("a displacement that is none");
        assert_eq!(error.exit_status(), 3);
        let begin = "displacement is NaN at (1, 0, 2.5) m at time 0.5, which ";
        assert!(error.to_string().starts_with(begin), "{error}");
    }
}
