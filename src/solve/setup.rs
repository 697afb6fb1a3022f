//! From a case and this rank's cells to a problem that is ready to be solved.

use super::convergence::Convergence;
use super::interfaces::{InterfaceState, JointLaw};
use super::linear::{LinearChoice, LinearTarget};
use super::problem::Problem;
use super::recycle::Recycle;
use super::saddle::SaddlePoint;
use super::stepping::Stepper;
use crate::assembly::{Cells, Discretization, Pattern, SaddleTangent, Tangent};
use crate::bulk::{Elastic, Loads, Stiffness};
use crate::case::{Case, Form};
use crate::error::{Error, Result};
use crate::interface::{Sides, jump_rows};
use crate::mesh::{LocalMesh, axes};
use crate::petsc::{KspSetup, Matrix, Snes, Vector};
use crate::runtime::Runtime;
use crate::space::{AtNode, Directory, Nodes, Prescribed};
use crate::timers::Timers;

/// A problem with its solver, and what is known of the discretisation for output and report.
pub struct Model<'a> {
    /// Advances the problem in time.
    pub stepper: Stepper<'a>,
    /// The cells of this rank.
    pub mesh: LocalMesh,
    /// The sides of the interfaces.
    pub sides: Vec<Sides>,
    /// The linear solver.
    pub choice: LinearChoice,
    /// Displacement unknowns of all ranks, prescribed ones included.
    pub unknowns: u64,
}

/// Builds the problem of `mesh`. Collective.
///
/// # Errors
/// `Input` when boundary entries disagree, a formula gives no finite number at an instant, or a side of an interface is not covered; `System` when
/// PETSc fails.
pub fn build<'a>(
    runtime: &'a Runtime,
    timers: &'a Timers,
    case: &'a Case,
    mesh: LocalMesh,
) -> Result<Model<'a>> {
    let comm = &runtime.comm;
    let prescribed = Prescribed::new(case, &mesh.column);
    let mut largest = [AtNode::agree(comm, prescribed.largest_value(&mesh.nodes, &case.time))?];
    comm.max(&mut largest);
    let agreement = prescribed.check_agreement(&mesh.nodes, &case.time, largest[0]);
    AtNode::agree(comm, agreement)?;
    let loads = Loads::new(case, &mesh);
    comm.agree(loads.check(&case.time))?;
    let sides = Sides::choose(case, &mesh.column);

    let directory = Directory::new(comm, mesh.column.nodes(), &mesh.nodes);
    let rows = jump_rows(comm, &mesh, &sides, &prescribed, &directory)?;
    let mut needed = mesh.nodes.clone();
    needed.extend(
        rows.iter()
            .flat_map(|r| r.rows.iter().flatten())
            .flat_map(|r| r.others.iter().map(|o| o.0)),
    );
    let nodes = Nodes::new(comm, &directory, &needed)?;
    drop(directory);

    let cells = cells(case, &mesh, &nodes);
    let largest_diagonal = {
        let mut largest = [cells.largest_diagonal()];
        comm.max(&mut largest);
        largest[0]
    };
    let dim = case.dim;
    let all = Discretization::new(dim, cells, nodes, &prescribed, rows);
    let unknowns = all.nodes.total * dim as u64;
    if i32::try_from(unknowns).is_err() {
        return Err(Error::Input(format!(
            "{unknowns} unknowns are more than the 32-bit indices of this PETSc can number; \
             use a coarser mesh"
        )));
    }

    let pattern = Pattern::new(comm, &all);
    let saddle = (case.solver.form == Form::SaddlePoint)
        .then(|| SaddleTangent::new(comm, &all, largest_diagonal));
    let (diagonal, off_diagonal) = match &saddle {
        None => pattern.counts(all.nodes.first),
        Some(saddle) => saddle.counts(comm, &all),
    };
    let rows = diagonal.len() * dim;
    let mut matrix = Matrix::new(&runtime.petsc, rows, dim, &diagonal, &off_diagonal)?;
    if saddle.is_some() {
        matrix.declare_unsymmetric()?;
    }
    let choice = LinearChoice::new(case, &mesh.column);
    if choice.preset == "gamg" {
        set_rigid_motions(runtime, &mesh, &all, &mut matrix)?;
    }
    let tangent = Tangent::new(&all, pattern, largest_diagonal);
    let laws = joint_laws(case, &mesh, &sides);
    let interfaces = InterfaceState::new(dim, laws, all.owned_secondary());
    let names = case.interfaces.iter().map(|i| i.name.clone()).collect();
    let solver = &case.solver;
    let convergence = Convergence::new(solver.tolerance, solver.max_newton, &mesh.column, names);
    let target = LinearTarget::new(solver.tolerance);
    let x = Vector::new(&runtime.petsc, rows, dim)?;
    let snes = Snes::new(&runtime.petsc, "", matrix, &KspSetup::new(&choice.options))?;
    let recycle = Recycle::new(&runtime.petsc, all.nodes.owned * dim, dim)?;
    let problem =
        Problem::new(comm, timers, all, loads, interfaces, tangent, convergence, target, recycle);
    let saddle = saddle.map(SaddlePoint::new);
    let stepper = Stepper::new(case, problem, snes, saddle, x, prescribed);
    Ok(Model { stepper, mesh, sides, choice, unknowns })
}

fn cells(case: &Case, mesh: &LocalMesh, nodes: &Nodes) -> Cells {
    let stiffness = mesh
        .prototypes
        .iter()
        .map(|p| {
            let material = &case.materials[p.material];
            let elastic = Elastic::new(material.young_modulus, material.poisson_ratio);
            Stiffness::new(p, elastic, case.dim)
        })
        .collect();
    let connectivity = mesh
        .cells
        .iter()
        .flat_map(|c| mesh.column.cell_nodes(mesh.column.cell_place(*c)))
        .map(|name| nodes.local(name).expect("the nodes of the rank's cells are held"))
        .collect();
    Cells::new(
        case.dim,
        mesh.nodes_per_cell(),
        connectivity,
        mesh.cell_prototype.clone(),
        stiffness,
    )
}

/// The laws, with the augmentation that suits the stiffness of the cells behind the interface.
fn joint_laws(case: &Case, mesh: &LocalMesh, sides: &[Sides]) -> Vec<JointLaw> {
    let law = |(spec, side): (&crate::case::InterfaceSpec, &Sides)| {
        let place = mesh.column.facet_cell(side.secondary, [0, 0]);
        let (size, material) = mesh.column.cell_size(place);
        let stiffness = case.materials[material].young_modulus / size[2];
        JointLaw { spec: spec.law.clone(), augmentation: spec.law.law().augmentation(stiffness) }
    };
    case.interfaces.iter().zip(sides).map(law).collect()
}

/// Gives smoothed aggregation the rigid-body motions.
fn set_rigid_motions(
    runtime: &Runtime,
    mesh: &LocalMesh,
    all: &Discretization,
    matrix: &mut Matrix,
) -> Result<()> {
    let mut coordinates = Vector::new(&runtime.petsc, all.nodes.owned * all.dim, all.dim)?;
    {
        let mut values = coordinates.write()?;
        for (node, name) in all.nodes.names[..all.nodes.owned].iter().enumerate() {
            let point = mesh.column.point(*name);
            for (c, axis) in axes(all.dim).iter().enumerate() {
                values[node * all.dim + c] = point[*axis];
            }
        }
    }
    matrix.set_rigid_body_near_null_space(&coordinates)
}
