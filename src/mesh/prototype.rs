//! What like cells have in common.

use std::collections::HashMap;

use serde::{Deserialize, Serialize};

use crate::element::{Family, Shape};

/// A cell that stands for all its like: boxes of one size, material and order are identical up to
/// translation, and share one stiffness; other cells have shape and material in common.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Prototype {
    /// Whether it is a box, and of what size.
    pub geometry: Geometry,
    /// Index of the material.
    pub material: usize,
    /// The shape of the cell.
    pub shape: Shape,
}

/// How much is known of the geometry of like cells.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Geometry {
    /// A box along the axes, its nodes in the order of the axes of the components: edge lengths
    /// along x, y, z (m; that across a plane is 1).
    Box([f64; 3]),
    /// Any: the positions of its nodes say.
    Points,
}

impl Geometry {
    /// The edge lengths of a box (m).
    pub fn size(&self) -> Option<[f64; 3]> {
        match self {
            Geometry::Box(size) => Some(*size),
            Geometry::Points => None,
        }
    }

    /// Of a cell with these nodes (m), in the order of its shape, whose displacement components lie
    /// along `axes`.
    pub fn of(shape: Shape, points: &[[f64; 3]], axes: &[usize]) -> Self {
        if shape.family() != Family::Cube || shape.dim() != axes.len() {
            return Geometry::Points;
        }
        let mut size = [1.0; 3];
        for (component, axis) in axes.iter().enumerate() {
            let low = points[0][*axis];
            let edge = points.iter().fold(0.0_f64, |m, x| m.max(x[*axis] - low));
            let fits = |(x, xi): (&[f64; 3], &[f64; 3])| {
                let at = 0.5 * (xi[component] + 1.0) * edge;
                (x[*axis] - low - at).abs() <= ALIKE * edge
            };
            if edge <= 0.0 || !points.iter().zip(shape.node_points()).all(fits) {
                return Geometry::Points;
            }
            size[*axis] = edge;
        }
        Geometry::Box(size)
    }
}

/// Cells whose edges differ by less than this part of them are alike.
const ALIKE: f64 = 1e-12;
/// Bits of a length that are not told apart, so many that alike lengths fall into one class or into
/// neighbouring ones.
const COARSE: u32 = 14;

/// Prototypes by geometry, each found in the same time however many there are.
#[derive(Default)]
pub(super) struct Prototypes {
    pub list: Vec<Prototype>,
    classes: HashMap<(usize, Shape, [u64; 3]), Vec<u32>>,
    others: HashMap<(usize, Shape), u32>,
    /// Boxes of late with their numbers, by a hash of their size: rounding leaves few sizes.
    recent: Vec<Option<(Prototype, u32)>>,
}

/// Places for boxes of late, as many as eight bits tell apart.
const RECENT: usize = 256;

impl Prototypes {
    /// The number of the first prototype that is like `cell`, which becomes one if there is none.
    pub fn number(&mut self, cell: Prototype) -> u32 {
        match cell.geometry {
            Geometry::Box(size) => {
                // An odd number by which products stir the upper bits.
                let stir =
                    |hash: u64, x: &f64| (hash ^ x.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15);
                let place = (size.iter().fold(0, stir) >> 56) as usize;
                self.recent.resize(RECENT, None);
                if let Some((_, number)) = self.recent[place].filter(|(known, _)| *known == cell) {
                    return number;
                }
                let number = self.box_number(cell, size);
                self.recent[place] = Some((cell, number));
                number
            }
            Geometry::Points => {
                let next = self.list.len() as u32;
                let number = *self.others.entry((cell.material, cell.shape)).or_insert(next);
                if number == next {
                    self.list.push(cell);
                }
                number
            }
        }
    }

    fn box_number(&mut self, cell: Prototype, size: [f64; 3]) -> u32 {
        let alike = |other: &Prototype| {
            let of = other.geometry.size();
            of.is_some_and(|of| (0..3).all(|i| (of[i] - size[i]).abs() <= ALIKE * size[i]))
        };
        let ends = size.map(|x| [x * (1.0 - ALIKE), x * (1.0 + ALIKE)].map(class));
        let mut first: Option<u32> = None;
        for corner in 0..8 {
            let end = |axis: usize| corner >> axis & 1;
            // Usually both ends are of one class.
            if (0..3).any(|axis| end(axis) == 1 && ends[axis][0] == ends[axis][1]) {
                continue;
            }
            let key = (cell.material, cell.shape, [0, 1, 2].map(|axis| ends[axis][end(axis)]));
            let found = self.classes.get(&key).into_iter().flatten();
            let found = found.copied().filter(|number| alike(&self.list[*number as usize]));
            first = first.into_iter().chain(found).min();
        }
        first.unwrap_or_else(|| {
            let number = self.list.len() as u32;
            let key = (cell.material, cell.shape, size.map(class));
            self.classes.entry(key).or_default().push(number);
            self.list.push(cell);
            number
        })
    }
}

fn class(length: f64) -> u64 {
    length.to_bits() >> COARSE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_alike_whatever_their_number() {
        let cell = |size| {
            let geometry = Geometry::Box(size);
            Prototype { geometry, material: 0, shape: Shape::Hex8 }
        };
        let mut prototypes = Prototypes::default();
        let count = 70_000_u32;
        let edge = |i: u32| 1.0 + 1e-9 * f64::from(i);
        for i in 0..count {
            assert_eq!(prototypes.number(cell([edge(i), 1.0, 2.0])), i);
        }
        for i in (0..count).step_by(7) {
            for by in [0.0, 9e-13, -9e-13] {
                assert_eq!(prototypes.number(cell([edge(i) * (1.0 + by), 1.0 + by, 2.0])), i);
            }
        }
        let other = Prototype { material: 1, ..cell([1.0; 3]) };
        assert_eq!(prototypes.number(other), count);
        assert_eq!(prototypes.list.len(), count as usize + 1);
    }
    #[test]
    fn boxes_are_seen_and_nothing_else_is_taken_for_one() {
        for (shape, axes) in [(Shape::Quad9, &[0, 2][..]), (Shape::Hex8, &[0, 1, 2])] {
            let size = [0.5, if axes.len() == 2 { 1.0 } else { 3.0 }, 0.25];
            let mut points: Vec<[f64; 3]> = vec![[7.0, 8.0, 9.0]; shape.nodes()];
            for (point, xi) in points.iter_mut().zip(shape.node_points()) {
                for (component, axis) in axes.iter().enumerate() {
                    point[*axis] += 0.5 * size[*axis] * xi[component];
                }
            }
            assert_eq!(Geometry::of(shape, &points, axes), Geometry::Box(size));
            let mut turned = points.clone();
            turned.rotate_left(1);
            assert_eq!(Geometry::of(shape, &turned, axes), Geometry::Points);
            points[2][0] += 1e-9;
            assert_eq!(Geometry::of(shape, &points, axes), Geometry::Points);
        }
    }

    #[test]
    fn general_cells_of_one_shape_and_material_have_one_prototype() {
        let mut prototypes = Prototypes::default();
        let of = |material, shape| Prototype { geometry: Geometry::Points, material, shape };
        let cells =
            [of(0, Shape::Tet4), of(0, Shape::Hex8), of(0, Shape::Tet4), of(1, Shape::Tet4)];
        assert_eq!(cells.map(|cell| prototypes.number(cell)), [0, 1, 0, 2]);
    }
}
