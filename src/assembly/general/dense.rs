//! The forces by the matrix of every cell: for processors without wide vectors, on which the other
//! kernels are not compiled, since that would take as long again.

use super::group::{Group, Pass};
use super::lanes::LANES;
use crate::element::MAX_NODES;

/// Runs a pass.
pub fn run(pass: Pass<'_>) {
    let Pass { group, general, field, force: [first, others], mut magnitude } = pass;
    let n = general.shape().nodes();
    let dim = general.shape().dim();
    let size = n * dim;
    let (mut matrix, mut u) = (vec![0.0; size * size], vec![0.0; size]);
    let mut points = [[0.0; 3]; MAX_NODES];
    for cell in 0..group.cells {
        let nodes: Vec<usize> = (0..n).map(|a| node(group, n, cell, a)).collect();
        for (a, node) in nodes.iter().enumerate() {
            points[a] = field.points[*node];
            u[a * dim..][..dim].copy_from_slice(&field.u[node * dim..][..dim]);
        }
        general.matrix(&points[..n], &mut matrix);
        for (a, node) in nodes.iter().enumerate() {
            let mut square = 0.0;
            for c in 0..dim {
                let row = &matrix[(a * dim + c) * size..][..size];
                let own: f64 = row.iter().zip(&u).map(|(k, u)| k * u).sum();
                let place = node * dim + c;
                match place.checked_sub(first.len()) {
                    None => first[place] += own,
                    Some(place) => others[place] += own,
                }
                square += own * own;
            }
            if let Some(magnitude) = magnitude.as_deref_mut() {
                magnitude[*node] += square.sqrt();
            }
        }
    }
}

/// A node of a cell of a group.
fn node(group: &Group, n: usize, cell: usize, a: usize) -> usize {
    group.nodes[(cell / LANES * n + a) * LANES + cell % LANES] as usize
}
