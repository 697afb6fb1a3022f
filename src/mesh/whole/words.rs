//! Words of messages.

use crate::error::{Error, number_text};

/// An error of the mesh.
pub fn wrong(text: String) -> Error {
    Error::Input(text)
}

/// A place (m), as (x, y, z) with six digits.
pub fn place(point: [f64; 3]) -> String {
    let [x, y, z] = point.map(|x| {
        // Not more digits than help to find it; minus zero is zero.
        let short: f64 = format!("{x:.5e}").parse().unwrap_or(x);
        number_text(short + 0.0)
    });
    format!("({x}, {y}, {z}) m")
}

/// `1 cell`, `2 cells`.
pub fn count(number: usize, what: &str) -> String {
    if number == 1 { format!("1 {what}") } else { format!("{number} {what}s") }
}

/// `is` or `are`.
pub fn are(number: usize) -> &'static str {
    if number == 1 { "is" } else { "are" }
}
