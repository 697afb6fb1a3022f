//! Where a node lies: its body, the named surfaces, and the lip of an interface.

use serde::{Deserialize, Serialize};

use crate::case::SurfaceBit;

/// One of the two lips of an interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Lip {
    /// The face of the body below: the normal of the interface points out of it.
    Lower,
    /// The face of the body above.
    Upper,
}

impl Lip {
    /// Both, the lower one first.
    pub const BOTH: [Lip; 2] = [Lip::Lower, Lip::Upper];

    /// The lip that it faces.
    pub fn other(self) -> Self {
        match self {
            Lip::Lower => Lip::Upper,
            Lip::Upper => Lip::Lower,
        }
    }

    /// Its name in words.
    pub fn name(self) -> &'static str {
        match self {
            Lip::Lower => "lower",
            Lip::Upper => "upper",
        }
    }

    /// Its place in [`Lip::BOTH`].
    pub fn index(self) -> usize {
        usize::from(self == Lip::Upper)
    }
}

/// Where a node lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Marks {
    /// The body, counted from the bottom.
    pub body: u32,
    /// Whether the node lies on a lip and carries no multiplier, because interfaces meet or end
    /// there; never in a column.
    pub is_junction: bool,
    /// One bit for each surface of the case, by its place in the list.
    surfaces: u128,
    /// Twice the interface plus the lip, plus one; 0 where there is none.
    lip: u32,
}

/// Bits of a number on its journey between ranks, all of which a number of 64 bits keeps.
const BITS: u32 = 52;

impl Marks {
    /// Surfaces of which marks tell.
    pub const SURFACES: usize = u128::BITS as usize;

    /// Numbers that marks take on their journey between ranks.
    pub const PACKED: usize = 4;

    /// Of a node of `body` on the surfaces whose bits are set, by their places in the list of the
    /// case; no junction.
    pub(super) fn new(body: usize, surfaces: u128, lip: Option<(usize, Lip)>) -> Self {
        let lip = lip.map_or(0, |(index, lip)| 1 + 2 * index + lip.index());
        Self { body: body as u32, is_junction: false, surfaces, lip: lip as u32 }
    }

    /// The same in another body.
    pub(super) fn in_body(self, body: u32) -> Self {
        Self { body, ..self }
    }

    /// Whether the node lies on a surface.
    pub fn is_on(&self, surface: SurfaceBit) -> bool {
        match surface {
            SurfaceBit::All => true,
            SurfaceBit::Place(place) => place < Self::SURFACES && self.surfaces >> place & 1 == 1,
        }
    }

    /// The interface on whose lip the node lies, and which lip that is.
    pub fn lip(&self) -> Option<(usize, Lip)> {
        let code = self.lip.checked_sub(1)? as usize;
        Some((code / 2, Lip::BOTH[code % 2]))
    }

    /// Whether the node lies on this lip of this interface.
    pub fn is_lip(&self, interface: usize, lip: Lip) -> bool {
        self.lip() == Some((interface, lip))
    }

    /// As whole numbers below 2^52, which survive any exchange of numbers.
    pub fn packed(&self) -> [f64; Self::PACKED] {
        let part = |shift: u32| (self.surfaces >> shift) as u64 & ((1 << BITS) - 1);
        let first = u64::from(self.body) | u64::from(self.is_junction) << 32;
        // The last 24 surfaces and, below 2^28 as there are at most 1000 interfaces, the lip.
        let last = part(2 * BITS) | u64::from(self.lip) << 24;
        [first, part(0), part(BITS), last].map(|bits| bits as f64)
    }

    /// Back from [`Marks::packed`].
    pub fn unpacked(numbers: [f64; Self::PACKED]) -> Self {
        let [first, low, middle, last] = numbers.map(|number| number as u64);
        let high = u128::from(last & 0xff_ffff) << (2 * BITS);
        Self {
            body: first as u32,
            is_junction: first >> 32 == 1,
            surfaces: u128::from(low) | u128::from(middle) << BITS | high,
            lip: (last >> 24) as u32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_survive_the_journey() {
        let ends = [0, 51, 52, 103, 104, 127].iter().fold(0, |bits, place| bits | 1_u128 << place);
        for lip in [None, Some((0, Lip::Lower)), Some((999, Lip::Upper))] {
            for (body, surfaces) in [(0, 0), (1000, 0b101101), (u32::MAX as usize, ends)] {
                for is_junction in [false, true] {
                    let marks = Marks { is_junction, ..Marks::new(body, surfaces, lip) };
                    assert_eq!(Marks::unpacked(marks.packed()), marks);
                }
            }
        }
        for place in 0..128 {
            let marks = Marks::unpacked(Marks::new(0, 1 << place, None).packed());
            assert!((0..130).all(|p| marks.is_on(SurfaceBit::Place(p)) == (p == place)));
        }
        let marks = Marks::new(3, 0b101101, Some((7, Lip::Upper)));
        assert!(marks.is_on(SurfaceBit::Place(0)) && !marks.is_on(SurfaceBit::Place(1)));
        assert!(marks.is_on(SurfaceBit::All) && marks.is_lip(7, Lip::Upper));
        assert!(!marks.is_lip(7, Lip::Lower));
    }
}
