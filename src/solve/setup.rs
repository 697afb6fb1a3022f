//! From a case and this rank's cells to a problem that is ready to be solved.

use std::rc::Rc;

use super::flow::Flow;
use super::flow::coupled::Coupling;
use super::flow::pressures::Displacements;
use super::flow::setup::{MECHANICS, Mechanics, couple, known_pressure};
use super::levels::with_levels;
use super::model::interfaces::{InterfaceState, JointLaw};
use super::model::linear::{AGGREGATION, LinearChoice, LinearTarget, MULTIGRID};
use super::model::near_null_space::rigid_motions;
use super::model::{
    BoundaryValueProblem, NodeData, Platens, discretize, gaps, gaps_in_words, has_lost_facets,
    places, starts, strength_factors,
};
use super::problem::block_tangent::BlockTangent;
use super::problem::convergence::Convergence;
use super::problem::path::PathControl;
use super::problem::saddle::SaddlePoint;
use super::problem::{PlatenSystem, Problem, ProblemParts, TangentForm};
use super::stepping::Stepper;
use crate::assembly::{Discretization, Pattern, SaddleTangent, Tangent, TangentOperator};
use crate::case::{Case, Control, Form};
use crate::comm::Comm;
use crate::error::Result;
use crate::fault;
use crate::interface::Sides;
use crate::mesh::{LocalMesh, MeshFacts};
use crate::multigrid::{Hierarchy, Level};
use crate::petsc::{KspSetup, LinearOperator, Matrix, Snes, Vector};
use crate::runtime::Runtime;
use crate::space::AtNode;
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
    /// Unknowns of all ranks, displacements and pressures, prescribed ones included.
    pub unknowns: u64,
}

/// Builds the model of a problem, with the solver of `choice`. The meshes of `coarser` are
/// nested in its mesh, coarsest first; only multigrid uses them. Collective.
///
/// # Errors
/// `Input` when a formula gives no positive factor; `System` when PETSc fails.
pub fn build<'a>(
    runtime: &'a Runtime,
    timers: &'a Timers,
    case: &'a Case,
    mut choice: LinearChoice,
    problem: BoundaryValueProblem,
    coarser: Vec<LocalMesh>,
) -> Result<Model<'a>> {
    let comm = &runtime.comm;
    let platens = Platens::new(comm, case, &problem)?;
    let BoundaryValueProblem { mesh, all, sides, supports, loads, initial_stress, mut remarks } =
        problem;
    let (dim, unknowns) = (case.dim, all.nodes.total * case.dim as u64);
    let interfaces = interfaces(comm, case, &mesh, &sides, &all, &mut remarks)?;
    let tolerance = case.solver.tolerance * share_of_corners(&mesh.facts);
    let mut convergence = convergence(case, tolerance);
    convergence.see_gaps(comm, &all, &interfaces);

    fault::strike(comm, "setup")?;
    let levels = levels(comm, case, &mut choice, &sides, coarser, &mesh, &all)?;
    let system = system(runtime, case, &choice, &all, levels)?;
    let System { snes, form, diagonal, saddle, rows } = system;
    let known_pressure = known_pressure(comm, case, &mesh, &all)?;
    let of = Displacements { mesh: &mesh, all: &all, sides: &sides, gaps: &interfaces.gaps };
    let (snes, mut x, mut coupling) = match &case.flow {
        Some(flow) => {
            let tangent = match &form {
                TangentForm::Levels(hierarchy) => Rc::clone(hierarchy.finest()),
                _ => Rc::new(TangentOperator::new(Rc::clone(&all), diagonal)),
            };
            let eliminate = (choice.preset == "mumps").then(|| KspSetup::new(&choice.options));
            let mechanics = Mechanics { snes, tangent };
            let coupled = couple(runtime, case, flow, of, mechanics, eliminate.as_ref())?;
            let x = Vector::new(&runtime.petsc, coupled.rows, 1)?;
            (coupled.snes, x, Some(coupled.coupling))
        }
        None => (snes, Vector::new(&runtime.petsc, rows, dim)?, None),
    };
    if let Some(Coupling { flow, .. }) = &mut coupling {
        begin_flow(comm, &all, flow, &mut x)?;
    }
    let mut problem = Problem::new(ProblemParts {
        comm,
        timers,
        all,
        loads,
        interfaces,
        form,
        diagonal,
        convergence,
        linear: LinearTarget::new(tolerance),
        mesh: mesh.facts.clone(),
    });
    (problem.known_pressure, problem.initial_stress) = (known_pressure, initial_stress);
    border(case, &mut problem, platens);
    let mut stepper = Stepper::new(case, problem, snes, saddle, coupling, x, supports);
    stepper.remarks = remarks;
    let pressures = stepper.coupling.as_ref().map_or(0, |c| c.flow.space.nodes.total);
    Ok(Model { stepper, mesh, sides, choice, unknowns: unknowns + pressures })
}

