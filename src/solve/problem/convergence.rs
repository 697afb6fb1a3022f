//! When a state is a solution, and why it is not.

use crate::assembly::Discretization;
use crate::comm::Comm;
use crate::error::{Error, Result};
use crate::hash::mix;
use crate::law::Branch;
use crate::petsc::Verdict;
use crate::signals;
use crate::solve::model::interfaces::InterfaceState;
use std::time::Duration;

/// Longest period of a branch cycle that is recognised.
const LONGEST_CYCLE: usize = 4;

/// After so many cycles of the branches in one solve a smaller step is cheaper.
const MOST_CYCLES: i32 = 3;

/// The largest of some nodal values, and where it is.
#[derive(Debug, Clone, Copy, Default)]
pub struct Worst {
    value: f64,
    node: u64,
    not_a_number: bool,
}

impl Worst {
    /// Takes a value into account.
    pub fn see(&mut self, value: f64, node: u64) {
        if !value.is_finite() && !self.not_a_number {
            *self = Self { value: f64::INFINITY, node, not_a_number: true };
        } else if value > self.value {
            (self.value, self.node) = (value, node);
        }
    }

    /// The largest over all ranks (the lowest rank's if several are equal). Collective.
    fn over_ranks(self, comm: &Comm) -> Self {
        let mine = [self.value.to_bits(), self.node, u64::from(self.not_a_number)];
        let all = comm.exchange(&vec![mine.to_vec(); comm.size() as usize]);
        let read = |w: &Vec<u64>| Self {
            value: f64::from_bits(w[0]),
            node: w[1],
            not_a_number: w[2] != 0,
        };
        all.iter().map(read).reduce(|a, b| if b.value > a.value { b } else { a }).unwrap_or(self)
    }
}

/// Forces cancel to this many units in the last place of the largest of them.
const UNITS: f64 = 32.0;
/// Where the largest force is no more than this many times the rounding, none acts.
const MEANINGLESS: f64 = 1e3;

/// What rounding may leave of parts that cancel, of size `cancelling` at most.
pub fn rounding(cancelling: f64) -> f64 {
    UNITS * f64::EPSILON * cancelling
}

/// Whether what is missing in a balance, at most, is no more than what rounding leaves of parts
/// that cancel, of size `cancelling` at most, beside which its largest part `scale` is nothing
/// either.
pub fn is_rounding(missing: f64, scale: f64, cancelling: f64) -> bool {
    let rounding = rounding(cancelling);
    missing <= rounding && scale <= MEANINGLESS * rounding
}

/// How large what makes up a state is at its nodes, at most.
#[derive(Debug, Clone, Copy, Default)]
pub struct Scales {
    /// Sum of the lengths of the forces of cells and loads at a node (N).
    pub force: f64,
    /// Displacement (m).
    pub displacement: f64,
    /// Stiffness times displacement of a node (N): what cancels where bodies move as wholes and no
    /// force acts, but for rounding.
    cancelling: f64,
}

impl Scales {
    /// Takes a node into account: its force (N), displacement (m) and stiffness (N/m).
    pub fn see(&mut self, force: f64, u: &[f64], stiffness: f64) {
        let largest = u.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
        self.force = self.force.max(force);
        self.displacement = self.displacement.max(largest);
        self.cancelling = self.cancelling.max(stiffness * largest);
    }
}

