//! The linear systems of displacement and pore pressure, and their preconditioner.
//!
//! Unknowns are the displacements of all nodes, then the scaled pressures. The linear systems
//!
//! ```text
//! [  A    -Q ] [du]
//! [ -Q^T  -C ] [dp]
//! ```
//!
//! have the tangent A of the condensed form, the coupling Q and the compressibility C, both
//! linearised at rest: symmetric, and the same for every state and step of one length. GMRES solves
//! them with a block triangular preconditioner: that of the mechanical problem for A, and multigrid
//! for the fixed-stress approximation of the Schur complement, C + b^2/K M (J. White, R. Borja,
//! Comput. Geosci. 15, 2011), with the geometric mean K of the drained bulk modulus and the
//! oedometric one: motions of the skeleton under a pressure lie between the two. With
//! `solver.linear: mumps` the whole matrix is eliminated instead.
//!
//! Fluid that flows along an interface adds what depends on the state and is not symmetric: the
//! operator has the derivatives by pressures and openings ([`FilmTangent`]), the pressure's block
//! those by pressures, and the fields are split with every solver.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use super::block::Block;
use super::coupled_factors::CoupledFactors;
use crate::assembly::{CoupledValues, FilmTangent, NodeState, PoreSpace, TangentOperator};
use crate::bulk::{FlowStep, PoroState, PorousCell};
use crate::comm::Comm;
use crate::error::Result;
use crate::petsc::{
    LinearOperator, NonlinearSystem, Petsc, Preconditioner, Ran, Snes, TangentChange,
};
use crate::solve::problem::{Problem, condensed};

/// How the linear system of both fields is preconditioned.
pub enum CoupledSolve {
    /// Field by field, block triangular: the block of the pressure.
    Split(RefCell<Block>),
    /// Both fields together, by elimination.
    Eliminated(RefCell<CoupledFactors>),
}

/// The linear operator of both fields, with the parts of its preconditioner.
pub struct Blocks {
    mechanics: RefCell<Block>,
    solve: CoupledSolve,
    tangent: Rc<TangentOperator>,
    pub(in crate::solve) pores: Rc<PoreSpace>,
    /// C of each prototype.
    compressibility: RefCell<Vec<Vec<f64>>>,
    /// What the films add to C at the last state, and their dependence on openings.
    pub(in crate::solve) films: RefCell<FilmTangent>,
    /// Pressure over its unknown (Pa/m).
    pub(in crate::solve) scale: f64,
    /// Entry of identity rows (N/m).
    pub(in crate::solve) diagonal: f64,
    /// Owned displacement components.
    pub(in crate::solve) split: usize,
    /// Whether any pressure is not prescribed.
    pub(in crate::solve) has_pressures: bool,
    /// Whether all pressures stay as they are, prescribed or not.
    pub(in crate::solve) holds: Cell<bool>,
}

