//! Displacement and pore pressure together, as PETSc's SNES sees them.
//!
//! Unknowns are the displacements of all nodes, then the scaled pressures. The linear systems
//!
//! ```text
//! [  A    -Q ] [du]
//! [ -Q^T  -C ] [dp]
//! ```
//!
//! have the tangent A of the condensed form, the coupling Q and the compressibility C, both linearised
//! at rest: symmetric, and the same for every state and step of one length. GMRES solves them with a
//! block triangular preconditioner: that of the mechanical problem for A, and multigrid for the
//! fixed-stress approximation of the Schur complement, C + b^2/K M (J. White, R. Borja, Comput. Geosci.
//! 15, 2011), with the geometric mean K of the drained bulk modulus and the oedometric one: motions of
//! the skeleton under a pressure lie between the two.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use super::condensed;
use super::flow::Flow;
use super::problem::Problem;
use crate::assembly::{FilmTangent, PoreSpace, TangentOperator};
use crate::bulk::{FlowStep, PorousCell};
use crate::comm::Comm;
use crate::error::Result;
use crate::petsc::{
    FurtherSolve, LinearOperator, LinearTolerance, Matrix, NonlinearSystem, Petsc, Snes,
    TangentChange, Trial, Vector, Verdict,
};
use crate::timers::Phase;

/// How many times smaller than that of forces the error of the fluid's balance has to be: errors of all
/// steps add up in the accounts.
const STRICTER: f64 = 100.0;

/// Part by which one correction may change the density of a fluid that flows along an interface. Between
/// lips that still hold nothing bounds the pressure but what the rock stores.
const MOST_DENSER: f64 = 0.1;

/// A block of the preconditioner: a solver that is only asked for its preconditioner.
struct Block {
    solver: Snes,
    from: Vector,
    to: Vector,
}

impl Block {
    fn new(petsc: &Petsc, solver: Snes) -> Result<Self> {
        let (rows, width) = (solver.matrix().owned_rows(), solver.matrix().block_size());
        let (from, to) = (Vector::new(petsc, rows, width)?, Vector::new(petsc, rows, width)?);
        Ok(Self { solver, from, to })
    }

    /// z = the preconditioner times r; not numbers where PETSc fails, which ends the linear solve.
    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        let mut work = || -> Result<()> {
            self.from.write()?.copy_from_slice(r);
            self.solver.apply_preconditioner(&self.from, &mut self.to)?;
            z.copy_from_slice(&self.to.read()?);
            Ok(())
        };
        if work().is_err() {
            z.fill(f64::NAN);
        }
    }
}

/// The linear operator of both fields, with the parts of its preconditioner.
pub struct Blocks {
    mechanics: RefCell<Block>,
    flow: RefCell<Block>,
    tangent: Rc<TangentOperator>,
    pores: Rc<PoreSpace>,
    /// C of each prototype.
    compressibility: RefCell<Vec<Vec<f64>>>,
    /// What the films add to C at the last state, and their dependence on openings.
    films: RefCell<FilmTangent>,
    /// Pressure over its unknown (Pa/m).
    scale: f64,
    /// Entry of identity rows (N/m).
    diagonal: f64,
    /// Owned displacement components.
    split: usize,
    /// Whether any pressure is not prescribed.
    is_coupled: bool,
    /// Whether all pressures stay as they are, prescribed or not.
    holds: Cell<bool>,
}