/// What is found beside the unknowns: the load factor of a path, the motions of platens.
fn border(case: &Case, problem: &mut Problem<'_>, platens: Option<Platens>) {
    let path = |of: &Control| PathControl::new(of.clone(), of.words(&case.interfaces));
    problem.path = case.control.as_ref().map(path);
    let other = problem.convergence.other;
    problem.platens = platens.map(|platens| PlatenSystem::new(platens, other));
}

/// Starts from the initial pressures, with displacements of zero. Collective.
fn begin_flow(comm: &Comm, all: &Discretization, flow: &mut Flow, x: &mut Vector) -> Result<()> {
    let unknowns = &mut x.write()?[all.nodes.owned * all.dim..];
    unknowns.iter_mut().zip(&flow.pressure).for_each(|(x, p)| *x = p / flow.scale);
    flow.begin(comm, all, &vec![0.0; all.nodes.len() * all.dim]);
    Ok(())
}

/// The unloaded interfaces; what is to be said of their gaps is added to `remarks`. Collective.
///
/// # Errors
/// `Input` where a formula gives what cannot be.
fn interfaces(
    comm: &Comm,
    case: &Case,
    mesh: &LocalMesh,
    sides: &[Sides],
    all: &Discretization,
    remarks: &mut Vec<String>,
) -> Result<InterfaceState> {
    let factors = AtNode::agree(comm, strength_factors(case, places(all)))?;
    let starts = AtNode::agree(comm, starts(case, places(all)))?;
    let (mut gaps, words) = gaps(comm, case, mesh, sides, all);
    for ((gap, rows), start) in gaps.iter_mut().zip(&all.secondary).zip(&starts) {
        *gap += if rows.rows[all.dim - 1].is_some() { start.gap } else { 0.0 };
    }
    remarks.extend(words);
    remarks.extend(gaps_in_words(comm, case, all, &gaps));
    let damages = starts.iter().map(|start| start.damage).collect();
    let nodes = NodeData { factors, gaps, damages };
    let mut state = InterfaceState::new(all, joint_laws(case, mesh, sides), nodes);
    state.is_gradual = case.interfaces.iter().any(|i| i.film.is_some());
    Ok(state)
}

/// The test of convergence, with this `tolerance` of forces.
fn convergence(case: &Case, tolerance: f64) -> Convergence {
    let names = case.interfaces.iter().map(|i| i.name.clone()).collect();
    let mut convergence = Convergence::new(tolerance, case.solver.max_newton, names);
    convergence.other = if case.flow.is_some() {
        "the balance of the fluid"
    } else {
        "the quantity that control follows"
    };
    convergence
}

