//! Rigid motions as starts of linear solves.
//!
//! Once an interface has opened, prescribed displacements move the bodies on its sides as wholes:
//! a load that the smoothers of no level take up quickly, and that costs nothing to guess.

#![allow(clippy::needless_range_loop)] // index notation over several arrays at once

use nalgebra::{DMatrix, DVector};

use super::energy_projection::least_energy;
use crate::assembly::Discretization;
use crate::comm::Comm;
use crate::graph::groups;
use crate::mesh::MeshFacts;
use crate::solve::model::interfaces::InterfaceState;

/// The bodies of a column as rigid ones; a group of bodies that interfaces hold together moves as
/// one.
pub struct RigidMotions {
    /// Extent of the mesh along x, y, z (m).
    size: [f64; 3],
    /// The axes of the components.
    axes: &'static [usize],
    bodies: usize,
    /// The two bodies that each interface joins.
    joints: Vec<[usize; 2]>,
    /// Group of each body for which `energy` holds.
    groups: Vec<usize>,
    /// R^T K R of each group's motions, which vanish where displacements are prescribed.
    energy: Vec<DMatrix<f64>>,
}

impl RigidMotions {
    /// Of the bodies of a mesh.
    pub fn new(mesh: &MeshFacts) -> Self {
        let joints =
            mesh.interfaces.iter().map(|lips| lips.each_ref().map(|lip| lip.body)).collect();
        let (size, axes, bodies) = (mesh.size, mesh.axes, mesh.bodies);
        Self { size, axes, bodies, joints, groups: Vec::new(), energy: Vec::new() }
    }

    /// The rigid motion of the bodies that is closest to the solution for `rhs`, at owned
    /// components; none where interfaces hold all bodies together. `stiffness` (N/m) resists the
    /// jumps of stuck components. Collective.
    pub fn closest(
        &mut self,
        comm: &Comm,
        all: &Discretization,
        interfaces: &InterfaceState,
        stiffness: f64,
        free: &[bool],
        rhs: &[f64],
    ) -> Option<Vec<f64>> {
        let groups = self.groups(comm, all, interfaces);
        let count = groups.iter().max()? + 1;
        if count == 1 {
            return None;
        }
        if groups != self.groups {
            self.groups = groups;
            self.set_energy(comm, all, count);
        }
        let motions = motions(all.dim).len();
        let size = count * motions;
        // One sum over the ranks: the interfaces' energies, then the work of the right-hand side.
        let mut sums = vec![0.0; size * (size + 1)];
        let (energies, work) = sums.split_at_mut(size * size);
        self.add_jumps(all, interfaces, stiffness, energies);
        let dim = all.dim;
        for (node, (rhs, free)) in rhs.chunks_exact(dim).zip(free.chunks_exact(dim)).enumerate() {
            let mut force = [0.0; 3];
            (0..dim).filter(|c| free[*c]).for_each(|c| force[c] = rhs[c]);
            let work = &mut work[self.first(all, node)..][..motions];
            self.add_work(all, node, force, work);
        }
        comm.sum(&mut sums);
        let mut energy = DMatrix::from_row_slice(size, size, &sums[..size * size]);
        for (group, own) in self.energy.iter().enumerate() {
            let at = (group * motions, group * motions);
            let mut part = energy.view_mut(at, (motions, motions));
            part += own;
        }
        let work = DVector::from_column_slice(&sums[size * size..]);
        let weights = least_energy(&energy, &work)?;
        let mut motion = vec![0.0; rhs.len()];
        for (node, u) in motion.chunks_exact_mut(dim).enumerate() {
            let weights = &weights.as_slice()[self.first(all, node)..][..motions];
            let moved = self.unknowns(all, node, weights);
            for c in (0..dim).filter(|c| !all.prescribed[node][*c]) {
                u[c] = moved[c];
            }
        }
        Some(motion)
    }

    /// The group of each body, rising: an interface with a node whose jump is known in all
    /// components holds its bodies together. Collective.
    fn groups(&self, comm: &Comm, all: &Discretization, interfaces: &InterfaceState) -> Vec<usize> {
        let mut holds = vec![0.0; interfaces.laws.len()];
        for (rows, response) in all.secondary.iter().zip(&interfaces.response) {
            if (0..all.dim).all(|c| rows.rows[c].is_none() || response.state.stuck[c]) {
                holds[rows.interface] = 1.0;
            }
        }
        comm.max(&mut holds);
        let joints = self.joints.iter().zip(&holds).filter(|(_, holds)| **holds != 0.0);
        groups(self.bodies, joints.map(|(joint, _)| *joint))
    }

    /// The first motion of the group of a node, and the node's unknowns in all of them.
    fn at(&self, all: &Discretization, node: usize) -> (usize, [[f64; 3]; 6]) {
        let mut values = [[0.0; 3]; 6];
        for (u, motion) in values.iter_mut().zip(motions(all.dim)) {
            *u = all.frames.unknowns(node as u32, |node| {
                let mut moved = [0.0; 3];
                motion.add(self.levers(all, node), 1.0, &mut moved);
                moved
            });
        }
        (self.first(all, node), values)
    }

    /// The first motion of the group of a node.
    fn first(&self, all: &Discretization, node: usize) -> usize {
        self.groups[all.nodes.marks[node].body as usize] * motions(all.dim).len()
    }

