//! Loads that are there from the start, reached by steps.
//!
//! At the start of a case nothing acts yet; a value that is not zero then jumps within the first
//! step, however short. So does what a stage changes. Where that step fails, all that jumps grows
//! in proportion to time from the start to the end of the step that was tried.

use super::ramp::{Carried, Ramp};
use super::{Coupling, Stepper};
use crate::error::Result;
use crate::solve::problem::PlatenSystem;

impl Stepper<'_> {
    /// The part of the loads that jump at the start which acts at `time`.
    pub(in crate::solve) fn part_at(&self, time: f64) -> f64 {
        let start = self.case.start;
        let part = |ramp: &Ramp| ((time - start) / (ramp.end - start)).min(1.0);
        self.ramp.as_ref().map_or(1.0, part)
    }

    /// The end of the growth of what jumps at the start, where it is not over. Local.
    pub(in crate::solve) fn grows_until(&self) -> Option<f64> {
        self.ramp.as_ref().map(|ramp| ramp.end).filter(|end| self.time < *end)
    }

    /// Lets the loads that jump at the start grow until `end`. Collective.
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number.
    pub(in crate::solve) fn grow_until(&mut self, end: f64) -> Result<()> {
        self.platens_jump(self.carried.is_none())?;
        if let Some(Carried { jump, .. }) = &self.carried {
            self.ramp = Some(Ramp { end, jump: jump.clone() });
            return Ok(());
        }
        self.problem.set_load(self.case.start)?;
        let mut jump = self.problem.load.clone();
        let initial = match &self.problem.known_pressure {
            Some(_) => &self.problem.pore_force,
            None => &self.initial_pore_force,
        };
        jump.iter_mut().zip(initial).for_each(|(jump, force)| *jump += force);
        self.ramp = Some(Ramp { end, jump });
        Ok(())
    }

    /// Sets the loads of `time`, with `part` of what jumps at the start. Collective.
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number.
    pub(in crate::solve) fn set_load(&mut self, time: f64, part: f64) -> Result<()> {
        self.problem.set_load(time)?;
        let Some(ramp) = self.ramp.as_ref().filter(|_| part < 1.0) else { return Ok(()) };
        let load = self.problem.load.iter_mut();
        load.zip(&ramp.jump).for_each(|(load, jump)| *load -= (1.0 - part) * jump);
        if let Some(PlatenSystem { platens, .. }) = &mut self.problem.platens {
            let load = platens.load.iter_mut().zip(&platens.jump);
            load.for_each(|(load, jump)| *load -= (1.0 - part) * jump);
        }
        Ok(())
    }

    /// Takes note of the loads of platens that jump at the start: all of them at that of the case.
    /// Those of a later stage are known since it began. Collective.
    fn platens_jump(&mut self, is_first: bool) -> Result<()> {
        if is_first && let Some(PlatenSystem { platens, .. }) = &mut self.problem.platens {
            let set = platens.set_load(self.case.start);
            platens.jump.clone_from(&platens.load);
            self.problem.comm.agree(set)?;
        }
        Ok(())
    }

    /// As above at the start of a later stage: what the platens are to carry beyond the forces that
    /// the state there has on them. Collective.
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number.
    pub(in crate::solve) fn platens_jump_from_here(&mut self) -> Result<()> {
        let Some(system) = &mut self.problem.platens else { return Ok(()) };
        let before = system.reactions().to_vec();
        let platens = &mut system.platens;
        let set = platens.set_load(self.case.start);
        let pairs = platens.load.iter().zip(&platens.free);
        platens.jump = pairs.map(|(load, k)| load - before[*k]).collect();
        self.problem.comm.agree(set)
    }

    /// Sets the loads of an accepted state. At the start of a later stage they are those before the
    /// jump. Collective.
    ///
    /// # Errors
    /// `Input` when a formula gives no finite number.
    pub(in crate::solve) fn set_accepted_load(&mut self) -> Result<()> {
        let path = self.problem.path.as_ref();
        let time = path.map_or(self.time, |path| path.load_time(self.time));
        self.set_load(time, self.part_at(time))?;
        let starts = self.time == self.case.start;
        if let Some(Carried { jump, .. }) = self.carried.as_ref().filter(|_| starts) {
            self.problem.load.iter_mut().zip(jump).for_each(|(load, jump)| *load -= jump);
        }
        Ok(())
    }

    /// Forces of the pressures that are there at the start, per local node, not summed (N); empty
    /// where none is computed. Local.
    pub(super) fn pore_force_of(&self, coupling: &Option<Coupling>) -> Vec<f64> {
        let Some(Coupling { flow, .. }) = coupling else { return Vec::new() };
        let all = &self.problem.all;
        let mut force = vec![0.0; all.nodes.len() * all.dim];
        flow.add_forces(all, &mut force);
        force
    }
}
