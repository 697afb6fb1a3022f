//! Whether any body of the column can move freely as a rigid body.

use nalgebra::DMatrix;

use crate::case::Case;
use crate::case::bodies::Bodies;
use crate::case::sections::{
    BoundarySpec, ColumnSpec, InterfaceSpec, Material, MeshSource, Surface,
};

impl Case {
    /// The rigid motions that are free when only the interfaces marked in `holds` join their
    /// bodies, one sentence for each group of bodies; none for a mesh file, whose bodies are
    /// not known. Local.
    pub fn free_motions(&self, holds: &[bool]) -> Vec<String> {
        let Some(column) = self.mesh.column() else { return Vec::new() };
        free_motions(column, &self.interfaces, &self.boundary, holds)
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

/// The rigid motions that nothing prevents, one sentence for each group of bodies.
///
/// Bodies joined by an interface that `holds` move together. A motion is free when no prescribed
/// component of the group sees it, which is the null space of the constraint rows taken at the
/// corners of the surfaces that the group touches.
pub(super) fn free_motions(
    column: &ColumnSpec,
    interfaces: &[InterfaceSpec],
    boundary: &[BoundarySpec],
    holds: &[bool],
) -> Vec<String> {
    let all = Bodies::new(column, interfaces);
    let mut sentences = Vec::new();
    for members in all.together(holds) {
        let [first, last] = [members[0], members[members.len() - 1]];
        let [[below, _], [_, above]] = [first, last].map(|body| all.interfaces_of(body));
        let part = Part {
            lengths: column.lengths(),
            z: [all.z(first)[0], all.z(last)[1]],
            touches_bottom: below.is_none(),
            touches_top: above.is_none(),
            dim: column.size.len(),
        };
        let motions = part.free_motions(boundary);
        if motions.is_empty() {
            continue;
        }
        let bodies = if first == last {
            format!("body {}", first + 1)
        } else {
            format!("bodies {} to {}", first + 1, last + 1)
        };
        let mut beside = [below, above].into_iter().flatten();
        let is_pressed = motions.iter().any(|motion| motion == "translation along z");
        let contact = if is_pressed && beside.any(|i| i.joins_at_start() == Some(false)) {
            "; a contact does not count, also where weight or a traction presses it: in the place \
             of the load prescribe the displacement of a surface of that body, or hold it by \
             linear_softening with a strength that is small beside the load"
        } else {
            ""
        };
        sentences.push(format!(
            "{bodies} ({}) can move freely: {}; prescribe displacements that prevent it, or choose \
             a law that holds{contact}",
            all.place(&members),
            motions.join(", ")
        ));
    }
    sentences
}

/// Bodies that move together: a box between two heights.
struct Part {
    lengths: [f64; 3],
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

    fn free_motions(&self, boundary: &[BoundarySpec]) -> Vec<String> {
        let motions = self.motions();
        let mut rows: Vec<f64> = Vec::new();
        let mut seen: Vec<(&Surface, usize)> = Vec::new();
        for entry in boundary.iter().filter(|entry| self.touches(&entry.on)) {
            for axis in (0..3).filter(|axis| entry.displacement[*axis].is_some()) {
                // Another entry that prescribes the same component there holds nothing more.
                if seen.contains(&(&entry.on, axis)) {
                    continue;
                }
                seen.push((&entry.on, axis));
                for point in self.corners(&entry.on) {
                    rows.extend(motions.iter().map(|motion| displacement(*motion, point)[axis]));
                }
            }
        }
        // Zero rows make the matrix tall, so that the decomposition has every right vector.
        rows.resize(rows.len() + motions.len() * motions.len(), 0.0);
        let rows = DMatrix::from_row_slice(rows.len() / motions.len(), motions.len(), &rows);
        let svd = rows.svd(false, true);
        let largest = svd.singular_values.max();
        let Some(right) = svd.v_t else { return Vec::new() };
        let free: Vec<usize> = (0..motions.len())
            .filter(|index| svd.singular_values[*index] <= 1e-9 * largest.max(1e-300))
            .collect();
        motions
            .iter()
            .enumerate()
            .filter(|(column, _)| {
                let share: f64 = free.iter().map(|row| right[(*row, *column)].powi(2)).sum();
                share.sqrt() > 1e-6
            })
            .filter(|(column, motion)| {
                // A rotation about a line off the centre has a translation in it that is not
                // free by itself: only the rotation is named.
                **motion > 2 || {
                    let share: f64 = free.iter().map(|row| right[(*row, *column)].powi(2)).sum();
                    (share - 1.0).abs() < 1e-6
                }
            })
            .map(|(_, motion)| {
                let axis = ["x", "y", "z"][motion % 3];
                let (kind, word) =
                    if *motion < 3 { ("translation", "along") } else { ("rotation", "about") };
                format!("{kind} {word} {axis}")
            })
            .collect()
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
