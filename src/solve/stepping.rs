//! From instant to instant, in one step where possible.

use super::energy::{Energy, Work};
use super::path::PathControl;
use super::problem::Problem;
use super::saddle::{SaddlePoint, SaddleSystem};
use crate::case::Case;
use crate::error::{Error, Result};
use crate::petsc::{Snes, SnesReason, SolveReport, Vector};
use crate::space::Prescribed;

/// A step is halved at most this often.
const MOST_HALVINGS: u32 = 10;

/// The load factor with which the onset of damage is looked for.
const SMALL_FACTOR: f64 = 1e-6;
/// So far below the onset a path starts.
const BELOW: f64 = 1.0 - 1e-11;

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
    case: &'a Case,
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
    /// At rest at the start of the case.
    pub fn new(
        case: &'a Case,
        problem: Problem<'a>,
        snes: Snes,
        saddle: Option<SaddlePoint>,
        x: Vector,
        prescribed: Prescribed,
    ) -> Self {
        let work = Work::new(problem.all.nodes.owned * problem.all.dim);
        let (time, energy) = (case.start, Energy::default());
        Self { problem, snes, case, saddle, x, prescribed, work, time, energy }
    }

    /// Solves for the state at `instant`. A step that fails is halved; the instant itself is
    /// always reached exactly. Collective.
    ///
    /// # Errors
    /// `Numerics` when the smallest step fails, with the reason and the place, and when a rupture
    /// leaves a body free; `Input` when a
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
                self.refuse_freed_bodies(target)?;
                self.accept(self.reached(target)?);
                total.steps += 1;
                step *= 2.0;
                continue;
            }
            let why = self.reason(&report);
            self.x.copy_from(&before)?;
            if step <= smallest {
                return Err(Error::Numerics(format!(
                    "no solution at time {target}, reached from {} with the smallest step {step:e} \
                     (after {MOST_HALVINGS} halvings): {why}{}",
                    self.time,
                    self.advice()
                )));
            }
            tracing::info!("  step from {} to {target} failed: {why}; halved", self.time);
            step = 0.5 * (target - self.time);
        }
        total.energy = self.energy;
        total.residual_norm = self.problem.residual_norm;
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
        let mut report = if self.problem.path.is_some() {
            self.solve_path(target)?
        } else {
            self.problem.set_load(target)?;
            let written = self.write_prescribed(target);
            self.problem.comm.agree(written)?;
            self.solve()?
        };
        if self.snes.try_more_work_space(&report)? {
            let why = self.reason(&report);
            tracing::info!("  {why}: MUMPS gets more work space");
            let (corrections, linear) = (report.iterations, report.linear_iterations);
            report = self.solve()?;
            report.iterations += corrections;
            report.linear_iterations += linear;
        }
        if self.snes.try_indefinite(&report)? {
            let why = self.reason(&report);
            tracing::info!("  {why}: GMRES takes the place of conjugate gradients");
            // Newton's method goes on from the last state: its corrections are not lost.
            let (corrections, linear) = (report.iterations, report.linear_iterations);
            report = self.solve()?;
            report.iterations += corrections;
            report.linear_iterations += linear;
        }
        Ok(report)
    }

    fn solve(&mut self) -> Result<SolveReport> {
        self.problem.convergence.start();
        let problem = &mut self.problem;
        let Some(form) = &mut self.saddle else { return self.snes.solve(problem, &mut self.x) };
        form.start(problem, &mut self.x)?;
        self.snes.solve(&mut SaddleSystem { problem, form }, &mut self.x)
    }

    fn write_prescribed(&mut self, time: f64) -> Result<()> {
        let mut x = self.x.write()?;
        self.problem.all.for_prescribed(|node, component| {
            let name = self.problem.all.nodes.names[node];
            let entry = self.prescribed.entries_of(name)[component];
            let value = |entry| self.prescribed.value(entry, component, name, time);
            x[node * self.problem.all.dim + component] = entry.map_or(Ok(0.0), value)?;
            Ok(())
        })
    }

    /// A step of path following. From rest it starts where the first point is about to give way, to
    /// which all loads are scaled: everything is linear up to there. Collective.
    fn solve_path(&mut self, target: f64) -> Result<SolveReport> {
        let Some(mut path) = self.problem.path.take() else {
            return Err(Error::Bug("a step of a path without one".into()));
        };
        path.start(target);
        let load_time = path.load_time(target);
        let mut unit = self.x.duplicate()?;
        std::mem::swap(&mut unit, &mut self.x);
        let written = self.write_prescribed(load_time);
        std::mem::swap(&mut unit, &mut self.x);
        self.problem.comm.agree(written)?;
        path.unit_displacement = self.prescribed_part(&unit)?;
        self.problem.path = Some(path);
        self.problem.set_load(load_time)?;
        let undamaged = self.problem.interfaces.committed.iter().all(|kappa| *kappa == 0.0);
        let mut corrections = [0; 2];
        if !self.problem.comm.any(!undamaged) {
            let report = self.load_to(SMALL_FACTOR)?;
            corrections = [report.iterations, report.linear_iterations];
            let share = self.problem.share_of_strength();
            if !report.reason.is_converged() || share == 0.0 {
                let words =
                    "no interface is pulled or sheared by the loads: nothing ever gives way";
                self.problem.convergence.failure.get_or_insert_with(|| words.into());
                return Ok(SolveReport { reason: SnesReason::Stopped, ..report });
            }
            let scale = BELOW / share;
            self.x.write()?.iter_mut().for_each(|x| *x *= scale);
            let onset = self.load_to(SMALL_FACTOR * scale)?;
            corrections[0] += onset.iterations;
            corrections[1] += onset.linear_iterations;
            if self.problem.path.as_ref().is_some_and(PathControl::asks_for_onset) {
                return Ok(SolveReport {
                    iterations: corrections[0],
                    linear_iterations: corrections[1],
                    ..onset
                });
            }
        }
        self.hold_factor(None)?;
        self.problem.interfaces.lean = self.problem.path.as_ref().map_or(1.0, PathControl::lean);
        let mut report = self.solve()?;
        report.iterations += corrections[0];
        report.linear_iterations += corrections[1];
        Ok(report)
    }

    /// The time that a converged step to `target` has reached: the step that is to break an interface
    /// may leave some of it. Collective.
    fn reached(&self, target: f64) -> Result<f64> {
        let Some(path) = self.problem.path.as_ref().filter(|path| path.breaks()) else {
            return Ok(target);
        };
        let problem = &self.problem;
        let value = path.value(problem.comm, &problem.all, &problem.interfaces);
        if value > 1.0 - 1e-12 {
            return Ok(target);
        }
        if value <= self.time + 1e-12 {
            return Err(Error::Numerics(format!(
                "the dissipated part of the energy grows no more at {value}: what is left of the \
                 interface is not pulled any more"
            )));
        }
        Ok(value)
    }

    /// Solves at a given load factor. Collective.
    fn load_to(&mut self, factor: f64) -> Result<SolveReport> {
        self.hold_factor(Some(factor))?;
        self.solve()
    }

    /// Holds the load factor, or lets it follow, and writes the prescribed displacements.
    fn hold_factor(&mut self, factor: Option<f64>) -> Result<()> {
        let Some(path) = &mut self.problem.path else { return Ok(()) };
        path.hold(factor);
        let mut x = self.x.write()?;
        self.problem.all.for_prescribed(|node, component| {
            let i = node * self.problem.all.dim + component;
            x[i] = path.factor * path.unit_displacement[i];
            Ok(())
        })?;
        drop(x);
        self.problem.scale_load();
        Ok(())
    }

    /// The entries of a vector at prescribed components, 0 elsewhere.
    fn prescribed_part(&self, of: &Vector) -> Result<Vec<f64>> {
        let all = &self.problem.all;
        let values = of.read()?;
        let mut part = vec![0.0; values.len()];
        all.for_prescribed(|node, component| {
            let i = node * all.dim + component;
            part[i] = values[i];
            Ok(())
        })?;
        Ok(part)
    }

    /// What all loads are scaled by at the last accepted state.
    pub fn load_factor(&self) -> f64 {
        self.problem.path.as_ref().map_or(1.0, |path| path.factor)
    }

    fn accept(&mut self, time: f64) {
        self.time = time;
        if let Some(path) = &mut self.problem.path {
            path.accept();
        }
        self.problem.convergence.accept(self.problem.comm);
        self.problem.interfaces.commit();
        self.energy = self.work.accept(&self.problem);
    }

    /// What may lie behind a step that fails however small it is. Collective.
    fn advice(&self) -> String {
        let gave_way = self.problem.convergence.interfaces_that_gave_way(self.problem.comm);
        let names: Vec<&str> = self
            .case
            .interfaces
            .iter()
            .zip(&gave_way)
            .filter(|(_, gave_way)| **gave_way)
            .map(|(interface, _)| interface.name.as_str())
            .collect();
        if names.is_empty() {
            return String::new();
        }
        let holds: Vec<bool> = gave_way.iter().map(|gave_way| !gave_way).collect();
        let free = self.case.free_motions(&holds);
        let first = names[0];
        let names = names.join(" and ");
        if free.is_empty() {
            return format!(
                "\ninterface {names} gives way over its whole area in this step: if the column \
                 gives back more energy than the interface takes (snap-back), no step is small \
                 enough, but control: {{opening: {{of: {first}, equals: ...}}}} follows it; otherwise a \
                 larger augmentation may help"
            );
        }
        format!(
            "\ninterface {names} ruptures: all of it softens or is broken, and without it {}",
            free.join("; ")
        )
    }

    /// Ends the run when the interfaces that broke leave a body to itself.
    fn refuse_freed_bodies(&self, time: f64) -> Result<()> {
        let problem = &self.problem;
        let mut holds = vec![0.0; self.case.interfaces.len()];
        let mut nodes = vec![0.0; holds.len()];
        for (rows, response) in problem.all.secondary.iter().zip(&problem.interfaces.response) {
            if rows.has_multiplier() {
                nodes[rows.interface] = 1.0;
                if !response.branch.is_separated() {
                    holds[rows.interface] = 1.0;
                }
            }
        }
        problem.comm.max(&mut holds);
        problem.comm.max(&mut nodes);
        let holds: Vec<bool> =
            holds.iter().zip(&nodes).map(|(h, n)| *h > 0.0 || *n == 0.0).collect();
        if holds.iter().all(|holds| *holds) {
            return Ok(());
        }
        let free = self.case.free_motions(&holds);
        if free.is_empty() {
            return Ok(());
        }
        let broken = self.case.interfaces.iter().zip(&holds).filter(|(_, holds)| !**holds);
        let names: Vec<&str> = broken.map(|(interface, _)| interface.name.as_str()).collect();
        Err(Error::Numerics(format!(
            "at time {time} interface {} has ruptured over its whole area: {}",
            names.join(" and "),
            free.join("; ")
        )))
    }

    /// Why a solve failed, in words. Collective.
    fn reason(&self, report: &SolveReport) -> String {
        let words = match (&self.problem.convergence.failure, &report.failing_linear) {
            (Some(words), _) => words.clone(),
            (None, Some(linear)) => format!("the linear solver failed: {}", linear.words),
            (None, None) => report.reason.to_string(),
        };
        // L D L^T goes through an indefinite tangent without a word; its pivots tell.
        let place = self.softening_place();
        if report.negative_pivots == 0 {
            return words;
        }
        let negative = report.negative_pivots;
        let place = place.map_or_else(String::new, |place| format!("; {place} softened"));
        format!("{words}; the tangent was indefinite ({negative} negative pivots){place}")
    }

    /// Interface and place of the lowest node that softened in the last solve. Collective.
    fn softening_place(&self) -> Option<String> {
        let mine = self.problem.convergence.softening;
        // The maximum of the complements is the minimum.
        let lowest =
            u64::MAX - self.problem.comm.max_u64(u64::MAX - mine.map_or(u64::MAX, |m| m.0));
        if lowest == u64::MAX {
            return None;
        }
        let interface = mine.filter(|m| m.0 == lowest).map_or(0, |m| m.1);
        let interface = self.problem.comm.max_u64(interface) as usize;
        let at = self.problem.convergence.at(lowest);
        Some(format!("interface {} {at}", self.case.interfaces[interface].name))
    }
}
