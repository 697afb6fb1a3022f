//! From instant to instant, in one step where possible.

mod advance;
mod along_path;
mod bifurcation;
mod branching;
mod descent;
mod doubts;
mod growth;
mod lifted;
mod persist;
mod ramp;
mod rounding;
mod sliding;
mod start;
mod step_size;
mod step_state;
mod words;

pub use bifurcation::Bifurcation;
pub use ramp::Carried;
pub use step_state::{FluidState, MOST_COUNTED, StepState};

use std::time::Duration;

use super::problem::{PlatenSystem, Problem};
use super::stability::Instability;
use crate::assembly::PoreSpace;
use crate::case::{Case, Stability};
use crate::error::Result;
use crate::petsc::{Snes, SolveReport, Vector};
use crate::signals;
use crate::solve::flow::coupled::{CoupledSystem, Coupling};
use crate::solve::problem::energy::{Energy, Work};
use crate::solve::problem::saddle::{SaddlePoint, SaddleSystem};
use crate::space::Supports;
use ramp::Ramp;
use step_size::StepSize;

/// A step is halved at most this often.
const MOST_HALVINGS: u32 = 10;

/// What it took to reach an instant.
#[derive(Debug, Clone, Copy, Default)]
pub struct Accepted {
    /// Linearised corrections, those of steps that failed included.
    pub newton_iterations: usize,
    /// Iterations of the linear solver.
    pub linear_iterations: usize,
    /// Steps that were accepted on the way, 1 if none was cut.
    pub steps: usize,
    /// Energies at the instant.
    pub energy: Energy,
    /// 2-norm of the out-of-balance forces at the instant (N).
    pub residual_norm: f64,
}

/// Advances a problem in time.
pub struct Stepper<'a> {
    /// The problem, at the last state it evaluated.
    pub problem: Problem<'a>,
    /// The nonlinear solver.
    pub snes: Snes,
    pub(super) case: &'a Case,
    /// Set in the saddle-point form.
    saddle: Option<SaddlePoint>,
    /// Set where the pore pressure is computed.
    pub coupling: Option<Coupling>,
    /// The unknowns, the displacements first.
    pub(super) x: Vector,
    supports: Supports,
    breakpoints: Vec<f64>,
    /// The accepted states that are not stable.
    pub instabilities: Vec<Instability>,
    /// The accepted states that were reached from one that is not stable.
    pub bifurcations: Vec<Bifurcation>,
    /// What else is to be said of accepted states.
    pub remarks: Vec<String>,
    /// Stages of the case before this one.
    pub stage: usize,
    /// What this one has from them.
    pub(super) carried: Option<Carried>,
    /// Where what jumps at the start has to grow.
    ramp: Option<Ramp>,
    /// Forces of the pressures at the start, per local node, not summed (N).
    initial_pore_force: Vec<f64>,
    /// Whether smaller steps are tried where states are unstable.
    pub(super) tries_smaller_steps: bool,
    /// Whether the running step was cut for an unstable state.
    is_cutting: bool,
    /// Error of the step that was judged last, over `time.tolerance`; 0 without one.
    excess: f64,
    /// The steps to go on with after a pause before the instant.
    paused: Option<StepSize>,
    /// Whether conjugate gradients have met an indefinite tangent.
    is_indefinite: bool,
    pub(super) work: Work,
    pub(super) time: f64,
    /// Length of the steps to begin with, where earlier ones had to be cut.
    pub(super) step: f64,
    pub(super) energy: Energy,
    /// What it took since the last instant.
    pub(super) since_instant: Accepted,
    /// Whether the equilibrium at the start has been found.
    pub(super) has_begun: bool,
    /// What an earlier run left behind.
    pub earlier: StepState,
    /// How long the longest accepted step took.
    longest: Duration,
}

impl<'a> Stepper<'a> {
    /// At rest at the start of the case.
    pub fn new(
        case: &'a Case,
        problem: Problem<'a>,
        snes: Snes,
        saddle: Option<SaddlePoint>,
        coupling: Option<Coupling>,
        x: Vector,
        supports: Supports,
    ) -> Self {
        let work = Work::new(problem.all.nodes.owned * problem.all.dim);
        let (time, energy) = (case.start, Energy::default());
        let breakpoints = case.breakpoints();
        let (instabilities, bifurcations) = (Vec::new(), Vec::new());
        let tries_smaller_steps =
            matches!(case.solver.stability, Stability::Auto | Stability::Follow);
        let mut stepper = Self {
            problem,
            snes,
            case,
            saddle,
            coupling,
            x,
            supports,
            breakpoints,
            instabilities,
            bifurcations,
            remarks: Vec::new(),
            stage: 0,
            carried: None,
            ramp: None,
            initial_pore_force: Vec::new(),
            tries_smaller_steps,
            is_cutting: false,
            excess: 0.0,
            paused: None,
            is_indefinite: false,
            work,
            time,
            step: f64::INFINITY,
            energy,
            since_instant: Accepted::default(),
            has_begun: false,
            earlier: StepState::default(),
            longest: Duration::ZERO,
        };
        stepper.initial_pore_force = stepper.pore_force_of(&stepper.coupling);
        stepper
    }

