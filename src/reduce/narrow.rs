//! The smaller models that are tried.

use super::Prolongation;
use super::bound::holds;
use crate::case::{Case, Linear, Reduce, Side, Surface};
use crate::interface::Sides;
use crate::mesh::{Column, Lip, LocalMesh, MeshFamily};

/// How far the smaller model is solved, over the tolerance of the case: its error counts as the
/// reduction's.
const TIGHTER: f64 = 1e-3;
/// And at most; rounding is the limit where cells are many.
const TIGHTEST: f64 = 1e-13;

/// The states of all instants are kept: what a node takes on an average, and what all may take
/// (bytes).
const BYTES_OF_NODE: u64 = 400;
const MOST_BYTES: u64 = 1 << 29;

/// Every rank solves the smaller model by itself.
const MOST_UNKNOWNS: u64 = 50_000;

/// A smaller model has at most one of so many cells.
const FEWER: u64 = 2;

/// A smaller model.
pub struct Candidate {
    /// What it leaves out, in words.
    pub left_out: &'static str,
    /// The axes along which it has the cells of the model asked for.
    pub kept: [bool; 3],
    /// Its lattice.
    pub(super) column: Column,
    /// The lattice that was asked for.
    wide: Column,
    /// Whether it serves only where displacements are linear in each of its cells.
    pub is_straight: bool,
}

/// What is left out, and the axes along which the cells are kept.
const KINDS: [(&str, [bool; 3]); 4] = [
    ("the column is uniform: one cell for each body and material", [false; 3]),
    ("the column is uniform across its section: one cell wide", [false, false, true]),
    ("nothing varies along y: a slice one cell deep", [true, false, true]),
    ("nothing varies along x: a slice one cell wide", [false, true, true]),
];

impl Candidate {
    /// From its nodes to those of the model asked for. Local.
    pub fn prolongation(&self) -> Prolongation {
        Prolongation::new(&self.column, &self.wide)
    }

    /// Its mesh, which one rank holds as a whole. Local.
    pub fn mesh(&self) -> LocalMesh {
        let cells = self.column.cells();
        LocalMesh::new(&self.column, (0..cells).collect(), cells)
    }
}

/// The smaller models to try in the place of one on `mesh`, smallest first. Local.
pub fn candidates(case: &Case, mesh: &LocalMesh) -> Vec<Candidate> {
    mesh.lattice().map_or_else(Vec::new, |wide| narrower(case, wide))
}

/// As [`candidates`], before any rank has its part of the mesh. Local.
pub fn candidates_in(case: &Case, family: &MeshFamily) -> Vec<Candidate> {
    family.lattice().map_or_else(Vec::new, |wide| narrower(case, wide))
}

fn narrower(case: &Case, wide: &Column) -> Vec<Candidate> {
    let has_weight =
        case.gravity != [0.0; 3] || case.body_force.iter().any(|force| !force.is_zero());
    let mut list: Vec<Candidate> = Vec::new();
    for (left_out, keep) in KINDS {
        // What acts inside the column bends its displacements, and nothing else that is uniform
        // does.
        let is_straight = keep == [false; 3];
        if !keep[0] && !keep[1] && is_straight == has_weight {
            continue;
        }
        if keep[0] != keep[1] && (case.dim == 2 || !is_held(case, usize::from(keep[0]))) {
            continue;
        }
        let column = wide.narrowed(keep);
        let states = column.nodes() * case.time.len() as u64 * BYTES_OF_NODE;
        if states > MOST_BYTES || column.nodes() * case.dim as u64 > MOST_UNKNOWNS {
            continue;
        }
        let is_new = list.iter().all(|c| c.column.cells() != column.cells());
        if is_new && column.cells() * FEWER <= wide.cells() {
            list.push(Candidate { left_out, kept: keep, column, wide: wide.clone(), is_straight });
        }
    }
    list
}

/// Whether both faces across an axis are held along it, so that nothing need vary there.
fn is_held(case: &Case, axis: usize) -> bool {
    let faces = &[[Surface::Left, Surface::Right], [Surface::Front, Surface::Back]][axis];
    faces.iter().all(|face| holds(case, face, axis))
}

/// The case of a smaller model of the one whose interfaces have these `sides`. Local.
pub fn narrowed(case: &Case, sides: &[Sides]) -> Case {
    let mut narrow = case.clone();
    for (interface, side) in narrow.interfaces.iter_mut().zip(sides) {
        interface.secondary = Some(match side.secondary {
            Lip::Lower => Side::Lower,
            Lip::Upper => Side::Upper,
        });
    }
    narrow.solver.linear = Linear::Mumps;
    narrow.solver.tolerance = (TIGHTER * case.solver.tolerance).max(TIGHTEST);
    narrow.reduce = Reduce::Never;
    narrow
}
