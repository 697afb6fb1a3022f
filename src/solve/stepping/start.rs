//! The state at the start, where it is not the undeformed one.

use std::time::Duration;

use super::doubts::Doubt;
use super::step_size::StepSize;
use super::words::in_words;
use super::{Accepted, Coupling, MOST_HALVINGS, Stepper};
use crate::error::{Error, Result};
use crate::law::Branch;
use crate::solve::problem::Energy;

/// What damage at the start has dissipated is known up to this part of it.
const ROUNDING: f64 = 1e-12;

impl Stepper<'_> {
    /// Whether the case asks for equilibrium at the start. Local.
    pub(in crate::solve) fn starts_in_equilibrium(&self) -> bool {
        self.case.starts_in_equilibrium()
    }

    /// Finds the equilibrium of stresses that are there at the start, from which displacements
    /// count; none without such stresses, or where that is done. Collective.
    ///
    /// # Errors
    /// As [`Stepper::advance`].
    pub fn begin(&mut self) -> Result<Option<Accepted>> {
        if self.case.initial_stress.is_none() || self.has_begun {
            return Ok(None);
        }
        let mut total = std::mem::take(&mut self.since_instant);
        if let Err(error) = self.begin_in_equilibrium(&mut total) {
            self.since_instant = total;
            return Err(error);
        }
        (total.energy, total.residual_norm) = (self.energy, self.problem.residual_norm);
        Ok(Some(total))
    }

    /// Makes the displacements at the start those in equilibrium with the initial stresses and
    /// pressures, which stay as they are, the loads and the prescribed displacements; where there
    /// are initial stresses, supports hold where they are. Stress and energy are those of loads and
    /// pressures that grow together from nothing; the fluid that is stored counts from here.
    /// Collective.
    ///
    /// # Errors
    /// `Numerics` when there is no equilibrium or it leaves a body free; `Input` when a formula
    /// gives no finite number or the stresses lie above a strength; `Stopped` on a signal: the
    /// state is then the undeformed one.
    pub(super) fn begin_in_equilibrium(&mut self, total: &mut Accepted) -> Result<()> {
        let mut before = self.x.duplicate()?;
        before.copy_from(&self.x)?;
        let (history, work) = (self.problem.interfaces.history(), self.work.clone());
        self.refuse_stress_above_strength()?;
        self.grow_until(self.time)?;
        self.hold_pressures(true);
        let begun = self.load_from_rest(total).and_then(|()| self.count_from_here());
        self.hold_pressures(false);
        self.ramp = None;
        if begun.is_err() {
            self.x.copy_from(&before)?;
            self.problem.interfaces.go_back_to(history);
            self.work = work;
            return begun;
        }
        let problem = &self.problem;
        if let Some(Coupling { flow, .. }) = &mut self.coupling {
            flow.begin(problem.comm, &problem.all, &problem.displacement);
        }
        self.has_begun = true;
        tracing::debug!("  in equilibrium with {}", self.at_start());
        Ok(())
    }

    /// What is given at the start, in words.
    fn at_start(&self) -> &'static str {
        match self.case.initial_stress {
            Some(_) => "the stresses at the start (initial.stress)",
            None => "the initial pressures (initial.equilibrium)",
        }
    }

    /// Lets all that acts at the start grow from nothing, at once where that converges. Collective.
    fn load_from_rest(&mut self, total: &mut Accepted) -> Result<()> {
        let (start, smallest) = (self.time, 0.5_f64.powi(MOST_HALVINGS as i32));
        let (mut reached, mut step) = (0.0_f64, 1.0);
        while reached < 1.0 {
            self.stop_if_asked(Duration::ZERO)?;
            let target = (reached + step).min(1.0);
            let mut before = self.x.duplicate()?;
            before.copy_from(&self.x)?;
            self.set_load(start, target)?;
            // Displacements that count from a state under stress are those after it.
            let moved = if self.case.initial_stress.is_some() { 0.0 } else { target };
            let written = self.write_displacements(start, moved);
            self.problem.comm.agree(written)?;
            self.problem.predict();
            let report = self.solve_from_here()?;
            total.count(&report);
            let converged = report.reason.is_converged();
            let mut doubt = if converged { self.doubt(start) } else { None };
            let size = StepSize { step, smallest };
            let is_cut = |doubt: &Option<Doubt>| {
                doubt.as_ref().is_some_and(|doubt| doubt.is_worth(size, false))
            };
            if converged && !is_cut(&doubt) {
                doubt = self.without_pressed_lips(doubt, total)?;
            }
            if converged && !is_cut(&doubt) {
                if let Some(doubt) = doubt.take() {
                    self.bear(doubt)?;
                }
                let problem = &mut self.problem;
                problem.convergence.accept();
                problem.interfaces.commit(&problem.all);
                self.energy = self.work.accept(&self.problem);
                (reached, step) = (target, 2.0 * step);
                continue;
            }
            let why = doubt.map_or_else(|| self.reason(&report), |doubt| doubt.words);
            self.x.copy_from(&before)?;
            self.stop_if_asked(Duration::ZERO)?;
            if step <= smallest {
                return Err(Error::Numerics(format!(
                    "no equilibrium with {} at time {start} beyond {reached} of all that acts: \
                     {why}{}",
                    self.at_start(),
                    self.advice()
                )));
            }
            tracing::info!("  {target} of what acts at the start failed: {why}; halved");
            step = 0.5 * (target - reached);
        }
        Ok(())
    }

    /// Lets displacements, jumps, slip and energies count from the state that was accepted last,
    /// where it is that of stresses at the start. Collective.
    fn count_from_here(&mut self) -> Result<()> {
        if self.case.initial_stress.is_none() {
            return Ok(());
        }
        let (all, state) = (&self.problem.all, &self.problem.interfaces);
        self.refuse_softened(|index| {
            let has_grown = state.committed[index] > state.initial[index];
            let before = state.dissipated_before(all, index);
            has_grown && state.dissipated[index] > (1.0 + ROUNDING) * before
        })?;
        self.tell_of_lips();
        let problem = &mut self.problem;
        problem.origin.clone_from(&problem.displacement);
        problem.interfaces.count_from(&problem.all, &problem.origin);
        problem.interfaces.forget_slip();
        self.work.count_from_here(self.energy.elastic);
        self.energy = Energy::default();
        Ok(())
    }

    /// Refuses stresses at the start that lie above the strength of an interface: its law would
    /// soften under their traction. Collective.
    fn refuse_stress_above_strength(&mut self) -> Result<()> {
        if self.case.initial_stress.is_none() {
            return Ok(());
        }
        self.set_load(self.time, 1.0)?;
        if self.coupling.is_some() {
            self.problem.pore_force.clone_from(&self.initial_pore_force);
        }
        let at_rest = vec![0.0; self.work.displacement.len()];
        self.problem.out_of_balance(&at_rest)?;
        let (all, state) = (&self.problem.all, &self.problem.interfaces);
        self.refuse_softened(|index| {
            let law = state.law_at(index, &all.secondary[index]);
            let dissipated = law.dissipated(state.response[index].history);
            dissipated > (1.0 + ROUNDING) * state.dissipated_before(all, index)
        })
    }

    /// Refuses a state at the start in which a point of an interface `has_softened`. Collective.
    fn refuse_softened(&self, has_softened: impl Fn(usize) -> bool) -> Result<()> {
        let (all, count) = (&self.problem.all, self.problem.interfaces.response.len());
        let softened = (0..count).filter(|index| has_softened(*index));
        let Some(place) = self.place_of(softened.map(|i| all.name_and_interface(i)).min()) else {
            return Ok(());
        };
        Err(Error::Input(format!(
            "initial.stress: the stress across {place} lies above the strength there, so that it \
             softens at the start; lower the stress, or raise the strength"
        )))
    }

    /// Remarks that lips have opened or slid on the way to the state at the start. Collective.
    fn tell_of_lips(&mut self) {
        let problem = &self.problem;
        let mut seen = vec![[0.0; 2]; self.case.interfaces.len()];
        for (index, response) in problem.interfaces.response.iter().enumerate() {
            let [opens, slides] = &mut seen[problem.all.secondary[index].interface];
            let is_open = matches!(response.branch, Branch::Open | Branch::Broken);
            *opens += f64::from(u8::from(is_open && problem.interfaces.gaps[index] == 0.0));
            *slides += f64::from(u8::from(problem.interfaces.sliding[index].path > 0.0));
        }
        problem.comm.sum(seen.as_flattened_mut());
        for (kind, does) in ["opens", "slides with friction"].into_iter().enumerate() {
            let names = self.case.interfaces.iter().zip(&seen).filter(|(_, seen)| seen[kind] > 0.0);
            let names: Vec<&str> = names.map(|(interface, _)| interface.name.as_str()).collect();
            if !names.is_empty() {
                let words = format!(
                    "initial.stress is not in equilibrium with the loads: where it is brought to it \
                     {} {does} at some points",
                    in_words(&names)
                );
                tracing::warn!("warning: {words}");
                self.remarks.push(words);
            }
        }
    }

    fn hold_pressures(&mut self, holds: bool) {
        if let Some(coupling) = &self.coupling {
            coupling.hold_pressures(holds);
            self.problem.forget_columns();
        }
    }
}