impl Blocks {
    /// The blocks with the solvers that precondition them; `tangent` is what the mechanical one has for
    /// its matrix. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn new(
        comm: &Comm,
        petsc: &Petsc,
        (mechanics, flow): (Snes, Snes),
        tangent: Rc<TangentOperator>,
        pores: Rc<PoreSpace>,
        scale: f64,
    ) -> Result<Self> {
        let diagonal = tangent.identity_entry();
        let split = mechanics.matrix().owned_rows();
        let mut known = 0;
        pores.for_identity_rows(|_| known += 1);
        let is_coupled = comm.any(known < pores.nodes.owned);
        Ok(Self {
            mechanics: RefCell::new(Block::new(petsc, mechanics)?),
            flow: RefCell::new(Block::new(petsc, flow)?),
            tangent,
            pores,
            compressibility: RefCell::default(),
            films: RefCell::default(),
            scale,
            diagonal,
            split,
            is_coupled,
            holds: Cell::new(false),
        })
    }

    /// Whether any pressure is to be found. Local: the same on all ranks.
    pub fn is_coupled(&self) -> bool {
        self.is_coupled && !self.holds.get()
    }

    /// Calls `act` with every owned pressure whose row is the identity. Local.
    fn for_identity_rows(&self, act: impl FnMut(usize)) {
        if self.holds.get() {
            (0..self.pores.nodes.owned).for_each(act);
        } else {
            self.pores.for_identity_rows(act);
        }
    }

    /// Sets up the tangent of the mechanical problem at the state that it evaluated last. Collective.
    fn set_mechanics(&self, problem: &mut Problem<'_>, x: &[f64]) -> Result<TangentChange> {
        let block = &mut *self.mechanics.borrow_mut();
        let change = problem.tangent(&x[..self.split], block.solver.matrix_mut())?;
        if change != TangentChange::Unchanged {
            self.tangent.set_state(problem.assembled_state());
            block.solver.set_up(change)?;
        }
        Ok(change)
    }

    /// Assembles the flow of a step, with the films as they were set last. Collective.
    fn set_flow(&self, comm: &Comm, step: &FlowStep) -> Result<()> {
        let like = self.pores.prototypes.iter().map(|cell| cell.compressibility(step));
        *self.compressibility.borrow_mut() = like.collect();
        let with_yielding = |cell: &PorousCell| -> Vec<f64> {
            let parts = cell.compressibility(step).into_iter().zip(cell.yielding());
            parts.map(|(c, y)| c + y).collect()
        };
        let yielding = |secondary| self.tangent.opening_compliance(secondary);
        let films = self.films.borrow().blocks(&self.pores.films, yielding);
        let block = &mut *self.flow.borrow_mut();
        let (square, matrix) = (self.scale * self.scale, block.solver.matrix_mut());
        self.pores.assemble(comm, with_yielding, &films, (square, self.diagonal), matrix)?;
        block.solver.set_up(TangentChange::Changed)?;
        Ok(())
    }

    /// Scaled pressures of owned nodes to pressures of all local ones. Collective.
    fn pressures(&self, x: &[f64]) -> Vec<f64> {
        let mut p = vec![0.0; self.pores.nodes.len()];
        p.iter_mut().zip(x).for_each(|(p, x)| *p = self.scale * x);
        self.pores.expand(&mut p);
        p
    }

    /// Adds Q p to forces on owned components, `factor` times. Collective.
    fn add_forces(&self, p: &[f64], factor: f64, y: &mut [f64]) {
        let mut force = vec![0.0; self.tangent.unknowns_held()];
        self.pores.add_forces(self.tangent.discretization(), p, false, &mut force);
        self.tangent.fold(&mut force, None);
        y.iter_mut().zip(&force).for_each(|(y, f)| *y += factor * f);
    }
}

/// The operator of the linear systems.
struct Operator(Rc<Blocks>);

impl LinearOperator for Operator {
    fn multiply(&self, x: &[f64], y: &mut [f64]) {
        let Self(blocks) = self;
        let ((xu, xp), (yu, yp)) = (x.split_at(blocks.split), y.split_at_mut(blocks.split));
        blocks.tangent.multiply(xu, yu);
        if blocks.is_coupled() {
            let p = blocks.pressures(xp);
            blocks.add_forces(&p, -1.0, yu);
            let mut u = vec![0.0; blocks.tangent.unknowns_held()];
            u[..xu.len()].copy_from_slice(xu);
            blocks.tangent.expand(&mut u);
            let (all, pores) = (blocks.tangent.discretization(), &blocks.pores);
            let mut rows = vec![0.0; p.len()];
            pores.add_volumes(all, &u, &mut rows);
            pores.add_product(&blocks.compressibility.borrow(), &p, &mut rows);
            blocks.films.borrow().add_product(&pores.films, all, (&u, &p), &mut rows);
            blocks.pores.fold(&mut rows);
            yp.iter_mut().zip(&rows).for_each(|(y, row)| *y = -blocks.scale * row);
        }
        blocks.for_identity_rows(|node| yp[node] = blocks.diagonal * xp[node]);
    }
}