impl Blocks {
    /// The blocks with the solvers that precondition them; `tangent` is what the mechanical one has
    /// for its matrix. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn new(
        comm: &Comm,
        petsc: &Petsc,
        mechanics: Snes,
        solve: CoupledSolve,
        tangent: Rc<TangentOperator>,
        pores: Rc<PoreSpace>,
        scale: f64,
    ) -> Result<Self> {
        let diagonal = tangent.identity_entry();
        let split = mechanics.matrix().owned_rows();
        let has_pressures = pores.has_unknowns(comm);
        Ok(Self {
            mechanics: RefCell::new(Block::new(petsc, mechanics)?),
            solve,
            tangent,
            pores,
            compressibility: RefCell::default(),
            films: RefCell::default(),
            scale,
            diagonal,
            split,
            has_pressures,
            holds: Cell::new(false),
        })
    }

    /// The solvers that are used, with what PETSc makes of them. Local.
    pub(in crate::solve) fn ran(&self) -> Result<Vec<Ran>> {
        let mechanics = || self.mechanics.borrow().solver.ran();
        match &self.solve {
            CoupledSolve::Split(flow) => Ok(vec![mechanics()?, flow.borrow().solver.ran()?]),
            CoupledSolve::Eliminated(factors) => Ok(vec![factors.borrow().block.solver.ran()?]),
        }
    }

    /// Whether the fields are split, rather than eliminated together.
    pub(in crate::solve) fn is_split(&self) -> bool {
        matches!(self.solve, CoupledSolve::Split(_))
    }

    /// Whether any pressure is to be found. Local: the same on all ranks.
    pub fn is_coupled(&self) -> bool {
        self.has_pressures && !self.holds.get()
    }

    /// Calls `act` with every owned pressure whose row is the identity. Local.
    pub(in crate::solve) fn for_identity_rows(&self, act: impl FnMut(usize)) {
        if self.holds.get() {
            (0..self.pores.nodes.owned).for_each(act);
        } else {
            self.pores.for_identity_rows(act);
        }
    }

    /// Sets up the tangent of the mechanical problem at the state that it evaluated last.
    /// Collective.
    pub(in crate::solve) fn set_mechanics(
        &self,
        problem: &mut Problem<'_>,
        x: &[f64],
    ) -> Result<TangentChange> {
        let block = &mut *self.mechanics.borrow_mut();
        let change = problem.tangent(&x[..self.split], block.solver.matrix_mut())?;
        if change != TangentChange::Unchanged {
            self.tangent.set_state(problem.assembled_state());
            if self.is_split() || self.holds.get() {
                block.solver.set_up_for(problem, change)?;
            }
        }
        Ok(change)
    }

    /// Assembles the flow of a step, with the films as they were set last. Collective.
    pub(in crate::solve) fn set_flow(&self, comm: &Comm, step: &FlowStep) -> Result<()> {
        let like = self.pores.prototypes.iter().map(|cell| cell.compressibility(step));
        *self.compressibility.borrow_mut() = like.collect();
        let CoupledSolve::Split(flow) = &self.solve else { return Ok(()) };
        let with_yielding = |cell: &PorousCell| -> Vec<f64> {
            let parts = cell.compressibility(step).into_iter().zip(cell.yielding());
            parts.map(|(c, y)| c + y).collect()
        };
        let yielding = |secondary| self.tangent.opening_compliance(secondary);
        let films = self.films.borrow().blocks(&self.pores.films, yielding);
        let block = &mut *flow.borrow_mut();
        let (square, matrix) = (self.scale * self.scale, block.solver.matrix_mut());
        self.pores.assemble(comm, with_yielding, &films, square, self.diagonal, matrix)?;
        block.solver.set_up(TangentChange::Changed)?;
        Ok(())
    }

    /// Eliminates both fields, where that is asked for; `state` is that of the tangent. Collective.
    pub(in crate::solve) fn set_whole(&self, comm: &Comm, state: &[NodeState]) -> Result<()> {
        let CoupledSolve::Eliminated(factors) = &self.solve else { return Ok(()) };
        let values = CoupledValues {
            state,
            compressibility: &self.compressibility.borrow(),
            scale: self.scale,
            diagonal: self.diagonal,
        };
        let (all, mechanics) = (self.tangent.discretization(), self.mechanics.borrow());
        let matrix = mechanics.solver.matrix();
        factors.borrow_mut().set_up(comm, all, &self.pores, matrix, &values)
    }

    /// Scaled pressures of owned nodes to pressures of all local ones. Collective.
    fn pressures(&self, x: &[f64]) -> Vec<f64> {
        let mut p = vec![0.0; self.pores.nodes.len()];
        p.iter_mut().zip(x).for_each(|(p, x)| *p = self.scale * x);
        self.pores.expand(&mut p);
        p
    }

    /// Adds Q p to forces on owned components. Collective.
    fn add_forces(&self, p: &[f64], y: &mut [f64]) {
        let mut force = vec![0.0; self.tangent.unknowns_held()];
        self.pores.add_forces(self.tangent.discretization(), p, false, &mut force);
        self.tangent.fold(&mut force, None);
        y.iter_mut().zip(&force).for_each(|(y, f)| *y += f);
    }
}

