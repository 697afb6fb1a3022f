//! From a case and this rank's cells to the coupled problem.

use std::cell::RefCell;
use std::rc::Rc;

use super::block::Block;
use super::blocks::{Blocks, CoupledSolve, operators};
use super::coupled::Coupling;
use super::coupled_factors::CoupledFactors;
use super::films::{films, further_nodes};
use super::pace::Pace;
use super::pressures::{Displacements, Pressures};
use super::ties::{named_ties, on_lips, ties};
use super::{Flow, FlowParts, Source};
use crate::assembly::{CoupledMatrix, Discretization, PoreCell, PoreSpace, TangentOperator};
use crate::bulk::{FlowStep, Loads, MAX_CORNERS, PorousCell, PorousMedium};
use crate::case::{Case, FlowSpec};
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::mesh::{Geometry, LocalMesh};
use crate::petsc::{KspSetup, Matrix, Snes};
use crate::runtime::Runtime;
use crate::solve::problem::KnownPressure;
use crate::space::{AtNode, Directory, Nodes, PrescribedPressure};

/// Prefix of PETSc options of the solver of the mechanical block.
pub const MECHANICS: &str = "mechanics_";
/// Prefix of PETSc options of the solver of the block of the pressure.
const FLOW: &str = "flow_";
/// Prefix of PETSc options of the elimination of both fields.
const WHOLE: &str = "whole_";

/// GMRES over both fields; the preconditioner is ours.
const COUPLED: &[(&str, &str)] = &[
    ("ksp_type", "gmres"),
    ("ksp_pc_side", "right"),
    ("ksp_gmres_restart", "150"),
    ("ksp_max_it", "600"),
    ("pc_type", "shell"),
];

/// Where every pressure is known the system is symmetric and positive, but for friction.
const KNOWN: &[(&str, &str)] = &[("ksp_type", "cg"), ("ksp_max_it", "500"), ("pc_type", "shell")];

/// One V-cycle of BoomerAMG for a scalar field, with few and short rows on the coarser levels.
const MULTIGRID: &[(&str, &str)] = &[
    ("ksp_type", "preonly"),
    ("pc_type", "hypre"),
    ("pc_hypre_type", "boomeramg"),
    ("pc_hypre_boomeramg_strong_threshold", "0.5"),
    ("pc_hypre_boomeramg_coarsen_type", "HMIS"),
    ("pc_hypre_boomeramg_interp_type", "ext+i"),
    ("pc_hypre_boomeramg_P_max", "6"),
];

/// Sweeps of its smoother beside displacements of second order, which cost so much more that a
/// second one costs nothing: in short steps the matrix is nearly a mass matrix, of which BoomerAMG
/// makes no coarser level.
const SWEEPS: (&str, &str) = ("pc_hypre_boomeramg_grid_sweeps_all", "2");

/// The first step after a jump of the load is so much of the shortest one that does not oscillate
/// along the shortest edge of a cell.
const FIRST: f64 = 0.01;

/// Few pressures are eliminated.
const ELIMINATION: &[(&str, &str)] =
    &[("ksp_type", "preonly"), ("pc_type", "cholesky"), ("pc_factor_mat_solver_type", "mumps")];

/// Up to so many.
const FEW: u64 = 3000;

/// A problem of both fields.
pub struct Coupled {
    /// The solver of both fields.
    pub snes: Snes,
    /// What couples them.
    pub coupling: Coupling,
    /// Unknowns of this rank.
    pub rows: usize,
}

/// The solver of the displacements alone.
pub struct Mechanics {
    /// Becomes a block of the preconditioner.
    pub snes: Snes,
    /// What it has for its matrix.
    pub tangent: Rc<TangentOperator>,
}

