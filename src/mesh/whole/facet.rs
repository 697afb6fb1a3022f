//! Facets of cells by number.

/// A facet of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct WholeFacet {
    /// The cell.
    pub cell: u32,
    /// Which of [`Shape::facets`](crate::element::Shape::facets) it is.
    pub facet: u8,
}
