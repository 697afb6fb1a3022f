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
//! the skeleton under a pressure lie between the two. With `solver.linear: mumps` the whole matrix is
//! eliminated instead.

use std::cell::RefCell;
use std::rc::Rc;

use super::condensed;
use super::flow::Flow;
use super::problem::Problem;
use super::whole::Whole;
use crate::assembly::{NodeState, PoreSpace, TangentOperator, WholeValues};
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

/// A block of the preconditioner: a solver that is only asked for its preconditioner.
pub struct Block {
    pub(super) solver: Snes,
    from: Vector,
    to: Vector,
}

impl Block {
    pub(super) fn new(petsc: &Petsc, solver: Snes) -> Result<Self> {
        let (rows, width) = (solver.matrix().owned_rows(), solver.matrix().block_size());
        let (from, to) = (Vector::new(petsc, rows, width)?, Vector::new(petsc, rows, width)?);
        Ok(Self { solver, from, to })
    }

    /// z = the preconditioner times r; not numbers where PETSc fails, which ends the linear solve.
    pub(super) fn apply(&mut self, r: &[f64], z: &mut [f64]) {
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

/// What preconditions the pressure beside the mechanical block.
pub enum Beside {
    /// The second block of a triangular preconditioner.
    Flow(RefCell<Block>),
    /// Factors of both fields, in place of the two blocks.
    Whole(RefCell<Whole>),
}

/// The linear operator of both fields, with the parts of its preconditioner.
pub struct Blocks {
    mechanics: RefCell<Block>,
    beside: Beside,
    tangent: Rc<TangentOperator>,
    pores: Rc<PoreSpace>,
    /// C of each prototype.
    compressibility: RefCell<Vec<Vec<f64>>>,
    /// Pressure over its unknown (Pa/m).
    scale: f64,
    /// Entry of identity rows (N/m).
    diagonal: f64,
    /// Owned displacement components.
    split: usize,
    /// Whether any pressure is to be found.
    is_coupled: bool,
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
        (mechanics, beside): (Snes, Beside),
        tangent: Rc<TangentOperator>,
        pores: Rc<PoreSpace>,
        scale: f64,
    ) -> Result<Self> {
        let diagonal = tangent.identity_entry();
        let split = mechanics.matrix().owned_rows();
        let is_coupled = pores.has_unknowns(comm);
        Ok(Self {
            mechanics: RefCell::new(Block::new(petsc, mechanics)?),
            beside,
            tangent,
            pores,
            compressibility: RefCell::default(),
            scale,
            diagonal,
            split,
            is_coupled,
        })
    }

    /// Whether any pressure is to be found.
    pub fn is_coupled(&self) -> bool {
        self.is_coupled
    }

    /// Sets up the tangent of the mechanical problem at the state that it evaluated last. Collective.
    fn set_mechanics(&self, problem: &mut Problem<'_>, x: &[f64]) -> Result<TangentChange> {
        let block = &mut *self.mechanics.borrow_mut();
        let change = problem.tangent(&x[..self.split], block.solver.matrix_mut())?;
        if change != TangentChange::Unchanged {
            self.tangent.set_state(problem.assembled_state());
            if matches!(self.beside, Beside::Flow(_)) {
                block.solver.set_up(change)?;
            }
        }
        Ok(change)
    }

    /// Assembles the flow of a step. Collective.
    fn set_flow(&self, comm: &Comm, step: &FlowStep) -> Result<()> {
        let like = self.pores.prototypes.iter().map(|cell| cell.compressibility(step));
        *self.compressibility.borrow_mut() = like.collect();
        let Beside::Flow(flow) = &self.beside else { return Ok(()) };
        let with_yielding = |cell: &PorousCell| -> Vec<f64> {
            let parts = cell.compressibility(step).into_iter().zip(cell.yielding());
            parts.map(|(c, y)| c + y).collect()
        };
        let block = &mut *flow.borrow_mut();
        let (square, matrix) = (self.scale * self.scale, block.solver.matrix_mut());
        self.pores.assemble(comm, with_yielding, (square, self.diagonal), matrix)?;
        block.solver.set_up(TangentChange::Changed)?;
        Ok(())
    }

    /// Eliminates both fields, where that is asked for; `state` is that of the tangent. Collective.
    fn set_whole(&self, comm: &Comm, state: &[NodeState]) -> Result<()> {
        let Beside::Whole(whole) = &self.beside else { return Ok(()) };
        let values = WholeValues {
            state,
            compressibility: &self.compressibility.borrow(),
            scale: self.scale,
            diagonal: self.diagonal,
        };
        let spaces = (&**self.tangent.discretization(), &*self.pores);
        let mechanics = self.mechanics.borrow();
        whole.borrow_mut().set_up(comm, spaces, mechanics.solver.matrix(), &values)
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

/// The operator of the linear systems.
struct Operator(Rc<Blocks>);

impl LinearOperator for Operator {
    fn multiply(&self, x: &[f64], y: &mut [f64]) {
        let Self(blocks) = self;
        let ((xu, xp), (yu, yp)) = (x.split_at(blocks.split), y.split_at_mut(blocks.split));
        if blocks.is_coupled {
            let p = blocks.pressures(xp);
            let mut rows = vec![0.0; p.len()];
            let minus: Vec<f64> = p.iter().map(|p| -p).collect();
            let all = blocks.tangent.discretization();
            // Within the product, which has the displacements of all local nodes and sums the forces.
            blocks.tangent.multiply_beside(xu, yu, |u, force| {
                blocks.pores.add_forces(all, &minus, false, force);
                blocks.pores.add_volumes(all, u, &mut rows);
            });
            blocks.pores.add_product(&blocks.compressibility.borrow(), &p, &mut rows);
            blocks.pores.fold(&mut rows);
            yp.iter_mut().zip(&rows).for_each(|(y, row)| *y = -blocks.scale * row);
        } else {
            blocks.tangent.multiply(xu, yu);
        }
        blocks.pores.for_identity_rows(|node| yp[node] = blocks.diagonal * xp[node]);
    }
}

/// The preconditioner.
struct Preconditioner(Rc<Blocks>);

impl LinearOperator for Preconditioner {
    fn multiply(&self, r: &[f64], z: &mut [f64]) {
        let Self(blocks) = self;
        let flow = match &blocks.beside {
            Beside::Whole(whole) => return whole.borrow_mut().apply(r, z),
            Beside::Flow(flow) => flow,
        };
        let ((ru, rp), (zu, zp)) = (r.split_at(blocks.split), z.split_at_mut(blocks.split));
        if !blocks.is_coupled {
            blocks.mechanics.borrow_mut().apply(ru, zu);
            zp.iter_mut().zip(rp).for_each(|(z, r)| *z = r / blocks.diagonal);
            return;
        }
        flow.borrow_mut().apply(rp, zp);
        zp.iter_mut().for_each(|z| *z = -*z);
        blocks.pores.for_identity_rows(|node| zp[node] = rp[node] / blocks.diagonal);
        let mut force = ru.to_vec();
        blocks.add_forces(&blocks.pressures(zp), &mut force);
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
        let state = (&problem.displacement[..], &problem.known_jumps[..]);
        *missing = flow.residual(problem.comm, &all, state, fp);
        Ok(())
    }

    fn tangent(&mut self, x: &[f64], matrix: &mut Matrix) -> Result<TangentChange> {
        let (problem, coupling) = (&mut *self.problem, &mut *self.coupling);
        let mut change = coupling.blocks.set_mechanics(problem, x)?;
        let step = coupling.flow.step;
        if !coupling.assembled.is_some_and(|assembled| assembled.serves(&step)) {
            let _phase = problem.timers.enter(Phase::Assembly);
            coupling.blocks.set_flow(problem.comm, &step)?;
            coupling.assembled = Some(step);
            change = TangentChange::Changed;
        }
        if change != TangentChange::Unchanged {
            matrix.assemble()?;
        }
        if change == TangentChange::Changed {
            coupling.blocks.set_whole(problem.comm, problem.assembled_state())?;
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
        let part = problem.convergence.part_of_step;
        correction.iter_mut().for_each(|c| *c *= part);
        Ok(())
    }

    fn initial_guess(&mut self, rhs: &[f64], guess: &mut [f64]) -> Result<()> {
        let blocks = &self.coupling.blocks;
        let (gu, gp) = guess.split_at_mut(blocks.split);
        let (ru, rp) = rhs.split_at(blocks.split);
        blocks.pores.for_identity_rows(|node| gp[node] = rp[node] / blocks.diagonal);
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
