//! Whether any body of the column can move freely as a rigid body.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::case::Case;
use crate::case::bodies::Bodies;
use crate::case::sections::{
    BoundarySpec, ColumnSpec, InterfaceSpec, Material, MeshSource, Motion, Surface,
};

impl Case {
    /// The rigid motions that are free when only the interfaces marked in `holds` join their
    /// bodies, and those marked in `presses` keep them together along their normals, one sentence
    /// for each group of bodies; none for a mesh file, whose bodies are not known. Local.
    pub fn free_motions(&self, holds: &[bool], presses: &[bool]) -> Vec<String> {
        let Some(column) = self.mesh.column() else { return Vec::new() };
        free_motions(column, &self.interfaces, &self.boundary, holds, presses)
    }

    /// Where a body lies, in words. Local.
    pub fn place_of_body(&self, body: usize) -> String {
        match &self.mesh.source {
            MeshSource::Boxes(column) => Bodies::new(column, &self.interfaces).place(&[body]),
            MeshSource::File(file) => format!("of {}", file.path.display()),
        }
    }

    /// The stiffness of the column against pulling, by area: 1 / sum of height over Young's modulus
    /// (Pa/m). An interface that softens more steeply snaps back. None for the mesh of a file.
    /// Local.
    pub fn axial_stiffness(&self) -> Option<f64> {
        let height = self.mesh.column()?.height();
        let part = |material: &Material| {
            let [low, high] = material.z.unwrap_or([0.0, height]);
            (high.min(height) - low.max(0.0)) / material.young_modulus
        };
        Some(1.0 / self.materials.iter().map(part).sum::<f64>())
    }
}

/// Whether each interface joins its bodies at the start; where that depends on the place it is
/// taken to do so.
pub(super) fn holds(interfaces: &[InterfaceSpec]) -> Vec<bool> {
    interfaces.iter().map(|i| i.joins_at_start().unwrap_or(true)).collect()
}

/// Whether each interface presses on its bodies where it does not join them: contact does, and a
/// crack that is there at the start, along its normal, as long as a load keeps it closed.
pub(super) fn presses(interfaces: &[InterfaceSpec]) -> Vec<bool> {
    let presses =
        |i: &InterfaceSpec| i.law.law().strength().is_none() || i.joins_at_start() == Some(false);
    interfaces.iter().map(presses).collect()
}

/// The rigid motions that nothing prevents, one sentence for each group of bodies.
///
/// Bodies joined by an interface that `holds` move together; one that only `presses` keeps their
/// normal displacements together. A motion is free when no prescribed component of a group and no
/// such interface sees it, which is the null space of the constraint rows taken at the corners of
/// the surfaces that the groups touch. A platen that follows its load has motions of its own,
/// against which alone it holds.
pub(super) fn free_motions(
    column: &ColumnSpec,
    interfaces: &[InterfaceSpec],
    boundary: &[BoundarySpec],
    holds: &[bool],
    presses: &[bool],
) -> Vec<String> {
    let all = Bodies::new(column, interfaces);
    let groups = all.together(holds);
    let part = |members: &Vec<usize>| {
        let [first, last] = [members[0], members[members.len() - 1]];
        let [[below, _], [_, above]] = [first, last].map(|body| all.interfaces_of(body));
        Part {
            lengths: column.lengths(),
            height: column.height(),
            z: [all.z(first)[0], all.z(last)[1]],
            touches_bottom: below.is_none(),
            touches_top: above.is_none(),
            dim: column.size.len(),
        }
    };
    let parts: Vec<Part> = groups.iter().map(part).collect();
    // An interface lies on top of the last body of its lower group.
    let is_pressed =
        |lower: usize| groups[lower].last().is_some_and(|interface| presses[*interface]);
    let mut sentences = Vec::new();
    for (members, motions) in groups.iter().zip(motions_left(&parts, boundary, is_pressed)) {
        if motions.is_empty() {
            continue;
        }
        let [first, last] = [members[0], members[members.len() - 1]];
        let [[below, _], [_, above]] = [first, last].map(|body| all.interfaces_of(body));
        let bodies = if first == last {
            format!("body {}", first + 1)
        } else {
            format!("bodies {} to {}", first + 1, last + 1)
        };
        let mut beside = [below, above].into_iter().flatten();
        let contact = if beside.any(|i| i.joins_at_start() == Some(false)) {
            "; a contact holds what is pressed on it along its normal, and nothing sideways without \
             friction"
        } else {
            ""
        };
        sentences.push(format!(
            "{bodies} ({}) can move freely: {}; prescribe displacements that prevent it, or choose \
             a law that holds{contact}",
            all.place(members),
            motions.join(", ")
        ));
    }
    sentences
}

