//! The forces of the bulk at a prolonged state.

use std::collections::HashMap;

use super::{Candidate, Prolongation, Snapshot};
use crate::mesh::{CellPlace, Column, axes};
use crate::solve::BoundaryValueProblem;

/// What is left of nodal values of this size, over the largest, when their linear part is taken out
/// is rounding.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// And what is left of a state that was solved for.
const STRAIGHT: f64 = 1e-10;

/// Forces and displacements of the linear part in cells of one prototype in one cell of the smaller
/// model.
type Alike = ((u64, u32), [Vec<f64>; 2]);

/// The displacements in a cell of the smaller model.
struct Parent {
    /// Derivatives of the components by x, y, z at the centre.
    gradient: [[f64; 3]; 3],
    /// What nodes have beyond the linear part, by name; empty where it is nothing.
    rest: HashMap<usize, [f64; 3]>,
}

/// Adds the forces of the cells at a prolonged state to `force` (N, `dim` numbers per local node);
/// its energy norm squared (J). `displacement` is by node of the smaller model (m). Local.
///
/// The linear part of the displacements in each cell of the smaller model acts by its gradient:
/// from nodal values, which are large beside their differences in small cells, rounding would be
/// all that is seen.
pub fn add_forces(
    asked: &BoundaryValueProblem,
    prolongation: &Prolongation,
    displacement: &[[f64; 3]],
    force: &mut [f64],
) -> f64 {
    let BoundaryValueProblem { mesh, all, .. } = asked;
    let (dim, column) = (all.dim, prolongation.wide());
    let largest = displacement.iter().flatten().fold(0.0_f64, |m, u| m.max(u.abs()));
    let parents: Vec<Parent> = (0..prolongation.narrow().cells())
        .map(|cell| parent(prolongation.narrow(), cell, displacement, ROUNDING * largest))
        .collect();
    // Long runs of cells are alike.
    let mut linear: Vec<Alike> = Vec::new();
    let (mut last, mut buffer) = (0, Vec::new());
    let mut energy = 0.0;
    for (index, cell) in mesh.cells.iter().enumerate() {
        let place = column.cell_place(*cell);
        let name = prolongation.parent_cell(place);
        let parent = &parents[name as usize];
        let nodes = all.cells.nodes(index);
        let matrix = all.cells.matrix(index, &mut buffer);
        let key = (name, mesh.cell_prototype[index]);
        if linear.get(last).is_none_or(|(before, _)| *before != key) {
            last = linear.iter().position(|(known, _)| *known == key).unwrap_or(linear.len());
        }
        if last == linear.len() {
            let u = linear_part(column, place, &parent.gradient);
            linear.push((key, [multiply(matrix, &u), u]));
        }
        let [own, u] = &linear[last].1;
        let mut add = |forces: &[f64]| {
            for (node, forces) in nodes.iter().zip(forces.chunks_exact(dim)) {
                let at = &mut force[*node as usize * dim..][..dim];
                at.iter_mut().zip(forces).for_each(|(at, force)| *at += force);
            }
        };
        add(own);
        if parent.rest.is_empty() {
            energy += u.iter().zip(own).map(|(u, f)| u * f).sum::<f64>();
            continue;
        }
        let mut rest = Vec::with_capacity(u.len());
        for node in nodes {
            let mut sum = [0.0; 3];
            prolongation.parents(all.nodes.names[*node as usize], |parent_node, weight| {
                let value = parent.rest.get(&parent_node).copied().unwrap_or_default();
                (0..3).for_each(|c| sum[c] += weight * value[c]);
            });
            rest.extend_from_slice(&sum[..dim]);
        }
        let more = multiply(matrix, &rest);
        add(&more);
        let both = u.iter().zip(&rest).zip(own.iter().zip(&more));
        energy += both.map(|((u, r), (f, m))| (u + r) * (f + m)).sum::<f64>();
    }
    energy
}

/// Whether the displacements of all states are linear in each cell, to rounding. Local.
pub fn are_straight(candidate: &Candidate, states: &[Snapshot]) -> bool {
    let column = &candidate.column;
    let all = states.iter().flat_map(|s| s.displacement.as_flattened());
    let largest = all.fold(0.0_f64, |m, u| m.max(u.abs()));
    // The solution's own rounding is larger than that of the values.
    let is_straight = |state: &Snapshot| {
        let split = |cell| parent(column, cell, &state.displacement, STRAIGHT * largest);
        (0..column.cells()).all(|cell| split(cell).rest.is_empty())
    };
    states.iter().all(is_straight)
}

/// Splits the displacements of the nodes of a cell into a linear part and the rest.
fn parent(column: &Column, cell: u64, displacement: &[[f64; 3]], rounding: f64) -> Parent {
    let place = column.cell_place(cell);
    let dim = column.dim;
    let shape = column.shape(place.body);
    let (size, _) = column.cell_size(place);
    let mut slopes = [[0.0; 3]; crate::element::MAX_NODES];
    shape.gradients([0.0; 3], &mut slopes);
    let names = column.cell_nodes(place);
    let mut gradient = [[0.0; 3]; 3];
    for (name, slope) in names.iter().zip(&slopes) {
        for (d, axis) in axes(dim).iter().enumerate() {
            for (c, row) in gradient.iter_mut().enumerate().take(dim) {
                row[*axis] += displacement[*name as usize][c] * slope[d] * 2.0 / size[*axis];
            }
        }
    }
    let origin = (column.point(names[0]), displacement[names[0] as usize]);
    let beyond = |name: &u64| {
        let (point, u) = (column.point(*name), displacement[*name as usize]);
        let value: [f64; 3] = std::array::from_fn(|c| {
            let along = (0..3).map(|axis| gradient[c][axis] * (point[axis] - origin.0[axis]));
            u[c] - origin.1[c] - along.sum::<f64>()
        });
        (*name as usize, value)
    };
    let mut rest: HashMap<usize, [f64; 3]> = names.iter().map(beyond).collect();
    if rest.values().flatten().all(|value| value.abs() <= rounding) {
        rest.clear();
    }
    Parent { gradient, rest }
}

/// Displacements of the nodes of a cell beyond those of its first one, for a gradient.
fn linear_part(column: &Column, place: CellPlace, gradient: &[[f64; 3]; 3]) -> Vec<f64> {
    let (size, _) = column.cell_size(place);
    let points = column.shape(place.body).node_points();
    let mut u = Vec::with_capacity(points.len() * column.dim);
    for point in points {
        for row in gradient.iter().take(column.dim) {
            let along = axes(column.dim).iter().enumerate();
            u.push(along.map(|(d, a)| row[*a] * size[*a] * 0.5 * (point[d] + 1.0)).sum());
        }
    }
    u
}

/// The product of a square matrix, row by row, with a vector.
fn multiply(matrix: &[f64], x: &[f64]) -> Vec<f64> {
    let row = |row: &[f64]| row.iter().zip(x).map(|(a, x)| a * x).sum();
    matrix.chunks_exact(x.len()).map(row).collect()
}
