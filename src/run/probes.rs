//! Displacements at given points.

use crate::case::Case;
use crate::element::MAX_NODES;
use crate::mesh::{LocalMesh, axes};
use crate::solve::Problem;

/// A probe, on the rank whose cell holds it.
pub struct Probe {
    /// Position in the list of the case.
    pub index: usize,
    nodes: Vec<u64>,
    values: [f64; MAX_NODES],
}

/// The probes of this rank; each is on exactly one rank. A point on an interface belongs to the
/// body below. Local.
pub fn locate(case: &Case, mesh: &LocalMesh) -> Vec<Probe> {
    let mut found = Vec::new();
    for (index, probe) in case.probes.iter().enumerate() {
        let (place, fraction) = mesh.column.locate(probe.at);
        if mesh.cells.binary_search(&mesh.column.cell(place)).is_err() {
            continue;
        }
        let mut xi = [0.0; 3];
        for (component, axis) in axes(case.dim).iter().enumerate() {
            xi[component] = 2.0 * fraction[*axis] - 1.0;
        }
        let mut values = [0.0; MAX_NODES];
        mesh.column.shape(place.body).values(xi, &mut values);
        found.push(Probe { index, nodes: mesh.column.cell_nodes(place), values });
    }
    found
}

impl Probe {
    /// Displacement by component (m). Local.
    pub fn displacement(&self, problem: &Problem<'_>) -> [f64; 3] {
        let (all, dim) = (&problem.all, problem.all.dim);
        let mut u = [0.0; 3];
        for (name, n) in self.nodes.iter().zip(&self.values) {
            let node = all.nodes.local(*name).expect("a node of the rank's own cell") as usize;
            let nodal = &problem.displacement[node * dim..][..dim];
            u.iter_mut().zip(nodal).for_each(|(u, nodal)| *u += n * nodal);
        }
        u
    }
}
