//! Stresses that are there at the start, at the unknowns of one rank.

use crate::assembly::Discretization;
use crate::bulk::InitialStress;
use crate::case::Case;
use crate::comm::Comm;
use crate::error::Result;
use crate::mesh::LocalMesh;

/// What the stresses at the start are and do.
pub struct StressAtStart {
    /// At the centre of each cell (Pa): xx, yy, zz, xy, yz, xz.
    pub at_centres: Vec<[f64; 6]>,
    /// The forces that they make, `dim` numbers per local node, not summed (N).
    pub(in crate::solve) force: Vec<f64>,
    /// The sum of the lengths of the cells' forces at each local node, complete at owned ones (N).
    pub(in crate::solve) magnitude: Vec<f64>,
    /// About how far this rank's part would move without them (m).
    pub(in crate::solve) displacement: f64,
    /// What is taken for granted, in words.
    pub(in crate::solve) assumed: Option<String>,
}

impl StressAtStart {
    /// Of a case; none where it has none. Collective.
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number; on all ranks.
    pub(in crate::solve) fn new(
        comm: &Comm,
        case: &Case,
        mesh: &LocalMesh,
        all: &Discretization,
    ) -> Result<Option<Self>> {
        let of_mesh = comm.agree(InitialStress::new(case, mesh))?;
        let Some(of_mesh) = of_mesh else { return Ok(None) };
        let InitialStress { at_centres, forces, magnitudes, displacement, assumed } = of_mesh;
        let dim = all.dim;
        let mut force = vec![0.0; all.nodes.len() * dim];
        let mut magnitude = vec![0.0; all.nodes.len()];
        for ((name, of_node), length) in mesh.nodes.names.iter().zip(forces).zip(magnitudes) {
            let node = all.nodes.local(*name).expect("a node of the rank's own cells") as usize;
            force[node * dim..][..dim].copy_from_slice(&of_node[..dim]);
            magnitude[node] = length;
        }
        all.frames.fold(&mut force);
        all.nodes.add_to_owners(&mut magnitude, 1);
        assumed.iter().for_each(|words| tracing::info!("stress     {words}"));
        Ok(Some(Self { at_centres, force, magnitude, displacement, assumed }))
    }
}
