//! Corners of quadrilaterals and hexahedra as bits: bit i is set where the local coordinate i is 1.

use crate::element::Shape;

/// The bits of a corner, and the corner of bits: nodes run round each layer.
pub fn bits(corner: usize) -> usize {
    corner ^ ((corner >> 1) & 1)
}

/// A side of a cube: the axis that it lies across, and whether at its high end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Side {
    pub axis: usize,
    pub is_high: bool,
}

impl Side {
    /// The facets of a shape of first order.
    pub fn of_facets(shape: Shape) -> Vec<Self> {
        let full = shape.nodes() - 1;
        let side = |facet: &&[usize]| {
            let and = facet.iter().fold(full, |all, corner| all & bits(*corner));
            let or = facet.iter().fold(0, |any, corner| any | bits(*corner));
            let common = !(and ^ or) & full;
            Self { axis: common.trailing_zeros() as usize, is_high: and & common != 0 }
        };
        shape.facets().iter().map(side).collect()
    }

    /// The facet on this side.
    pub fn facet(self, sides: &[Self]) -> usize {
        sides.iter().position(|side| *side == self).expect("a cube has all its sides")
    }

    /// Bits of a corner moved to this side.
    pub fn pull(self, bits: usize) -> usize {
        if self.is_high { bits | 1 << self.axis } else { bits & !(1 << self.axis) }
    }

    /// Whether the corner of these bits lies on it.
    pub fn has(self, bits: usize) -> bool {
        self.pull(bits) == bits
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_those_of_local_coordinates() {
        for shape in [Shape::Quad4, Shape::Hex8] {
            for (corner, point) in shape.node_points().iter().enumerate() {
                let of_point: usize =
                    (0..shape.dim()).map(|i| usize::from(point[i] > 0.0) << i).sum();
                assert_eq!((bits(corner), bits(of_point)), (of_point, corner));
            }
            let sides = Side::of_facets(shape);
            for (facet, side) in sides.iter().enumerate() {
                assert_eq!(side.facet(&sides), facet);
                let on = shape.facets()[facet];
                for (corner, point) in shape.node_points().iter().enumerate() {
                    assert_eq!(side.has(bits(corner)), on.contains(&corner));
                    assert_eq!(on.contains(&corner), (point[side.axis] > 0.0) == side.is_high);
                }
            }
        }
    }
}
