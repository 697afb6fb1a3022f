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
            let (first, values) = self.at(all, node);
            for (work, r) in work[first..][..motions].iter_mut().zip(values) {
                *work += (0..dim).filter(|c| free[*c]).map(|c| r[c] * rhs[c]).sum::<f64>();
            }
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
            let (first, values) = self.at(all, node);
            for c in (0..dim).filter(|c| !all.prescribed[node][*c]) {
                u[c] = (0..motions).map(|m| weights[first + m] * values[m][c]).sum();
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
        let (body, motions) = (all.nodes.marks[node].body as usize, motions(all.dim));
        let mut values = [[0.0; 3]; 6];
        for (u, motion) in values.iter_mut().zip(motions) {
            *u = all.frames.unknowns(node as u32, |node| self.moved(all, node, motion));
        }
        (self.groups[body] * motions.len(), values)
    }

    /// The displacement of a node in a motion.
    fn moved(&self, all: &Discretization, node: u32, motion: &Motion) -> [f64; 3] {
        let (point, axes) = (all.nodes.points[node as usize], self.axes);
        let mut u = [0.0; 3];
        match *motion {
            Motion::Along(c) => u[c] = 1.0,
            Motion::About(a, b) => {
                u[a] = -self.lever(point, axes[b]);
                u[b] = self.lever(point, axes[a]);
            }
        }
        u
    }

    /// Distance from the middle of the mesh along an axis, over its extent along the last one.
    fn lever(&self, point: [f64; 3], axis: usize) -> f64 {
        (point[axis] - 0.5 * self.size[axis]) / self.size[self.axes[self.axes.len() - 1]]
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

fn motions(dim: usize) -> &'static [Motion] {
    use Motion::{About, Along};
    match dim {
        2 => &[Along(0), Along(1), About(0, 1)],
        _ => &[Along(0), Along(1), Along(2), About(0, 1), About(1, 2), About(2, 0)],
    }
}