/// The levels of multigrid, coarsest first; none for other solvers, among them the one that takes
/// its place where no coarser mesh is of use. Collective.
fn levels(
    comm: &Comm,
    case: &Case,
    choice: &mut LinearChoice,
    sides: &[Sides],
    coarser: Vec<LocalMesh>,
    finest: &LocalMesh,
    all: &Rc<Discretization>,
) -> Result<Vec<Level>> {
    let mut levels = Vec::new();
    if choice.preset != MULTIGRID {
        return Ok(levels);
    }
    let mut below: Option<LocalMesh> = None;
    let first = coarser.first().unwrap_or(finest);
    let of_first_order = (first.is_of_file() && first.order() > 1).then(|| first.of_first_order());
    for mesh in of_first_order.into_iter().chain(coarser) {
        // Where no node of its own holds a facet, the matrix of the coarse mesh can be singular.
        if has_lost_facets(comm, case, &mesh, sides) {
            (levels, below) = (Vec::new(), None);
            continue;
        }
        let all = Rc::new(discretize(comm, case, &mesh, sides)?.0);
        levels.push(level(&mesh, all, below.as_ref()));
        below = Some(mesh);
    }
    if levels.is_empty() {
        *choice = choice.clone().without_levels(case, &finest.facts);
        return Ok(levels);
    }
    levels.push(level(finest, Rc::clone(all), below.as_ref()));
    Ok(levels)
}

/// A level of multigrid, with its nodes' dependence on those of the one below.
fn level(mesh: &LocalMesh, all: Rc<Discretization>, below: Option<&LocalMesh>) -> Level {
    // In the mesh of a file the unknowns of a node may contain displacements of ghosts.
    let count = if mesh.is_of_file() { all.nodes.len() } else { all.nodes.owned };
    let names = &all.nodes.names[..count];
    let interpolation = below.map(|below| mesh.interpolation(below, names)).unwrap_or_default();
    Level { all, interpolation }
}

/// Part of the tolerance of forces that holds. Tolerances are relative to the largest nodal force;
/// of second order the corners of a face have a sixteenth of the weight of its centre, of first
/// order a quarter of that of an inner node, and the same force at them is the more traction.
fn share_of_corners(mesh: &MeshFacts) -> f64 {
    if mesh.order == 1 { 1.0 } else { 0.25 }
}

/// The solver with the form of its tangent.
struct System {
    snes: Snes,
    form: TangentForm,
    diagonal: f64,
    saddle: Option<SaddlePoint>,
    /// Unknowns of this rank.
    rows: usize,
}

/// The operator of a model that nobody solves.
struct NoTangent;

impl LinearOperator for NoTangent {
    fn multiply(&self, _: &[f64], y: &mut [f64]) {
        y.fill(f64::NAN);
    }
}

/// Sets up SNES with the matrix, the levels of multigrid, or the saddle-point form. Collective.
fn system(
    runtime: &Runtime,
    case: &Case,
    choice: &LinearChoice,
    all: &Rc<Discretization>,
    levels: Vec<Level>,
) -> Result<System> {
    let (comm, petsc, dim) = (&runtime.comm, &runtime.petsc, all.dim);
    let mut largest = [all.cells.largest_diagonal()];
    comm.max(&mut largest);
    let diagonal = largest[0];
    let setup = KspSetup::new(&choice.options);
    let prefix = if case.flow.is_some() { MECHANICS } else { "" };
    if choice.options.is_empty() {
        let rows = all.nodes.owned * dim;
        let matrix = Matrix::shell(petsc, rows, rows, dim, Rc::new(NoTangent))?;
        let snes = Snes::new(petsc, prefix, matrix, &setup)?;
        return Ok(System { snes, form: TangentForm::None, diagonal, saddle: None, rows });
    }
    if !levels.is_empty() {
        let mut hierarchy = Hierarchy::new(comm, petsc, levels)?;
        let rows = all.nodes.owned * dim;
        let matrix = Matrix::shell(petsc, rows, rows, dim, hierarchy.finest().clone())?;
        let snes = with_levels(runtime, prefix, case.axes, matrix, &setup, &mut hierarchy)?;
        return Ok(System {
            snes,
            form: TangentForm::Levels(hierarchy),
            diagonal,
            saddle: None,
            rows,
        });
    }
    if case.solver.form == Form::SaddlePoint {
        let saddle = SaddleTangent::new(comm, all, diagonal);
        let (own, other) = saddle.counts(comm, all);
        let rows = own.len() * dim;
        let mut matrix = Matrix::new(petsc, rows, dim, &own, &other)?;
        matrix.declare_unsymmetric()?;
        let snes = Snes::new(petsc, "", matrix, &setup)?;
        let saddle = Some(SaddlePoint::new(saddle));
        return Ok(System { snes, form: TangentForm::None, diagonal, saddle, rows });
    }
    if choice.preset == AGGREGATION {
        return in_blocks(runtime, case, all, diagonal, &setup);
    }
    let pattern = Pattern::new(comm, all);
    let (own, other) = pattern.counts(all.nodes.first);
    let rows = own.len() * dim;
    let mut matrix = Matrix::new(petsc, rows, dim, &own, &other)?;
    if case.has_friction() {
        matrix.declare_unsymmetric()?;
    }
    if choice.preset == "gamg" {
        set_motions(runtime, case.axes, all, &mut matrix)?;
    }
    let form = TangentForm::Assembled(Tangent::new(all, pattern, diagonal));
    let snes = Snes::new(petsc, prefix, matrix, &setup)?;
    Ok(System { snes, form, diagonal, saddle: None, rows })
}

