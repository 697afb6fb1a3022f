//! What of an accepted state is not a field.

use serde::{Deserialize, Serialize};

use crate::solve::flow::{FluidBalance, NextStep};

/// Everything of an accepted state that is not a field.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepState {
    /// The time that was reached (s).
    pub time: f64,
    /// Length of the steps to begin with, where earlier ones had to be cut (s).
    pub step: Option<f64>,
    /// Energies: elastic, dissipated, external (J).
    pub energy: [f64; 4],
    /// Stored, dissipated and taken by friction where earlier stages had multipliers (J).
    #[serde(default)]
    pub elsewhere: [f64; 3],
    /// What the fluid has done so far.
    #[serde(default)]
    pub fluid: FluidState,
    /// Whether the equilibrium at the start has been found (`initial.equilibrium`).
    #[serde(default)]
    pub has_begun: bool,
    /// Elastic energy of the state from which results count (J).
    #[serde(default)]
    pub elastic_at_start: f64,
    /// Until when what jumps at the start grows, where it has to (s).
    #[serde(default)]
    pub ramp: Option<f64>,
    /// By how much the loads of platens jump at the start of the stage (N, N m).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub platens: Vec<f64>,
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

/// The fluid at an accepted state; without flow only the work of a pressure that is a load.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f64; 7]", into = "[f64; 7]")]
pub struct FluidState {
    /// Work of the fluid on the skeleton (J).
    pub work: f64,
    /// In, out and stored (kg).
    pub balance: FluidBalance,
    /// Largest nodal magnitude of the balance (m3).
    pub scale: f64,
    /// How long the next step is.
    pub next_step: NextStep,
    /// Largest pressure (Pa).
    pub largest_pressure: f64,
}

/// The numbers of a checkpoint.
impl From<FluidState> for [f64; 7] {
    fn from(state: FluidState) -> Self {
        let FluidState { work, balance, scale, next_step, largest_pressure } = state;
        let FluidBalance { inflow, outflow, stored } = balance;
        // No step has the length 0.
        let length = match next_step {
            NextStep::First => 0.0,
            NextStep::Second(length) => -length,
            NextStep::Later(length) => length,
        };
        [work, inflow, outflow, stored, scale, length, largest_pressure]
    }
}

impl From<[f64; 7]> for FluidState {
    fn from(numbers: [f64; 7]) -> Self {
        let [work, inflow, outflow, stored, scale, length, largest_pressure] = numbers;
        let balance = FluidBalance { inflow, outflow, stored };
        let next_step = if length == 0.0 {
            NextStep::First
        } else if length < 0.0 {
            NextStep::Second(-length)
        } else {
            NextStep::Later(length)
        };
        Self { work, balance, scale, next_step, largest_pressure }
    }
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
        let fluid: [f64; 7] = self.fluid.into();
        let numbers = self.energy.iter().chain(&self.elsewhere).chain(&fluid);
        let numbers = numbers.chain(&self.load_factor).chain(&self.ramp);
        let numbers = numbers.chain(&self.platens).chain([&self.time, &self.elastic_at_start]);
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
    fn the_fluid_is_seven_numbers_in_a_checkpoint() {
        for text in [
            "[0.5,1.0,2.0,-1.0,3.0,0.0,4.0]",
            "[0.5,1.0,2.0,-1.0,3.0,0.25,4.0]",
            "[0.5,1.0,2.0,-1.0,3.0,-0.25,4.0]",
        ] {
            let state: FluidState = serde_json::from_str(text).expect("seven numbers");
            assert_eq!(serde_json::to_string(&state).expect("finite numbers"), text);
            assert_eq!(state.balance.stored, -1.0);
        }
        let second = FluidState::from([0.0, 0.0, 0.0, 0.0, 0.0, -0.25, 0.0]);
        assert_eq!(second.next_step, NextStep::Second(0.25));
        assert_eq!(FluidState::from([0.0; 7]), FluidState::default());
    }

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
            (StepState { energy: [0.0, f64::INFINITY, 0.0, 0.0], ..good() }, "its state is inf"),
            (StepState { fluid: [f64::NAN; 7].into(), ..good() }, "its state is NaN"),
            (
                StepState { since_instant: [0, 1 << 54, 0], ..good() },
                "it counts 18014398509481984 corrections or steps",
            ),
        ] {
            assert_eq!(state.check(), Err(words.to_owned()));
        }
    }
}
