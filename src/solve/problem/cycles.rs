//! Cycles of Newton's method among the branches of the laws.

/// Longest period of a cycle that is recognised.
const LONGEST_CYCLE: usize = 4;

/// After so many cycles of the branches in one solve a smaller step is cheaper.
const MOST_CYCLES: i32 = 3;

/// The branches in the states of a solve.
pub(super) struct Cycles {
    /// Of each state.
    signatures: Vec<u64>,
    /// Cycles of the running solve.
    count: i32,
    /// How much of a correction is taken: less from a cycle on, until the branches stay.
    part_of_step: f64,
}

/// What the branches of the last states do.
pub(super) enum Cycle {
    /// They are no cycle.
    None,
    /// They have this period; less of each correction is taken from now on.
    Damped(usize),
    /// They have this period, in spite of all that was done.
    Endless(usize),
}

impl Cycles {
    /// Before any state.
    pub fn new() -> Self {
        Self { signatures: Vec::new(), count: 0, part_of_step: 1.0 }
    }

    /// How much of a correction is taken.
    pub fn part_of_step(&self) -> f64 {
        self.part_of_step
    }

    /// Takes note of the branches of a state.
    pub fn see(&mut self, signature: u64) -> Cycle {
        if self.signatures.last() == Some(&signature) {
            self.part_of_step = 1.0;
        }
        self.signatures.push(signature);
        match self.period() {
            None => Cycle::None,
            Some(period) if self.count < MOST_CYCLES => {
                self.count += 1;
                self.part_of_step = 0.5_f64.powi(self.count);
                self.signatures.clear();
                Cycle::Damped(period)
            }
            Some(period) => Cycle::Endless(period),
        }
    }

    /// The period, if the last states of the branches repeat twice.
    fn period(&self) -> Option<usize> {
        let s = &self.signatures;
        (2..=LONGEST_CYCLE).find(|period| {
            s.len() > 2 * period
                && (0..=*period).all(|i| s[s.len() - 1 - i] == s[s.len() - 1 - i - period])
                && s[s.len() - 1] != s[s.len() - 2]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cycles_are_damped_until_the_branches_stay() {
        let mut cycles = Cycles::new();
        let mut see = |signatures: &[u64]| {
            let last = signatures.iter().map(|signature| cycles.see(*signature)).last();
            (last.expect("a state"), cycles.part_of_step())
        };
        assert!(matches!(see(&[1, 2, 1, 2]), (Cycle::None, 1.0)));
        assert!(matches!(see(&[1]), (Cycle::Damped(2), 0.5)));
        assert!(matches!(see(&[3, 4]), (Cycle::None, 0.5)));
        assert!(matches!(see(&[4]), (Cycle::None, 1.0)));
        assert!(matches!(see(&[1, 2, 3, 1, 2, 3, 1]), (Cycle::Damped(3), 0.25)));
        assert!(matches!(see(&[1, 2, 1, 2, 1]), (Cycle::Damped(2), 0.125)));
        assert!(matches!(see(&[1, 2, 1, 2, 1]), (Cycle::Endless(2), 0.125)));
    }
}
