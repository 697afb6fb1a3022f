//! How large a mesh becomes when it is refined.

use crate::element::Shape;
use crate::error::Result;
use crate::mesh::whole::cells::Cells;
use crate::mesh::whole::words::{count, wrong};

/// Cells of each shape, by its number.
type Counts = [u128; Shape::ALL.len()];

/// Refuses refinements after which the connectivity could not be counted in 32 bits, before
/// memory is asked for.
///
/// # Errors
/// `Input` with the sizes and how often it can be refined.
pub fn check(cells: &Cells, times: u32) -> Result<()> {
    let mut counts: Counts = [0; Shape::ALL.len()];
    cells.shapes.iter().for_each(|shape| counts[*shape as usize] += 1);
    let mut possible = 0;
    for time in 0..times {
        counts = refined(&counts);
        if length(&counts) > i32::MAX as u128 {
            break;
        }
        possible = time + 1;
    }
    if possible == times {
        return Ok(());
    }
    // What comes after the first one that is too large would only be larger.
    Err(wrong(format!(
        "refined {times} times, {} would become more than {} with {} nodes together, and more than \
         {} cannot be numbered; {}",
        count(cells.shapes.len(), "cell"),
        counts.iter().sum::<u128>(),
        length(&counts),
        i32::MAX,
        match possible {
            0 => "leave `mesh.refine` out".to_owned(),
            _ => format!("`mesh.refine: {possible}` is the most that fits"),
        }
    )))
}

/// The lengths of the connectivity, of the cells or of those of second order that are halved.
fn length(counts: &Counts) -> u128 {
    Shape::ALL.iter().map(|shape| counts[*shape as usize] * shape.nodes() as u128).sum()
}

fn refined(counts: &Counts) -> Counts {
    let mut fine = [0; Shape::ALL.len()];
    for shape in Shape::ALL {
        let number = counts[shape as usize];
        match shape {
            Shape::Pyramid5 => {
                fine[shape as usize] += 6 * number;
                fine[Shape::Tet4 as usize] += 4 * number;
            }
            _ => fine[shape as usize] += number << shape.dim(),
        }
    }
    fine
}