/// The names of the free motions of each part, bottom to top; `is_pressed` tells whether a part and
/// the one above it keep their normal displacements together.
fn motions_left(
    parts: &[Part],
    boundary: &[BoundarySpec],
    is_pressed: impl Fn(usize) -> bool,
) -> Vec<Vec<String>> {
    let Some(motions) = parts.first().map(Part::motions) else { return Vec::new() };
    let platens = platens(boundary);
    let (width, of_parts) = (motions.len(), motions.len() * parts.len());
    let size = of_parts + platens.len();
    let mut rows: Vec<f64> = Vec::new();
    let mut add = |values: &[(usize, f64, [f64; 3], usize)], of_platens: &[f64]| {
        let mut row = vec![0.0; of_parts];
        for (part, sign, point, axis) in values {
            for (value, motion) in row[part * width..][..width].iter_mut().zip(motions) {
                *value += sign * displacement(*motion, *point)[*axis];
            }
        }
        rows.extend(row.iter().chain(of_platens));
    };
    let none = vec![0.0; platens.len()];
    for (number, part) in parts.iter().enumerate() {
        for (point, axis, entry) in part.held_points(boundary) {
            let lever = part.lever(point, &boundary[entry].on);
            let moved = |(of, motion): &(usize, usize)| match *of == entry {
                true => -displacement(*motion, lever)[axis],
                false => 0.0,
            };
            add(&[(number, 1.0, point, axis)], &platens.iter().map(moved).collect::<Vec<f64>>());
        }
        if number + 1 < parts.len() && is_pressed(number) {
            let upper = parts[number + 1].corners(&Surface::Bottom);
            for (below, above) in part.corners(&Surface::Top).into_iter().zip(upper) {
                add(&[(number, -1.0, below, 2), (number + 1, 1.0, above, 2)], &none);
            }
        }
    }
    // Zero rows make the matrix tall, so that the decomposition has every right vector.
    rows.resize(rows.len() + size * size, 0.0);
    let rows = DMatrix::from_row_slice(rows.len() / size, size, &rows);
    let svd = rows.svd(false, true);
    let largest = svd.singular_values.max().max(1e-300);
    let Some(right) = svd.v_t else { return vec![Vec::new(); parts.len()] };
    let free: Vec<usize> =
        (0..size).filter(|index| svd.singular_values[*index] <= 1e-9 * largest).collect();
    let of_part = |number: usize| {
        let moved = DMatrix::from_fn(width, free.len().max(1), |motion, index| {
            free.get(index).map_or(0.0, |free| right[(*free, number * width + motion)])
        });
        names_of(motions, moved)
    };
    (0..parts.len()).map(of_part).collect()
}

/// The motions of a part in those that `moved` has as columns.
fn names_of(motions: &[usize], moved: DMatrix<f64>) -> Vec<String> {
    // A singular value decomposition of less than full rank has left vectors that are less exact.
    let eigen = SymmetricEigen::new(&moved * moved.transpose());
    let kept: Vec<usize> = (0..motions.len()).filter(|k| eigen.eigenvalues[*k] > 1e-12).collect();
    let share =
        |row: usize| kept.iter().map(|k| eigen.eigenvectors[(row, *k)].powi(2)).sum::<f64>();
    let named = motions.iter().enumerate().filter(|(row, motion)| {
        // A rotation about a line off the centre has a translation in it that is not free by
        // itself: only the rotation is named.
        if **motion > 2 { share(*row).sqrt() > 1e-6 } else { (share(*row) - 1.0).abs() < 1e-6 }
    });
    let name = |motion: usize| {
        let (kind, word) =
            if motion < 3 { ("translation", "along") } else { ("rotation", "about") };
        format!("{kind} {word} {}", ["x", "y", "z"][motion % 3])
    };
    named.map(|(_, motion)| name(*motion)).collect()
}

