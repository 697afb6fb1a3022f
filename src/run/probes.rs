//! Displacements and pore pressures at given points.

use crate::assembly::PoreSpace;
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
    /// Names of the pressure nodes, and their values there.
    corners: (Vec<u64>, [f64; MAX_NODES]),
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
        let mut at_corners = [0.0; MAX_NODES];
        mesh.column.shape(place.body).corners().values(xi, &mut at_corners);
        let corners = (mesh.column.of_first_order().cell_nodes(place), at_corners);
        found.push(Probe { index, nodes: mesh.column.cell_nodes(place), values, corners });
    }
    found
}

impl Probe {
    /// Pore pressure (Pa); none in a cell without pores. Local.
    pub fn pressure(&self, space: &PoreSpace, pressure: &[f64]) -> Option<f64> {
        let (names, values) = &self.corners;
        let nodal = names.iter().map(|name| space.nodes.local(*name));
        let nodal: Option<Vec<u32>> = nodal.collect();
        Some(nodal?.iter().zip(values).map(|(n, v)| v * pressure[*n as usize]).sum())
    }

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
