//! The rigid motions in the unknowns, which smoothed aggregation has to reproduce.

use crate::assembly::Discretization;
use crate::comm::Comm;

/// The rigid motions of the whole mesh at owned unknowns, at right angles to each other and of
/// 2-norm 1. `axes` are those of the components. Collective.
pub fn rigid_motions(comm: &Comm, axes: &[usize], all: &Discretization) -> Vec<Vec<f64>> {
    let dim = all.dim;
    let owned = 0..all.nodes.owned as u32;
    let along = |c: usize| {
        let mut u = [0.0; 3];
        u[c] = 1.0;
        let motion =
            owned.clone().flat_map(|node| all.frames.unknowns(node, |_| u)[..dim].to_vec());
        motion.collect::<Vec<f64>>()
    };
    let about = |[a, b]: [usize; 2]| {
        let turned = |node: u32| {
            let (point, mut u) = (all.nodes.points[node as usize], [0.0; 3]);
            (u[a], u[b]) = (-point[axes[b]], point[axes[a]]);
            u
        };
        let motion =
            owned.clone().flat_map(|node| all.frames.unknowns(node, turned)[..dim].to_vec());
        motion.collect::<Vec<f64>>()
    };
    let pairs: &[[usize; 2]] = if dim == 2 { &[[0, 1]] } else { &[[0, 1], [1, 2], [2, 0]] };
    let mut motions: Vec<Vec<f64>> = (0..dim).map(along).collect();
    motions.extend(pairs.iter().copied().map(about));
    let mut found: Vec<Vec<f64>> = Vec::new();
    for mut motion in motions {
        // Twice is enough.
        for _ in 0..2 {
            let mut parts: Vec<f64> = found.iter().map(|other| dot(other, &motion)).collect();
            comm.sum(&mut parts);
            for (other, part) in found.iter().zip(parts) {
                motion.iter_mut().zip(other).for_each(|(m, o)| *m -= part * o);
            }
        }
        let mut square = [dot(&motion, &motion)];
        comm.sum(&mut square);
        if square[0] > 0.0 {
            let size = square[0].sqrt();
            found.push(motion.into_iter().map(|m| m / size).collect());
        }
    }
    found
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
