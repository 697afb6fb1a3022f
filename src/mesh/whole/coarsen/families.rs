//! Cells that are the parts of one.

use super::bits::{Side, bits};
use super::kept::Cubes;
use crate::element::Shape;
use crate::mesh::whole::cells::NONE;
use crate::mesh::whole::refine::reference_points;

/// A cell of a coarser mesh and its parts.
#[derive(Debug, Clone)]
pub struct Family {
    /// Its corners among the nodes of the mesh, in the order of its shape.
    pub corners: [u32; 8],
    pub children: Vec<Child>,
}

/// A part of a coarser cell.
#[derive(Debug, Clone, Copy)]
pub struct Child {
    pub cell: u32,
    /// For each of its corners the place among [`reference_points`] of the coarser cell.
    pub places: [u8; 8],
    /// For each of its corners the corner of the coarser cell that lies the same way.
    pub towards: [u8; 8],
}

/// How a part lies: for each local axis the axis of the coarser cell, and at which end of that it
/// keeps its corner.
type Way = [Side; 3];

/// Joins cells to coarser ones.
pub struct Joiner<'a> {
    cubes: &'a Cubes<'a>,
    /// Places of reference points by their coordinates.
    places: [u8; 27],
    /// For each node whether it is a corner of the coarser mesh: yes, no, or unknown.
    role: Vec<u8>,
}

const IS_CORNER: u8 = 1;
const IS_BETWEEN: u8 = 2;

impl<'a> Joiner<'a> {
    pub fn new(cubes: &'a Cubes<'a>) -> Self {
        let mut places = [u8::MAX; 27];
        for (place, point) in reference_points(cubes.shape).iter().enumerate() {
            places[slot_of(*point)] = place as u8;
        }
        Self { cubes, places, role: vec![0; cubes.view.points.len()] }
    }

    /// The coarser cells of connected ones with these `kept` corners, none where they would not
    /// conform. `is_joined` is a scratch, false for all cells and left so.
    pub fn join(
        &mut self,
        cells: &[u32],
        kept: &[u8],
        is_joined: &mut [bool],
    ) -> Option<Vec<Family>> {
        for node in cells.iter().flat_map(|cell| self.cubes.view.cell_nodes(*cell as usize)) {
            self.role[*node as usize] = 0;
        }
        let mut families = Some(Vec::new());
        for cell in cells {
            if is_joined[*cell as usize] {
                continue;
            }
            let family = self.family(*cell, kept, is_joined);
            families = families.zip(family).map(|(mut all, one)| {
                all.push(one);
                all
            });
            if families.is_none() {
                break;
            }
        }
        cells.iter().for_each(|cell| is_joined[*cell as usize] = false);
        families
    }

    /// The coarser cell of which a cell is a part.
    fn family(&mut self, first: u32, kept: &[u8], is_joined: &mut [bool]) -> Option<Family> {
        let dim = self.cubes.shape.dim();
        let own = usize::from(kept[first as usize]);
        let way: Way = std::array::from_fn(|axis| Side { axis, is_high: own >> axis & 1 == 1 });
        let is_halved: [bool; 3] = std::array::from_fn(|axis| {
            axis < dim && self.cubes.beyond(first, inner(own, axis)).is_some()
        });
        let mut family = Family { corners: [NONE; 8], children: Vec::new() };
        let mut ways = vec![(first, own, way)];
        is_joined[first as usize] = true;
        let mut next = 0;
        while let Some((cell, own, way)) = ways.get(next).copied() {
            next += 1;
            for axis in 0..dim {
                let beyond = self.cubes.beyond(cell, inner(own, axis));
                if beyond.is_some() != is_halved[way[axis].axis] {
                    return None;
                }
                let Some(other) = beyond else { continue };
                if !std::mem::replace(&mut is_joined[other.cell as usize], true) {
                    let (of_other, there) = self.way_of((cell, own, &way), axis, other.cell)?;
                    ways.push((other.cell, of_other, there));
                }
            }
            family.children.push(self.child(cell, own, &way, &is_halved, &mut family.corners)?);
        }
        let wanted = 1 << is_halved.iter().filter(|halved| **halved).count();
        let is_whole =
            ways.len() == wanted && !family.corners[..=self.cubes.full()].contains(&NONE);
        is_whole.then_some(family)
    }

    /// The kept corner of a part that is reached along a local axis of another, and how it lies.
    fn way_of(
        &self,
        (cell, own, way): (u32, usize, &Way),
        axis: usize,
        other: u32,
    ) -> Option<(usize, Way)> {
        let (cubes, full) = (self.cubes, self.cubes.full());
        // Both have the middle, and its neighbours on their common side.
        let at = cubes.node(cell, full ^ own);
        let middle = (0..=full).find(|corner| cubes.node(other, *corner) == at)?;
        let mut found = [None; 3];
        for (along, side) in way.iter().enumerate().take(cubes.shape.dim()) {
            if along != axis {
                let node = cubes.node(cell, full ^ own ^ 1 << along);
                let is_it = |local: &usize| cubes.node(other, middle ^ 1 << local) == node;
                found[(0..cubes.shape.dim()).find(is_it)?] = Some(*side);
            }
        }
        let turned = Side { axis: way[axis].axis, is_high: !way[axis].is_high };
        Some((full ^ middle, found.map(|side| side.unwrap_or(turned))))
    }

    /// A part with its places; its kept corners go into those of the coarser cell.
    fn child(
        &mut self,
        cell: u32,
        own: usize,
        way: &Way,
        is_halved: &[bool; 3],
        corners: &mut [u32; 8],
    ) -> Option<Child> {
        let mut child = Child { cell, places: [0; 8], towards: [0; 8] };
        for of_bits in 0..=self.cubes.full() {
            let (mut point, mut towards, mut is_corner) = ([0.0; 3], 0, true);
            for (local, side) in way.iter().enumerate().take(self.cubes.shape.dim()) {
                let keeps = (of_bits ^ own) >> local & 1 == 0;
                let is_high = side.is_high == keeps;
                towards |= usize::from(is_high) << side.axis;
                if keeps || !is_halved[side.axis] {
                    point[side.axis] = if is_high { 1.0 } else { -1.0 };
                } else {
                    is_corner = false;
                }
            }
            child.places[bits(of_bits)] = self.places[slot_of(point)];
            child.towards[bits(of_bits)] = bits(towards) as u8;
            let node = self.cubes.node(cell, of_bits);
            let role = if is_corner { IS_CORNER } else { IS_BETWEEN };
            let before = std::mem::replace(&mut self.role[node as usize], role);
            if before != 0 && before != role {
                return None;
            }
            if is_corner {
                let place = &mut corners[bits(towards)];
                if *place != NONE && *place != node {
                    return None;
                }
                *place = node;
            }
        }
        Some(child)
    }
}

/// The side of a cell with the middle, across an axis, where it keeps the corner `own`.
fn inner(own: usize, axis: usize) -> Side {
    Side { axis, is_high: own >> axis & 1 == 0 }
}

/// A number for each point with coordinates -1, 0 and 1.
fn slot_of(point: [f64; 3]) -> usize {
    point.iter().rev().fold(0, |all, x| 3 * all + (x + 1.0) as usize)
}

/// The shape of first order of all cells, if they are all quadrilaterals or all hexahedra.
pub fn only_shape(shapes: &[Shape]) -> Option<Shape> {
    let first = shapes.first()?.corners();
    let is_cube = matches!(first, Shape::Quad4 | Shape::Hex8);
    (is_cube && shapes.iter().all(|shape| shape.corners() == first)).then_some(first)
}
