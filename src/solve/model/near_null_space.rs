//! The rigid motions in the unknowns, which smoothed aggregation has to reproduce.

use crate::aggregation::Motions;
use crate::assembly::{Discretization, NodeState};
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

/// The rigid motions of the mesh at each owned node in the unknowns, without those whose row is the
/// identity, and without jumps, which they leave at zero; `state` is that of every entry of
/// `all.secondary`. Lengths are parts of the size of the mesh. Collective.
pub fn motions_of_nodes(
    comm: &Comm,
    axes: &[usize],
    all: &Discretization,
    state: &[NodeState],
) -> Motions {
    let dim = all.dim;
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in &all.nodes.points[..all.nodes.owned] {
        for c in 0..3 {
            (low[c], high[c]) = (low[c].min(point[c]), high[c].max(point[c]));
        }
    }
    comm.min(&mut low);
    comm.max(&mut high);
    let size = (0..3).map(|c| high[c] - low[c]).fold(0.0, f64::max);
    let planes: &[[usize; 2]] = if dim == 2 { &[[0, 1]] } else { &[[0, 1], [1, 2], [2, 0]] };
    let count = dim + planes.len();
    let mut values = vec![0.0; all.nodes.owned * dim * count];
    for (node, values) in values.chunks_exact_mut(dim * count).enumerate() {
        let held = all.identity_components(state, node);
        let jump = all.secondary_of[node].map_or([false; 3], |index| state[index as usize].jump);
        let points = &all.nodes.points;
        for k in 0..count {
            let motion = all.frames.unknowns(node as u32, |node| {
                let mut u = [0.0; 3];
                match k.checked_sub(dim) {
                    None => u[k] = 1.0,
                    Some(plane) => {
                        let [a, b] = planes[plane];
                        let place = |c: usize| {
                            let axis = axes[c];
                            let middle = 0.5 * (low[axis] + high[axis]);
                            (points[node as usize][axis] - middle) / size
                        };
                        (u[a], u[b]) = (-place(b), place(a));
                    }
                }
                u
            });
            for c in (0..dim).filter(|c| !held[*c] && !jump[*c]) {
                values[c * count + k] = motion[c];
            }
        }
    }
    Motions { height: dim, count, values }
}