/// Errors of a state.
struct Measure {
    /// Largest out-of-balance force (N).
    worst: Worst,
    /// Largest error of the jump of each interface, over its scale.
    defect: Vec<Worst>,
    /// `worst` over the force scale.
    out_of_balance: f64,
    /// Largest of `defect`.
    largest: f64,
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
    signatures: Vec<u64>,
    /// How much of a correction is taken: less from a cycle of the branches on, until they stay.
    pub part_of_step: f64,
    /// Cycles of the running solve.
    cycles: i32,
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
            signatures: Vec::new(),
            part_of_step: 1.0,
            cycles: 0,
            holds: Vec::new(),
            softening: None,
            failure: None,
            broken: None,
        }
    }

    /// Takes note of the scales of a state, those of this rank's nodes. Collective.
    pub fn see_scales(&mut self, comm: &Comm, own: Scales) {
        let mut all = [own.force, own.displacement, own.cancelling];
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
        self.signatures.clear();
        (self.part_of_step, self.cycles) = (1.0, 0);
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

    /// How far the last evaluated state is from a solution, over the tolerance; not finite where it
    /// makes no sense. `worst` as in [`Convergence::judge`]. Collective.
    pub fn excess(
        &self,
        comm: &Comm,
        all: &Discretization,
        interfaces: &InterfaceState,
        worst: Worst,
    ) -> f64 {
        let m = self.measure(comm, all, interfaces, worst);
        m.out_of_balance.max(m.largest) / self.tolerance
    }

    /// The errors of the last evaluated state, field by field, over their scales. Collective.
    fn measure(
        &self,
        comm: &Comm,
        all: &Discretization,
        interfaces: &InterfaceState,
        worst: Worst,
    ) -> Measure {
        let scales = self.current;
        let force_scale = scales.force.max(self.accepted[0]);
        let displacement_scale = scales.displacement.max(self.accepted[1]);
        let mut defect = vec![Worst::default(); interfaces.laws.len()];
        for (rows, response) in all.secondary.iter().zip(&interfaces.response) {
            let law = interfaces.laws[rows.interface].spec.law();
            let scale = law.typical_jump().unwrap_or(displacement_scale);
            let square: f64 = response.defect.iter().map(|d| d * d).sum();
            let relative = if square == 0.0 {
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

    /// The verdict on a state: `worst` is the largest out-of-balance nodal force (N), `control` how
    /// far what the load factor follows from is from its value, over its scale. Collective.
    #[allow(clippy::too_many_arguments)] // the parts of a state
    pub fn judge(
        &mut self,
        comm: &Comm,
        all: &Discretization,
        interfaces: &InterfaceState,
        iteration: usize,
        norm: f64,
        worst: Worst,
        control: f64,
    ) -> Result<Verdict> {
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
        let Measure { worst, defect, out_of_balance, largest } =
            self.measure(comm, all, interfaces, worst);
        if worst.not_a_number || !norm.is_finite() || defect.iter().any(|d| d.not_a_number) {
            let first = defect.iter().find(|d| d.not_a_number).copied().unwrap_or(worst);
            let place = all.nodes.place_in_words(comm, first.node);
            self.failure = Some(format!("a force is not a number {place}"));
            return Ok(Verdict::Diverged);
        }
        tracing::debug!(
            target: "newton",
            "  correction {iteration:3}  out of balance {out_of_balance:9.3e}  jumps {largest:9.3e}  \
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
        let signature = comm.sum_u64(signature) ^ mix(on_path);
        if self.signatures.last() == Some(&signature) {
            self.part_of_step = 1.0;
        }
        if let Some(period) = self.cycle(signature) {
            if self.cycles < MOST_CYCLES {
                self.cycles += 1;
                self.part_of_step = 0.5_f64.powi(self.cycles);
                self.signatures.clear();
                let part = self.part_of_step;
                tracing::debug!(
                    target: "newton",
                    "  the branches cycle with period {period}: {part} of each correction until \
                     they stay"
                );
                return Ok(Verdict::Continue);
            }
            self.failure = Some(format!(
                "Newton's method cycles between {period} states of the interfaces \
                 ({iteration} corrections, out of balance {out_of_balance:.1e})"
            ));
            return Ok(Verdict::Diverged);
        }
        if iteration >= self.max_newton {
            let what = if control > out_of_balance.max(largest) {
                format!("{} is off by {control:.1e}", self.other)
            } else {
                let (node, what) = self.worst_place(worst, &defect, out_of_balance);
                format!("{what} {}", all.nodes.place_in_words(comm, node))
            };
            self.failure = Some(format!(
                "no convergence in {iteration} corrections (solver.max_newton): {what}; tolerance {:.1e}",
                self.tolerance
            ));
            return Ok(Verdict::Diverged);
        }
        Ok(Verdict::Continue)
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

    /// The period, if the last states of the branches repeat twice.
    fn cycle(&mut self, signature: u64) -> Option<usize> {
        self.signatures.push(signature);
        let s = &self.signatures;
        (2..=LONGEST_CYCLE).find(|period| {
            s.len() > 2 * period
                && (0..=*period).all(|i| s[s.len() - 1 - i] == s[s.len() - 1 - i - period])
                && s[s.len() - 1] != s[s.len() - 2]
        })
    }
}
