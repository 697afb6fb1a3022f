//! Memory that a run will need, before it starts.
//!
//! Measured on columns and cubes of 10 000 to 530 000 unknowns: within 30 % of the largest resident
//! memory with every preset on 1 and 2 ranks; with flow on squares and cubes of 13 000 to 150 000.

use super::linear::{AGGREGATION, MULTIGRID};
use crate::case::Case;
use crate::mesh::MeshFacts;

/// What a rank has before its share of the problem: libraries, mostly (bytes).
const PER_RANK: f64 = 5.5e7;

/// Bytes per unknown of the presets whose memory grows with the size alone: 2D and 3D of first
/// order, 2D and 3D of second order.
const PER_UNKNOWN: [(&str, [f64; 4]); 4] = [
    (AGGREGATION, [1030.0, 1840.0, 1200.0, 3600.0]),
    (MULTIGRID, [440.0, 420.0, 420.0, 400.0]),
    ("gamg", [870.0, 1850.0, 1200.0, 3470.0]),
    ("hypre", [980.0, 2650.0, 1520.0, 5700.0]),
];

/// The cells of a file have stiffness matrices of their own, where those of a box share theirs.
const LEVELS_OF_FILE: f64 = 1.75;

/// With smoothed aggregation and elimination several ranks hold more than one does.
const SHARED: [(&str, f64); 2] = [("gamg", 1.6), ("mumps", 1.35)];

/// Factors hold per unknown so many bytes times a power of the unknowns of the smallest section: 2D
/// and 3D.
const FACTORS: [f64; 2] = [157.0, 400.0];
const POWER: f64 = 0.45;
/// Rows of second order are fuller.
const FACTORS_OF_SECOND_ORDER: f64 = 1.25;

/// Flow takes so many bytes per pressure, 2D and 3D, most of them for the multigrid of its block,
/// and for the vectors of GMRES and earlier corrections so many per displacement.
const PER_PRESSURE: [f64; 2] = [1100.0, 1600.0];
const PER_VECTORS: f64 = 275.0;

/// Pressures that are unknown, at most: as if all cells were porous.
pub fn pressures(case: &Case, mesh: &MeshFacts) -> u64 {
    if case.flow.is_some() { mesh.corners } else { 0 }
}

/// The memory of all ranks, about (bytes).
pub fn memory(preset: &str, case: &Case, mesh: &MeshFacts, ranks: usize) -> f64 {
    let displacements = mesh.nodes as f64 * mesh.dim as f64;
    let pressures = pressures(case, mesh) as f64;
    let (flat, second) = (mesh.dim == 2, mesh.order == 2);
    let kind = 2 * usize::from(second) + usize::from(!flat);
    let listed = PER_UNKNOWN.iter().find(|(name, _)| *name == preset);
    let shared = SHARED.iter().find(|(name, _)| *name == preset && ranks > 1);
    let shared = shared.map_or(1.0, |(_, factor)| *factor);
    let own = preset == MULTIGRID && case.mesh.file().is_some();
    let shared = if own { LEVELS_OF_FILE * shared } else { shared };
    let solver = if let Some((_, bytes)) = listed {
        let vectors = if pressures > 0.0 { PER_VECTORS } else { 0.0 };
        let beside = pressures * PER_PRESSURE[usize::from(!flat)] + displacements * vectors;
        displacements * bytes[kind] * shared + beside
    } else {
        // Both fields are eliminated together: pressures lengthen the rows and the sections.
        let longer = 1.0 + pressures / displacements;
        let rows =
            FACTORS[usize::from(!flat)] * (longer * (mesh.dim as f64 * mesh.section)).powf(POWER);
        let rows = rows * if second { FACTORS_OF_SECOND_ORDER } else { 1.0 };
        (displacements + pressures) * rows * shared
    };
    PER_RANK * ranks as f64 + solver
}