/// The motions of platens that follow their loads: the entry, and the translation or rotation.
fn platens(boundary: &[BoundarySpec]) -> Vec<(usize, usize)> {
    let mut all = Vec::new();
    for (entry, rigid) in
        boundary.iter().enumerate().filter_map(|(i, e)| Some((i, e.rigid.as_ref()?)))
    {
        let motions = rigid.along.iter().chain(&rigid.about).enumerate();
        let free = motions.filter(|(_, motion)| **motion == Some(Motion::Free));
        all.extend(free.map(|(motion, _)| (entry, motion)));
    }
    all
}

/// Bodies that move together: a box between two heights.
struct Part {
    lengths: [f64; 3],
    /// Of the whole column (m).
    height: f64,
    z: [f64; 2],
    touches_bottom: bool,
    touches_top: bool,
    dim: usize,
}

impl Part {
    /// The translations (0, 1, 2) and rotations (3, 4, 5) that exist in this dimension.
    fn motions(&self) -> &'static [usize] {
        if self.dim == 2 { &[0, 2, 4] } else { &[0, 1, 2, 3, 4, 5] }
    }

    fn touches(&self, surface: &Surface) -> bool {
        match surface {
            Surface::Bottom => self.touches_bottom,
            Surface::Top => self.touches_top,
            Surface::All => false,
            _ => true,
        }
    }

    /// The corners of the surface of this part, relative to its centre and size.
    fn corners(&self, surface: &Surface) -> Vec<[f64; 3]> {
        let size = [self.lengths[0], self.lengths[1], self.z[1] - self.z[0]];
        let scale = size.iter().copied().fold(0.0, f64::max);
        (0..8)
            .map(|corner| [corner & 1, (corner >> 1) & 1, corner >> 2])
            .filter(|ends| surface.axis().is_some_and(|(axis, far)| ends[axis] == usize::from(far)))
            .map(|ends| std::array::from_fn(|i| (ends[i] as f64 - 0.5) * size[i] / scale))
            .collect()
    }

    /// A point as [`Part::corners`] has it, from the centroid of a surface of the column and over
    /// the height of that.
    fn lever(&self, point: [f64; 3], surface: &Surface) -> [f64; 3] {
        let size = [self.lengths[0], self.lengths[1], self.z[1] - self.z[0]];
        let scale = size.iter().copied().fold(0.0, f64::max);
        let whole = [self.lengths[0], self.lengths[1], self.height];
        let middle = [0.5 * whole[0], 0.5 * whole[1], 0.5 * (self.z[0] + self.z[1])];
        std::array::from_fn(|i| {
            let centroid = match surface.axis() {
                Some((axis, far)) if axis == i => {
                    if far {
                        whole[i]
                    } else {
                        0.0
                    }
                }
                _ => 0.5 * whole[i],
            };
            (middle[i] + scale * point[i] - centroid) / self.height
        })
    }

    /// The points at which supports hold a component, with the axis of that and the entry.
    fn held_points(&self, boundary: &[BoundarySpec]) -> Vec<([f64; 3], usize, usize)> {
        let mut held = Vec::new();
        let mut seen: Vec<(&Surface, usize)> = Vec::new();
        let entries = boundary.iter().enumerate().filter(|(_, entry)| self.touches(&entry.on));
        for (number, entry) in entries {
            for axis in (0..3).filter(|axis| entry.displacement[*axis].is_some()) {
                // Another entry that prescribes the same component there holds nothing more.
                if seen.contains(&(&entry.on, axis)) {
                    continue;
                }
                seen.push((&entry.on, axis));
                let corners = self.corners(&entry.on).into_iter();
                held.extend(corners.map(|point| (point, axis, number)));
            }
        }
        held
    }
}

/// The displacement of a point under a unit translation (0, 1, 2) or rotation (3, 4, 5).
fn displacement(motion: usize, [x, y, z]: [f64; 3]) -> [f64; 3] {
    match motion {
        0 => [1.0, 0.0, 0.0],
        1 => [0.0, 1.0, 0.0],
        2 => [0.0, 0.0, 1.0],
        3 => [0.0, -z, y],
        4 => [z, 0.0, -x],
        _ => [-y, x, 0.0],
    }
}