/// Adds the pore pressure to a mechanical problem, whose solver becomes a block of the
/// preconditioner. With `eliminate`, its options of elimination, both fields are eliminated
/// together, but for films. Collective.
///
/// # Errors
/// `Input` when pressures disagree or a formula gives no finite number; `System` when PETSc fails.
pub fn couple(
    runtime: &Runtime,
    case: &Case,
    flow: &FlowSpec,
    of: Displacements<'_>,
    mechanics: Mechanics,
    eliminate: Option<&KspSetup>,
) -> Result<Coupled> {
    let (comm, petsc, dim) = (&runtime.comm, &runtime.petsc, case.dim);
    let Displacements { mesh, all, .. } = of;
    let corners = mesh.corners();
    let prescribed = PrescribedPressure::new(case);
    let pressures = Pressures { corners: &corners, prescribed: &prescribed };
    let space = Rc::new(pore_space(comm, case, of, &pressures)?);
    AtNode::agree(comm, prescribed.check(space.nodes.iter_owned(), &case.load_times()))?;
    let [inflow, injection] = [Loads::inflow(case, &corners), Loads::injection(case, &corners)];
    comm.agree([&inflow, &injection].iter().try_for_each(|of| of.check(&case.load_times())))?;
    let [inflow, injection] = [inflow, injection].map(|rate| Source::new(rate, space.nodes.len()));
    let mut initial = AtNode::agree(comm, initial(case, flow, &space))?;
    space.follow(&mut initial);

    let scale = stiffest(comm, case, mesh);
    let eliminate = eliminate.filter(|_| space.has_unknowns(comm) && !space.films.are_there());
    let solve = coupled_solve(runtime, case, of, &space, eliminate)?;
    let pores = Rc::clone(&space);
    let blocks = Blocks::new(comm, petsc, mechanics.snes, solve, mechanics.tangent, pores, scale)?;
    let (blocks, rows) = (Rc::new(blocks), all.nodes.owned * dim + space.nodes.owned);
    let (operator, preconditioner) = operators(&blocks);
    let matrix = Matrix::shell(petsc, rows, rows, 1, operator)?;
    let is_symmetric = !blocks.is_coupled() && !case.has_friction();
    let options = if is_symmetric { KNOWN } else { COUPLED };
    let mut snes = Snes::new(petsc, "", matrix, &KspSetup::new(options))?;
    snes.precondition_by(preconditioner)?;

    let lips = on_lips(case, &pressures, &space.nodes);
    let Steps { shortest, bounds } = steps(comm, &space, flow.theta);
    let pace = flow.tolerance.map(|tolerance| Pace::new(tolerance, FIRST * shortest));
    let density = case.materials.iter().find_map(|m| Some(m.porous.as_ref()?.fluid_density));
    let mut gravity = [0.0; 3];
    case.axes.iter().enumerate().for_each(|(c, axis)| gravity[c] = case.gravity[*axis]);
    let flow = Flow::new(FlowParts {
        space,
        prescribed,
        inflow,
        injection,
        density: density.unwrap_or(1.0),
        scale,
        step: FlowStep { length: 0.0, theta: flow.theta, gravity, lumped: flow.lumped },
        pace,
        bounds,
        lips,
        interfaces: case.interfaces.len(),
        initial,
    });
    Ok(Coupled { snes, coupling: Coupling::new(flow, blocks), rows })
}

/// The stiffness that scales the pressures: the largest modulus over the longest edge of its cells
/// (Pa/m). Collective.
fn stiffest(comm: &Comm, case: &Case, mesh: &LocalMesh) -> f64 {
    let of = |cell: usize| {
        let size = mesh.extent(cell);
        let edges = case.axes.iter().map(|axis| size[*axis]);
        let material = mesh.prototype(cell).material;
        case.materials[material].young_modulus / edges.fold(0.0, f64::max)
    };
    let mut largest = [(0..mesh.cells.len()).map(of).fold(0.0, f64::max)];
    comm.max(&mut largest);
    largest[0]
}

/// The part of the preconditioner that concerns the pressure; with `eliminate` that of both fields.
/// Collective.
fn coupled_solve(
    runtime: &Runtime,
    case: &Case,
    of: Displacements<'_>,
    space: &PoreSpace,
    eliminate: Option<&KspSetup>,
) -> Result<CoupledSolve> {
    let (comm, petsc) = (&runtime.comm, &runtime.petsc);
    let Some(setup) = eliminate else {
        let matrix = space.matrix(comm, petsc)?;
        let second = of.mesh.facts.order == 2;
        let multigrid = [MULTIGRID, if second { &[SWEEPS] } else { &[] }].concat();
        let options = if space.nodes.total <= FEW { ELIMINATION } else { &multigrid };
        let solver = Snes::new(petsc, FLOW, matrix, &KspSetup::new(options))?;
        return Ok(CoupledSolve::Split(RefCell::new(Block::new(petsc, solver)?)));
    };
    let numbers = CoupledMatrix::new(comm, of.all, space);
    let mut matrix = numbers.matrix(comm, petsc, of.all, space)?;
    if case.has_friction() {
        matrix.declare_unsymmetric()?;
    }
    let block = Block::new(petsc, Snes::new(petsc, WHOLE, matrix, setup)?)?;
    Ok(CoupledSolve::Eliminated(RefCell::new(CoupledFactors::new(numbers, block))))
}

/// Lengths of steps (s).
struct Steps {
    /// The shortest that does not oscillate along the shortest edge of a cell.
    shortest: f64,
    /// The longest in which the pressure of some cell would oscillate: of cells that are held back
    /// then, and of others.
    bounds: [f64; 2],
}

/// The lengths of steps that matter for the cells of all ranks. Collective.
fn steps(comm: &Comm, space: &PoreSpace, theta: f64) -> Steps {
    let mut bounds = [0.0_f64; 3];
    let mut shortest = f64::INFINITY;
    for cell in &space.prototypes {
        let [least, bound] = cell.shortest_steps(theta);
        let of = if cell.is_held_back() { 0 } else { 1 };
        bounds[of] = bounds[of].max(bound);
        shortest = shortest.min(least);
    }
    bounds[2] = -shortest;
    comm.max(&mut bounds);
    Steps { shortest: -bounds[2], bounds: [bounds[0], bounds[1]] }
}

