//! What a problem stands on, whoever solves it: nodes, cells, jump rows, supports and loads.

use std::rc::Rc;

use super::fit;
use super::initial_stress::StressAtStart;
use super::special::{Carriers, special_of};
use super::special_by_name::SpecialByName;
use crate::assembly::{Cells, Discretization};
use crate::bulk::{CellStiffness, Elastic, Loads};
use crate::case::Case;
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::interface::{Multipliers, Sides, jump_rows};
use crate::mesh::LocalMesh;
use crate::space::{AtNode, Directory, Nodes, Prescribed};
use crate::space::{Supports, check_directions};

/// A case on this rank's cells.
pub struct BoundaryValueProblem {
    /// The cells of this rank.
    pub mesh: LocalMesh,
    /// Cells, nodes, rows.
    pub all: Rc<Discretization>,
    /// The sides of the interfaces.
    pub sides: Vec<Sides>,
    /// The prescribed displacements.
    pub supports: Supports,
    /// Loads on the bulk.
    pub loads: Loads,
    /// Stresses that are there at the start.
    pub initial_stress: Option<StressAtStart>,
    /// What is to be said of it, in words; the same on every rank.
    pub remarks: Vec<String>,
}

impl BoundaryValueProblem {
    /// Of a case on `mesh`. Collective.
    ///
    /// # Errors
    /// `Input` when boundary entries disagree, a formula gives no finite number at an instant, a
    /// side of an interface is not covered, or there are more unknowns than PETSc numbers.
    pub fn new(comm: &Comm, case: &Case, mesh: LocalMesh) -> Result<Self> {
        let prescribed = Prescribed::new(case);
        let times = case.load_times();
        let mut largest = [AtNode::agree(comm, prescribed.largest_value(&mesh.nodes, &times))?];
        comm.max(&mut largest);
        let agreement = prescribed.check_agreement(&mesh.nodes, &times, largest[0]);
        AtNode::agree(comm, agreement)?;
        AtNode::agree(comm, check_directions(&mesh, &prescribed, &times, largest[0]))?;
        let loads = Loads::new(case, &mesh);
        comm.agree(loads.check(&times))?;
        let sides = Sides::choose(case, &mesh.facts);
        fit::check(comm, case, &mesh)?;
        let (all, mut remarks) = discretize(comm, case, &mesh, &sides)?;
        remarks.iter().for_each(|words| tracing::warn!("warning: {words}"));
        let all = Rc::new(all);
        let unknowns = all.nodes.total * case.dim as u64;
        if i32::try_from(unknowns).is_err() {
            return Err(Error::Input(format!(
                "{unknowns} unknowns are more than the 32-bit indices of this PETSc can number; \
                 use a coarser mesh"
            )));
        }
        let mut special = special_of(case, &mesh, &sides, &prescribed);
        for special in &mut special {
            let local = all.nodes.local(mesh.nodes.names[special.node as usize]);
            special.node = local.expect("a node of the rank's own cell");
        }
        let supports = Supports::new(prescribed, special);
        let initial_stress = StressAtStart::new(comm, case, &mesh, &all)?;
        remarks.extend(initial_stress.iter().filter_map(|stress| stress.assumed.clone()));
        Ok(Self { mesh, all, sides, supports, loads, initial_stress, remarks })
    }
}

/// Nodes, cells and jump rows of a mesh, and what is to be said of them. Collective.
pub(in crate::solve) fn discretize(
    comm: &Comm,
    case: &Case,
    mesh: &LocalMesh,
    sides: &[Sides],
) -> Result<(Discretization, Vec<String>)> {
    let prescribed = Prescribed::new(case);
    let names = &mesh.nodes.names;
    let directory = Directory::new(comm, mesh.facts.nodes, names);
    let special = special_of(case, mesh, sides, &prescribed);
    let carriers = Carriers { mesh, special: &special, prescribed: &prescribed };
    let (fixed, is_lost) = (|name| carriers.fixed(name), |name| carriers.is_lost(name));
    let multipliers = Multipliers { fixed: &fixed, is_lost: &is_lost };
    let (rows, remarks) = jump_rows(comm, mesh, sides, case.dim, &multipliers, &directory)?;
    let mut needed = names.clone();
    needed.extend(rows.iter().flat_map(|rows| rows.names_of_others()));
    let known = SpecialByName::new(comm, &directory, mesh, &special, &mut needed);
    let nodes = Nodes::new(comm, &directory, &needed, &mesh.nodes)?;
    drop(directory);
    let frames = known.frames(case.dim, &nodes);
    let fixed = |(node, name): (usize, &u64)| match known.fixed(*name) {
        Some(fixed) => fixed,
        None => prescribed.components_of(&nodes.marks[node]),
    };
    let fixed = nodes.names.iter().enumerate().map(fixed).collect();
    let cells = cells(case, mesh, &nodes);
    Ok((Discretization::new(case.dim, cells, nodes, frames, fixed, rows), remarks))
}

/// The cells of a mesh with the stiffness of the materials of a case. Local.
pub(in crate::solve) fn cells(case: &Case, mesh: &LocalMesh, nodes: &Nodes) -> Cells {
    let axes = case.axes;
    let stiffness = mesh
        .prototypes
        .iter()
        .map(|p| {
            let material = &case.materials[p.material];
            let elastic = Elastic::new(material.young_modulus, material.poisson_ratio);
            CellStiffness::new(p, elastic, axes, case.has_mean_dilatation(material))
        })
        .collect();
    let local = |name: &u64| nodes.local(*name).expect("the nodes of the rank's cells are held");
    let locals: Vec<u32> = mesh.nodes.names.iter().map(local).collect();
    let connectivity = (0..mesh.cells.len())
        .map(|cell| mesh.cell_nodes(cell).iter().map(|node| locals[*node as usize]).collect());
    Cells::new(axes, connectivity, mesh.cell_prototype.clone(), stiffness, &nodes.points)
}
