//! Displacement and pore pressure together, as PETSc's SNES sees them.
//!
//! Unknowns are the displacements of all nodes, then the scaled pressures; see
//! [`crate::solve::flow::blocks`] for the linear systems.

use std::rc::Rc;

use super::Flow;
use super::blocks::{Blocks, Operator};
use crate::bulk::{FlowStep, PoroState};
use crate::error::Result;
use crate::petsc::{
    FurtherSolve, LinearOperator, LinearTolerance, Matrix, NonlinearSystem, Ran, TangentChange,
    Trial, Verdict,
};
use crate::solve::guess::residual_projection::ResidualProjection;
use crate::solve::problem::platen_columns::Linearised;
use crate::solve::problem::{Problem, condensed};
use crate::timers::Phase;

/// How many times smaller than that of forces the error of the fluid's balance has to be: errors of
/// all steps add up in the accounts. Below what rounding may leave it cannot be.
const STRICTER: f64 = 100.0;

/// Part by which one correction may change the density of a fluid that flows along an interface.
/// Between lips that still hold nothing bounds the pressure but what the rock stores.
const MOST_DENSER: f64 = 0.1;

/// Residual of a linear solve over that of the state it starts from. The tangent is that of pores
/// at rest, so that a correction leaves about as much as the pores have changed, whatever its
/// digits: what is left of the residual is left to the next correction, and Newton's test alone
/// says when to stop.
const REDUCTION: f64 = 1e-5;

/// What the coupled model has beside the mechanical problem.
pub struct Coupling {
    /// Pressure and balance.
    pub flow: Flow,
    blocks: Rc<Blocks>,
    /// The step with which the flow was assembled.
    assembled: Option<FlowStep>,
    /// The last corrections of both fields.
    projection: ResidualProjection,
    /// What is missing in the balance of the fluid at the last state, and how much of that rounding
    /// may be, over its scale.
    pub(in crate::solve) missing: [f64; 2],
}

impl Coupling {
    /// Nothing is assembled yet.
    pub fn new(flow: Flow, blocks: Rc<Blocks>) -> Self {
        Self {
            flow,
            blocks,
            assembled: None,
            projection: ResidualProjection::default(),
            missing: [0.0; 2],
        }
    }

    /// The solvers of the preconditioner's blocks. Local.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn ran(&self) -> Result<Vec<Ran>> {
        self.blocks.ran()
    }

    /// Whether the pressures stay as they are, and the mechanical problem alone is solved. Local.
    pub fn hold_pressures(&self, holds: bool) {
        self.blocks.holds.set(holds);
    }
}

