//! What of an accepted state is not a field.

use serde::{Deserialize, Serialize};

/// Everything of an accepted state that is not a field.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepState {
    /// The time that was reached (s).
    pub time: f64,
    /// Length of the steps to begin with, where earlier ones had to be cut (s).
    pub step: Option<f64>,
    /// Energies: elastic, dissipated, external (J).
    pub energy: [f64; 3],
    /// With flow: work of the fluid on the skeleton (J), fluid in, out and stored (kg), and the
    /// largest nodal magnitude of its balance (m3), length of the next step (s; 0: the first one
    /// after a jump, negative: the second) and largest pressure (Pa).
    #[serde(default)]
    pub fluid: [f64; 7],
    /// Whether the equilibrium at the start has been found (`initial.equilibrium`).
    #[serde(default)]
    pub has_begun: bool,
    /// Until when what jumps at the start grows, where it has to (s).
    #[serde(default)]
    pub ramp: Option<f64>,
    /// What else was said of accepted states.
    #[serde(default)]
    pub remarks: Vec<String>,
    /// 2-norm of the out-of-balance forces (N).
    pub residual_norm: f64,
    /// Largest nodal force scale (N) and displacement (m) of the accepted states.
    pub scales: [f64; 2],
    /// What all loads are scaled by, on a path.
    pub load_factor: Option<f64>,
    /// Whether smaller steps are tried where states are unstable.
    pub tries_smaller_steps: bool,
    /// Corrections, linear iterations and steps since the last instant.
    pub since_instant: [usize; 3],
    /// What was found about accepted states so far, in words.
    pub instabilities: Vec<String>,
    /// The states that are not unique, in words.
    pub bifurcations: Vec<String>,
}

/// Counts above are of no run, and could not be added to: the whole numbers that a float holds.
pub const MOST_COUNTED: u64 = 1 << 53;

impl StepState {
    /// What in it no run can have written, in words; for what is read from a file. Local.
    ///
    /// # Errors
    /// The name of the first such part and its value.
    pub fn check(&self) -> std::result::Result<(), String> {
        let wrong = |what: &str, value: f64| Err(format!("its {what} is {value}"));
        if let Some(step) = self.step.filter(|step| !(step.is_finite() && *step > 0.0)) {
            return wrong("step", step);
        }
        let [force, displacement] = self.scales;
        let sizes =
            [("residual norm", self.residual_norm), ("force", force), ("size", displacement)];
        for (what, size) in sizes {
            if !(size.is_finite() && size >= 0.0) {
                return wrong(what, size);
            }
        }
        let numbers = self.energy.iter().chain(&self.fluid);
        let numbers = numbers.chain(&self.load_factor).chain(&self.ramp).chain([&self.time]);
        if let Some(number) = numbers.copied().find(|number| !number.is_finite()) {
            return wrong("state", number);
        }
        match self.since_instant.iter().find(|count| **count as u64 > MOST_COUNTED) {
            Some(count) => Err(format!("it counts {count} corrections or steps")),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_run_writes_is_told() {
        assert_eq!(StepState::default().check(), Ok(()));
        let good = || StepState { step: Some(0.5), load_factor: Some(-2.0), ..Default::default() };
        assert_eq!(good().check(), Ok(()));
        for (state, words) in [
            (StepState { step: Some(0.0), ..good() }, "its step is 0"),
            (StepState { step: Some(-1.0), ..good() }, "its step is -1"),
            (StepState { residual_norm: -1.0, ..good() }, "its residual norm is -1"),
            (StepState { scales: [-2.0, 0.0], ..good() }, "its force is -2"),
            (StepState { scales: [0.0, f64::NAN], ..good() }, "its size is NaN"),
            (StepState { energy: [0.0, f64::INFINITY, 0.0], ..good() }, "its state is inf"),
            (
                StepState { since_instant: [0, 1 << 54, 0], ..good() },
                "it counts 18014398509481984 corrections or steps",
            ),
        ] {
            assert_eq!(state.check(), Err(words.to_owned()));
        }
    }
}
