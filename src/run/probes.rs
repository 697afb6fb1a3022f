//! Displacements and pore pressures at given points.

use crate::assembly::PoreSpace;
use crate::case::{Case, Probe};
use crate::comm::Comm;
use crate::element::MAX_NODES;
use crate::error::{Error, Result};
use crate::mesh::LocalMesh;
use crate::solve::Problem;

/// A probe, on the rank whose cell holds it.
pub struct LocatedProbe {
    /// Position in the list of the case.
    pub index: usize,
    nodes: Vec<u64>,
    values: [f64; MAX_NODES],
    /// Names of the pressure nodes, and their values there.
    corners: (Vec<u64>, [f64; MAX_NODES]),
}

/// The probes of this rank; each is on exactly one rank. A point on an interface belongs to the
/// body below, or in the mesh of a file to the first cell that holds it. Collective.
///
/// # Errors
/// `Input` when no cell of any rank holds a point.
pub fn locate(comm: &Comm, case: &Case, mesh: &LocalMesh) -> Result<Vec<LocatedProbe>> {
    let places: Vec<_> = case.probes.iter().map(|probe| mesh.locate(probe.at)).collect();
    // Names of cells are whole numbers far below 2^53.
    let name = |place: &Option<(usize, [f64; 3])>| {
        place.map_or(f64::INFINITY, |(cell, _)| mesh.cells[cell] as f64)
    };
    let own: Vec<f64> = places.iter().map(name).collect();
    let mut first = own.clone();
    comm.min(&mut first);
    let missing = first.iter().position(|name| !name.is_finite());
    if let Some(index) = missing.filter(|_| mesh.is_of_file()) {
        let Probe { name, at } = &case.probes[index];
        return Err(Error::Input(format!(
            "probes.{index} ({name}): no cell of the mesh holds the point {at:?} m"
        )));
    }
    let mut found = Vec::new();
    for (index, place) in places.into_iter().enumerate() {
        let Some((cell, xi)) = place.filter(|_| own[index] <= first[index]) else { continue };
        let shape = mesh.shape(cell);
        let mut values = [0.0; MAX_NODES];
        shape.values(xi, &mut values);
        let mut at_corners = [0.0; MAX_NODES];
        shape.corners().values(xi, &mut at_corners);
        let nodes = mesh.cell_nodes(cell).iter().map(|node| mesh.nodes.names[*node as usize]);
        let nodes: Vec<u64> = nodes.collect();
        let corners = (nodes[..shape.corners().nodes()].to_vec(), at_corners);
        found.push(LocatedProbe { index, nodes, values, corners });
    }
    Ok(found)
}

impl LocatedProbe {
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
        let since_start = problem.displacement_since_start();
        let displacement = all.frames.displacements(&since_start);
        let mut u = [0.0; 3];
        for (name, n) in self.nodes.iter().zip(&self.values) {
            let node = all.nodes.local(*name).expect("a node of the rank's own cell") as usize;
            let nodal = &displacement[node * dim..][..dim];
            u.iter_mut().zip(nodal).for_each(|(u, nodal)| *u += n * nodal);
        }
        u
    }
}
