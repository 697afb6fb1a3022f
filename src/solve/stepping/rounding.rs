//! What rounding allows, where a step fails for it.

use super::Stepper;

/// Rounding errors that a nodal force gathers, over the one of its largest part.
const GATHERED: f64 = 4.0;

/// What rounding leaves of the balance of nodal forces, over the scale of forces: the parts of a
/// nodal force are as large as a stiffness times a displacement, whatever they sum up to.
fn rounding(stiffness: f64, [force, displacement]: [f64; 2]) -> f64 {
    if force > 0.0 { GATHERED * f64::EPSILON * stiffness * displacement / force } else { 0.0 }
}

impl Stepper<'_> {
    /// That a step failed for rounding, in words, with its size; empty where it did not. Local.
    pub(super) fn rounding_words(&self) -> String {
        let (problem, tolerance) = (&self.problem, self.case.solver.tolerance);
        let current = problem.convergence.current();
        let mut scales = [current.force, current.displacement];
        let accepted = problem.convergence.accepted_scales();
        if accepted.iter().all(|scale| *scale > 0.0) {
            scales = accepted;
        }
        let stiffness = problem.stiffness();
        let part = rounding(stiffness, scales);
        if !(part > tolerance && part.is_finite()) {
            return self.rounding_of_fluid();
        }
        let [force, displacement] = scales;
        format!(
            "\nrounding alone leaves about {part:.0e} of the largest nodal force out of balance, more than \
             solver.tolerance {tolerance:e}: a stiffness of {stiffness:.1e} N/m times a displacement of \
             {displacement:.1e} m is known to {:.0e} N, beside forces of {force:.1e} N; less contrast between \
             moduli, sizes of cells, or compressibilities, or a larger tolerance",
            GATHERED * f64::EPSILON * stiffness * displacement
        )
    }
}

impl Stepper<'_> {
    /// As [`Stepper::rounding_words`], of the balance of the fluid. Local.
    fn rounding_of_fluid(&self) -> String {
        let tolerance = self.case.solver.tolerance;
        let part = self.coupling.as_ref().map_or(0.0, |coupling| coupling.missing[1]);
        if !(part > tolerance && part.is_finite()) {
            return String::new();
        }
        format!(
            "\nrounding alone leaves up to {part:.0e} of the largest volume of fluid out of balance, more than \
             solver.tolerance {tolerance:e}: displacements are large beside what flows; longer steps, or a \
             larger tolerance"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_grows_with_stiffness_and_displacement_beside_the_forces() {
        assert_eq!(rounding(1e9, [0.0, 1.0]), 0.0);
        let part = rounding(1e18, [1e6, 1e-3]);
        assert!((part - 4.0 * f64::EPSILON * 1e9).abs() < 1e-20, "{part}");
    }
}