/// Sets up SNES with a matrix of blocks, preconditioned by smoothed aggregation. Collective.
fn in_blocks(
    runtime: &Runtime,
    case: &Case,
    all: &Discretization,
    diagonal: f64,
    setup: &KspSetup,
) -> Result<System> {
    let (petsc, rows) = (&runtime.petsc, all.nodes.owned * all.dim);
    let blocks = BlockTangent::new(&runtime.comm, all, case.axes, diagonal)?;
    let matrix = Matrix::shell(petsc, rows, rows, all.dim, blocks.operator())?;
    let prefix = if case.flow.is_some() { MECHANICS } else { "" };
    let mut snes = Snes::new(petsc, prefix, matrix, setup)?;
    snes.precondition_by(blocks.preconditioner())?;
    Ok(System { snes, form: TangentForm::Blocks(blocks), diagonal, saddle: None, rows })
}

/// The laws, with the augmentation that suits the stiffness of the cells behind the interface.
fn joint_laws(case: &Case, mesh: &LocalMesh, sides: &[Sides]) -> Vec<JointLaw> {
    let law = |(spec, side): (&crate::case::InterfaceSpec, &Sides)| {
        let lip = side.secondary_facts(&mesh.facts);
        let stiffness = case.materials[lip.material].young_modulus / lip.cell[2];
        JointLaw { spec: spec.law.clone(), augmentation: spec.law.law().augmentation(stiffness) }
    };
    case.interfaces.iter().zip(sides).map(law).collect()
}

/// Gives PETSc's smoothed aggregation the rigid-body motions.
fn set_motions(
    runtime: &Runtime,
    axes: &[usize],
    all: &Discretization,
    matrix: &mut Matrix,
) -> Result<()> {
    if runtime.comm.any(!all.frames.is_empty()) {
        set_motions_in_frames(runtime, axes, all, matrix)
    } else {
        set_rigid_motions(runtime, axes, all, matrix)
    }
}

/// The motions where nodes have frames of their own.
fn set_motions_in_frames(
    runtime: &Runtime,
    axes: &[usize],
    all: &Discretization,
    matrix: &mut Matrix,
) -> Result<()> {
    let motion = |values: Vec<f64>| {
        let mut vector = Vector::new(&runtime.petsc, values.len(), all.dim)?;
        vector.write()?.copy_from_slice(&values);
        Ok(vector)
    };
    let motions = rigid_motions(&runtime.comm, axes, all).into_iter().map(motion);
    matrix.set_near_null_space(&motions.collect::<Result<Vec<_>>>()?)
}

/// The motions from the places of the nodes.
fn set_rigid_motions(
    runtime: &Runtime,
    axes: &[usize],
    all: &Discretization,
    matrix: &mut Matrix,
) -> Result<()> {
    let mut coordinates = Vector::new(&runtime.petsc, all.nodes.owned * all.dim, all.dim)?;
    {
        let mut values = coordinates.write()?;
        for (node, point) in all.nodes.points[..all.nodes.owned].iter().enumerate() {
            for (c, axis) in axes.iter().enumerate() {
                values[node * all.dim + c] = point[*axis];
            }
        }
    }
    matrix.set_rigid_body_near_null_space(&coordinates)
}