/// The preconditioner.
struct Preconditioner(Rc<Blocks>);

impl LinearOperator for Preconditioner {
    fn multiply(&self, r: &[f64], z: &mut [f64]) {
        let Self(blocks) = self;
        let ((ru, rp), (zu, zp)) = (r.split_at(blocks.split), z.split_at_mut(blocks.split));
        if !blocks.is_coupled() {
            blocks.mechanics.borrow_mut().apply(ru, zu);
            zp.iter_mut().zip(rp).for_each(|(z, r)| *z = r / blocks.diagonal);
            return;
        }
        blocks.flow.borrow_mut().apply(rp, zp);
        zp.iter_mut().for_each(|z| *z = -*z);
        blocks.for_identity_rows(|node| zp[node] = rp[node] / blocks.diagonal);
        let mut force = ru.to_vec();
        blocks.add_forces(&blocks.pressures(zp), 1.0, &mut force);
        blocks.mechanics.borrow_mut().apply(&force, zu);
    }
}

/// What the coupled model has beside the mechanical problem.
pub struct Coupling {
    /// Pressure and balance.
    pub flow: Flow,
    blocks: Rc<Blocks>,
    /// The step with which the flow was assembled.
    assembled: Option<FlowStep>,
    /// What is missing in the balance of the fluid at the last state, over its scale.
    missing: f64,
}

impl Coupling {
    /// Nothing is assembled yet.
    pub fn new(flow: Flow, blocks: Rc<Blocks>) -> Self {
        Self { flow, blocks, assembled: None, missing: 0.0 }
    }

    /// Whether the pressures stay as they are, and the mechanical problem alone is solved. Local.
    pub fn hold_pressures(&self, holds: bool) {
        self.blocks.holds.set(holds);
    }

    /// The operator and the preconditioner for PETSc.
    pub fn operators(blocks: &Rc<Blocks>) -> [Rc<dyn LinearOperator>; 2] {
        [Rc::new(Operator(Rc::clone(blocks))), Rc::new(Preconditioner(Rc::clone(blocks)))]
    }
}

/// A problem with its pore pressure.
pub(super) struct CoupledSystem<'s, 'a> {
    pub(super) problem: &'s mut Problem<'a>,
    pub(super) coupling: &'s mut Coupling,
}

impl NonlinearSystem for CoupledSystem<'_, '_> {
    fn residual(&mut self, x: &[f64], f: &mut [f64]) -> Result<()> {
        let (problem, Coupling { flow, blocks, missing, .. }) =
            (&mut *self.problem, &mut *self.coupling);
        let (u, p) = x.split_at(blocks.split);
        let (fu, fp) = f.split_at_mut(blocks.split);
        let all = Rc::clone(&problem.all);
        flow.take(p);
        problem.pore_force.resize(problem.load.len(), 0.0);
        problem.pore_force.fill(0.0);
        flow.add_forces(&all, &mut problem.pore_force);
        problem.residual(u, fu)?;
        let _phase = problem.timers.enter(Phase::Assembly);
        if blocks.holds.get() {
            fp.fill(0.0);
            *missing = 0.0;
            return Ok(());
        }
        let state = (&problem.displacement[..], &problem.known_jumps[..]);
        *missing = flow.residual(problem.comm, &all, state, fp);
        Ok(())
    }

