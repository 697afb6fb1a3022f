//! Steps along a path, whose loads are scaled by a factor that follows from an interface.

use super::Stepper;
use crate::error::{Error, Result};
use crate::petsc::{SnesReason, SolveReport, Vector};
use crate::solve::problem::PlatenSystem;
use crate::solve::problem::path::PathControl;

/// The load factor with which the onset of damage is looked for.
const SMALL_FACTOR: f64 = 1e-6;
/// So far below the onset a path starts.
const BELOW: f64 = 1.0 - 1e-11;
/// As close to it as that.
const CLOSE: f64 = 1e-12;
/// Loads are scaled at most so often.
const MOST_SCALINGS: usize = 3;

impl Stepper<'_> {
    /// A step of path following. From rest it starts where the first point is about to give way, to
    /// which all loads are scaled: everything is proportional up to there. Collective.
    pub(super) fn solve_path(&mut self, target: f64) -> Result<SolveReport> {
        self.start_on_path(target)?;
        let interfaces = &self.problem.interfaces;
        let is_changed = interfaces.committed != interfaces.initial;
        // Lips that have slid against friction do not slide back where loads are scaled down.
        let is_changed = is_changed || interfaces.have_slid(&self.problem.all);
        let mut corrections = [0; 2];
        if !self.problem.comm.any(is_changed) {
            let small = self.load_to(SMALL_FACTOR)?;
            let share = self.share_of_strength();
            if !small.reason.is_converged() || share == 0.0 {
                let words =
                    "no interface is pulled or sheared by the loads: nothing ever gives way";
                self.problem.convergence.failure.get_or_insert_with(|| words.into());
                return Ok(SolveReport { reason: SnesReason::Stopped, ..small });
            }
            let onset = self.scale_to_onset(small, share)?;
            if self.problem.path.as_ref().is_some_and(PathControl::asks_for_onset) {
                return Ok(onset);
            }
            corrections = [onset.iterations, onset.linear_iterations];
        }
        self.hold_factor(None)?;
        self.problem.predict_freely();
        self.problem.interfaces.overstress =
            self.problem.path.as_ref().map_or(1.0, PathControl::overstress);
        let mut report = self.solve()?;
        report.iterations += corrections[0];
        report.linear_iterations += corrections[1];
        Ok(report)
    }

    /// Takes a state on the path of the opposite loads for none.
    pub(super) fn without_turned(&mut self, mut report: SolveReport) -> SolveReport {
        let turned = self.problem.path.as_ref().and_then(PathControl::turned);
        if let Some(words) = turned.filter(|_| report.reason.is_converged()) {
            self.problem.convergence.failure.get_or_insert(words);
            report.reason = SnesReason::Stopped;
        }
        report
    }

    /// Sets the loads and prescribed displacements at factor 1 of a step to `target`. Collective.
    fn start_on_path(&mut self, target: f64) -> Result<()> {
        let Some(mut path) = self.problem.path.take() else {
            return Err(Error::Bug("a step of a path without one".into()));
        };
        path.start(target);
        // A step that failed early may have left it.
        self.problem.interfaces.overstress = 1.0;
        let load_time = path.load_time(target);
        let mut unit = self.x.duplicate()?;
        std::mem::swap(&mut unit, &mut self.x);
        let written = self.write_displacements(load_time, 1.0);
        std::mem::swap(&mut unit, &mut self.x);
        self.problem.comm.agree(written)?;
        path.unit_displacement = self.prescribed_part(&unit)?;
        self.problem.path = Some(path);
        self.problem.set_load(load_time)
    }

    /// Scales the state of `small` loads, which take up a `share` of the strength, to the one in
    /// which the first point is about to give way; with all corrections in the report. Collective.
    fn scale_to_onset(&mut self, small: SolveReport, share: f64) -> Result<SolveReport> {
        let (mut factor, mut scale) = (SMALL_FACTOR, BELOW / share);
        let mut onset = small;
        // Beside the forces of accepted states those of the small load are known to few digits.
        for _ in 0..MOST_SCALINGS {
            self.x.write()?.iter_mut().for_each(|x| *x *= scale);
            factor *= scale;
            let report = self.load_to(factor)?;
            onset = SolveReport {
                iterations: onset.iterations + report.iterations,
                linear_iterations: onset.linear_iterations + report.linear_iterations,
                ..report
            };
            scale = BELOW / self.share_of_strength();
            if (scale - 1.0).abs() <= CLOSE || !onset.reason.is_converged() {
                break;
            }
        }
        Ok(onset)
    }

    /// The largest traction over the strength of its interface. Collective.
    fn share_of_strength(&self) -> f64 {
        let problem = &self.problem;
        problem.interfaces.share_of_strength(problem.comm, &problem.all)
    }

    /// The time that a converged step to `target` has reached: the step that is to break an
    /// interface may leave some of it. Collective.
    pub(super) fn reached(&self, target: f64) -> Result<f64> {
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
        self.problem.predict();
        self.solve()
    }

    /// Holds the load factor, or lets it follow, and writes the prescribed displacements.
    fn hold_factor(&mut self, factor: Option<f64>) -> Result<()> {
        let now = self.platens_before(&self.x.read()?).0[0].clone();
        let Some(path) = &mut self.problem.path else { return Ok(()) };
        path.hold(factor);
        let mut x = self.x.write()?;
        self.problem.all.for_prescribed(|node, component| {
            let i = node * self.problem.all.dim + component;
            x[i] = path.factor * path.unit_displacement[i];
            Ok(())
        })?;
        if let Some(PlatenSystem { platens, .. }) = &self.problem.platens {
            platens.add_free(&mut x, &now);
        }
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
}
