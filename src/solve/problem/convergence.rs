//! When a state is a solution, and why it is not.

use super::cycles::{Cycle, Cycles};
use super::measure::{Measure, Scales, Worst, is_rounding, rounding};
use crate::assembly::Discretization;
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::hash::mix;
use crate::law::Branch;
use crate::petsc::Verdict;
use crate::signals;
use crate::solve::model::interfaces::InterfaceState;
use std::time::Duration;

/// What is judged of a state beside the answers of the laws.
pub struct Iterate {
    /// Those that led to it in this solve.
    pub corrections: usize,
    /// 2-norm of the residual.
    pub norm: f64,
    /// Largest out-of-balance nodal force of this rank (N).
    pub worst: Worst,
    /// How far what the load factor follows from is from its value, or how much is missing in the
    /// balance of the fluid, over its scale.
    pub control: f64,
}

/// Convergence test: field by field, with scales that do not vanish when every force does.
pub struct Convergence {
    tolerance: f64,
    max_newton: usize,
    interface_names: Vec<String>,
    /// What has to hold beside forces and jumps, in words.
    pub other: &'static str,
    /// Largest nodal force scale (N) and displacement (m) of the accepted states.
    accepted: [f64; 2],
    /// Those of the last evaluated state.
    current: Scales,
    /// Largest force that cancels in the laws where gaps are open at the start (N).
    of_gaps: f64,
    /// The branches in the states of the running solve.
    cycles: Cycles,
    /// For each state of the running solve and each interface, whether a node of this rank holds.
    holds: Vec<f64>,
    /// Lowest node of this rank that softened in a state of the running solve, and its interface.
    pub softening: Option<(u64, u64)>,
    /// Why the last solve failed, in words; the same on all ranks.
    pub failure: Option<String>,
    /// Position of a node of this rank at which the last residual was not a number (m).
    broken: Option<[f64; 3]>,
}

impl Convergence {
    /// `tolerance` relative, `max_newton` corrections at most.
    pub fn new(tolerance: f64, max_newton: usize, interface_names: Vec<String>) -> Self {
        Self {
            tolerance,
            max_newton,
            interface_names,
            other: "",
            accepted: [0.0; 2],
            current: Scales::default(),
            of_gaps: 0.0,
            cycles: Cycles::new(),
            holds: Vec::new(),
            softening: None,
            failure: None,
            broken: None,
        }
    }

    /// Takes note of the gaps at the start: their augmented tractions cancel where nothing touches,
    /// but for rounding, also while nothing moves. Collective.
    pub fn see_gaps(&mut self, comm: &Comm, all: &Discretization, interfaces: &InterfaceState) {
        let mut largest = [0.0_f64];
        for (index, gap) in interfaces.gaps.iter().enumerate() {
            let rows = &all.secondary[index];
            let augmentation = interfaces.law_at(index, rows).augmentation();
            largest[0] = largest[0].max(rows.law_weight(all.dim) * augmentation * gap.abs());
        }
        comm.max(&mut largest);
        self.of_gaps = largest[0];
    }

    /// Takes note of the scales of a state, those of this rank's nodes. Collective.
    pub fn see_scales(&mut self, comm: &Comm, own: Scales) {
        let mut all = [own.force, own.displacement, own.cancelling.max(self.of_gaps)];
        comm.max(&mut all);
        let [force, displacement, cancelling] = all;
        self.current = Scales { force, displacement, cancelling };
    }

    /// Takes note of a residual that is not a number, which ends a solve before it is judged.
    /// Local.
    pub fn see_residual(&mut self, all: &Discretization, f: &[f64]) {
        let broken = f.iter().position(|force| !force.is_finite());
        self.broken = broken.map(|i| all.nodes.points[i / all.dim]);
    }

    /// Where the last residual was not a number, in words. Collective.
    pub fn broken_place(&self, comm: &Comm) -> Option<String> {
        let at = |[x, y, z]: [f64; 3]| Err(Error::Numerics(format!("at ({x}, {y}, {z}) m")));
        let first = comm.agree(self.broken.map_or(Ok(()), at));
        first.err().map(|place| place.to_string())
    }

    /// How much of a correction is taken: less from a cycle of the branches on, until they stay.
    pub fn part_of_step(&self) -> f64 {
        self.cycles.part_of_step()
    }