    fn tangent(&mut self, x: &[f64], matrix: &mut Matrix) -> Result<TangentChange> {
        let (problem, coupling) = (&mut *self.problem, &mut *self.coupling);
        let mut change = coupling.blocks.set_mechanics(problem, x)?;
        let step = coupling.flow.step;
        if coupling.blocks.holds.get() {
            if change != TangentChange::Unchanged {
                matrix.assemble()?;
            }
            return Ok(change);
        }
        let state = (&problem.displacement[..], &coupling.flow.pressure[..]);
        let films = coupling.flow.space.films.linearise(&problem.all, state, &step);
        let differ = films != *coupling.blocks.films.borrow();
        if problem.comm.any(differ) || coupling.assembled != Some(step) {
            coupling.blocks.films.replace(films);
            let _phase = problem.timers.enter(Phase::Assembly);
            coupling.blocks.set_flow(problem.comm, &step)?;
            coupling.assembled = Some(step);
            change = TangentChange::Changed;
        }
        if change != TangentChange::Unchanged {
            matrix.assemble()?;
        }
        Ok(change)
    }

    fn direction(
        &mut self,
        _x: &[f64],
        correction: &mut [f64],
        _solve: &mut FurtherSolve<'_>,
    ) -> Result<()> {
        let (problem, blocks) = (&mut *self.problem, &self.coupling.blocks);
        problem.interfaces.lean = 1.0;
        let u = &mut correction[..blocks.split];
        condensed::follow(&problem.all, &problem.interfaces, u);
        if !blocks.is_coupled {
            problem.keep(u);
        }
        let mut part = problem.convergence.part_of_step;
        if let Some(fluid) = &blocks.pores.films.fluid {
            let pressures = correction[blocks.split..].iter();
            let mut largest = [pressures.fold(0.0_f64, |m, p| m.max(p.abs()))];
            problem.comm.max(&mut largest);
            let denser = fluid.compressibility * blocks.scale * largest[0];
            part *= (MOST_DENSER / denser).min(1.0);
        }
        correction.iter_mut().for_each(|c| *c *= part);
        Ok(())
    }

    fn initial_guess(&mut self, rhs: &[f64], guess: &mut [f64]) -> Result<()> {
        let blocks = &self.coupling.blocks;
        let (gu, gp) = guess.split_at_mut(blocks.split);
        let (ru, rp) = rhs.split_at(blocks.split);
        blocks.for_identity_rows(|node| gp[node] = rp[node] / blocks.diagonal);
        if !blocks.is_coupled {
            return self.problem.initial_guess(ru, gu);
        }
        let problem = &*self.problem;
        let free = condensed::free_components(&problem.all, &problem.interfaces);
        for ((guess, rhs), _) in gu.iter_mut().zip(ru).zip(free).filter(|(_, free)| !free) {
            *guess = rhs / blocks.diagonal;
        }
        Ok(())
    }

    fn trial(&mut self, correction: &[f64], norm: f64) -> Result<Trial> {
        let blocks = &self.coupling.blocks;
        if blocks.is_coupled {
            return Ok(Trial::GoOn(None));
        }
        self.problem.trial(&correction[..blocks.split], norm)
    }

    fn verdict(&mut self, iteration: usize, _x: &[f64], f: &[f64], norm: f64) -> Result<Verdict> {
        let split = self.coupling.blocks.split;
        self.problem.judge(iteration, &f[..split], norm, STRICTER * self.coupling.missing)
    }

    fn linear_tolerance(&mut self, _iteration: usize, norm: f64) -> LinearTolerance {
        let problem = &*self.problem;
        let mut force = [problem.convergence.current()[0]];
        problem.comm.max(&mut force);
        let force = force[0].max(problem.convergence.accepted_force());
        let fluid = self.coupling.flow.force_scale() / STRICTER;
        let both = [force, fluid].into_iter().filter(|scale| *scale > 0.0);
        problem.linear.tolerance(norm, both.fold(f64::INFINITY, f64::min).min(f64::MAX))
    }
}
