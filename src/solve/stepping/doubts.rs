//! Converged states that speak of a step that was too long.

use super::step_size::StepSize;
use super::{Accepted, Stepper};
use crate::error::Result;
use crate::solve::problem::energy::potential;

/// Jumps above this part of the jump scale of the law are no rounding.
const OPEN: f64 = 1e-6;

/// Open lips pressed by more than this part of the strength speak of a step that turns too far. (A
/// law of two modes presses them by the order of the step.)
const PRESSED: f64 = 1e-2;
/// Pressed by less than this part of it they are not.
const ROUNDING: f64 = 1e-6;
const PRESSED_LIPS: &str = "is open and pressed at the same time";
const TOO_LONG: &str = "more than time.tolerance";
/// A state is let go on at the same loads at most so often.
const MOST_REPEATS: usize = 50;

/// A state that has more energy than it can have by this part of it was not reached.
const EXCESS: f64 = 1e-3;

/// What speaks against a converged state.
pub(super) struct Doubt {
    /// In words.
    pub words: String,
    /// Of what kind.
    kind: Kind,
}

/// Kinds of doubts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// A run cannot go on from the state.
    Final,
    /// It is probably a wrong one.
    Wrong,
    /// Lips are open and pressed.
    Lips,
    /// The step has a larger error than asked for.
    Length,
}

/// Displacements of more than so many times the size of the mesh are those of a mechanism.
const ASTRAY: f64 = 1e7;

/// Steps are cut for doubts that are not final down to so many of the smallest ones.
const WORTH: f64 = 64.0;

impl Doubt {
    /// Whether a step of such a size is worth cutting; `is_last` where none of its parts were
    /// solved.
    pub(super) fn is_worth(&self, size: StepSize, is_last: bool) -> bool {
        let StepSize { step, smallest } = size;
        match self.kind {
            Kind::Final => step > smallest,
            Kind::Length => !is_last && step > smallest,
            Kind::Wrong | Kind::Lips => !is_last && step > WORTH * smallest,
        }
    }

    /// Whether a run can go on from it, so that parts of the step that fail may be left out.
    pub(super) fn can_be_borne(&self) -> bool {
        self.kind != Kind::Final
    }
}