    /// The scales of the last evaluated state.
    pub fn current(&self) -> Scales {
        self.current
    }

    /// Goes back to the scales of an earlier state. Local.
    pub fn see_again(&mut self, scales: Scales) {
        self.current = scales;
    }

    /// Largest nodal force scale of the accepted states (N); 0 before the first.
    pub fn accepted_force(&self) -> f64 {
        self.accepted[0]
    }

    /// Largest nodal force scale (N) and displacement (m) of the accepted states.
    pub fn accepted_scales(&self) -> [f64; 2] {
        self.accepted
    }

    /// Takes the scales of the states that an earlier run accepted.
    pub fn resume(&mut self, accepted: [f64; 2]) {
        self.accepted = accepted;
    }

    /// Starts a step.
    pub fn start(&mut self) {
        self.cycles = Cycles::new();
        self.holds.clear();
        self.softening = None;
        self.failure = None;
    }

    /// Makes the scales of the last evaluated state those of an accepted one. Local.
    pub fn accept(&mut self) {
        let Scales { force, displacement, .. } = self.current;
        self.accepted = [self.accepted[0].max(force), self.accepted[1].max(displacement)];
    }

    /// Interfaces all of whose nodes gave way in some state of the last solve. Collective.
    pub fn interfaces_that_gave_way(&self, comm: &Comm) -> Vec<bool> {
        let mut holds = self.holds.clone();
        comm.max(&mut holds);
        let count = self.interface_names.len();
        (0..count).map(|i| holds.iter().skip(i).step_by(count).any(|h| *h == 0.0)).collect()
    }

    /// What errors over their scales may be.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// What forces of the last evaluated state are measured by (N).
    pub fn force_scale(&self) -> f64 {
        self.current.force.max(self.accepted[0])
    }

    /// What rounding may leave of the forces at a node in the last evaluated state (N).
    pub fn rounding(&self) -> f64 {
        rounding(self.current.cancelling)
    }

    /// How far the last evaluated state is from a solution, over the tolerance; not finite where it
    /// makes no sense. `worst` as in [`Iterate`], measured by `force_scale` (N). Collective.
    pub fn excess(
        &self,
        comm: &Comm,
        all: &Discretization,
        interfaces: &InterfaceState,
        (worst, force_scale): (Worst, f64),
    ) -> f64 {
        let m = self.measure(comm, all, interfaces, (worst, force_scale));
        m.out_of_balance.max(m.largest) / self.tolerance
    }

    /// The errors of the last evaluated state, field by field, over their scales, that of forces as
    /// given. Collective.
    fn measure(
        &self,
        comm: &Comm,
        all: &Discretization,
        interfaces: &InterfaceState,
        (worst, force_scale): (Worst, f64),
    ) -> Measure {
        let scales = self.current;
        let displacement_scale = scales.displacement.max(self.accepted[1]);
        let mut defect = vec![Worst::default(); interfaces.laws.len()];
        for (index, response) in interfaces.response.iter().enumerate() {
            let rows = &all.secondary[index];
            let law = interfaces.laws[rows.interface].spec.law();
            let scale = law.typical_jump().unwrap_or(displacement_scale);
            let square: f64 = response.defect.iter().map(|d| d * d).sum();
            let relative = if square.sqrt() <= rounding(interfaces.gaps[index].abs()) {
                0.0
            } else if scale == 0.0 && square.is_finite() {
                f64::MAX // nothing has moved yet, but something should
            } else {
                square.sqrt() / scale
            };
            defect[rows.interface].see(relative, all.nodes.names[rows.node as usize]);
        }
        let worst = worst.over_ranks(comm);
        let defect: Vec<Worst> = defect.into_iter().map(|d| d.over_ranks(comm)).collect();
        let is_rounding = is_rounding(worst.value, force_scale, scales.cancelling);
        let out_of_balance = if is_rounding { 0.0 } else { worst.value / force_scale };
        let largest = defect.iter().map(|d| d.value).fold(0.0, f64::max);
        Measure { worst, defect, out_of_balance, largest }
    }