/// A problem with its pore pressure.
pub(in crate::solve) struct CoupledSystem<'s, 'a> {
    pub(in crate::solve) problem: &'s mut Problem<'a>,
    pub(in crate::solve) coupling: &'s mut Coupling,
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
            *missing = [0.0; 2];
            return Ok(());
        }
        let (u, known) = (&problem.displacement, &problem.known_jumps);
        *missing = flow.residual(problem.comm, &all, u, known, fp);
        Ok(())
    }

    fn tangent(&mut self, x: &[f64], matrix: &mut Matrix) -> Result<TangentChange> {
        let (problem, coupling) = (&mut *self.problem, &mut *self.coupling);
        let mut change = coupling.blocks.set_mechanics(problem, x)?;
        let step = coupling.flow.step;
        if coupling.blocks.holds.get() {
            coupling.projection.forget_products();
            if change != TangentChange::Unchanged {
                matrix.assemble()?;
            }
            return Ok(change);
        }
        let mut serves = coupling.assembled.is_some_and(|assembled| assembled.serves(&step));
        let films = &coupling.flow.space.films;
        if films.are_there() {
            let (displacement, pressure) = (&problem.displacement, &coupling.flow.pressure);
            let state = PoroState { displacement, pressure };
            let linearised = films.linearise(&problem.all, state, &step);
            serves &= !problem.comm.any(linearised != *coupling.blocks.films.borrow());
            coupling.blocks.films.replace(linearised);
        }
        if !serves {
            let _phase = problem.timers.enter(Phase::Assembly);
            coupling.blocks.set_flow(problem.comm, &step)?;
            coupling.assembled = Some(step);
            change = TangentChange::Changed;
        }
        if change != TangentChange::Unchanged {
            matrix.assemble()?;
        }
        if change != TangentChange::Unchanged {
            coupling.projection.forget_products();
            problem.forget_columns();
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
        solve: &mut FurtherSolve<'_>,
    ) -> Result<()> {
        let (problem, Coupling { blocks, projection, .. }) =
            (&mut *self.problem, &mut *self.coupling);
        problem.interfaces.overstress = 1.0;
        problem.correct();
        let (u, p) = correction.split_at_mut(blocks.split);
        problem.set_known(u);
        blocks.for_identity_rows(|node| p[node] = 0.0);
        problem.is_skew = problem.add_unsymmetric(correction, problem.judged_norm, solve)?;
        let mut free = condensed::free_components(&problem.all, &problem.interfaces);
        free.resize(correction.len(), true);
        blocks.for_identity_rows(|node| free[blocks.split + node] = false);
        let product = |of: &Problem<'_>, x: &[f64]| blocks.forces_of(of, x);
        let at = Linearised::new(&free, &product);
        problem.move_platens(correction, &at, solve)?;
        let u = &mut correction[..blocks.split];
        condensed::follow(&problem.all, &problem.interfaces, u);
        if !blocks.has_pressures {
            problem.keep(u);
        } else if blocks.is_coupled() && blocks.is_split() {
            projection.keep(correction);
        }
        let mut part = problem.convergence.part_of_step();
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
        let Coupling { blocks, projection, .. } = &mut *self.coupling;
        let (gu, gp) = guess.split_at_mut(blocks.split);
        let (ru, rp) = rhs.split_at(blocks.split);
        blocks.for_identity_rows(|node| gp[node] = rp[node] / blocks.diagonal);
        if !blocks.has_pressures {
            return self.problem.initial_guess(ru, gu);
        }
        let problem = &*self.problem;
        let free = condensed::free_components(&problem.all, &problem.interfaces);
        for ((guess, rhs), _) in gu.iter_mut().zip(ru).zip(&free).filter(|(_, free)| !**free) {
            *guess = rhs / blocks.diagonal;
        }
        if blocks.is_coupled() && blocks.is_split() {
            let operator = Operator(Rc::clone(blocks));
            let mut left = rhs.to_vec();
            let (lu, lp) = left.split_at_mut(blocks.split);
            let fixed = lu.iter_mut().zip(&free).filter(|(_, free)| !**free);
            fixed.for_each(|(left, _)| *left = 0.0);
            blocks.for_identity_rows(|node| lp[node] = 0.0);
            let unknowns = |x: &mut [f64]| {
                let (u, p) = x.split_at_mut(blocks.split);
                condensed::to_unknowns(&problem.all, &problem.interfaces, u);
                blocks.for_identity_rows(|node| p[node] = 0.0);
            };
            let multiply = |x: &[f64], y: &mut [f64]| operator.multiply(x, y);
            projection.add_best(problem.comm, unknowns, multiply, &left, guess);
        }
        Ok(())
    }

    fn has_trials(&self) -> bool {
        !self.coupling.blocks.has_pressures
    }

    fn trial(&mut self, correction: &[f64], norm: f64) -> Result<Trial> {
        self.problem.trial(&correction[..self.coupling.blocks.split], norm)
    }

    fn heed(&mut self) -> Result<()> {
        self.problem.pulse.iteration(self.problem.comm)
    }

    fn verdict(&mut self, iteration: usize, _x: &[f64], f: &[f64], norm: f64) -> Result<Verdict> {
        self.problem.pulse.correction(self.problem.comm, iteration)?;
        let split = self.coupling.blocks.split;
        let [missing, rounding] = self.coupling.missing;
        let stricter = if missing <= rounding { 1.0 } else { STRICTER };
        self.problem.judge(iteration, &f[..split], norm, stricter * missing)
    }

    fn linear_tolerance(&mut self, _iteration: usize, norm: f64) -> LinearTolerance {
        let problem = &*self.problem;
        let current = problem.convergence.current().force;
        let force = current.max(problem.convergence.accepted_force());
        let fluid = self.coupling.flow.force_scale() / STRICTER;
        let both = [force, fluid].into_iter().filter(|scale| *scale > 0.0);
        let scale = both.fold(f64::INFINITY, f64::min).min(f64::MAX);
        let tolerance = problem.linear.tolerance(norm, problem.areas.least() * scale);
        if self.coupling.blocks.is_coupled() {
            return LinearTolerance { relative: REDUCTION, ..tolerance };
        }
        tolerance
    }
}