    /// Adds the work of a force on the unknowns of a node in every motion of its group.
    fn add_work(&self, all: &Discretization, node: usize, force: [f64; 3], work: &mut [f64]) {
        all.frames.spread(node as u32, force, |node, force| {
            let levers = self.levers(all, node);
            for (work, motion) in work.iter_mut().zip(motions(all.dim)) {
                *work += motion.work(levers, force);
            }
        });
    }

    /// The unknowns of a node in the weighted sum of the motions of its group.
    fn unknowns(&self, all: &Discretization, node: usize, weights: &[f64]) -> [f64; 3] {
        all.frames.unknowns(node as u32, |node| {
            let (levers, mut moved) = (self.levers(all, node), [0.0; 3]);
            for (weight, motion) in weights.iter().zip(motions(all.dim)) {
                motion.add(levers, *weight, &mut moved);
            }
            moved
        })
    }

    /// By component, the distance of a node from the middle of the mesh along its axis, over the
    /// extent along the last one.
    fn levers(&self, all: &Discretization, node: u32) -> [f64; 3] {
        let (point, size) = (all.nodes.points[node as usize], self.size);
        let (mut levers, last) = ([0.0; 3], size[self.axes[self.axes.len() - 1]]);
        for (lever, axis) in levers.iter_mut().zip(self.axes) {
            *lever = (point[*axis] - 0.5 * size[*axis]) / last;
        }
        levers
    }

    /// Works out the energies of the bulk: only cells with prescribed displacements have any.
    /// Collective.
    fn set_energy(&mut self, comm: &Comm, all: &Discretization, count: usize) {
        let (dim, motions) = (all.dim, motions(all.dim).len());
        let mut sums = vec![0.0; count * motions * motions];
        let mut buffer = Vec::new();
        for cell in 0..all.cells.len() {
            let nodes = all.cells.nodes(cell);
            if nodes.iter().all(|n| all.prescribed[*n as usize] == [false; 3]) {
                continue;
            }
            let size = nodes.len() * dim;
            let mut u = DMatrix::zeros(size, motions);
            let mut first = 0;
            for (i, node) in nodes.iter().map(|n| *n as usize).enumerate() {
                let (group, values) = self.at(all, node);
                first = group;
                for c in (0..dim).filter(|c| !all.prescribed[node][*c]) {
                    (0..motions).for_each(|m| u[(i * dim + c, m)] = values[m][c]);
                }
            }
            let stiffness = all.cell_matrix(cell, &mut buffer);
            let stiffness = DMatrix::from_row_slice(size, size, stiffness);
            let energy = u.transpose() * stiffness * &u;
            let sums = &mut sums[first * motions..][..motions * motions];
            sums.iter_mut().zip(energy.iter()).for_each(|(sum, e)| *sum += e);
        }
        comm.sum(&mut sums);
        self.energy = sums
            .chunks_exact(motions * motions)
            .map(|part| DMatrix::from_row_slice(motions, motions, part))
            .collect();
    }

    /// Adds this rank's part of the energies of the jumps.
    fn add_jumps(
        &self,
        all: &Discretization,
        interfaces: &InterfaceState,
        stiffness: f64,
        energies: &mut [f64],
    ) {
        let (dim, motions) = (all.dim, motions(all.dim).len());
        let size = self.energy.len() * motions;
        for (rows, response) in all.secondary.iter().zip(&interfaces.response) {
            let mut jumps = vec![[0.0; 3]; size];
            for c in 0..dim {
                let Some(row) = &rows.rows[c] else { continue };
                for (unknown, a) in row.coefficients(rows.own(c)) {
                    let (node, component) = (unknown as usize / dim, unknown as usize % dim);
                    if all.prescribed[node][component] {
                        continue;
                    }
                    let (first, values) = self.at(all, node);
                    for m in 0..motions {
                        jumps[first + m][c] += a * values[m][component];
                    }
                }
            }
            let weight = |c: usize| rows.rows[c].as_ref().map_or(0.0, |row| row.weight.sqrt());
            for (i, j) in (0..size).flat_map(|i| (0..size).map(move |j| (i, j))) {
                for (c, d) in (0..dim).flat_map(|c| (0..dim).map(move |d| (c, d))) {
                    let spring = if c == d && response.state.stuck[c] {
                        stiffness
                    } else {
                        weight(c) * weight(d) * response.state.tangent[c][d]
                    };
                    energies[i * size + j] += jumps[i][c] * spring * jumps[j][d];
                }
            }
        }
    }
}

/// A rigid motion by displacement components.
enum Motion {
    /// Translation.
    Along(usize),
    /// Rotation from the first component to the second.
    About(usize, usize),
}

impl Motion {
    /// Adds the displacement at a place with these levers, times a weight.
    fn add(&self, levers: [f64; 3], weight: f64, u: &mut [f64; 3]) {
        match *self {
            Motion::Along(c) => u[c] += weight,
            Motion::About(a, b) => {
                u[a] -= weight * levers[b];
                u[b] += weight * levers[a];
            }
        }
    }

    /// The work of a force at a place with these levers.
    fn work(&self, levers: [f64; 3], force: [f64; 3]) -> f64 {
        match *self {
            Motion::Along(c) => force[c],
            Motion::About(a, b) => levers[a] * force[b] - levers[b] * force[a],
        }
    }
}

fn motions(dim: usize) -> &'static [Motion] {
    use Motion::{About, Along};
    match dim {
        2 => &[Along(0), Along(1), About(0, 1)],
        _ => &[Along(0), Along(1), Along(2), About(0, 1), About(1, 2), About(2, 0)],
    }
}
