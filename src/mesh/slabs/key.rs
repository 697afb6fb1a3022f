//! What a node is before it has its name.

/// New nodes in the middle of edges.
pub const EDGE: u64 = 1;
/// New nodes in the middle of quadrilaterals.
pub const FACE: u64 = 2;
/// New nodes in the middle of cells.
pub const CENTRE: u64 = 3;

/// Bits of the sector.
const SECTOR: u32 = 14;
/// Bits of the place among the new nodes of one base.
const PLACE: u32 = 16;

/// A node by what it was made of: its kind, the lowest corner (or the cell) around it, its place
/// among those that have the same one, and the sector of cells after cutting. Keys rise as names
/// do, as long as nothing is cut.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key(pub u64);

impl Key {
    /// A node of the file.
    pub fn plain(name: u32) -> Self {
        Self(u64::from(name) << (PLACE + SECTOR))
    }

    /// A new node.
    pub fn fresh(kind: u64, base: u32, place: u64) -> Self {
        Self(kind << 62 | u64::from(base) << (PLACE + SECTOR) | place << SECTOR)
    }

    /// A copy of this node in a sector, from 1 on.
    pub fn copy(self, sector: u64) -> Self {
        Self(self.0 | sector)
    }

    /// The node of the file, where it is one.
    pub fn name(self) -> Option<u32> {
        (self.kind() == 0 && self.sector() == 0).then(|| self.base())
    }

    /// [`EDGE`], [`FACE`], [`CENTRE`], or 0 for a node of the file.
    pub fn kind(self) -> u64 {
        self.0 >> 62
    }

    /// Lowest corner or cell.
    pub fn base(self) -> u32 {
        (self.0 >> (PLACE + SECTOR)) as u32
    }

    /// Place among those of the same base.
    pub fn place(self) -> u32 {
        (self.0 >> SECTOR) as u32 & ((1 << PLACE) - 1)
    }

    /// 0 for the node that was there before cutting.
    pub fn sector(self) -> u32 {
        self.0 as u32 & ((1 << SECTOR) - 1)
    }

    /// The node before cutting.
    pub fn origin(self) -> Self {
        Self(self.0 & !((1 << SECTOR) - 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_holds_what_it_was_made_of() {
        let base = (1_u32 << 31) - 1;
        let plain = Key::plain(base);
        assert_eq!((plain.name(), plain.kind(), plain.base()), (Some(base), 0, base));
        let key = Key::fresh(CENTRE, base, 65_535).copy(16_383);
        assert_eq!((key.kind(), key.base(), key.place(), key.sector()), (3, base, 65_535, 16_383));
        assert_eq!(key.origin(), Key::fresh(CENTRE, base, 65_535));
        assert_eq!(plain.copy(2).name(), None);
    }
}