impl Stepper<'_> {
    /// What speaks against the converged state at `time`, if anything. Collective.
    pub(super) fn doubt(&mut self, time: f64) -> Option<Doubt> {
        self.excess = 0.0;
        if let Some(words) = self.freed_bodies(time) {
            return Some(Doubt { words, kind: Kind::Final });
        }
        if let Some(words) = self.astray(time) {
            return Some(Doubt { words, kind: Kind::Final });
        }
        let from = self.time;
        if let Some(words) = self.excess_of_energy(time) {
            return Some(Doubt { words, kind: Kind::Wrong });
        }
        let problem = &self.problem;
        let is_missed = problem.path.is_none()
            && problem.onset.is_missed(problem.comm, &problem.all, &problem.interfaces);
        if is_missed {
            let place = self.place_of(problem.onset.lowest(&problem.all))?;
            let words = format!(
                "the step from {from} to {time} is too long: on its way the first to give way is \
                 {place}, which is no more damaged at its end than before"
            );
            return Some(Doubt { words, kind: Kind::Wrong });
        }
        if let Some(place) = self.place_of(self.pressed_opening(PRESSED)) {
            let words = format!(
                "the step from {from} to {time} is too long for the law of the interface: {place} \
                 {PRESSED_LIPS}"
            );
            return Some(Doubt { words, kind: Kind::Lips });
        }
        let (excess, words) = self.error_of_step(time)?;
        self.excess = excess;
        (excess > 1.0).then_some(Doubt { words, kind: Kind::Length })
    }

    /// The error of the step to `time` over `time.tolerance`, if there is one, and in words.
    /// Collective.
    fn error_of_step(&self, time: f64) -> Option<(f64, String)> {
        let (problem, tolerance) = (&self.problem, self.case.step_tolerance()?);
        let (all, state) = (&problem.all, &problem.interfaces);
        let (mut errors, mut worst) = ([0.0_f64], None);
        for index in 0..state.response.len() {
            let error = state.error_of_traction(all, index);
            if error > errors[0] {
                (errors[0], worst) = (error, Some(all.name_and_interface(index)));
            }
        }
        let own = errors[0];
        problem.comm.max(&mut errors);
        let of_traction = errors[0] / tolerance;
        // The work of a pressure that is computed has an error of its own.
        let of_work = if self.coupling.is_some() { 0.0 } else { self.error_of_work() / tolerance };
        if of_work > of_traction {
            let words = format!(
                "the step from {} to {time} is too long: on its way interfaces open, close, slide \
                 or give way, which puts the work of the loads off by {:.1e} of the energy, \
                 {TOO_LONG}",
                self.time,
                of_work * tolerance
            );
            return Some((of_work, words));
        }
        let place = self.place_of(worst.filter(|_| own == errors[0])).unwrap_or_default();
        let words = format!(
            "the step from {} to {time} is too long for the law of the interface: the error of its \
             traction at {place} is about {:.1e} of the strength, {TOO_LONG}",
            self.time, errors[0]
        );
        Some((of_traction, words))
    }

    /// By how much the work of the running step may be off, over the energy. Collective.
    fn error_of_work(&self) -> f64 {
        let problem = &self.problem;
        let (all, state) = (&problem.all, &problem.interfaces);
        let works = (0..state.response.len()).map(|index| state.error_of_work(all, index));
        let mut sum = [works.sum::<f64>()];
        problem.comm.sum(&mut sum);
        let now = self.work.energies(problem).iter().map(|energy| energy.abs()).sum::<f64>();
        let energy = now.max(self.energy.external.abs());
        if sum[0] > 0.0 { sum[0] / energy } else { 0.0 }
    }

    /// What still speaks against a converged state at `time`, of a step that is not cut for that:
    /// where lips are open and pressed the state goes on at the same loads, each time with the
    /// history that it has reached, until they are not. Collective.
    ///
    /// # Errors
    /// `System` when PETSc fails.
    pub(super) fn without_pressed_lips(
        &mut self,
        doubt: Option<Doubt>,
        total: &mut Accepted,
    ) -> Result<Option<Doubt>> {
        let place = self.place_of(self.pressed_opening(ROUNDING));
        let Some(place) = place.filter(|_| self.problem.path.is_none()) else { return Ok(doubt) };
        let (history, work) = (self.problem.interfaces.history(), self.work.clone());
        let energy = self.energy;
        for _ in 0..MOST_REPEATS {
            self.problem.interfaces.commit(&self.problem.all);
            self.energy = self.work.accept(&self.problem);
            let report = self.solve_from_here()?;
            total.count(&report);
            if !report.reason.is_converged() {
                break;
            }
            if self.place_of(self.pressed_opening(ROUNDING)).is_none() {
                return Ok(doubt);
            }
        }
        self.problem.interfaces.go_back_to(history);
        (self.work, self.energy) = (work, energy);
        let words = format!("{place} {PRESSED_LIPS}, and stays so at the same loads");
        Ok(Some(Doubt { words, kind: Kind::Final }))
    }

    /// That displacements are far larger than the mesh and than those prescribed, in words: what
    /// iterations make of a singular tangent, whose forces are then large enough to seem balanced.
    /// Collective.
    fn astray(&self, time: f64) -> Option<String> {
        let (all, dim) = (&self.problem.all, self.problem.all.dim);
        // Of prescribed displacements, and of the others.
        let mut most = [0.0_f64; 2];
        for node in 0..all.nodes.owned {
            for (c, u) in self.problem.displacement[node * dim..][..dim].iter().enumerate() {
                let kind = usize::from(!all.prescribed[node][c]);
                most[kind] = most[kind].max(u.abs());
            }
        }
        self.problem.comm.max(&mut most);
        let [prescribed, free] = most;
        let size = self.problem.mesh.size.iter().fold(0.0_f64, |size, x| size.max(*x));
        (free > ASTRAY * size.max(prescribed)).then(|| {
            format!(
                "at time {time} the displacements reach {free:.1e} m in a mesh of {size:.1e} m: nothing \
                 holds some part of it, or the units of loads and stiffness do not agree; look for \
                 parts that can turn or slide, and hold them"
            )
        })
    }

    /// That the converged state holds and has dissipated more energy than its loads can have given,
    /// in words. The loads are at their end when the laws have not answered yet: from there on
    /// energy only goes down on the way to a state that is reached. Collective.
    fn excess_of_energy(&self, time: f64) -> Option<String> {
        let problem = &self.problem;
        let most = problem.most_energy.filter(|_| problem.path.is_none())?;
        if self.coupling.is_some() {
            return None;
        }
        let found = potential(problem);
        // Energies that errors within the tolerance of forces make are none.
        let scales = problem.convergence.current();
        let nothing = self.case.solver.tolerance * scales.force * scales.displacement;
        (found - most > nothing + EXCESS * found.abs().max(most.abs())).then(|| {
            format!(
                "the step from {} to {time} is too long: the state at its end, with a potential \
                 energy of {found:.4e} J, has used more than the loads can have given, which is \
                 {most:.4e} J before anything gives way",
                self.time
            )
        })
    }

    /// Goes on from a state in spite of a doubt, with a warning (one in a run for pressed lips, and
    /// one for errors of steps), or ends the run.
    pub(super) fn bear(&mut self, doubt: Doubt) -> Result<()> {
        let once = match doubt.kind {
            Kind::Final => return Err(crate::error::Error::Numerics(doubt.words)),
            Kind::Wrong => None,
            Kind::Lips => Some(PRESSED_LIPS),
            Kind::Length => Some(TOO_LONG),
        };
        if once.is_some_and(|words| self.remarks.iter().any(|told| told.contains(words))) {
            tracing::debug!("  {}", doubt.words);
            return Ok(());
        }
        let words = format!("{}; take more instants before this time", doubt.words);
        tracing::warn!("warning: {words}");
        self.remarks.push(words);
        Ok(())
    }

    /// The lowest owned secondary node, by its name, whose lips are open and pressed by more than a
    /// `part` of the strength: its interface. Local.
    fn pressed_opening(&self, part: f64) -> Option<(u64, usize)> {
        let (all, state) = (&self.problem.all, &self.problem.interfaces);
        let is_pressed = |index: usize| {
            let response = &state.response[index];
            let law = state.laws[all.secondary[index].interface].spec.law();
            let (Some(scale), Some(strength)) = (law.typical_jump(), law.strength()) else {
                return false;
            };
            // As the law answers: what equilibrium and jump are off by presses nothing.
            let normal = all.dim - 1;
            let r = state.law_at(index, &all.secondary[index]).augmentation();
            let jump = response.jump[normal] - response.defect[normal];
            let traction = response.bulk_traction[normal] + r * response.defect[normal];
            jump > OPEN * scale && traction < -part * strength
        };
        let pressed = (0..state.response.len()).filter(|index| is_pressed(*index));
        pressed.map(|index| all.name_and_interface(index)).min()
    }

    /// Interface and place, in words, of the lowest of the nodes that ranks give by name and
    /// interface; none if no rank gives any. Collective.
    pub(super) fn place_of(&self, mine: Option<(u64, usize)>) -> Option<String> {
        let problem = &self.problem;
        // The maximum of the complements is the minimum.
        let lowest = u64::MAX - problem.comm.max_u64(u64::MAX - mine.map_or(u64::MAX, |m| m.0));
        if lowest == u64::MAX {
            return None;
        }
        let interface = mine.filter(|m| m.0 == lowest).map_or(0, |m| m.1 as u64);
        let interface = problem.comm.max_u64(interface) as usize;
        let at = problem.all.nodes.place_in_words(problem.comm, lowest);
        Some(format!("interface {} {at}", self.case.interfaces[interface].name))
    }
}