/// The pressure that is a load, where there is one. Collective.
///
/// # Errors
/// As [`KnownPressure::new`].
pub fn known_pressure(
    comm: &Comm,
    case: &Case,
    mesh: &LocalMesh,
    all: &Rc<Discretization>,
) -> Result<Option<KnownPressure>> {
    if !case.pressure_is_load {
        return Ok(None);
    }
    let corners = mesh.corners();
    let prescribed = PrescribedPressure::new(case);
    let pressures = Pressures { corners: &corners, prescribed: &prescribed };
    let of = Displacements { mesh, all, sides: &[], gaps: &[] };
    let space = pore_space(comm, case, of, &pressures)?;
    KnownPressure::new(comm, space, prescribed, &case.load_times()).map(Some)
}

/// The porous cells of this rank, each with the index of what it has in common with its like: boxes
/// of one prototype share it, other cells have it alone. Local.
fn porous_cells(case: &Case, mesh: &LocalMesh) -> (Vec<PorousCell>, Vec<(usize, u32)>) {
    let axes = case.axes;
    let mut index = vec![None; mesh.prototypes.len()];
    let (mut like, mut porous) = (Vec::new(), Vec::new());
    for (cell, prototype) in mesh.cell_prototype.iter().enumerate() {
        let of = &mesh.prototypes[*prototype as usize];
        let material = &case.materials[of.material];
        let Some(properties) = &material.porous else { continue };
        let known: &mut Option<u32> = &mut index[*prototype as usize];
        if let Some(known) = known {
            porous.push((cell, *known));
            continue;
        }
        let number = like.len() as u32;
        let medium = PorousMedium::new(material, properties, case.dim);
        like.push(match of.geometry {
            Geometry::Box(size) => {
                *known = Some(number);
                PorousCell::new(of.shape, size, medium, axes)
            }
            Geometry::Points => {
                let along = |node: &u32| {
                    let mut out = [0.0; 3];
                    let point = mesh.nodes.points[*node as usize];
                    axes.iter().enumerate().for_each(|(c, axis)| out[c] = point[*axis]);
                    out
                };
                let points: Vec<[f64; 3]> = mesh.cell_nodes(cell).iter().map(along).collect();
                PorousCell::of_points(of.shape, &points, medium)
            }
        });
        porous.push((cell, number));
    }
    (like, porous)
}

/// Nodes, cells, ties and films of the pressure. Collective.
///
/// # Errors
/// As [`named_ties`]; `Input` where a formula gives no aperture.
fn pore_space(
    comm: &Comm,
    case: &Case,
    of: Displacements<'_>,
    pressures: &Pressures<'_>,
) -> Result<PoreSpace> {
    let (dim, Displacements { mesh, sides, .. }) = (case.dim, of);
    let Pressures { corners, prescribed } = pressures;
    let (prototypes, porous) = porous_cells(case, mesh);
    let names_of =
        |cell: usize| corners.cell_nodes(cell).iter().map(|n| corners.nodes.names[*n as usize]);
    let mut touched: Vec<u64> = porous.iter().flat_map(|(cell, _)| names_of(*cell)).collect();
    touched.sort_unstable();
    touched.dedup();
    let directory = Directory::new(comm, mesh.facts.nodes, &touched);
    let named = named_ties(comm, case, sides, pressures, &directory)?;
    touched.extend(further_nodes(case, of, &named));
    let nodes = Nodes::new(comm, &directory, &touched, &corners.nodes)?;
    let cells = porous.iter().map(|(cell, prototype)| {
        let mut of = [0; MAX_CORNERS];
        for (of, name) in of.iter_mut().zip(names_of(*cell)) {
            *of = nodes.local(name).expect("the nodes of the rank's cells are held");
        }
        let count = corners.cell_nodes(*cell).len() as u8;
        PoreCell { cell: *cell as u32, prototype: *prototype, nodes: of, count }
    });
    let cells = cells.collect();
    let (ties, tie_of) = ties(&named, &nodes);
    let films = AtNode::agree(comm, films(case, of, &nodes))?;
    Ok(PoreSpace {
        dim,
        cells,
        prototypes,
        ties,
        tie_of,
        films,
        prescribed: nodes.marks.iter().map(|n| prescribed.entry_of(n).is_some()).collect(),
        nodes,
    })
}

/// The pressures at the start, of all local nodes (Pa).
fn initial(
    case: &Case,
    flow: &FlowSpec,
    space: &PoreSpace,
) -> std::result::Result<Vec<f64>, AtNode> {
    let at = |(name, [x, y, z]): (&u64, &[f64; 3])| {
        let value = flow.initial.at([*x, *y, *z], case.start);
        let words = || {
            format!(
                "initial.pressure is {value} at ({x}, {y}, {z}) m; the formula must give finite \
                 numbers everywhere"
            )
        };
        if value.is_finite() { Ok(value) } else { Err(AtNode(*name, Error::Input(words()))) }
    };
    space.nodes.names.iter().zip(&space.nodes.points).map(at).collect()
}
