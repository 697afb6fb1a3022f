//! Where a node lies: its body, the named surfaces, and the lip of an interface.

use crate::case::Surface;

/// The named surfaces, in the order of their bits.
pub(super) const SURFACES: [Surface; 6] =
    [Surface::Bottom, Surface::Top, Surface::Left, Surface::Right, Surface::Front, Surface::Back];

/// One of the two lips of an interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Marks {
    /// The body, counted from the bottom.
    pub body: u32,
    /// One bit for each named surface.
    surfaces: u8,
    /// Twice the interface plus the lip, plus one; 0 where there is none.
    lip: u32,
}

impl Marks {
    /// Of a node of `body` on the surfaces of `is_on`, in the order of their bits.
    pub(super) fn new(body: usize, is_on: [bool; 6], lip: Option<(usize, Lip)>) -> Self {
        let surfaces = is_on.iter().enumerate().map(|(bit, on)| u8::from(*on) << bit).sum();
        let lip = lip.map_or(0, |(index, lip)| 1 + 2 * index + lip.index());
        Self { body: body as u32, surfaces, lip: lip as u32 }
    }

    /// Whether the node lies on `surface`.
    pub fn is_on(&self, surface: Surface) -> bool {
        let bit = SURFACES.iter().position(|s| *s == surface);
        bit.is_none_or(|bit| self.surfaces >> bit & 1 == 1)
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

    /// As one number, which is whole and below 2^52.
    pub fn packed(&self) -> f64 {
        (u64::from(self.surfaces) | u64::from(self.body) << 6 | u64::from(self.lip) << 28) as f64
    }

    /// Back from [`Marks::packed`].
    pub fn unpacked(number: f64) -> Self {
        let bits = number as u64;
        let body = (bits >> 6 & 0x3f_ffff) as u32;
        Self { body, surfaces: (bits & 0x3f) as u8, lip: (bits >> 28) as u32 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_survive_the_journey() {
        let some = [true, false, true, true, false, true];
        for lip in [None, Some((0, Lip::Lower)), Some((999, Lip::Upper))] {
            for (body, is_on) in [(0, [false; 6]), (1000, some)] {
                let marks = Marks::new(body, is_on, lip);
                assert_eq!(Marks::unpacked(marks.packed()), marks);
            }
        }
        let marks = Marks::new(3, some, Some((7, Lip::Upper)));
        assert!(marks.is_on(Surface::Bottom) && !marks.is_on(Surface::Top));
        assert!(marks.is_on(Surface::All) && marks.is_lip(7, Lip::Upper));
        assert!(!marks.is_lip(7, Lip::Lower));
    }
}
