//! From instant to instant, in one step where possible.

use super::energy::{Energy, Work};
use super::problem::Problem;
use super::saddle::{SaddlePoint, SaddleSystem};
use crate::error::{Error, Result};
use crate::petsc::{Snes, SolveReport, Vector};
use crate::space::Prescribed;

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
}

/// Advances a problem in time.
pub struct Stepper<'a> {
    /// The problem, at the last state it evaluated.
    pub problem: Problem<'a>,
    /// The nonlinear solver.
    pub snes: Snes,
    /// Set in the saddle-point form.
    saddle: Option<SaddlePoint>,
    /// The unknowns, the displacements first.
    x: Vector,
    prescribed: Prescribed,
    work: Work,
    time: f64,
    energy: Energy,
}

impl<'a> Stepper<'a> {
    /// At rest at `start`.
    pub fn new(
        problem: Problem<'a>,
        snes: Snes,
        saddle: Option<SaddlePoint>,
        x: Vector,
        prescribed: Prescribed,
        start: f64,
    ) -> Self {
        let work = Work::new(problem.all.nodes.owned * problem.all.dim);
        Self { problem, snes, saddle, x, prescribed, work, time: start, energy: Energy::default() }
    }

    /// Solves for the state at `instant`. A step that fails is halved; the instant itself is
    /// always reached exactly. Collective.
    ///
    /// # Errors
    /// `Numerics` when the smallest step fails, with the reason and the place; `Input` when a
    /// formula gives no finite number.
    pub fn advance(&mut self, instant: f64) -> Result<Accepted> {
        let smallest = (instant - self.time) / f64::from(1 << MOST_HALVINGS);
        let mut step = instant - self.time;
        let mut total = Accepted::default();
        while self.time < instant {
            // Halving is exact, so the last step ends at the instant to the last bit.
            let target = if instant - self.time <= 1.5 * step { instant } else { self.time + step };
            let mut before = self.x.duplicate()?;
            before.copy_from(&self.x)?;
            let report = self.try_step(target)?;
            total.newton_iterations += report.iterations;
            total.linear_iterations += report.linear_iterations;
            if report.reason.is_converged() {
                self.accept(target);
                total.steps += 1;
                step *= 2.0;
                continue;
            }
            let why = self.reason(&report);
            self.x.copy_from(&before)?;
            if step <= smallest {
                return Err(Error::Numerics(format!(
                    "no solution at time {target}, reached from {} with the smallest step {step:e}: \
                     {why}",
                    self.time
                )));
            }
            tracing::info!("  step from {} to {target} failed: {why}; halved", self.time);
            step = 0.5 * (target - self.time);
        }
        total.energy = self.energy;
        Ok(total)
    }

    /// Force of the support on the body at each owned node with prescribed components, by the
    /// surface that prescribes them (N; 0 at other components). Local.
    pub fn reactions(&self) -> Vec<(&'static str, [f64; 3])> {
        let (all, dim) = (&self.problem.all, self.problem.all.dim);
        let mut list = Vec::new();
        for node in (0..all.nodes.owned).filter(|n| all.prescribed[*n] != [false; 3]) {
            let entries = self.prescribed.entries_of(all.nodes.names[node]);
            for (c, entry) in entries.iter().enumerate().take(dim) {
                if let Some(entry) = entry {
                    let mut force = [0.0; 3];
                    force[c] = self.problem.balance[node * dim + c];
                    list.push((self.prescribed.surface(*entry), force));
                }
            }
        }
        list
    }

    fn try_step(&mut self, target: f64) -> Result<SolveReport> {
        self.problem.set_load(target)?;
        let written = self.write_prescribed(target);
        self.problem.comm.agree(written)?;
        self.problem.convergence.start();
        let problem = &mut self.problem;
        let Some(form) = &mut self.saddle else { return self.snes.solve(problem, &mut self.x) };
        form.start(problem, &mut self.x)?;
        self.snes.solve(&mut SaddleSystem { problem, form }, &mut self.x)
    }

    fn write_prescribed(&mut self, time: f64) -> Result<()> {
        let all = &self.problem.all;
        let mut x = self.x.write()?;
        for node in 0..all.nodes.owned {
            if all.prescribed[node] == [false; 3] {
                continue;
            }
            let name = all.nodes.names[node];
            for (component, entry) in self.prescribed.entries_of(name).into_iter().enumerate() {
                if let Some(entry) = entry {
                    x[node * all.dim + component] =
                        self.prescribed.value(entry, component, name, time)?;
                }
            }
        }
        Ok(())
    }

    fn accept(&mut self, time: f64) {
        self.time = time;
        self.problem.convergence.accept(self.problem.comm);
        self.problem.interfaces.commit();
        self.energy = self.work.accept(&self.problem);
    }

    /// Why a solve failed, in words.
    fn reason(&self, report: &SolveReport) -> String {
        if let Some(words) = &self.problem.convergence.failure {
            return words.clone();
        }
        match &report.failing_linear {
            Some(linear) => format!("the linear solver failed: {}", linear.words),
            None => report.reason.to_string(),
        }
    }
}
