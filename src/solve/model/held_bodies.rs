//! Whether supports hold the bodies of the mesh of a file, before anything is solved.

use nalgebra::{DMatrix, SymmetricEigen};

use super::BoundaryValueProblem;
use crate::assembly::Discretization;
use crate::case::Case;
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::graph::groups;
use crate::mesh::MeshFacts;

/// A motion is free where what resists it is less than this part of the most that any meets.
const FREE: f64 = 1e-12;
/// More bodies than this are taken to be held: what resists them is not gathered.
const MOST_GROUPS: usize = 10_000;

/// Refuses a case in which bodies can move without resistance at the start: neither supports nor
/// interfaces that hold stop them. Collective.
///
/// # Errors
/// `Input` that names the body and the motion.
pub fn check(comm: &Comm, case: &Case, problem: &BoundaryValueProblem) -> Result<()> {
    let BoundaryValueProblem { mesh, all, .. } = problem;
    if !mesh.is_of_file() {
        return Ok(());
    }
    let bodies = Bodies::new(case, &mesh.facts);
    if bodies.count > MOST_GROUPS {
        return Ok(());
    }
    let (resistance, middles) = bodies.sums(comm, all);
    let motions = bodies.motions();
    for (group, sums) in resistance.chunks_exact(motions * motions).enumerate() {
        let eigen = SymmetricEigen::new(DMatrix::from_row_slice(motions, motions, sums));
        let most = eigen.eigenvalues.amax();
        let free =
            (0..motions).find(|i| eigen.eigenvalues[*i] <= FREE * most.max(f64::MIN_POSITIVE));
        let Some(free) = free else { continue };
        let motion = eigen.eigenvectors.column(free);
        let number = (0..motions).max_by(|i, j| motion[*i].abs().total_cmp(&motion[*j].abs()));
        let [x, y, z] = middles[group];
        return Err(Error::Input(format!(
            "nothing holds the body around ({x:.4}, {y:.4}, {z:.4}) m against a {}: neither the \
             prescribed displacements nor an interface that holds (contact does not); prescribe a \
             displacement on one of its surfaces, or join it to another body",
            bodies.name(number.unwrap_or_default()),
        )));
    }
    Ok(())
}

/// Bodies that interfaces hold together, as one.
struct Bodies<'m> {
    mesh: &'m MeshFacts,
    group: Vec<usize>,
    count: usize,
}

impl<'m> Bodies<'m> {
    fn new(case: &Case, mesh: &'m MeshFacts) -> Self {
        let holds = |interface: usize| case.interfaces[interface].law.law().holds_sliding(0.0);
        let joints = mesh.joints.iter().filter(|joint| holds(joint.interface));
        let group = groups(mesh.bodies, joints.map(|joint| joint.bodies));
        let count = group.iter().max().map_or(0, |last| last + 1);
        Self { mesh, group, count }
    }

    fn motions(&self) -> usize {
        if self.mesh.dim == 2 { 3 } else { 6 }
    }

    /// What resists the motions of each group, and its middle (m). Collective.
    fn sums(&self, comm: &Comm, all: &Discretization) -> (Vec<f64>, Vec<[f64; 3]>) {
        let (motions, dim) = (self.motions(), all.dim);
        let mut sums = vec![0.0; self.count * motions * motions];
        let mut middles = vec![[0.0; 4]; self.count];
        for node in 0..all.nodes.owned {
            let group = self.group[all.nodes.marks[node].body as usize];
            let point = all.nodes.points[node];
            let middle = &mut middles[group];
            (0..3).for_each(|i| middle[i] += point[i]);
            middle[3] += 1.0;
            if !all.prescribed[node][..dim].contains(&true) {
                continue;
            }
            let moved: Vec<[f64; 3]> = (0..motions)
                .map(|number| {
                    let moved = |node: u32| self.moved(number, all.nodes.points[node as usize]);
                    all.frames.unknowns(node as u32, moved)
                })
                .collect();
            let of_group = &mut sums[group * motions * motions..][..motions * motions];
            for c in (0..dim).filter(|c| all.prescribed[node][*c]) {
                for (i, j) in (0..motions).flat_map(|i| (0..motions).map(move |j| (i, j))) {
                    of_group[i * motions + j] += moved[i][c] * moved[j][c];
                }
            }
        }
        comm.sum(&mut sums);
        comm.sum(middles.as_flattened_mut());
        let middle = |[x, y, z, n]: [f64; 4]| [x, y, z].map(|sum| sum / n);
        (sums, middles.into_iter().map(middle).collect())
    }

    /// The displacement of a point in a motion: translations, then rotations about the middle of
    /// the mesh, over its size.
    fn moved(&self, number: usize, point: [f64; 3]) -> [f64; 3] {
        let (axes, mut u) = (self.mesh.axes, [0.0; 3]);
        if number < axes.len() {
            u[number] = 1.0;
            return u;
        }
        let largest = self.mesh.size.iter().fold(0.0_f64, |m, x| m.max(*x));
        let lever = |c: usize| {
            let axis = axes[c];
            (point[axis] - self.mesh.origin[axis] - 0.5 * self.mesh.size[axis]) / largest
        };
        let [a, b] = Self::turned(axes.len(), number);
        (u[a], u[b]) = (-lever(b), lever(a));
        u
    }

    /// The components that a rotation exchanges.
    fn turned(dim: usize, number: usize) -> [usize; 2] {
        [[0, 1], [1, 2], [2, 0]][number - dim]
    }

    fn name(&self, number: usize) -> String {
        const AXES: [&str; 3] = ["x", "y", "z"];
        let (axes, dim) = (self.mesh.axes, self.mesh.axes.len());
        if number < dim {
            return format!("translation along {}", AXES[axes[number]]);
        }
        let [a, b] = Self::turned(dim, number).map(|c| axes[c]);
        format!("rotation about {}", AXES[3 - a - b])
    }
}