    /// The verdict on the last evaluated state. Collective.
    pub fn judge(
        &mut self,
        comm: &Comm,
        all: &Discretization,
        interfaces: &InterfaceState,
        iterate: Iterate,
    ) -> Result<Verdict> {
        let branches = self.see_branches(all, interfaces);
        let Iterate { corrections, norm, worst, control } = iterate;
        let errors = self.measure(comm, all, interfaces, (worst, self.force_scale()));
        let Measure { out_of_balance, largest, .. } = errors;
        let broken = errors.not_a_number();
        if broken.is_some() || !norm.is_finite() {
            let node = broken.unwrap_or(errors.worst.node);
            let place = all.nodes.place_in_words(comm, node);
            self.failure = Some(format!("a force is not a number {place}"));
            return Ok(Verdict::Diverged);
        }
        tracing::debug!(
            target: "newton",
            "  correction {corrections:3}  out of balance {out_of_balance:9.3e}  jumps {largest:9.3e}  \
             other {control:9.3e}"
        );
        if out_of_balance.max(largest).max(control) <= self.tolerance {
            return Ok(Verdict::Converged);
        }
        if let Some(signal) = signals::stop(comm, Duration::ZERO) {
            self.failure = Some(format!("stopped by {signal}"));
            return Ok(Verdict::Diverged);
        }
        // On a path the load factor may cycle while the branches stay.
        let on_path = if control > 0.0 { (1e3 * control.ln()).round().to_bits() } else { 0 };
        match self.cycles.see(comm.sum_u64(branches) ^ mix(on_path)) {
            Cycle::Damped(period) => {
                let part = self.part_of_step();
                tracing::debug!(
                    target: "newton",
                    "  the branches cycle with period {period}: {part} of each correction until \
                     they stay"
                );
            }
            Cycle::Endless(period) => {
                self.failure = Some(format!(
                    "Newton's method cycles between {period} states of the interfaces \
                     ({corrections} corrections, out of balance {out_of_balance:.1e})"
                ));
                return Ok(Verdict::Diverged);
            }
            Cycle::None if corrections >= self.max_newton => {
                self.failure = Some(self.exhausted(comm, all, corrections, &errors, control));
                return Ok(Verdict::Diverged);
            }
            Cycle::None => {}
        }
        Ok(Verdict::Continue)
    }

    /// Takes note of the branches at this rank's nodes in the last evaluated state: which
    /// interfaces hold, and what softens. Returns their signature. Local.
    fn see_branches(&mut self, all: &Discretization, interfaces: &InterfaceState) -> u64 {
        let (mut signature, mut holds) = (0u64, vec![0.0; interfaces.laws.len()]);
        for (rows, response) in all.secondary.iter().zip(&interfaces.response) {
            let name = all.nodes.names[rows.node as usize];
            signature = signature.wrapping_add(mix(mix(name) ^ response.branch as u64));
            if matches!(response.branch, Branch::Softening | Branch::SofteningClosed) {
                let place = (name, rows.interface as u64);
                self.softening = Some(self.softening.map_or(place, |first| first.min(place)));
            }
            if !rows.has_multiplier() || !response.branch.gives_way() {
                holds[rows.interface] = 1.0;
            }
        }
        self.holds.extend(holds);
        signature
    }

    /// That the corrections are used up, in words. Collective.
    fn exhausted(
        &self,
        comm: &Comm,
        all: &Discretization,
        corrections: usize,
        errors: &Measure,
        control: f64,
    ) -> String {
        let Measure { worst, defect, out_of_balance, largest } = errors;
        let what = if control > out_of_balance.max(*largest) {
            format!("{} is off by {control:.1e}", self.other)
        } else {
            let (node, what) = self.worst_place(*worst, defect, *out_of_balance);
            format!("{what} {}", all.nodes.place_in_words(comm, node))
        };
        format!(
            "no convergence in {corrections} corrections (solver.max_newton): {what}; tolerance {:.1e}",
            self.tolerance
        )
    }

    /// The node of the largest contribution, and what that is, in words.
    fn worst_place(&self, worst: Worst, defect: &[Worst], force: f64) -> (u64, String) {
        let (index, jump) = defect
            .iter()
            .enumerate()
            .max_by(|a, b| a.1.value.total_cmp(&b.1.value))
            .map_or((0, Worst::default()), |(i, d)| (i, *d));
        if jump.value > force {
            let name = &self.interface_names[index];
            let what = format!("the jump of interface {name} is off by {:.1e}", jump.value);
            (jump.node, what)
        } else {
            (worst.node, format!("the largest out-of-balance force is {force:.1e}"))
        }
    }
}
