//! How long the steps of the flow are: as long as an estimate of their error allows.

use crate::comm::Comm;

/// Part of the length that the estimate allows which is taken.
const CAUTION: f64 = 0.9;
/// Lengths change by no more than these factors.
const CHANGE: [f64; 2] = [0.2, 2.0];

/// Lengths of steps by the error of the implicit Euler method, half of the second difference of the
/// pressure; with a weight below 1 of the end of a step the error is smaller.
pub struct Pace {
    /// Error of the pressure that a step may make, over the largest pressure so far.
    tolerance: f64,
    /// Length of the first step after a jump of the load (s).
    first: f64,
    /// Length of the next step (s).
    next: f64,
    /// Change of the pressure of owned nodes in the last step (Pa/s); none before two steps after a
    /// jump, since the first one has the jump itself in it.
    pub rate: Option<Vec<f64>>,
    /// Whether the next step is the first one after a jump.
    is_jump: bool,
    /// Largest pressure so far (Pa).
    pub largest: f64,
    /// Error of the last step over the tolerance.
    excess: f64,
}

/// How long the next step is, by how many there were since a jump of the load.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum NextStep {
    /// As long as the first one after each jump.
    #[default]
    First,
    /// The second one, of this length (s): the change of the pressure in the first says nothing.
    Second(f64),
    /// A later one, of this length (s).
    Later(f64),
}

impl Pace {
    /// At the start, which is a jump.
    pub fn new(tolerance: f64, first: f64) -> Self {
        Self { tolerance, first, next: first, rate: None, is_jump: true, largest: 0.0, excess: 0.0 }
    }

    /// What follows is not smooth with what was before. Local.
    pub fn jump(&mut self) {
        (self.rate, self.next, self.is_jump) = (None, self.first, true);
    }

    /// The length of the next step.
    pub fn next_step(&self) -> NextStep {
        match (self.is_jump, &self.rate) {
            (true, _) => NextStep::First,
            (false, None) => NextStep::Second(self.next),
            (false, Some(_)) => NextStep::Later(self.next),
        }
    }

    /// Goes on from a state of an earlier run: its next step, the change of the pressure of owned
    /// nodes in the last one (Pa/s) and the largest pressure (Pa). Local.
    pub fn resume(&mut self, next: NextStep, rate: Vec<f64>, largest: f64) {
        self.largest = largest;
        if let NextStep::Second(length) | NextStep::Later(length) = next {
            (self.next, self.is_jump) = (length, false);
            self.rate = matches!(next, NextStep::Later(_)).then_some(rate);
        }
    }

    /// Whether the step of this length from the pressures `before` to `after`, of owned nodes, is
    /// accurate enough; if not, the next one is shorter. Collective.
    pub fn accepts(&mut self, comm: &Comm, before: &[f64], after: &[f64], length: f64) -> bool {
        let mut sizes = [0.0_f64; 2];
        for (i, (before, after)) in before.iter().zip(after).enumerate() {
            sizes[0] = sizes[0].max(after.abs());
            let foreseen = self.rate.as_ref().map(|rate| length * rate[i]);
            let difference = foreseen.map_or(0.0, |foreseen| after - before - foreseen);
            sizes[1] = sizes[1].max(0.5 * difference.abs());
        }
        comm.max(&mut sizes);
        let largest = self.largest.max(sizes[0]);
        self.excess = if sizes[1] == 0.0 { 0.0 } else { sizes[1] / (self.tolerance * largest) };
        // Where the pressure jumps, as at a rupture, no step is short enough.
        if self.excess <= 1.0 || length <= self.first {
            self.largest = largest;
            return true;
        }
        self.next = (length * self.change()).max(self.first);
        false
    }

    fn change(&self) -> f64 {
        (CAUTION / self.excess.sqrt()).clamp(CHANGE[0], CHANGE[1])
    }

    /// The step was accepted: takes note of the pressures of owned nodes. Local.
    pub fn go_on(&mut self, before: &[f64], after: &[f64], length: f64) {
        if std::mem::take(&mut self.is_jump) {
            self.rate = None;
            return;
        }
        if self.rate.is_some() {
            self.next = (length * self.change()).max(self.first);
        }
        let pairs = before.iter().zip(after);
        self.rate = Some(pairs.map(|(before, after)| (after - before) / length).collect());
    }

    /// The end of the next step, on the way from `time` to `instant` in equal steps.
    pub fn target(&self, time: f64, instant: f64) -> f64 {
        let steps = ((instant - time) / self.next * (1.0 - 1e-6)).ceil();
        let target = time + (instant - time) / steps;
        // A step that is nothing beside the time would lead nowhere.
        if steps <= 1.0 || target <= time { instant } else { target }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_end_at_the_instant_and_are_no_longer_than_allowed() {
        let pace = Pace::new(1e-3, 0.3);
        assert_eq!(pace.target(0.0, 0.3), 0.3);
        assert_eq!(pace.target(0.0, 0.1), 0.1);
        assert_eq!(pace.target(1.0, 2.0), 1.25);
        assert_eq!(Pace::new(1e-3, 1e-20).target(1.0, 2.0), 2.0);
    }
}
