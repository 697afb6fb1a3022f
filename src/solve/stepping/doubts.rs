//! Converged states that speak of a step that was too long.

use super::Stepper;
use super::step_size::StepSize;
use crate::error::Result;
use crate::solve::model::interfaces::to_local;
use crate::solve::problem::energy::potential;

/// Jumps above this part of the jump scale of the law are no rounding.
const OPEN: f64 = 1e-6;

/// Open lips pressed by more than this part of the strength speak of a step that turns too far. (A
/// law of two modes presses them by the order of the step.)
const PRESSED: f64 = 1e-2;
const PRESSED_LIPS: &str = "is open and pressed at the same time";

/// A state that has more energy than it can have by this part of it was not reached.
const EXCESS: f64 = 1e-3;

/// What speaks against a converged state.
pub(super) struct Doubt {
    /// In words.
    pub words: String,
    /// Whether a run cannot go on from it.
    pub is_final: bool,
    /// Whether it is of lips that are open and pressed, which goes on over many steps.
    is_of_lips: bool,
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
        if self.is_final { step > smallest } else { !is_last && step > WORTH * smallest }
    }
}

impl Stepper<'_> {
    /// What speaks against the converged state at `time`, if anything. Collective.
    pub(super) fn doubt(&self, time: f64) -> Option<Doubt> {
        if let Some(words) = self.freed_bodies(time) {
            return Some(Doubt { words, is_final: true, is_of_lips: false });
        }
        if let Some(words) = self.astray(time) {
            return Some(Doubt { words, is_final: true, is_of_lips: false });
        }
        let (problem, from) = (&self.problem, self.time);
        if let Some(words) = self.excess_of_energy(time) {
            return Some(Doubt { words, is_final: false, is_of_lips: false });
        }
        let is_missed = problem.path.is_none()
            && problem.onset.is_missed(problem.comm, &problem.all, &problem.interfaces);
        let words = if is_missed {
            let place = self.place_of(problem.onset.lowest(&problem.all))?;
            format!(
                "the step from {from} to {time} is too long: on its way the first to give way is \
                 {place}, which is no more damaged at its end than before"
            )
        } else {
            let pressed = self.pressed_opening();
            let place = self.place_of(pressed)?;
            format!(
                "the step from {from} to {time} is too long for the law of the interface: {place} \
                 {PRESSED_LIPS}"
            )
        };
        Some(Doubt { words, is_final: false, is_of_lips: !is_missed })
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

    /// Goes on from a state in spite of a doubt, with a warning (one in a run for pressed lips), or
    /// ends the run.
    pub(super) fn bear(&mut self, doubt: Doubt) -> Result<()> {
        if doubt.is_final {
            return Err(crate::error::Error::Numerics(doubt.words));
        }
        if doubt.is_of_lips && self.remarks.iter().any(|told| told.contains(PRESSED_LIPS)) {
            tracing::debug!("  {}", doubt.words);
            return Ok(());
        }
        let words = format!("{}; take more instants before this time", doubt.words);
        tracing::warn!("warning: {words}");
        self.remarks.push(words);
        Ok(())
    }

    /// The lowest owned secondary node, by its name, whose lips are open and pressed: its
    /// interface. Local.
    fn pressed_opening(&self) -> Option<(u64, usize)> {
        let (all, state) = (&self.problem.all, &self.problem.interfaces);
        let is_pressed = |index: usize| {
            let response = &state.response[index];
            let law = state.laws[all.secondary[index].interface].spec.law();
            let (Some(scale), Some(strength)) = (law.typical_jump(), law.strength()) else {
                return false;
            };
            let jump = to_local(response.jump, all.dim)[0];
            let traction = to_local(response.law_traction, all.dim)[0];
            jump > OPEN * scale && traction < -PRESSED * strength
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