impl Blocks {
    /// What [`Operator`] multiplies by, for a change of all unknowns in which prescribed
    /// displacements move too: the change of the forces on all owned displacements, and of the
    /// rows of those pressures that are to be found. Collective.
    pub(in crate::solve) fn forces_of(&self, problem: &Problem<'_>, x: &[f64]) -> Vec<f64> {
        let (xu, xp) = x.split_at(self.split);
        let (all, pores) = (&problem.all, &self.pores);
        let p = self.is_coupled().then(|| self.pressures(xp));
        let mut rows = vec![0.0; pores.nodes.len()];
        let beside = |u: &[f64], force: &mut [f64]| {
            let Some(p) = &p else { return };
            let minus: Vec<f64> = p.iter().map(|p| -p).collect();
            pores.add_forces(all, &minus, false, force);
            pores.add_volumes(all, u, &mut rows);
            let change = PoroState { displacement: u, pressure: p };
            self.films.borrow().add_product(&pores.films, all, change, &mut rows);
        };
        let (comm, state) = (problem.comm, &problem.interfaces);
        let mut forces = condensed::linear_forces(comm, all, state, xu.to_vec(), beside);
        forces.resize(x.len(), 0.0);
        if let Some(p) = &p {
            pores.add_product(&self.compressibility.borrow(), p, &mut rows);
            pores.fold(&mut rows);
            let of_pressures = forces[self.split..].iter_mut().zip(&rows);
            of_pressures.for_each(|(y, row)| *y = -self.scale * row);
            self.for_identity_rows(|node| forces[self.split + node] = 0.0);
        }
        forces
    }
}

/// The operator of the linear systems.
pub(in crate::solve) struct Operator(pub(in crate::solve) Rc<Blocks>);

impl LinearOperator for Operator {
    fn multiply(&self, x: &[f64], y: &mut [f64]) {
        let Self(blocks) = self;
        let ((xu, xp), (yu, yp)) = (x.split_at(blocks.split), y.split_at_mut(blocks.split));
        if blocks.is_coupled() {
            let (all, pores) = (blocks.tangent.discretization(), &blocks.pores);
            let p = blocks.pressures(xp);
            let mut rows = vec![0.0; p.len()];
            let minus: Vec<f64> = p.iter().map(|p| -p).collect();
            // Within the product, which has the displacements of all local nodes and sums the
            // forces.
            blocks.tangent.multiply_beside(xu, yu, |u, force| {
                pores.add_forces(all, &minus, false, force);
                pores.add_volumes(all, u, &mut rows);
                let change = PoroState { displacement: u, pressure: &p };
                blocks.films.borrow().add_product(&pores.films, all, change, &mut rows);
            });
            pores.add_product(&blocks.compressibility.borrow(), &p, &mut rows);
            pores.fold(&mut rows);
            yp.iter_mut().zip(&rows).for_each(|(y, row)| *y = -blocks.scale * row);
        } else {
            blocks.tangent.multiply(xu, yu);
        }
        blocks.for_identity_rows(|node| yp[node] = blocks.diagonal * xp[node]);
    }
}

/// The blocks as the preconditioner.
struct Triangular(Rc<Blocks>);

impl Preconditioner for Triangular {
    fn apply(&self, r: &[f64], z: &mut [f64]) -> Result<()> {
        let Self(blocks) = self;
        let ((ru, rp), (zu, zp)) = (r.split_at(blocks.split), z.split_at_mut(blocks.split));
        if !blocks.is_coupled() {
            blocks.mechanics.borrow_mut().apply(ru, zu)?;
            zp.iter_mut().zip(rp).for_each(|(z, r)| *z = r / blocks.diagonal);
            return Ok(());
        }
        let flow = match &blocks.solve {
            CoupledSolve::Eliminated(factors) => return factors.borrow_mut().apply(r, z),
            CoupledSolve::Split(flow) => flow,
        };
        flow.borrow_mut().apply(rp, zp)?;
        zp.iter_mut().for_each(|z| *z = -*z);
        blocks.for_identity_rows(|node| zp[node] = rp[node] / blocks.diagonal);
        let mut force = ru.to_vec();
        blocks.add_forces(&blocks.pressures(zp), &mut force);
        blocks.mechanics.borrow_mut().apply(&force, zu)
    }
}

/// The operator of the linear systems and its preconditioner, for PETSc.
pub fn operators(blocks: &Rc<Blocks>) -> (Rc<dyn LinearOperator>, Rc<dyn Preconditioner>) {
    (Rc::new(Operator(Rc::clone(blocks))), Rc::new(Triangular(Rc::clone(blocks))))
}
