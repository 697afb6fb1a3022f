//! Facets of cells by their corners, and the cells on their other sides.

use super::buckets::{Buckets, Entry, split};
use super::cells::{Cells, NONE};
use super::facet::WholeFacet;
use super::view::View;
use super::words::wrong;
use crate::error::Result;

/// No cell has more facets.
const MOST_FACETS: usize = 6;

/// The place of a facet in arrays of all facets.
pub fn slot(facet: WholeFacet) -> usize {
    facet.cell as usize * MOST_FACETS + facet.facet as usize
}

/// The facet of a place.
pub fn of_slot(slot: u32) -> WholeFacet {
    let most = MOST_FACETS as u32;
    WholeFacet { cell: slot / most, facet: (slot % most) as u8 }
}

/// All facets by their corners.
pub struct FacetTable {
    buckets: Buckets<3>,
}

impl FacetTable {
    /// That of all cells.
    pub fn new(view: View<'_>) -> Self {
        let of_cell = |cell| {
            view.facets(cell).map(move |facet| {
                let corners = view.facet_nodes(facet).take(view.corner_count(facet));
                let (first, rest) = split::<3>(corners);
                (first, Entry { rest, id: slot(facet) as u32 })
            })
        };
        let things = || (0..view.shapes.len()).flat_map(of_cell);
        Self { buckets: Buckets::new(view.points.len(), things) }
    }

    /// The facets with these corners, by rising cell.
    pub fn find(&self, corners: impl Iterator<Item = u32>) -> impl Iterator<Item = WholeFacet> {
        let (first, rest) = split::<3>(corners);
        self.buckets.find(first, rest).iter().map(|entry| of_slot(entry.id))
    }

    /// The facets that have the same corners.
    pub fn runs(&self) -> impl Iterator<Item = &[Entry<3>]> {
        self.buckets.runs().map(|(_, run)| run)
    }

    /// For each place of a facet the place of the one on its other side, or [`NONE`].
    ///
    /// # Errors
    /// `Input` if more than two cells share a facet, two lie on the same side of one, or their
    /// nodes on it differ.
    pub fn mates(&self, cells: &Cells) -> Result<Vec<u32>> {
        let mut mates = vec![NONE; cells.shapes.len() * MOST_FACETS];
        for run in self.runs() {
            match run {
                [_] => {}
                [one, other] => {
                    check_pair(cells, of_slot(one.id), of_slot(other.id))?;
                    (mates[one.id as usize], mates[other.id as usize]) = (other.id, one.id);
                }
                _ => {
                    let numbers: Vec<String> = run
                        .iter()
                        .map(|e| cells.numbers[of_slot(e.id).cell as usize].to_string())
                        .collect();
                    return Err(wrong(format!(
                        "{} cells (elements {}) share one facet: {}; cells overlap there, so make \
                         the geometry conform (Coherence in Gmsh, Partition in SALOME) and mesh \
                         it again",
                        run.len(),
                        numbers.join(", "),
                        cells.describe_facet(of_slot(run[0].id))
                    )));
                }
            }
        }
        Ok(mates)
    }
}

/// Checks that two cells with common corners fit together there.
fn check_pair(cells: &Cells, one: WholeFacet, other: WholeFacet) -> Result<()> {
    let view = cells.view();
    let numbers = [one, other].map(|facet| cells.numbers[facet.cell as usize]);
    let what = || {
        let [a, b] = numbers;
        format!("elements {a} and {b} meet in {}", cells.describe_facet(one))
    };
    let orders = [one, other].map(|facet| view.facet_shape(facet).order());
    if orders[0] != orders[1] {
        return Err(wrong(format!(
            "{}, but one is of first and the other of second order; give all cells one order \
             (`mesh.raise_order: 2` raises all but pyramids)",
            what()
        )));
    }
    if orders[0] > 1 && sorted_nodes(view, one) != sorted_nodes(view, other) {
        return Err(wrong(format!(
            "{}, but not in the same middle nodes; mesh both bodies together, so that they share \
             all nodes there",
            what()
        )));
    }
    let corners = [one, other].map(|facet| view.facet_corners(facet));
    if runs_alike(&corners[0], &corners[1], view.corner_count(one)) {
        return Err(wrong(format!(
            "{}, but lie on the same side of it; cells overlap there, or one is turned over",
            what()
        )));
    }
    Ok(())
}

fn sorted_nodes(view: View<'_>, facet: WholeFacet) -> [u32; 9] {
    let mut nodes = [NONE; 9];
    nodes.iter_mut().zip(view.facet_nodes(facet)).for_each(|(place, node)| *place = node);
    nodes.sort_unstable();
    nodes
}

/// Whether the same corners run the same way round in two rows of `count` of them.
pub fn runs_alike(one: &[u32; 4], other: &[u32; 4], count: usize) -> bool {
    if count == 2 {
        return one[0] == other[0];
    }
    let place = other[..count].iter().position(|node| *node == one[0]);
    place.is_some_and(|place| other[(place + 1) % count] == one[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sense_of_corners_does_not_depend_on_the_first() {
        let square = [4, 7, 5, 1];
        for shift in 0..4 {
            let turned: [u32; 4] = std::array::from_fn(|i| square[(i + shift) % 4]);
            let mirrored: [u32; 4] = std::array::from_fn(|i| square[(8 - i - shift) % 4]);
            assert!(runs_alike(&square, &turned, 4) && !runs_alike(&square, &mirrored, 4));
        }
        assert!(runs_alike(&[1, 2, 9, 9], &[1, 2, 8, 8], 2));
        assert!(!runs_alike(&[1, 2, 9, 9], &[2, 1, 8, 8], 2));
    }

    #[test]
    fn places_and_facets_are_one_to_one() {
        for place in 0..60 {
            assert_eq!(slot(of_slot(place)), place as usize);
        }
    }
}