    /// Ends the run at the last accepted state when a signal asks for it, or when another step of
    /// the length `ahead` would pass the wall-clock limit. Collective.
    fn stop_if_asked(&self, ahead: Duration) -> Result<()> {
        match signals::stop(self.problem.comm, ahead) {
            Some(reason) => Err(signals::stopped(reason)),
            None => Ok(()),
        }
    }

    /// The porous cells and the pressures of all local nodes of theirs (Pa), computed or known.
    /// Local.
    pub fn pores(&self) -> Option<(&PoreSpace, &[f64])> {
        let computed = self.coupling.as_ref().map(|c| (&*c.flow.space, &c.flow.pressure[..]));
        let known = self.problem.known_pressure.as_ref();
        computed.or(known.map(|known| (&known.space, &known.pressure[..])))
    }

    fn try_step(&mut self, target: f64) -> Result<SolveReport> {
        let report = if self.problem.path.is_some() {
            self.solve_path(target)?
        } else {
            self.set_load(target, self.part_at(target))?;
            if let Some(coupling) = &mut self.coupling {
                coupling.flow.start_step(self.problem.comm, self.time, target)?;
            }
            let written = self.write_displacements(target, self.part_at(target));
            self.problem.comm.agree(written)?;
            let written = self.write_pressures(target);
            self.problem.comm.agree(written)?;
            self.problem.predict();
            self.solve()?
        };
        let report = self.persist(report)?;
        Ok(self.without_turned(report))
    }

    fn solve(&mut self) -> Result<SolveReport> {
        self.problem.convergence.start();
        let problem = &mut self.problem;
        if let Some(coupling) = &mut self.coupling {
            return self.snes.solve(&mut CoupledSystem { problem, coupling }, &mut self.x);
        }
        let Some(form) = &mut self.saddle else { return self.snes.solve(problem, &mut self.x) };
        form.start(problem, &mut self.x)?;
        self.snes.solve(&mut SaddleSystem { problem, form }, &mut self.x)
    }

    /// Writes the prescribed displacements at `time`, with `part` of what jumps at the start.
    fn write_displacements(&mut self, time: f64, part: f64) -> Result<()> {
        let start = self.case.start;
        let platens = self.problem.platens.as_ref().map(|of| &of.platens);
        let (of_platens, carried) = self.platens_before(&self.x.read()?);
        let mut x = self.x.write()?;
        self.problem.all.for_prescribed(|node, component| {
            let nodes = &self.problem.all.nodes;
            let unknown = node * self.problem.all.dim + component;
            if carried.binary_search(&unknown).is_ok() {
                return Ok(());
            }
            // What is prescribed counts from where results do.
            let origin = self.problem.origin.get(unknown).copied().unwrap_or(0.0);
            let at = |time| -> Result<f64> {
                Ok(origin + self.supports.value(nodes, node, component, time)?)
            };
            let before = self.carried.as_ref().map_or(0.0, |carried| carried.start[unknown]);
            x[unknown] = match part {
                1.0 => at(time)?,
                _ => at(time)? - (1.0 - part) * (at(start)? - before),
            };
            Ok(())
        })?;
        if let (Some(platens), [now, before]) = (platens, &of_platens) {
            platens.write(&mut x, now, (before, start), (time, part));
        }
        Ok(())
    }

    /// The motions of the platens in the displacements `x` and at the start of the stage, and the
    /// unknowns that are theirs alone, rising. Collective.
    fn platens_before(&self, x: &[f64]) -> ([Vec<f64>; 2], Vec<usize>) {
        let Some(PlatenSystem { platens, .. }) = &self.problem.platens else {
            return Default::default();
        };
        let (comm, origin) = (self.problem.comm, &self.problem.origin);
        let at = |of: &[f64], i: usize| of.get(i).copied().unwrap_or(0.0);
        let start = self.carried.as_ref().map_or(&[][..], |carried| &carried.start);
        let now = platens.motions(comm, |i| x[i] - at(origin, i));
        let before = platens.motions(comm, |i| at(start, i));
        ([now, before], platens.carried().collect())
    }

    fn write_pressures(&mut self, time: f64) -> Result<()> {
        let Some(Coupling { flow, .. }) = &self.coupling else { return Ok(()) };
        let displacements = self.problem.all.nodes.owned * self.problem.all.dim;
        flow.write_prescribed(time, &mut self.x.write()?[displacements..])
    }

    /// Takes a state that was found elsewhere for the accepted one at `time`: `displacement` of
    /// owned nodes, with the history and energy of the interfaces before it in place. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub fn adopt(&mut self, time: f64, displacement: &[f64], accepted: &Accepted) -> Result<()> {
        self.x.write()?[..displacement.len()].copy_from_slice(displacement);
        self.problem.set_load(time)?;
        self.problem.residual_norm = self.problem.out_of_balance(displacement)?;
        self.accept(time);
        self.work.total = accepted.energy.external;
        self.energy = accepted.energy;
        Ok(())
    }

    fn accept(&mut self, time: f64) {
        self.time = time;
        if let Some(path) = &mut self.problem.path {
            path.accept();
        }
        self.problem.convergence.accept();
        self.problem.interfaces.commit(&self.problem.all);
        if let Some(Coupling { flow, .. }) = &mut self.coupling {
            flow.accept(self.problem.comm, &self.problem.all, &self.problem.displacement);
        }
        self.energy = self.work.accept(&self.problem);
        self.problem.pulse.accept();
    }
}
