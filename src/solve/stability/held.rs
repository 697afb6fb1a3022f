//! Which rigid motions of the bodies what is left of the interfaces does not hold.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::assembly::Discretization;
use crate::case::Case;
use crate::comm::Comm;
use crate::mesh::{MeshFacts, axes};
use crate::solve::model::interfaces::{InterfaceState, NodeResponse};

/// A motion is free where what resists it is less than this part of what would if everything held.
const FREE: f64 = 1e-12;
/// Part of a motion in those that are free with which it is named; a translation is named only
/// where it is free by itself.
const NAMED: [f64; 2] = [1e-6, 1.0 - 1e-6];

/// Cohesion is gone where the damage differs from 1 by less: what is left of it is below the usual
/// tolerance of forces.
const LEFT: f64 = 1e-9;

/// Whether nothing but contact is left at a secondary node. Local.
pub fn is_separated(
    interfaces: &InterfaceState,
    interface: usize,
    response: &NodeResponse,
) -> bool {
    let law = interfaces.laws[interface].spec.law();
    response.branch.is_separated() || law.damage(response.history) >= 1.0 - LEFT
}

/// The displacement of a point in a rigid motion: three translations, then three rotations about
/// the axes through `centre`.
fn motion(number: usize, point: [f64; 3], centre: [f64; 3]) -> [f64; 3] {
    let mut u = [0.0; 3];
    if number < 3 {
        u[number] = 1.0;
        return u;
    }
    let (a, b) = ((number - 2) % 3, (number - 1) % 3);
    u[a] = -(point[b] - centre[b]);
    u[b] = point[a] - centre[a];
    u
}

/// The motions that nothing holds in the state that was evaluated last, a sentence for each body:
/// neither prescribed displacements, nor the points of interfaces at which any cohesion is left;
/// points in contact hold the normal displacement. Collective.
pub fn free_motions(
    comm: &Comm,
    case: &Case,
    mesh: &MeshFacts,
    all: &Discretization,
    interfaces: &InterfaceState,
) -> Vec<String> {
    let (dim, bodies) = (all.dim, mesh.bodies);
    let (axes, motions) = (axes(dim), if dim == 2 { &[0, 2, 4][..] } else { &[0, 1, 2, 3, 4, 5] });
    let (width, size) = (motions.len(), motions.len() * bodies);
    let place = |node: usize| (all.nodes.points[node], all.nodes.marks[node].body as usize);
    let holds = |interface: usize, response: &NodeResponse, c: usize| {
        let separated = is_separated(interfaces, interface, response);
        !separated || c + 1 == dim && response.branch.is_closed()
    };
    let prescribed = || (0..all.nodes.owned).filter(|node| all.prescribed[*node] != [false; 3]);
    // Rotations are about the middle of the points of each body that hold it.
    let mut middle = vec![0.0; 4 * bodies];
    let mut count = |node: usize| {
        let (point, body) = place(node);
        let sums = &mut middle[4 * body..][..4];
        sums.iter_mut().zip(point.into_iter().chain([1.0])).for_each(|(sum, x)| *sum += x);
    };
    prescribed().for_each(&mut count);
    for (rows, response) in all.secondary.iter().zip(&interfaces.response) {
        if (0..dim).any(|c| rows.rows[c].is_some() && holds(rows.interface, response, c)) {
            rows.nodes().into_iter().for_each(|node| count(node as usize));
        }
    }
    comm.sum(&mut middle);
    let centre = |body: usize| -> [f64; 3] {
        let sums = &middle[4 * body..][..4];
        std::array::from_fn(|i| if sums[3] > 0.0 { sums[i] / sums[3] } else { 0.5 * mesh.size[i] })
    };
    let at = |node: usize, row: &mut [f64], c: usize, factor: f64| {
        let (point, body) = place(node);
        for (value, number) in row[body * width..].iter_mut().zip(motions) {
            *value += factor * motion(*number, point, centre(body))[axes[c]];
        }
    };
    // What resists the motions, and what would if everything held.
    let mut sums = vec![0.0; size * size + size];
    let mut see = |row: &[f64], holds: bool| {
        let (held, full) = sums.split_at_mut(size * size);
        for (i, a) in row.iter().enumerate().filter(|(_, a)| **a != 0.0) {
            full[i] += a * a;
            if holds {
                row.iter().enumerate().for_each(|(j, b)| held[i * size + j] += a * b);
            }
        }
    };
    for node in prescribed() {
        for c in (0..dim).filter(|c| all.prescribed[node][*c]) {
            let mut row = vec![0.0; size];
            at(node, &mut row, c, 1.0);
            see(&row, true);
        }
    }
    for (rows, response) in all.secondary.iter().zip(&interfaces.response) {
        for c in 0..dim {
            let Some(jump) = &rows.rows[c] else { continue };
            let mut row = vec![0.0; size];
            at(rows.node as usize, &mut row, c, jump.own);
            jump.others.iter().for_each(|(node, a)| at(*node as usize, &mut row, c, *a));
            see(&row, holds(rows.interface, response, c));
        }
    }
    comm.sum(&mut sums);
    let (held, full) = sums.split_at(size * size);
    let scale = |i: usize| if full[i] > 0.0 { full[i].sqrt().recip() } else { 0.0 };
    let held = DMatrix::from_fn(size, size, |i, j| scale(i) * held[i * size + j] * scale(j));
    let spectrum = SymmetricEigen::new(held);
    let free: Vec<usize> = (0..size).filter(|i| spectrum.eigenvalues[*i] <= FREE).collect();
    let mut sentences: Vec<String> = Vec::new();
    for body in 0..bodies {
        let named = motions.iter().enumerate().filter(|(i, number)| {
            let vectors = &spectrum.eigenvectors;
            let share: f64 = free.iter().map(|f| vectors[(body * width + i, *f)].powi(2)).sum();
            share.sqrt() > NAMED[usize::from(**number < 3)]
        });
        let names: Vec<String> = named.map(|(_, number)| name(*number)).collect();
        if !names.is_empty() {
            sentences.push(format!(
                "body {} ({}) can move freely: {}",
                body + 1,
                case.place_of_body(body),
                names.join(", ")
            ));
        }
    }
    sentences
}

fn name(number: usize) -> String {
    let kind = if number < 3 { "translation along" } else { "rotation about" };
    format!("{kind} {}", ["x", "y", "z"][number % 3])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_leave_their_axis_at_rest() {
        let centre = [1.0, 2.0, 3.0];
        for axis in 0..3 {
            let mut point = centre;
            point[axis] += 5.0;
            assert_eq!(motion(3 + axis, point, centre), [0.0; 3]);
            point[(axis + 1) % 3] += 2.0;
            let mut u = [0.0; 3];
            u[(axis + 2) % 3] = 2.0;
            assert_eq!(motion(3 + axis, point, centre), u);
        }
    }
}
